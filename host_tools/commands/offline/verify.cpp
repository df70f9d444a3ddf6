#include "fem_offline/reduce/verify.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/error_limit.hpp"
#include "fem_offline/reduce/network_checks.hpp"
#include "fem_offline/reduce/worst_search.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/offline/accuracy_options.hpp"
#include "host_tools/commands/offline/certificate_report.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "host_tools/commands/offline/read_model.hpp"
#include "host_tools/commands/offline/worst_report.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "host_tools/inspection/certificate_json.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

/// Enough to balance; they cost as much as a case of the comparison.
constexpr std::uint32_t most_balanced_cases = 3;

struct VerifyArguments {
  std::string network_path;
  std::string spindle_path;
  fem_offline::VerifyOptions options;  ///< without the seed
  std::optional<std::uint64_t> seed;
  std::string box = "whole";
  int search_cases = 0;
  bool json = false;
  Plausibility plausibility;
};

nlohmann::ordered_json checks_json(const fem_offline::NetworkChecks& checks) {
  return {{"passed", checks.passed()},
          {"asymmetry", checks.asymmetry},
          {"capacity_definite", checks.capacity_definite},
          {"conduction_definite", checks.conduction_definite},
          {"row_sum", checks.row_sum},
          {"exchange_sum", checks.exchange_sum},
          {"source_sum", checks.source_sum},
          {"largest_rank", checks.largest_rank},
          {"heat_balance", checks.heat_balance}};
}

void print_checks(const fem_offline::NetworkChecks& checks) {
  const auto line = [](const char* what, double is, double most) {
    std::printf("  %-52s %8.1e  %s\n", what, is, is <= most ? "ok" : "FAILED");
  };
  line("asymmetry of C and K0", checks.asymmetry, 1e-12);
  std::printf("  %-52s %8s  %s\n", "C and K positive definite", "",
              checks.capacity_definite && checks.conduction_definite ? "ok" : "FAILED");
  line("rows of K0 sum to zero", checks.row_sum, 1e-12);
  line("exchange between bodies sums to zero", checks.exchange_sum, 1e-12);
  line("sources give all their heat", checks.source_sum, 1e-12);
  line("heat balance of a drive cycle, share of heat put in", checks.heat_balance, fem_offline::most_heat_unbalanced);
}

nlohmann::ordered_json limits_json(const fem_offline::LimitCheck& limits) {
  nlohmann::ordered_json above = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < limits.outputs.size(); ++i) above[limits.outputs[i]] = limits.above[i];
  return {{"cases", limits.cases}, {"share_above", limits.share()}, {"cases_above", above}};
}

void print_limits(const fem_offline::LimitCheck& limits, bool are_its_own) {
  if (limits.outputs.empty()) return;
  const auto most = std::max_element(limits.above.begin(), limits.above.end());
  std::printf(
      "  the file's limits are exceeded in %.2f %% of %d cases x %zu outputs; most often that of the %s, in %d%s\n",
      100.0 * limits.share(), limits.cases, limits.outputs.size(),
      limits.outputs[static_cast<std::size_t>(most - limits.above.begin())].c_str(), *most,
      are_its_own ? "; but these are the certificate's own cases" : "");
}

void print_json(const rom::Network& network, const fem_offline::LimitCheck& limits,
                const fem_offline::NetworkChecks& checks, const std::optional<fem_offline::WorstFound>& found) {
  nlohmann::ordered_json result = {{"nodes", network.nodes.size()}};
  result.update(certificate_to_json(network));
  if (!limits.outputs.empty()) result["limits_of_file"] = limits_json(limits);
  if (found) result["worst_found"] = worst_found_json(*found, network.boundaries);
  result["checks"] = checks_json(checks);
  std::printf("%s\n", result.dump(2).c_str());
}

fem_offline::WorstFound search(const VerifyArguments& arguments, const rom::Network& network,
                               const fem_offline::FeModel& model, const fem_offline::VerifyOptions& options,
                               ProgressDisplay& display) {
  const fem_offline::WorstSearchOptions search{arguments.search_cases, options.seed, options.threads,
                                               options.drive.box};
  return fem_offline::search_worst(network, model.affine(), search,
                                   [&](const std::string& stage, double fraction) { display.show(stage, fraction); });
}

void run(VerifyArguments& arguments) {
  const rom::Network network = rom::read_network(arguments.network_path);
  const fem_offline::FeModel model = read_model(arguments.spindle_path, arguments.plausibility);
  if (network.description_hash != model.affine().description_hash) {
    throw rom::InputError({arguments.network_path, 0}, "description_hash",
                          "was built from another description than " + arguments.spindle_path + " (" +
                              network.description_hash.substr(0, 12) + " against " +
                              model.affine().description_hash.substr(0, 12) +
                              "); run 'spindle-twin build' on this description first");
  }
  fem_offline::VerifyOptions options = arguments.options;
  options.seed = arguments.seed.value_or(network.certificate.seed + 1);
  options.drive.box = named_box(arguments.box, network.boundaries.reference_speed_rpm);
  ProgressDisplay display;
  const fem_offline::VerifyReport report =
      fem_offline::verify_network(network, model.affine(), options,
                                  [&](const std::string& stage, double fraction) { display.show(stage, fraction); });
  display.show("verification", 1.0);
  std::vector<fem_offline::DriveCase> drives;
  for (std::uint32_t index = 0; index < std::min(options.cases, most_balanced_cases); ++index) {
    drives.push_back(fem_offline::random_case(network.boundaries, options.seed, index, options.drive));
  }
  const fem_offline::NetworkChecks checks = fem_offline::check_laws(network, drives);
  display.show("checks", 1.0);
  const fem_offline::LimitCheck limits = fem_offline::check_limits(network, report.errors);
  rom::Network measured = network;
  measured.certificate = report.certificate;
  measured.certificate.mesh_size_m = model.description().mesh.element_size_m;
  std::optional<fem_offline::WorstFound> found;
  if (arguments.search_cases > 0) found = search(arguments, network, model, options, display);
  if (arguments.json) {
    print_json(measured, limits, checks, found);
  } else {
    std::printf("%zu nodes against the FE model of %u unknowns, %s box%s\n", network.nodes.size(),
                measured.certificate.fe_unknowns, arguments.box.c_str(),
                options.drive.drift ? ", contacts and films drifting by up to 2x per 10 min" : "");
    print_certificate(measured);
    print_limits(limits, options.seed == network.certificate.seed);
    if (found) print_worst_found(*found, network.boundaries);
    print_checks(checks);
  }
  if (!checks.passed()) throw std::runtime_error(arguments.network_path + ": the network breaks a law of its kind");
}

}  // namespace

void add_verify(CLI::App& app) {
  auto arguments = std::make_shared<VerifyArguments>();
  arguments->options.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  CLI::App* command = app.add_subcommand("verify", "Compare a network against the FE model on random cases");
  command->add_option("network", arguments->network_path, "network file, .rom")->required();
  command->add_option("spindle", arguments->spindle_path, "spindle description that it was built from, TOML")
      ->required();
  command->add_option("--cases", arguments->options.cases, "random cases")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option(
      "--seed", arguments->seed,
      "seed; case k depends on seed and k alone. Without it one more than the certificate's, whose cases "
      "are no test of it");
  command->add_option("--threads", arguments->options.threads, "threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command
      ->add_option("--fe-step", arguments->options.fe_step_s,
                   "FE solution by steps in time, the longest in s; without it by projection where that pays")
      ->check(finite_range(0.01, 128.0, "0.01 to 128 s"));
  command->add_flag("--drift", arguments->options.drive.drift,
                    "contacts and films move during the run, by up to a factor of two in ten minutes");
  command->add_option("--box", arguments->box, "factors on contacts and films that cases are drawn from")
      ->check(CLI::IsMember({"whole", "small"}))
      ->capture_default_str();
  command
      ->add_option("--search", arguments->search_cases,
                   "jumps to look through for the worst error in the box, besides the random cases; 0 for none")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  arguments->plausibility.add_to(*command);
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace spindle_twin::host_tools
