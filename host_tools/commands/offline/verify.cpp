#include "fem_offline/reduce/verify.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "fem_offline/model/build_model.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/offline/certificate_json.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

struct VerifyArguments {
  std::string network_path;
  std::string spindle_path;
  fem_offline::VerifyOptions options;
  bool json = false;
};

nlohmann::ordered_json by_name(const std::vector<fem_offline::NamedError>& errors) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (const fem_offline::NamedError& error : errors) result[error.name] = error.worst;
  return result;
}

void print_json(const rom::Network& network, const fem_offline::VerifyReport& report) {
  nlohmann::ordered_json result;
  result["nodes"] = network.nodes.size();
  result["cases"] = report.certificate.cases;
  result["seed"] = report.certificate.seed;
  result["worst"] = to_json(report.certificate.worst);
  result["median"] = to_json(report.certificate.median);
  result["worst_of_each"] = {{"key_points_K", by_name(report.key_points_K)},
                             {"part_max_K", by_name(report.part_max_K)},
                             {"deformations_um", by_name(report.deformations_um)}};
  std::printf("%s\n", result.dump(2).c_str());
}

void print_table(const rom::Network& network, const fem_offline::VerifyReport& report) {
  const rom::Certificate& certificate = report.certificate;
  std::printf("%zu nodes against the FE model, %u random cases of 1 to 2 h, seed %llu\n", network.nodes.size(),
              certificate.cases, static_cast<unsigned long long>(certificate.seed));
  std::printf("                 %10s %10s\n", "worst", "median");
  const auto line = [](const char* name, double worst, double median, const char* unit) {
    std::printf("  %-14s %10.4f %10.4f %s\n", name, worst, median, unit);
  };
  line("key points", certificate.worst.key_points_K, certificate.median.key_points_K, "K");
  line("nose", certificate.worst.nose_um, certificate.median.nose_um, "um");
  line("part maximum", certificate.worst.part_max_K, certificate.median.part_max_K, "K");
  const auto each = [](const char* title, const std::vector<fem_offline::NamedError>& errors, const char* unit) {
    std::printf("  worst of each %s\n", title);
    for (const fem_offline::NamedError& error : errors) {
      std::printf("    %-24s %10.4f %s\n", error.name.c_str(), error.worst, unit);
    }
  };
  each("key point", report.key_points_K, "K");
  each("part maximum", report.part_max_K, "K");
  each("deformation", report.deformations_um, "um");
}

void run(const VerifyArguments& arguments) {
  const rom::Network network = rom::read_network(arguments.network_path);
  const fem_offline::FeModel model = fem_offline::build_fe_model(arguments.spindle_path);
  if (network.description_hash != model.affine().description_hash) {
    throw rom::InputError({arguments.network_path, 0}, "description_hash",
                          "was built from another description than " + arguments.spindle_path + " (" +
                              network.description_hash.substr(0, 12) + " against " +
                              model.affine().description_hash.substr(0, 12) +
                              "); run 'spindle-twin build' on this description first");
  }
  ProgressDisplay display;
  const fem_offline::VerifyReport report =
      fem_offline::verify_network(network, model.affine(), arguments.options,
                                  [&](const std::string& stage, double fraction) { display.show(stage, fraction); });
  display.show("verification", 1.0);
  arguments.json ? print_json(network, report) : print_table(network, report);
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
  command->add_option("--seed", arguments->options.seed, "seed; case k depends on seed and k alone")
      ->capture_default_str();
  command->add_option("--threads", arguments->options.threads, "threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--fe-step", arguments->options.fe_step_s, "longest time step of the FE solution, s")
      ->check(finite_range(0.01, 32.0, "0.01 to 32 s"))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace spindle_twin::host_tools
