#include <malloc.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "fem_offline/look/section_outlines.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/choose_size.hpp"
#include "fem_offline/reduce/error_limit.hpp"
#include "fem_offline/reduce/mesh_error.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/stage_clock.hpp"
#include "fem_offline/reduce/verify.hpp"
#include "fem_offline/reduce/worst_search.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/offline/accuracy_options.hpp"
#include "host_tools/commands/offline/certificate_report.hpp"
#include "host_tools/commands/offline/missed_tolerance.hpp"
#include "host_tools/commands/offline/progress.hpp"
#include "host_tools/commands/offline/read_model.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "host_tools/inspection/certificate_json.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

struct BuildArguments {
  std::string spindle_path;
  std::string output_path;
  fem_offline::ReduceOptions reduce;
  std::string tolerance = "0.03K,0.015um,0.2K";
  std::string box = "whole";
  bool fixed_size = false;
  std::uint32_t certificate_cases = 20;
  int search_cases = 0;
  bool json = false;
  Plausibility plausibility;
};

struct Reduced {
  rom::Network network;
  std::optional<fem_offline::SizeChoice> choice;    ///< its own network has no certificate; none where --nodes is given
  std::optional<fem_offline::Reduction> reduction;  ///< that larger ones are made of; none where --nodes is given
};

/// What all stages share.
struct Work {
  const BuildArguments& arguments;
  const fem_offline::FeModel& model;
  const fem_offline::Progress& progress;
  fem_offline::ReduceReport& report;
};

nlohmann::ordered_json tried_json(const std::vector<fem_offline::TriedSize>& tried) {
  nlohmann::ordered_json result = nlohmann::ordered_json::array();
  for (const fem_offline::TriedSize& size : tried) {
    result.push_back({{"nodes", size.nodes},
                      {"key_points_K", size.reached.key_points_K},
                      {"deformations_um", size.reached.deformations_um},
                      {"part_max_K", size.reached.part_max_K}});
  }
  return result;
}

void print_json(const BuildArguments& arguments, const rom::Network& network,
                const std::optional<fem_offline::SizeChoice>& choice, const std::optional<ToleranceVerdict>& verdict,
                const fem_offline::ReduceReport& report) {
  nlohmann::ordered_json result;
  result["file"] = arguments.output_path;
  result["spindle"] = network.spindle;
  result["nodes"] = network.nodes.size();
  result["fe_unknowns"] = report.full_unknowns;
  result["rich_states"] = report.rich_states;
  result["condition"] = report.condition;
  result["seed"] = arguments.reduce.seed;
  for (const fem_offline::StageTime& stage : report.stages) {
    result["stages_s"][stage.stage] = stage.seconds;
    result["stages_processor_s"][stage.stage] = stage.processor_s;
  }
  if (choice) result["sizes_tried"] = tried_json(choice->tried);
  if (verdict) result["tolerance"] = tolerance_json(*verdict);
  result["certificate"] = certificate_to_json(network);
  std::printf("%s\n", result.dump(2).c_str());
}

void print_tried(const std::vector<fem_offline::TriedSize>& tried) {
  std::printf(
      "  sizes tried: %.0f %% of all histories err less (with %.0f %% confidence, by %d of them)\n"
      "  %8s %14s %16s %14s\n",
      100.0 * fem_offline::size_choice_content, 100.0 * fem_offline::limit_confidence,
      fem_offline::size_choice_histories, "nodes", "key points, K", "deformations, um", "part maxima, K");
  for (const fem_offline::TriedSize& size : tried) {
    std::printf("  %8d %14.4f %16.4f %14.4f\n", size.nodes, size.reached.key_points_K, size.reached.deformations_um,
                size.reached.part_max_K);
  }
}

void print_table(const BuildArguments& arguments, const rom::Network& network,
                 const std::optional<fem_offline::SizeChoice>& choice, const fem_offline::ReduceReport& report) {
  std::printf("%s: %zu nodes from %d FE unknowns, condition %.1f\n", arguments.output_path.c_str(),
              network.nodes.size(), report.full_unknowns, report.condition);
  std::printf("  %-24s %8s %16s\n", "", "s", "s of processors");
  double seconds = 0.0, processor_s = 0.0;
  for (const fem_offline::StageTime& stage : report.stages) {
    std::printf("  %-24s %8.1f %16.1f\n", stage.stage.c_str(), stage.seconds, stage.processor_s);
    seconds += stage.seconds;
    processor_s += stage.processor_s;
  }
  std::printf("  %-24s %8.1f %16.1f\n", "all", seconds, processor_s);
  if (choice) print_tried(choice->tried);
  const rom::Certificate& certificate = network.certificate;
  if (certificate.cases == 0) {
    std::printf("  no certificate measured\n");
    return;
  }
  print_certificate(network);
}

/// For a nested basis that holds every size up to the largest that build grows to.
fem_offline::ReduceOptions of_any_size(const fem_offline::AffineModel& model, fem_offline::ReduceOptions options) {
  options.nodes = std::min(fem_offline::largest_size, static_cast<int>(model.capacity_J_per_K.rows()));
  return options;
}

/// The network of the wanted size, or the smallest that keeps the tolerance, or the one that comes nearest to it.
Reduced reduce(const BuildArguments& arguments, const fem_offline::AffineModel& model,
               const fem_offline::ReduceOptions& options, const fem_offline::Progress& progress,
               fem_offline::ReduceReport& report) {
  if (arguments.fixed_size) return {fem_offline::reduce_model(model, options, progress, &report), {}, {}};
  const fem_offline::ReduceOptions any_size = of_any_size(model, options);
  fem_offline::Reduction reduction(model, any_size, progress, &report);
  const fem_offline::SizeSearch search{parse_tolerance(arguments.tolerance)};
  fem_offline::SizeChoice choice = fem_offline::choose_size(model, reduction, search, any_size, progress, &report);
  rom::Network network = choice.network;
  return {std::move(network), std::move(choice), std::move(reduction)};
}

/// Runs a stage, and notes what it took.
template <typename Make>
void timed(const Work& work, const std::string& stage, const Make& make) {
  malloc_trim(0);  // what the threads of the stages before have freed: these stages hold most
  fem_offline::StageClock clock(&work.report, work.progress);
  make();
  clock.finish(stage);
}

/// The certificate's errors and limits. `of`: behind the name of the stage.
void certify(const Work& work, const fem_offline::ReduceOptions& reduce_options, rom::Network& network,
             const std::string& of = {}) {
  const BuildArguments& arguments = work.arguments;
  const fem_offline::AffineModel& model = work.model.affine();
  timed(work, "verification" + of, [&] {
    fem_offline::VerifyOptions options;
    options.cases = arguments.certificate_cases;
    options.seed = reduce_options.seed;
    options.threads = reduce_options.threads;
    options.drive.box = reduce_options.box;
    const fem_offline::Tolerance wanted = parse_tolerance(arguments.tolerance);
    network.certificate =
        arguments.fixed_size || static_cast<int>(arguments.certificate_cases) < fem_offline::fewest_limiting_cases
            ? fem_offline::verify_network(network, model, options, work.progress).certificate
            : fem_offline::verify_until(network, model, options, wanted, work.progress).certificate;
    network.certificate.mesh_size_m = work.model.description().mesh.element_size_m;
  });
}

/// What else stands in the certificate of the network that is written: the worst found, and the mesh's own error.
void complete_certificate(const Work& work, const fem_offline::ReduceOptions& reduce_options, rom::Network& network) {
  const BuildArguments& arguments = work.arguments;
  if (arguments.search_cases > 0) {
    timed(work, "search for the worst", [&] {
      fem_offline::WorstSearchOptions search{arguments.search_cases, reduce_options.seed, reduce_options.threads,
                                             reduce_options.box};
      const fem_offline::WorstFound found =
          fem_offline::search_worst(network, work.model.affine(), search, work.progress);
      network.certificate.searched = static_cast<std::uint32_t>(found.cases);
      network.certificate.worst_found = found.errors();
    });
  }
  timed(work, "mesh error", [&] {
    try {
      fem_offline::measure_mesh_error(work.model, work.progress, network.certificate);
    } catch (const rom::InputError& error) {  // no reason to lose the network
      std::fprintf(stderr, "spindle-twin: no mesh error in the certificate, no finer mesh can be made: %s\n",
                   error.what());
    }
  });
}

std::vector<fem_offline::MissedOutput> missed_by(const Work& work, const rom::Network& network) {
  if (network.certificate.limit_rule.content <= 0.0) return {};
  return fem_offline::missed_limits(work.model.affine(), network.certificate,
                                    parse_tolerance(work.arguments.tolerance));
}

/// Replaces a network whose certificate misses the tolerance by a larger one, if that misses it less. Each is certified
/// by cases of its own seed, for those of the one before have asked for it.
void grow(const Work& work, const fem_offline::ReduceOptions& reduce_options, Reduced& reduced) {
  std::vector<fem_offline::MissedOutput> missed = missed_by(work, reduced.network);
  if (!reduced.reduction || missed.empty()) return;
  const fem_offline::Reduction& reduction = *reduced.reduction;
  const int largest = std::min(fem_offline::largest_size, reduction.most_nodes());
  std::string of;
  fem_offline::GrowSteps steps;
  steps.network = [&](int nodes) {
    of = ": " + std::to_string(nodes) + " nodes";
    rom::Network network;
    work.progress("grown" + of, 0.0);
    timed(work, "grown" + of, [&] {
      fem_offline::ReduceReport own;
      network = reduction.network(nodes, &own, work.progress);
      work.report.condition = own.condition;
    });
    return network;
  };
  steps.certify = [&](rom::Network& network, int round) {
    fem_offline::ReduceOptions own = reduce_options;
    own.seed += static_cast<std::uint64_t>(round);
    certify(work, own, network, of);
    return missed_by(work, network);
  };
  reduced.network = fem_offline::grow_until_kept(std::move(reduced.network), std::move(missed), largest, steps);
  reduced.choice->network = reduced.network;
}

void run(BuildArguments& arguments) {
  rom::check_writable(arguments.output_path, "--output");
  mallopt(M_ARENA_MAX, 1);  // what one thread has freed another can have: threads hold large matrices in turn
  ProgressDisplay display;
  const auto progress = [&](const std::string& stage, double fraction) { display.show(stage, fraction); };

  progress("FE model", 0.0);
  fem_offline::ReduceReport report;
  fem_offline::StageClock clock(&report, progress);
  fem_offline::FeModel model = read_model(arguments.spindle_path, arguments.plausibility);
  model.forget_growth();
  clock.finish("FE model");
  if (model.affine().deformations.empty()) {
    throw rom::InputError({arguments.spindle_path, 0}, "deformation",
                          "a network needs at least one deformation output, the nose first");
  }
  fem_offline::ReduceOptions options = arguments.reduce;
  options.box = named_box(arguments.box, model.affine().boundaries.reference_speed_rpm);
  Reduced reduced = reduce(arguments, model.affine(), options, progress, report);
  rom::Network& network = reduced.network;
  const Work work{arguments, model, progress, report};
  if (arguments.certificate_cases > 0) {
    certify(work, options, network);
    grow(work, options, reduced);
    reduced.reduction.reset();  // what follows needs the memory
    complete_certificate(work, options, network);
  }
  network.outlines = fem_offline::section_outlines(model.description(), model.section());
  rom::write_network(network, arguments.output_path);
  std::optional<ToleranceVerdict> verdict;
  if (reduced.choice) {
    verdict =
        judge_tolerance(*reduced.choice, model.affine(), network.certificate, parse_tolerance(arguments.tolerance));
  }
  arguments.json ? print_json(arguments, network, reduced.choice, verdict, report)
                 : print_table(arguments, network, reduced.choice, report);
  if (!verdict) return;
  const std::string text = tolerance_text(*verdict, arguments.box);
  if (!text.empty()) {
    std::fprintf(stderr, "spindle-twin: %s is written with %d nodes%s%s\n", arguments.output_path.c_str(),
                 verdict->nodes, verdict->kept() ? "; " : ", but ", text.c_str());
  }
  if (!verdict->kept()) throw CLI::RuntimeError(tolerance_missed);
}

}  // namespace

void add_build(CLI::App& app) {
  auto arguments = std::make_shared<BuildArguments>();
  arguments->reduce.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  CLI::App* command = app.add_subcommand("build", "Build the nodal network of a spindle description");
  command->add_option("spindle", arguments->spindle_path, "spindle description, TOML")->required();
  command->add_option("-o,--output", arguments->output_path, "network file to write, .rom")->required();
  CLI::Option* nodes =
      command->add_option("--nodes", arguments->reduce.nodes, "nodes of the network, in place of --tolerance")
          ->check(CLI::Range(2, most_nodes));
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "largest errors of key points, deformations and part maxima: the smallest network that keeps them. "
                   "Where none does, the nearest is written, with exit code 3")
      ->capture_default_str()
      ->excludes(nodes)
      ->check([](const std::string& text) {
        parse_tolerance(text);
        return std::string();
      });
  command->add_option("--box", arguments->box, "factors on contacts and films that the network is made for")
      ->check(CLI::IsMember({"whole", "small"}))
      ->capture_default_str();
  command->add_option("--seed", arguments->reduce.seed, "seed of the random parameter sets and certificate cases")
      ->capture_default_str();
  command
      ->add_option(
          "--certificate-cases", arguments->certificate_cases,
          "random cases behind the certificate in the file; 0 for none. With --tolerance up to 59 as long as a "
          "limit exceeds it and no case does")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      ->add_option("--search", arguments->search_cases,
                   "jumps to look through for the worst error in the box, for the certificate; 0 for none")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command->add_option("--threads", arguments->reduce.threads, "threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  arguments->plausibility.add_to(*command);
  command->add_flag("--json", arguments->json, "as JSON");
  command->callback([arguments, nodes] {
    arguments->fixed_size = nodes->count() > 0;
    run(*arguments);
  });
}

}  // namespace spindle_twin::host_tools
