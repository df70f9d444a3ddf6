#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "host_tools/commands/commands.hpp"
#include "host_tools/fmu/write_fmu.hpp"
#include "host_tools/network_files/matrix_files.hpp"
#include "host_tools/network_files/reduced_network.hpp"
#include "host_tools/network_files/schedule_course.hpp"
#include "host_tools/network_files/spice_netlist.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// spindle-twin export reference.rom --spice net.cir --schedule day.csv --matrices matrices --fmu reference.fmu
// spindle-twin export reference.toml --calculix ccx --freefem ff
namespace spindle_twin::host_tools {
namespace {

struct ExportOptions {
  std::string input;
  std::string netlist;
  std::string spice_nodes;
  std::string schedule;
  std::string matrices;
  std::string fmu;
  std::string calculix_directory;
  std::string freefem_directory;

  bool of_network() const { return !netlist.empty() || !matrices.empty() || !fmu.empty(); }
  bool of_description() const { return !calculix_directory.empty() || !freefem_directory.empty(); }
};

// With more nodes a reduced netlist pays: ngspice factorises in every step, which goes with the cube of their number.
constexpr std::size_t most_nodes_as_they_are = 30;
constexpr double reduction_tolerance_K = 2e-3;

void export_netlist(const rom::Network& network, const ExportOptions& options) {
  const rom::Schedule schedule = options.schedule.empty()
                                     ? rom::constant_schedule(network.boundaries, rom::seconds_per_hour)
                                     : rom::read_schedule(options.schedule, network.boundaries);
  const ScheduleCourse course = course_of(network.boundaries, schedule);
  const bool reduce =
      options.spice_nodes.empty() ? network.nodes.size() > most_nodes_as_they_are : options.spice_nodes == "reduced";
  const ReducedNetwork written =
      reduce ? reduced_network(network, course, reduction_tolerance_K) : ReducedNetwork{network};
  SpiceTarget target{std::filesystem::path(options.netlist).stem().string() + ".data", options.schedule, {}};
  std::string nodes = std::to_string(network.nodes.size()) + " nodes";
  if (written.network.nodes.size() < network.nodes.size()) {
    char error_K[16];
    std::snprintf(error_K, sizeof error_K, "%.1g", written.largest_error_K);
    nodes = std::to_string(written.network.nodes.size()) + " of " + nodes + ", within " + error_K +
            " K of the whole network along this schedule";
    target.remark = nodes;
  }
  rom::write_whole_file(options.netlist, spice_netlist(written.network, course, target));
  std::printf("ngspice netlist in %s: %s, %g s; ngspice -b %s writes %s\n", options.netlist.c_str(), nodes.c_str(),
              schedule.end_s, options.netlist.c_str(), target.data_file.c_str());
}

void export_network(const ExportOptions& options) {
  const rom::Network network = rom::read_network(options.input);
  if (!options.netlist.empty()) export_netlist(network, options);
  if (!options.matrices.empty()) {
    write_matrix_files(network, options.matrices);
    std::printf("Matrix Market files in %s: %zu nodes\n", options.matrices.c_str(), network.nodes.size());
  }
  if (!options.fmu.empty()) {
    write_fmu(network, rom::read_whole_file(options.input, rom::rom_largest_file_bytes), options.fmu);
    std::printf("FMU (FMI 2.0, co-simulation, %s) in %s\n", fmu_platform(), options.fmu.c_str());
  }
}

void run_export(const ExportOptions& options, WriteDecks* write_decks) {
  const std::string extension = std::filesystem::path(options.input).extension().string();
  if (!options.of_network() && !options.of_description()) {
    throw rom::InputError({options.input, 0}, "export",
                          write_decks != nullptr && extension == ".toml"
                              ? "needs --calculix DIR, --freefem DIR or both"
                              : "needs --spice FILE, --matrices DIR or --fmu FILE");
  }
  if (options.of_network() && (extension == ".toml" || options.of_description())) {
    throw rom::InputError({options.input, 0}, "export",
                          "--spice, --matrices and --fmu need a network file, .rom, and no deck beside them; "
                          "spindle-twin build makes a network of a description");
  }
  if (options.of_description() && extension == ".rom") {
    throw rom::InputError({options.input, 0}, "export",
                          "--calculix and --freefem need a spindle description, .toml; a network has no geometry");
  }
  if (!options.netlist.empty()) rom::check_writable(options.netlist, "--spice");
  if (!options.fmu.empty()) rom::check_writable(options.fmu, "--fmu");
  if (options.of_network()) export_network(options);
  if (options.of_description()) write_decks(options.input, options.calculix_directory, options.freefem_directory);
}

}  // namespace

void add_export(CLI::App& app, WriteDecks* write_decks) {
  const auto options = std::make_shared<ExportOptions>();
  const bool has_decks = write_decks != nullptr;
  CLI::App* command =
      app.add_subcommand("export", has_decks ? "Write a network, or the FE model behind it, for other programs to run"
                                             : "Write a network for other programs to run");
  command
      ->add_option("input", options->input,
                   has_decks ? "network file, .rom; for decks a spindle description, .toml" : "network file, .rom")
      ->required();
  CLI::Option* spice = command->add_option("--spice", options->netlist, "netlist for ngspice to write");
  command
      ->add_option("--schedule", options->schedule,
                   "what the netlist runs: CSV as for simulate; without it an hour of the operating state")
      ->needs(spice);
  command
      ->add_option("--spice-nodes", options->spice_nodes,
                   "the network's nodes in the netlist: all, or reduced to the few that follow this schedule alike; up "
                   "to 30 all, beyond reduced, which runs in a small part of the time")
      ->check(CLI::IsMember({"all", "reduced"}))
      ->needs(spice);
  command->add_option("--matrices", options->matrices, "new folder for Matrix Market files");
  command->add_option("--fmu", options->fmu, "FMU to write: FMI 2.0, co-simulation");
  if (has_decks) {
    command->add_option("--calculix", options->calculix_directory, "folder for a CalculiX deck");
    command->add_option("--freefem", options->freefem_directory, "folder for a FreeFEM deck");
  }
  command->callback([options, write_decks] { run_export(*options, write_decks); });
}

}  // namespace spindle_twin::host_tools
