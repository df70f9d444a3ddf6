#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <string>

#include "firmware/keep/read_sqlite_history.hpp"
#include "host_tools/commands/commands.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

// spindle-twin history twin.sqlite --csv day.csv
namespace spindle_twin::host_tools {
namespace {

struct HistoryOptions {
  std::string file;
  std::string csv;
  std::optional<std::int64_t> run;
};

std::string utc(double unix_s) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::gmtime(static_cast<std::time_t>(unix_s)));
}

void list(const firmware::SqliteHistoryReader& history) {
  std::printf("%12s  %-19s  %-19s  %10s  %s\n", "run", "first cycle (UTC)", "last cycle (UTC)", "cycles", "spindle");
  for (const firmware::HistoryRun& run : history.runs()) {
    std::printf("%12lld  %s  %s  %10lld  %s\n", static_cast<long long>(run.id), utc(run.first_unix_s).c_str(),
                utc(run.last_unix_s).c_str(), static_cast<long long>(run.rows), run.spindle.c_str());
  }
}

void write_rows(const firmware::SqliteHistoryReader& history, std::optional<std::int64_t> run, std::ostream& to) {
  to << fmt::format("{}\n", fmt::join(history.columns(), ","));
  history.each_row(run, [&](std::span<const double> values) {
    std::string row;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) row += ',';
      if (std::isfinite(values[i])) fmt::format_to(std::back_inserter(row), "{}", values[i]);
    }
    to << row << '\n';
  });
}

/// Row by row, as a history may be larger than the memory, into a file beside, which is renamed when it is whole; with
/// the digits that bring the same numbers back.
void write_csv(const firmware::SqliteHistoryReader& history, const HistoryOptions& options) {
  rom::check_writable(options.csv, "--csv");
  const std::string unfinished = options.csv + ".unfinished";
  try {
    std::ofstream file(unfinished, std::ios::binary | std::ios::trunc);
    write_rows(history, options.run, file);
    file.close();
    if (!file || std::rename(unfinished.c_str(), options.csv.c_str()) != 0) {
      throw rom::InputError({options.csv, 0}, "--csv", std::string("cannot be written: ") + std::strerror(errno));
    }
  } catch (...) {
    std::remove(unfinished.c_str());
    throw;
  }
}

void run_history(const HistoryOptions& options) {
  if (std::ifstream probe(options.file); !probe) {
    throw rom::InputError({options.file, 0}, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  if (!firmware::is_sqlite_file(options.file)) {
    throw rom::InputError({options.file, 0}, "", "is no history in SQLite (a history in CSV is a table already)");
  }
  const firmware::SqliteHistoryReader history(options.file);
  options.csv.empty() ? list(history) : write_csv(history, options);
}

}  // namespace

void add_history(CLI::App& app) {
  CLI::App* command = app.add_subcommand("history", "List the runs of a history in SQLite, or write one as CSV");
  const auto options = std::make_shared<HistoryOptions>();
  command->add_option("file", options->file, "history of spindle-twind whose path ends in .sqlite")->required();
  CLI::Option* csv = command->add_option("--csv", options->csv, "CSV to write, as spindle-twind would have written it");
  command->add_option("--run", options->run, "which run is written; else the last")->needs(csv);
  command->callback([options] { run_history(*options); });
}

}  // namespace spindle_twin::host_tools
