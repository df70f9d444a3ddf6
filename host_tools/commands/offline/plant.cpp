#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <thread>

#include "fem_offline/mesh/section.hpp"
#include "fem_offline/model/build_model.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/virtual_spindle/plant_server.hpp"
#include "host_tools/virtual_spindle/plant_truth.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

std::atomic<bool> stop_wanted{false};

void stop(int) { stop_wanted = true; }

struct PlantOptions {  // NOLINT(public-members): one for each option of the command line
  std::string spindle;
  std::string address = "127.0.0.1";
  int port = 0;
  double rate = 1.0;
  double step_s = 1.0;
  double element_size_mm = 5.0;
  double duration_s = 0.0;
  double log_every_s = 1.0;
  std::string schedule;
  std::string log;
  std::vector<std::string> heat_factors, contact_factors, film_factors, offsets_K;
  std::string contact_spread;
  HiddenTruth truth;
  bool wait_for_client = false;
};

std::vector<NamedValue> named(const std::vector<std::string>& texts, const std::string& option) {
  std::vector<NamedValue> values;
  for (const std::string& text : texts) values.push_back(parse_named_value(text, option));
  return values;
}

/// Carries the plant along its clock until stopped or done; returns how far it ever fell behind, in model seconds.
double run_clock(Plant& plant, PlantServer& server, const rom::Boundaries& boundaries, const PlantOptions& options,
                 std::ostream* log) {
  using Clock = std::chrono::steady_clock;
  double log_due_s = 0.0;
  const auto record = [&] {
    server.publish(encode_plant(boundaries, plant.snapshot()));
    if (log == nullptr || plant.snapshot().time_s < log_due_s - 1e-9) return;
    write_plant_row(*log, plant.snapshot());
    log->flush();
    log_due_s += options.log_every_s;
  };
  record();
  while (options.wait_for_client && !server.was_read() && !stop_wanted) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const Clock::time_point start = Clock::now();
  double furthest_behind_s = 0.0;
  while (!stop_wanted && (options.duration_s <= 0.0 || plant.snapshot().time_s < options.duration_s - 1e-9)) {
    const double due_s = plant.snapshot().time_s + options.step_s;
    const double wall_s = std::chrono::duration<double>(Clock::now() - start).count();
    const double behind_s = wall_s * options.rate - due_s;
    if (behind_s < 0.0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(-behind_s / options.rate, 0.1)));
      continue;
    }
    furthest_behind_s = std::max(furthest_behind_s, behind_s);
    plant.advance(options.step_s);
    record();
  }
  return furthest_behind_s;
}

void run_plant(PlantOptions options) {
  if (!(options.rate > 0.0) || !std::isfinite(options.rate)) throw rom::InputError({}, "--rate", "must be above 0");
  if (!(options.step_s > 0.0)) throw rom::InputError({}, "--step-s", "must be above 0 s");
  if (!(options.element_size_mm > 0.0)) throw rom::InputError({}, "--element-size-mm", "must be above 0 mm");
  if (!(options.duration_s >= 0.0)) throw rom::InputError({}, "--duration", "must be at least 0 s");
  if (!(options.log_every_s > 0.0)) throw rom::InputError({}, "--log-every-s", "must be above 0 s");
  if (!(options.truth.noise_K >= 0.0)) throw rom::InputError({}, "--noise-K", "must be at least 0 K");
  options.truth.heat_factors = named(options.heat_factors, "--heat-factor");
  options.truth.contact_factors = named(options.contact_factors, "--contact-factor");
  options.truth.film_factors = named(options.film_factors, "--film-factor");
  options.truth.offsets_K = named(options.offsets_K, "--offset-K");
  if (!options.contact_spread.empty()) options.truth.contact_spread = parse_contact_spread(options.contact_spread);

  PlantServer server(options.address, options.port);
  fem_offline::Spindle spindle = fem_offline::read_spindle(options.spindle);
  spindle.mesh.element_size_m = 1e-3 * options.element_size_mm;
  const fem_offline::FeModel fe(spindle, fem_offline::build_section(spindle));
  const fem_offline::AffineModel& model = fe.affine();
  Plant plant(model, options.truth,
              options.schedule.empty() ? rom::constant_schedule(model.boundaries, 1.0)
                                       : rom::read_schedule(options.schedule, model.boundaries));
  std::ofstream log;
  if (!options.log.empty()) {
    log.open(options.log);
    if (!log) throw rom::InputError({options.log, 0}, "", "cannot be opened for writing");
    write_plant_header(log, model);
  }

  std::signal(SIGTERM, stop);
  std::signal(SIGINT, stop);
  std::printf("simulated spindle '%s': %td unknowns, no hardware behind it\n", spindle.name.c_str(),
              model.capacity_J_per_K.rows());
  std::printf("serving Modbus/TCP on %s:%d, model time %g times real time\n", options.address.c_str(), options.port,
              options.rate);
  std::fflush(stdout);

  double behind_s = 0.0;
  std::exception_ptr failure;
  std::atomic<bool> done{false};
  std::thread clock([&] {
    try {
      behind_s = run_clock(plant, server, model.boundaries, options, options.log.empty() ? nullptr : &log);
    } catch (...) {
      failure = std::current_exception();
    }
    done = true;
  });
  server.serve(done);
  clock.join();
  if (failure) std::rethrow_exception(failure);
  std::printf("stopped at model time %.0f s; furthest behind its clock: %.1f s\n", plant.snapshot().time_s, behind_s);
}

}  // namespace

void add_plant(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("plant", "Run a simulated spindle (FE model) as a Modbus/TCP data-acquisition device");
  const auto options = std::make_shared<PlantOptions>();
  command->add_option("spindle", options->spindle, "spindle description, TOML")->required();
  command->add_option("--port", options->port, "TCP port")->required()->check(CLI::Range(1, 65535));
  command->add_option("--address", options->address, "address to listen on")->capture_default_str();
  command->add_option("--rate", options->rate, "model seconds per second")->capture_default_str();
  command->add_option("--schedule", options->schedule, "drive cycle, CSV; without: the description's operating state");
  command->add_option("--heat-factor", options->heat_factors, "SOURCE=x or all=x, on the description's heat");
  command->add_option("--contact-factor", options->contact_factors, "CONTACT=x or all=x, on the conductance");
  command->add_option("--contact-spread", options->contact_spread,
                      "SEED:F, every contact log-uniform between 1/F and F");
  command->add_option("--film-factor", options->film_factors, "FILM=x or all=x, on the coefficient");
  command->add_flag("--joint-law", options->truth.joint_law, "contacts with a fit follow their pressure");
  command->add_option("--noise-K", options->truth.noise_K, "standard deviation of a reading")->capture_default_str();
  command->add_option("--offset-K", options->offsets_K, "KEYPOINT=x or all=x, constant error of a reading");
  command->add_option("--seed", options->truth.seed, "of the noise")->capture_default_str();
  command->add_option("--element-size-mm", options->element_size_mm, "mesh size, apart from the twin's")
      ->capture_default_str();
  command->add_option("--step-s", options->step_s, "model time per step")->capture_default_str();
  command->add_option("--duration", options->duration_s, "stop after this model time, s; 0: until SIGTERM");
  command->add_flag("--wait-for-client", options->wait_for_client, "hold the model at time 0 until the first request");
  command->add_option("--log", options->log, "CSV of the truth");
  command->add_option("--log-every-s", options->log_every_s, "model time between its lines")->capture_default_str();
  command->callback([options] { run_plant(*options); });
}

}  // namespace spindle_twin::host_tools
