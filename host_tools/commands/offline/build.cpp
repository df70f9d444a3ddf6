#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "fem_offline/look/section_outlines.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "host_tools/commands/check_output.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/certificate_json.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

struct BuildArguments {
  std::string spindle_path;
  std::string output_path;
  fem_offline::ReduceOptions reduce;
  std::uint32_t certificate_cases = 6;
  bool json = false;
};

void print_json(const BuildArguments& arguments, const rom::Network& network, const fem_offline::ReduceReport& report) {
  nlohmann::ordered_json result;
  result["file"] = arguments.output_path;
  result["spindle"] = network.spindle;
  result["nodes"] = network.nodes.size();
  result["fe_unknowns"] = report.full_unknowns;
  result["rich_states"] = report.rich_states;
  result["condition"] = report.condition;
  result["seed"] = arguments.reduce.seed;
  for (const fem_offline::StageTime& stage : report.stages) result["stages_s"][stage.stage] = stage.seconds;
  const rom::Certificate& certificate = network.certificate;
  result["certificate"] = {{"cases", certificate.cases}, {"seed", certificate.seed}};
  result["certificate"]["worst"] = to_json(certificate.worst);
  result["certificate"]["median"] = to_json(certificate.median);
  std::printf("%s\n", result.dump(2).c_str());
}

void print_table(const BuildArguments& arguments, const rom::Network& network,
                 const fem_offline::ReduceReport& report) {
  std::printf("%s: %zu nodes from %d FE unknowns, condition %.1f\n", arguments.output_path.c_str(),
              network.nodes.size(), report.full_unknowns, report.condition);
  for (const fem_offline::StageTime& stage : report.stages) {
    std::printf("  %-18s %6.1f s\n", stage.stage.c_str(), stage.seconds);
  }
  const rom::Certificate& certificate = network.certificate;
  if (certificate.cases == 0) {
    std::printf("  no certificate measured\n");
    return;
  }
  std::printf("  certificate, worst of %u cases: key points %.3f K, nose %.3f um, part maximum %.3f K\n",
              certificate.cases, certificate.worst.key_points_K, certificate.worst.nose_um,
              certificate.worst.part_max_K);
}

void run(const BuildArguments& arguments) {
  if (rom::is_by_hand(arguments.spindle_path)) {
    throw rom::InputError({arguments.spindle_path, 0}, "node",
                          "this is a network written by hand, for `spindle-twin assemble`");
  }
  check_output(arguments.output_path, "--output");
  ProgressDisplay display;
  const auto progress = [&](const std::string& stage, double fraction) { display.show(stage, fraction); };
  const auto timed = [](fem_offline::ReduceReport& report, const std::string& stage, const auto& work) {
    const auto started = std::chrono::steady_clock::now();
    work();
    report.stages.push_back({stage, std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count()});
  };

  fem_offline::ReduceReport before, report;
  std::unique_ptr<fem_offline::FeModel> model;
  progress("FE model", 0.0);
  timed(before, "FE model",
        [&] { model = std::make_unique<fem_offline::FeModel>(fem_offline::build_fe_model(arguments.spindle_path)); });
  progress("FE model", 1.0);
  if (model->affine().deformations.empty()) {
    throw rom::InputError({arguments.spindle_path, 0}, "deformation",
                          "a network needs at least one deformation output, the nose first");
  }
  rom::Network network = fem_offline::reduce_model(model->affine(), arguments.reduce, progress, &report);
  report.stages.insert(report.stages.begin(), before.stages.begin(), before.stages.end());
  if (arguments.certificate_cases > 0) {
    fem_offline::VerifyOptions options;
    options.cases = arguments.certificate_cases;
    options.seed = arguments.reduce.seed;
    options.threads = arguments.reduce.threads;
    options.box = arguments.reduce.box;
    timed(report, "verification", [&] {
      network.certificate = fem_offline::verify_network(network, model->affine(), options, progress).certificate;
    });
    progress("verification", 1.0);
  }
  network.outlines = fem_offline::section_outlines(model->description(), model->section());
  rom::write_network(network, arguments.output_path);
  arguments.json ? print_json(arguments, network, report) : print_table(arguments, network, report);
}

}  // namespace

void add_build(CLI::App& app) {
  auto arguments = std::make_shared<BuildArguments>();
  arguments->reduce.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  CLI::App* command = app.add_subcommand("build", "Build the nodal network of a spindle description");
  command->add_option("spindle", arguments->spindle_path, "spindle description, TOML")->required();
  command->add_option("-o,--output", arguments->output_path, "network file to write, .rom")->required();
  command->add_option("--nodes", arguments->reduce.nodes, "nodes of the network")
      ->check(CLI::Range(2, 400))
      ->capture_default_str();
  command->add_option("--seed", arguments->reduce.seed, "seed of the random parameter sets and certificate cases")
      ->capture_default_str();
  command
      ->add_option("--certificate-cases", arguments->certificate_cases,
                   "random cases behind the certificate in the file; 0 for none")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_option("--threads", arguments->reduce.threads, "threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace spindle_twin::host_tools
