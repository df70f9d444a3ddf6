#include "tests/bench/reality/truth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::bench {
namespace {

// As in twin_campaign's truth with independent heats.
constexpr double heat_deviation = 0.5;
constexpr double contact_deviation = 0.6;
constexpr double film_deviation = 0.3;
constexpr double joint_drift = 0.2;  // within followed_s, in steps of refactor_s
constexpr double refactor_s = 600.0;
constexpr double friction_update_s = 30.0;
constexpr double friction_per_K = 0.010;
constexpr double inlet_error_K = 0.1;
constexpr double inlet_memory_s = 1800.0;

constexpr double before_s = 3600.0;  // that a warm or cold one runs before
constexpr double earliest_event_s = 1800.0;
constexpr double latest_event_s = 4500.0;
constexpr double earliest_cutting_s = 600.0;  // so that touch-offs each half hour can tell of it
constexpr double latest_cutting_s = 1800.0;
constexpr double missing_contact = 0.01;
constexpr double grease_peak = 1.5;
constexpr double grease_s = 400.0;  // a twentieth of the peak is left after 20 min
constexpr double run_in_excess = 0.5;
const double halved_film = std::pow(0.5, 0.8);  // turbulent flow in a channel: Nu ~ Re^0.8
constexpr double standing_film = 0.03;          // water that stands and warms up takes some per cent of the heat

enum Purpose : std::uint32_t { factors_of, spectrum_of, earlier_spectrum_of, inlets_of, event_of, contact_of };

struct Block {
  double until_s;
  double speed_rpm;
  double load;
};

void add_spectrum(std::mt19937_64 random, double until_s, std::vector<Block>& blocks) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (double time_s = blocks.empty() ? 0.0 : blocks.back().until_s; time_s < until_s;) {
    time_s = std::min(until_s, time_s + truth_sample_s * std::round((180.0 + 540.0 * unit(random)) / truth_sample_s));
    const double speed_rpm = unit(random) < 0.1 ? 0.0 : 12000.0 * unit(random);
    blocks.push_back({time_s, speed_rpm, unit(random)});
  }
}

/// What the machine does; the twin starts at start_s.
struct Schedule {
  std::vector<Block> blocks;
  double start_s = 0.0;
};

Schedule draw_schedule(TruthKind kind, std::uint64_t seed) {
  Schedule schedule;
  if (kind == TruthKind::warm || kind == TruthKind::cold) {
    add_spectrum(random_of(seed, earlier_spectrum_of), before_s, schedule.blocks);
    schedule.start_s = before_s;
  }
  if (kind == TruthKind::cold) {
    std::mt19937_64 random = random_of(seed, event_of);
    const double stop_s = 1200.0 + 1200.0 * std::uniform_real_distribution<double>(0.0, 1.0)(random);
    schedule.start_s += truth_sample_s * std::round(stop_s / truth_sample_s);
    schedule.blocks.push_back({schedule.start_s, 0.0, 0.0});
  }
  add_spectrum(random_of(seed, spectrum_of), schedule.start_s + followed_s + truth_sample_s, schedule.blocks);
  return schedule;
}

/// Hidden ln factors; their medians are 1.
struct Hidden {
  Eigen::VectorXd heat, conductance;
};

double conductance_W_per_K(const rom::Boundaries& boundaries, Eigen::Index j) {
  const rom::Conductance& conductance = boundaries.conductances[static_cast<std::size_t>(j)];
  return conductance.nominal_W_per_m2K * conductance.area_m2;
}

Hidden draw_hidden(const rom::Boundaries& boundaries, TruthKind kind, std::uint64_t seed) {
  std::mt19937_64 random = random_of(seed, factors_of);
  std::normal_distribution<double> normal(0.0, 1.0);
  Hidden hidden{Eigen::VectorXd(boundaries.sources.size()), Eigen::VectorXd(boundaries.conductances.size())};
  for (double& heat : hidden.heat) heat = heat_deviation * normal(random);
  std::vector<Eigen::Index> contacts;
  for (Eigen::Index j = 0; j < hidden.conductance.size(); ++j) {
    const bool contact = boundaries.conductances[static_cast<std::size_t>(j)].kind == rom::ConductanceKind::contact;
    hidden.conductance[j] = (contact ? contact_deviation : film_deviation) * normal(random);
    if (contact) contacts.push_back(j);
  }
  if (kind == TruthKind::contact) {
    // One that matters: of the larger half.
    std::sort(contacts.begin(), contacts.end(), [&](Eigen::Index a, Eigen::Index b) {
      return conductance_W_per_K(boundaries, a) > conductance_W_per_K(boundaries, b);
    });
    std::mt19937_64 chosen = random_of(seed, contact_of);
    hidden.conductance[contacts[chosen() % (contacts.size() / 2)]] = std::log(missing_contact);
  }
  return hidden;
}

struct Inlets {
  Eigen::VectorXd error_K, phase;
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0.0, 1.0};

  Inlets(Eigen::Index count, std::uint64_t seed) : error_K(count), phase(count), random(random_of(seed, inlets_of)) {
    for (Eigen::Index e = 0; e < count; ++e) {
      error_K[e] = inlet_error_K * normal(random);
      phase[e] = 2.0 * std::numbers::pi * normal(random);
    }
  }
  double swing(Eigen::Index e, double time_s) const {
    return std::sin(2.0 * std::numbers::pi * time_s / 5400.0 + phase[e]) - std::sin(phase[e]);
  }
  void pass() {
    const double keep = std::exp(-truth_sample_s / inlet_memory_s);
    for (double& error : error_K) error = keep * error + inlet_error_K * std::sqrt(1.0 - keep * keep) * normal(random);
  }
};

bool has_event(TruthKind kind) {
  return kind == TruthKind::flow || kind == TruthKind::blocked || kind == TruthKind::cutting ||
         kind == TruthKind::inlet;
}

void draw_event(RealityTruth& truth) {
  if (!has_event(truth.kind)) return;
  std::mt19937_64 random = random_of(truth.seed, event_of);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const bool cutting = truth.kind == TruthKind::cutting;
  const double earliest_s = cutting ? earliest_cutting_s : earliest_event_s;
  const double latest_s = cutting ? latest_cutting_s : latest_event_s;
  const double event_s = earliest_s + (latest_s - earliest_s) * unit(random);
  truth.event_s = truth_sample_s * std::round(event_s / truth_sample_s);
  if (truth.kind == TruthKind::inlet) truth.inlet_step_K = unit(random) < 0.5 ? -inlet_step_size_K : inlet_step_size_K;
}

/// One virtual spindle on its way.
class Run {
 public:
  Run(const fem_offline::AffineModel& model, RealityTruth& truth)
      : model_(model),
        boundaries_(model.boundaries),
        truth_(truth),
        schedule_(draw_schedule(truth.kind, truth.seed)),
        hidden_(draw_hidden(boundaries_, truth.kind, truth.seed)),
        inlets_(static_cast<Eigen::Index>(boundaries_.environments.size()), truth.seed),
        stepper_(model),
        factors_(rom::no_correction(boundaries_)),
        values_(rom::make_boundary_values(boundaries_)) {
    stepper_.set_uniform_temperature(boundaries_.reference_temperature_K);
  }

  void go() {
    const long samples = std::lround((schedule_.start_s + followed_s) / truth_sample_s) + 1;
    for (long k = 0; k < samples; ++k) {
      time_s_ = static_cast<double>(k) * truth_sample_s;
      operate();
      if (time_s_ >= schedule_.start_s) sample();
      inlets_.pass();
      set_factors();
      rom::evaluate_boundaries(boundaries_, operating_, factors_, values_);
      stepper_.advance(truth_sample_s, truth_sample_s, values_);
      last_speed_rpm_ = operating_.speed_rpm;
    }
  }

 private:
  bool after_event() const { return truth_.event_s >= 0.0 && time_s_ - schedule_.start_s >= truth_.event_s; }
  double film_after_event() const {
    if (truth_.kind == TruthKind::flow) return halved_film;
    return truth_.kind == TruthKind::blocked ? standing_film : 1.0;
  }
  bool is_coolant(Eigen::Index environment) const {
    return environment >= 0 &&
           boundaries_.environments[static_cast<std::size_t>(environment)].kind == rom::EnvironmentKind::coolant;
  }

  void operate() {
    while (time_s_ >= schedule_.blocks[block_].until_s && block_ + 1 < schedule_.blocks.size()) ++block_;
    operating_ = boundaries_.operating;
    operating_.speed_rpm = schedule_.blocks[block_].speed_rpm;
    operating_.load = schedule_.blocks[block_].load;
    for (Eigen::Index e = 0; e < operating_.environment_K.size(); ++e) {
      operating_.environment_K[e] += (is_coolant(e) ? 0.5 : 1.5) * inlets_.swing(e, time_s_);
      if (is_coolant(e) && after_event()) operating_.environment_K[e] += truth_.inlet_step_K;
    }
    if (operating_.speed_rpm > 0.0 && last_speed_rpm_ == 0.0) started_s_ = time_s_;
  }

  void sample() {
    TruthSample now;
    now.speed_rpm = operating_.speed_rpm;
    now.load = operating_.load;
    for (Eigen::Index e = 0; e < operating_.environment_K.size(); ++e) {
      (is_coolant(e) ? now.coolant_K : now.ambient_K) = operating_.environment_K[e];
      (is_coolant(e) ? now.coolant_error_K : now.ambient_error_K) = inlets_.error_K[e];
    }
    const Eigen::VectorXd& nodes_K = stepper_.temperatures_K();
    for (std::size_t p = 0; p < place_count; ++p) now.place_K[p] = model_.key_points[p].row.dot(nodes_K);
    const Eigen::VectorXd& nose = model_.deformations.front().row_m_per_K;
    now.nose_m = nose.dot(nodes_K) - nose.sum() * boundaries_.reference_temperature_K;
    truth_.samples.push_back(now);
  }

  double friction() const {
    if (truth_.kind == TruthKind::grease) return 1.0 + grease_peak * std::exp(-(time_s_ - started_s_) / grease_s);
    if (truth_.kind == TruthKind::run_in) return 1.0 + run_in_excess * (1.0 - time_s_ / followed_s);
    return 1.0;
  }

  void set_factors() {
    if (rises_K_.size() == 0 || std::fmod(time_s_, friction_update_s) == 0.0 ||
        operating_.speed_rpm != last_speed_rpm_) {
      rises_K_ = model_.source_distribution.transpose() * stepper_.temperatures_K();
      rises_K_.array() -= boundaries_.reference_temperature_K;
    }
    const Eigen::Index cutting = hidden_.heat.size() - 1;
    for (Eigen::Index i = 0; i < cutting; ++i) {
      const bool rubs = boundaries_.sources[static_cast<std::size_t>(i)].friction;
      const double cooled = rubs ? std::max(0.1, 1.0 - friction_per_K * rises_K_[i]) * friction() : 1.0;
      factors_.heat[i] = std::exp(hidden_.heat[i]) * cooled;
    }
    factors_.heat[cutting] = truth_.kind == TruthKind::cutting && after_event() ? 1.0 : 0.0;
    const double settled = std::log1p(joint_drift * std::floor(time_s_ / refactor_s) * refactor_s / followed_s);
    for (Eigen::Index j = 0; j < hidden_.conductance.size(); ++j) {
      const rom::Conductance& conductance = boundaries_.conductances[static_cast<std::size_t>(j)];
      const bool contact = conductance.kind == rom::ConductanceKind::contact;
      factors_.conductance[j] = std::exp(hidden_.conductance[j] + (contact ? settled : 0.0));
      if (is_coolant(conductance.environment) && after_event()) factors_.conductance[j] *= film_after_event();
    }
  }

  const fem_offline::AffineModel& model_;
  const rom::Boundaries& boundaries_;
  RealityTruth& truth_;
  Schedule schedule_;
  Hidden hidden_;
  Inlets inlets_;
  fem_offline::FeStepper stepper_;
  rom::CorrectionFactors factors_;
  rom::BoundaryValues values_;
  rom::OperatingState operating_;
  Eigen::VectorXd rises_K_;
  std::size_t block_ = 0;
  double time_s_ = 0.0;
  double last_speed_rpm_ = 0.0;
  double started_s_ = 0.0;
};

}  // namespace

const char* name_of(TruthKind kind) {
  constexpr std::array names{"nominal",   "warm",         "cold",          "flow",  "blocked", "early_cutting",
                             "structure", "structure_10", "large_contact", "inlet", "grease",  "run_in"};
  return names[static_cast<std::size_t>(kind)];
}

std::mt19937_64 random_of(std::uint64_t seed, std::uint32_t purpose) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U), purpose};
  return std::mt19937_64(sequence);
}

const TruthSample& RealityTruth::held(double time_s) const {
  const auto k = static_cast<std::size_t>(std::floor(time_s / truth_sample_s + 1e-9));
  return samples[std::min(k, samples.size() - 1)];
}

double RealityTruth::nose_m(double time_s) const {
  const auto k = std::min(static_cast<std::size_t>(time_s / truth_sample_s), samples.size() - 2);
  return std::lerp(samples[k].nose_m, samples[k + 1].nose_m, time_s / truth_sample_s - static_cast<double>(k));
}

double RealityTruth::place_K(std::size_t place, double time_s) const {
  const auto k = std::min(static_cast<std::size_t>(time_s / truth_sample_s), samples.size() - 2);
  return std::lerp(samples[k].place_K[place], samples[k + 1].place_K[place],
                   time_s / truth_sample_s - static_cast<double>(k));
}

RealityTruth make_reality(const fem_offline::AffineModel& model, TruthKind kind, std::uint64_t seed) {
  RealityTruth truth;
  truth.kind = kind;
  truth.seed = seed;
  draw_event(truth);
  Run(model, truth).go();
  return truth;
}

}  // namespace spindle_twin::bench
