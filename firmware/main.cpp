#include <spdlog/fmt/chrono.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "firmware/config/daemon_config.hpp"
#include "firmware/config/expect_of_sensors.hpp"
#include "firmware/config/implausible_plan.hpp"
#include "firmware/keep/state_files.hpp"
#include "firmware/login/password.hpp"
#include "firmware/run/daemon.hpp"
#include "firmware/run/prepare.hpp"
#include "firmware/watch/log.hpp"
#include "firmware/watch/memory_lock.hpp"
#include "rom/units.hpp"

namespace {

using namespace spindle_twin;
using namespace spindle_twin::firmware;

const char* name_of(int signal) {
  switch (signal) {
    case SIGTERM:
      return "SIGTERM";
    case SIGINT:
      return "SIGINT";
    case SIGQUIT:
      return "SIGQUIT";
    case SIGHUP:
      return "SIGHUP";
    case SIGUSR1:
      return "SIGUSR1";
    default:
      return "SIGUSR2";
  }
}

/// Blocked in every thread, so that only the wait at the end of a run sees them.
sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int each : {SIGTERM, SIGINT, SIGQUIT, SIGHUP, SIGUSR1, SIGUSR2}) sigaddset(&signals, each);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);  // who reads the log may go away
  return signals;
}

/// Returns the signal that ends the daemon; the others are said and change nothing.
int wait_for_the_end(const sigset_t& signals) {
  while (true) {
    int signal = 0;
    sigwait(&signals, &signal);
    if (signal == SIGTERM || signal == SIGINT || signal == SIGQUIT) return signal;
    spdlog::info("{} changes nothing; the configuration is read at the start only", name_of(signal));
  }
}

/// Until a signal ends it. The start is in a thread of its own, so that a signal is heard meanwhile. Throws what the
/// start threw.
int run_until_signal(Daemon& daemon, const sigset_t& signals) {
  std::exception_ptr failure;
  std::thread starter([&] {
    try {
      daemon.start();
    } catch (...) {
      failure = std::current_exception();
      kill(getpid(), SIGTERM);
    }
  });
  const int signal = wait_for_the_end(signals);
  sd_notify(0, "STOPPING=1");
  daemon.end();
  starter.join();
  daemon.stop();
  if (failure) std::rethrow_exception(failure);
  return signal;
}

/// Of when a calibration is, and what it promises; empty without one.
std::string calibration_text(const Config& config) {
  if (!config.calibration) return {};
  const correction::Calibration& calibration = config.calibration->calibration;
  return fmt::format(
      "{}: calibrated {:%Y-%m-%d} from {:.1f} h of test, which promised {:.2f} um (1 sigma) without a sensor{}",
      config.calibration->path, fmt::gmtime(static_cast<std::time_t>(calibration.made_unix_s)),
      calibration.tested_s / rom::seconds_per_hour, calibration.promised_m * rom::um_per_m,
      calibration.accepted ? "" : "; written although it missed its limits");
}

void say_ok(const std::string& config_path, const PreparedSpindle& spindle) {
  const rom::Network& network = spindle.file.network;
  const std::string who =
      spindle.name.empty() ? "" : " " + spindle.name + " (unit " + std::to_string(spindle.unit) + "):";
  std::printf("%s:%s ok, %s with %zu nodes, %s, %s\n", config_path.c_str(), who.c_str(), network.spindle.c_str(),
              network.nodes.size(), network.certificate.cases > 0 ? "certified" : "hand-written without certificate",
              signer(spindle.file).c_str());
  if (spindle.config.calibration) std::printf("%s\n", calibration_text(spindle.config).c_str());
  std::fputs(expect_of_sensors(network, spindle.plan.cycle).c_str(), stdout);
}

/// One line for each on stderr; strict: throws the first.
void warn_of_implausible(const PreparedSpindle& spindle, bool strict) {
  for (const rom::InputError& each : implausible_plan(spindle.config, spindle.file.network, spindle.plan.cycle)) {
    if (strict) throw each;
    std::fprintf(stderr, "warning: %s\n", each.what());
  }
  for (const rom::InputError& each : unwritable_files(spindle.config)) {
    std::fprintf(stderr, "warning: %s\n", each.what());
  }
}

void log_network(const PreparedSpindle& spindle) {
  const LogName name(spindle.name);
  const std::string& path = spindle.config.network.path;
  spdlog::info("{}: SHA-256 {}, {}", path, spindle.file.sha256, signer(spindle.file));
  if (spindle.config.calibration) spdlog::info("{}", calibration_text(spindle.config));
  if (!spindle.note.empty()) spdlog::error("{}", spindle.note);
  if (spindle.file.network.certificate.cases == 0) {
    spdlog::warn("{} is hand-written: its error is unknown, the quality bit \"uncertified\" is set", path);
  }
}

int print_account(const std::string& user) {
  if (!is_user_name(user)) {
    throw std::runtime_error("--hash-password: NAME must be 1 to 32 letters, digits, '_', '-' or '.'");
  }
  std::printf("%s:%s\n", user.c_str(), hash_password(ask_for_password()).c_str());
  return 0;
}

/// What only a check asks for.
struct Check {
  bool only = false;
  bool strict = false;
};

int run(const std::string& config_path, Check check) {
  const DaemonConfig config = read_daemon_config(config_path);
  std::vector<std::unique_ptr<PreparedSpindle>> spindles;
  std::vector<std::string> files;
  for (const ConfiguredSpindle& spindle : config.spindles) {
    spindles.push_back(prepare(spindle));
    for (const std::string& file : state_files(spindle.config)) files.push_back(file);
  }
  if (check.only) {
    for (const auto& spindle : spindles) {
      warn_of_implausible(*spindle, check.strict);
      say_ok(config_path, *spindle);
    }
    return 0;
  }
  const StateLock lock(files);
  const sigset_t signals = block_signals();
  std::atomic<std::uint64_t> log_lines_dropped{0};
  const Log log(config.log_level, STDERR_FILENO, log_lines_dropped);
  lock_memory(lockable_bytes());
  Daemon daemon(config, spindles, log_lines_dropped);
  for (const auto& spindle : spindles) log_network(*spindle);
  const int signal = run_until_signal(daemon, signals);
  spdlog::info("stopped by {}", name_of(signal));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app{"spindle-twind: thermal twin of a CNC spindle, served by Modbus/TCP"};
    std::string config_path;
    std::string user;
    Check check;
    CLI::Option* const config = app.add_option("CONFIG", config_path, "configuration file (TOML)");
    CLI::Option* const hash = app.add_option(
        "--hash-password", user,
        "read a password from the terminal or stdin, print the line of this NAME for http.commands.accounts, and end");
    hash->type_name("NAME")->excludes(config);
    CLI::Option* const only_check =
        app.add_flag("--check", check.only, "read configuration and network, say whether they fit, and end");
    app.add_flag("--strict", check.strict,
                 "with --check: refuse implausible constants, heats and films, else warned of")
        ->needs(only_check);
    app.set_version_flag("--version", SPINDLE_TWIN_VERSION);
    app.failure_message([](const CLI::App*, const CLI::Error& error) {
      return std::string("spindle-twind: ") + error.what() + "; see spindle-twind --help\n";
    });
    try {
      app.parse(argc, argv);
      if (config->empty() && hash->empty()) throw CLI::RequiredError("CONFIG");
    } catch (const CLI::ParseError& error) {
      constexpr int usage_error = 2;
      return app.exit(error) == 0 ? 0 : usage_error;
    }
    return hash->empty() ? run(config_path, check) : print_account(user);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spindle-twind: %s\n", error.what());
    return 1;
  }
}
