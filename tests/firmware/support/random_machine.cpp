#include "tests/firmware/support/random_machine.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/by_hand/read_by_hand.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double rated_speed_rpm = 6000.0;
constexpr double room_K = 293.15;
constexpr double noise_K = 0.03;
constexpr double seconds_per_hour = 3600.0;
// A conductance over a square metre is its value in W/K.
constexpr const char* square_metre = "area_mm2 = 1e6\n";

double draw_log(Random& random, double low, double high) {
  return std::exp(draw(random, std::log(low), std::log(high)));
}

void write_exchange(std::ostringstream& text, int number, int a, int b, Random& random) {
  const int kind = draw_int(random, 0, 9);
  const double conductance_W_per_K = draw_log(random, 2.0, 30.0);
  text << (kind < 6   ? "[[contact]]"
           : kind < 8 ? "[[gap_film]]"
                      : "[[conduction]]")
       << "\nbetween = [\"node_" << a << "\", \"node_" << b << "\"]\n";
  if (kind >= 8) {
    text << "conductance_W_per_K = " << conductance_W_per_K << "\n";
    return;
  }
  text << "name = \"exchange_" << number << "\"\n" << square_metre;
  if (kind < 6) {
    text << "conductance_W_per_m2K = " << conductance_W_per_K << "\n";
  } else {
    text << "coefficient_W_per_m2K = " << conductance_W_per_K
         << "\nspeed_law = { constant = 0.4, speed_terms = [[0.6, 0.8]] }\n";
  }
}

/// Returns its conductance at rated speed.
double write_film(std::ostringstream& text, const char* surrounding, int node, Random& random) {
  const double conductance_W_per_K = draw_log(random, 1.0, 6.0);
  text << "[[film]]\nname = \"" << surrounding << "_" << node << "\"\nsurrounding = \"" << surrounding
       << "\"\nnode = \"node_" << node << "\"\n"
       << square_metre << "coefficient_W_per_m2K = " << conductance_W_per_K << "\n";
  if (toss(random, 0.5)) text << "speed_law = { constant = 0.5, speed_terms = [[0.5, 0.8]] }\n";
  return conductance_W_per_K;
}

void write_heat(std::ostringstream& text, int number, int node, double heat_W, Random& random) {
  constexpr std::array<const char*, 4> laws{
      "{ speed_terms = [[0.5, 1.0], [0.5, 1.67]] }", "{ load_squared = 1.0 }",
      "{ constant = 0.2, speed_terms = [[0.2, 1.3]], load_squared = 0.6, zero_at_standstill = true }",
      "{ constant = 0.3, speed_terms = [[0.7, 1.5]] }"};
  text << "[[heat]]\nname = \"heat_" << number << "\"\nnode = \"node_" << node << "\"\nheat_W = " << heat_W
       << "\nspeed_law = " << laws[static_cast<std::size_t>(draw_int(random, 0, 3))] << "\n";
}

}  // namespace

rom::Network random_network(Random& random) {
  const int nodes = draw_int(random, 3, 10);
  const bool has_water = toss(random, 0.5);
  std::ostringstream text;
  text << "name = \"random\"\n[operating]\nspeed_rpm = " << rated_speed_rpm
       << "\nreference_temperature_degC = 20.0\ntemperatures_degC = { room = 20.0"
       << (has_water ? ", water = 20.0" : "") << " }\n[[surrounding]]\nname = \"room\"\nkind = \"ambient\"\n";
  if (has_water) text << "[[surrounding]]\nname = \"water\"\nkind = \"coolant\"\n";
  for (int i = 0; i < nodes; ++i) {
    text << "[[node]]\nname = \"node_" << i << "\"\npart = \"part_" << i % 3
         << "\"\ncapacity_J_per_K = " << draw_log(random, 100.0, 5000.0) << "\n[[key_point]]\nname = \"node_" << i
         << "\"\nnode = \"node_" << i << "\"\n";
  }
  // Conductions of the same two nodes may stand only once: the tree's pairs differ from those of node and next but one.
  int exchanges = 0;
  for (int i = 1; i < nodes; ++i) write_exchange(text, exchanges++, std::max(0, i - draw_int(random, 1, 2)), i, random);
  for (int i = 3; i < nodes; ++i) {
    if (toss(random, 0.3)) write_exchange(text, exchanges++, i - 3, i, random);
  }
  double films_W_per_K = 0.0;
  for (int i = 0; i < nodes; ++i) {
    if (i == 0 || toss(random, 0.25)) films_W_per_K += write_film(text, "room", i, random);
  }
  if (has_water) films_W_per_K += write_film(text, "water", nodes - 1, random);
  const int heats = draw_int(random, 1, 3);
  for (int h = 0; h < heats; ++h) {
    const double rise_K = draw(random, 10.0, 40.0);  // of everything, if this heat were alone
    write_heat(text, h, draw_int(random, 0, nodes - 1), films_W_per_K * rise_K / heats, random);
  }
  for (const char* name : {"nose", "rear"}) {
    text << "[[deformation]]\nname = \"" << name << "\"\num_per_K = { ";
    for (int i = 0; i < nodes; ++i) text << (i > 0 ? ", " : "") << "node_" << i << " = " << draw(random, -1.0, 2.0);
    text << " }\n";
  }
  return rom::parse_by_hand(text.str(), "random.toml");
}

rom::Network made_other(const rom::Network& network, double spread, Random& random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto factor = [&] { return std::exp(spread * std::clamp(normal(random), -1.5, 1.5)); };
  rom::Network other = network;
  for (Eigen::Index i = 0; i < other.capacity_J_per_K.rows(); ++i) other.capacity_J_per_K(i, i) *= factor();
  other.conduction_W_per_K *= factor();
  for (rom::Conductance& conductance : other.boundaries.conductances) conductance.nominal_W_per_m2K *= factor();
  for (rom::HeatSource& source : other.boundaries.sources) source.nominal_W *= factor();
  return other;
}

std::vector<LogStep> random_log(const rom::Network& network, double end_s, Random& random) {
  std::vector<LogStep> log;
  LogStep now;
  now.ambient_K = room_K + draw(random, -5.0, 10.0);
  now.coolant_K = room_K + draw(random, -3.0, 8.0);
  for (double time_s = 0.0; time_s < end_s; time_s += log.back().lasting_s) {
    const bool stands = toss(random, 0.2);
    now.lasting_s = draw(random, 300.0, 2400.0);
    now.speed_rpm = stands ? 0.0 : network.boundaries.reference_speed_rpm * draw(random, 0.1, 1.2);
    now.load = stands ? 0.0 : draw(random, 0.0, 1.2);
    if (toss(random, 0.3)) now.ambient_K = room_K + draw(random, -8.0, 12.0);
    if (toss(random, 0.3)) now.coolant_K = room_K + draw(random, -5.0, 10.0);
    log.push_back(now);
  }
  return log;
}

const LogStep& at_time(const std::vector<LogStep>& log, double time_s) {
  for (const LogStep& step : log) {
    if (time_s < step.lasting_s) return step;
    time_s -= step.lasting_s;
  }
  return log.back();
}

RandomMachine::RandomMachine(rom::Network network)
    : network_(std::move(network)),
      model_(make_model(network_, [](const rom::Network& of) { return rom::make_runtime_stepper(of); })),
      none_(rom::no_correction(network_.boundaries)),
      operating_(network_.boundaries.operating) {}

void RandomMachine::start(double temperature_K) {
  model_.stepper->set_temperatures(
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network_.nodes.size()), temperature_K));
  predict(network_, model_);
}

void RandomMachine::advance(double period_s, const LogStep& step) {
  operating_.speed_rpm = step.speed_rpm;
  operating_.load = step.load;
  for (std::size_t e = 0; e < network_.boundaries.environments.size(); ++e) {
    const bool coolant = network_.boundaries.environments[e].kind == rom::EnvironmentKind::coolant;
    operating_.environment_K[static_cast<Eigen::Index>(e)] = coolant ? step.coolant_K : step.ambient_K;
  }
  integrate(network_, operating_, none_, period_s, model_);
  predict(network_, model_);
}

const char* name_of(Trouble trouble) {
  constexpr std::array<const char*, static_cast<std::size_t>(Trouble::count)> names{
      "jump",   "drift",       "stuck",          "exchanged",      "not a number", "gap",
      "spikes", "absurd load", "absurd coolant", "absurd ambient", "speed scale",  "signals missing"};
  return names[static_cast<std::size_t>(trouble)];
}

std::vector<TroubleEvent> random_troubles(const std::vector<std::size_t>& sensors, double end_s, Random& random) {
  std::vector<TroubleEvent> events;
  const int count = draw_int(random, 1, 3);
  for (int i = 0; i < count; ++i) {
    TroubleEvent event;
    event.trouble = static_cast<Trouble>(draw_int(random, 0, static_cast<int>(Trouble::count) - 1));
    event.from_s = toss(random, 0.2) ? 0.0 : draw(random, 0.0, 0.8 * end_s);
    event.until_s = toss(random, 0.4) ? end_s : event.from_s + draw(random, 20.0, 3600.0);
    const int last = static_cast<int>(sensors.size()) - 1;
    event.sensor = sensors[static_cast<std::size_t>(draw_int(random, 0, last))];
    event.partner = sensors[static_cast<std::size_t>(draw_int(random, 0, last))];
    const double sign = toss(random, 0.5) ? 1.0 : -1.0;
    switch (event.trouble) {
      case Trouble::jump:
      case Trouble::spikes:
        event.size = sign * draw_log(random, 1.0, 80.0);
        break;
      case Trouble::drift:
        event.size = sign * draw_log(random, 0.5, 60.0);
        break;
      case Trouble::load_absurd:
        event.size = toss(random, 0.5) ? 70.0 : draw(random, -8.0, 8.0);
        break;
      case Trouble::coolant_absurd:
        event.size = toss(random, 0.5) ? room_K + 275.0 : room_K + draw(random, -60.0, 100.0);
        break;
      case Trouble::ambient_absurd:
        event.size = room_K + draw(random, -65.0, 120.0);
        break;
      case Trouble::speed_scale:
        event.size = sign * draw_log(random, 0.05, 15.0);
        break;
      default:
        break;
    }
    events.push_back(event);
  }
  return events;
}

std::string describe(const std::vector<TroubleEvent>& events) {
  std::ostringstream text;
  for (const TroubleEvent& event : events) {
    text << name_of(event.trouble) << " (node_" << event.sensor << ", size " << event.size << ") from " << event.from_s
         << " to " << event.until_s << " s; ";
  }
  return text.str();
}

TroubledDevice::TroubledDevice(std::vector<std::size_t> sensors, std::vector<TroubleEvent> events, std::uint64_t seed)
    : sensors_(std::move(sensors)), events_(std::move(events)), random_(seed) {
  offset_K_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(slots::key_points));
  std::normal_distribution<double> normal(0.0, 0.1);
  for (double& offset_K : offset_K_) offset_K = normal(random_);
}

void TroubledDevice::apply(const TroubleEvent& event, const Eigen::VectorXd& nodes_K, double time_s) {
  Reading& reading = frame_.sensors[event.sensor];
  switch (event.trouble) {
    case Trouble::jump:
      reading.value += event.size;
      break;
    case Trouble::drift:
      reading.value += event.size * (time_s - event.from_s) / seconds_per_hour;
      break;
    case Trouble::stuck:
      if (before_.connected) reading.value = before_.sensors[event.sensor].value;
      break;
    case Trouble::exchanged:
      reading.value = nodes_K[static_cast<Eigen::Index>(event.partner)];
      frame_.sensors[event.partner].value = nodes_K[static_cast<Eigen::Index>(event.sensor)];
      break;
    case Trouble::not_a_number:
      reading.value = not_a_value;
      break;
    case Trouble::gap:
      if (before_.connected) frame_.sensors = before_.sensors;
      break;
    case Trouble::spikes:
      if (toss(random_, 0.05)) reading.value += event.size;
      break;
    case Trouble::load_absurd:
      signal(Signal::load).value = event.size;
      break;
    case Trouble::coolant_absurd:
      signal(Signal::coolant).value = event.size;
      break;
    case Trouble::ambient_absurd:
      signal(Signal::ambient).value = event.size;
      break;
    case Trouble::speed_scale:
      signal(Signal::speed).value *= event.size;
      break;
    case Trouble::signals_missing:
      if (before_.connected) frame_.signals = before_.signals;
      break;
    case Trouble::count:
      break;
  }
}

const DeviceFrame& TroubledDevice::read(const Eigen::VectorXd& nodes_K, const LogStep& step, double time_s,
                                        std::int64_t now_ns) {
  std::normal_distribution<double> normal(0.0, noise_K);
  before_ = frame_;
  frame_.connected = true;
  for (const std::size_t k : sensors_) {
    const auto node = static_cast<Eigen::Index>(k);
    frame_.sensors[k] = {nodes_K[node] + offset_K_[node] + normal(random_), now_ns};
  }
  signal(Signal::speed) = {step.speed_rpm, now_ns};
  signal(Signal::load) = {step.load, now_ns};
  signal(Signal::ambient) = {step.ambient_K, now_ns};
  signal(Signal::coolant) = {step.coolant_K, now_ns};
  for (const TroubleEvent& event : events_) {
    if (time_s >= event.from_s && time_s < event.until_s) apply(event, nodes_K, time_s);
  }
  return frame_;
}

}  // namespace spindle_twin::firmware
