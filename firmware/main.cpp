#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <thread>

#include "firmware/acquire/modbus_device.hpp"
#include "firmware/config/config.hpp"
#include "firmware/config/expect_of_sensors.hpp"
#include "firmware/config/load_network.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "firmware/keep/keeper.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "firmware/watch/single_instance.hpp"

namespace {

using namespace spindle_twin;
using namespace spindle_twin::firmware;

void log_to_stderr(const std::string& level) {
  auto logger = spdlog::stderr_logger_mt("spindle-twind");
  logger->set_level(spdlog::level::from_str(level));
  logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %l %v");
  spdlog::set_default_logger(logger);
}

/// Blocked in every thread, so that only the wait at the end of main() sees them.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

std::string signer(const rom::RomFile& file) {
  return file.signed_by ? "signed by " + rom::to_hex(*file.signed_by) : "not signed";
}

int run(const std::string& config_path, bool only_check) {
  const Config config = read_config(config_path);
  const rom::RomFile file = load_network(config.network);
  const rom::Network& network = file.network;
  const DaemonPlan plan = bind_config(config, network);
  Cycle cycle(network, plan.cycle, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  if (only_check) {
    std::printf("%s: ok, %s with %zu nodes, %s, %s\n", config_path.c_str(), network.spindle.c_str(),
                network.nodes.size(), network.certificate.cases > 0 ? "certified" : "hand-written without certificate",
                signer(file).c_str());
    std::fputs(expect_of_sensors(network, plan.cycle).c_str(), stdout);
    return 0;
  }
  const SingleInstance lock(config_path);
  log_to_stderr(config.log_level);
  const sigset_t stop_signals = block_stop_signals();

  MonotonicClock clock;
  Latest<DeviceFrame> frames;
  Latest<PlcCommand> commands;
  Latest<Snapshot> snapshots;
  ModbusServer server(plan.serve, clock, snapshots, commands);
  ModbusDevice device(plan.device, clock, frames);
  const auto history = config.history_path.empty() ? nullptr : std::make_unique<History>(config.history_path, network);

  const double unix_now_s = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  resume_from_checkpoint(config.keep, file.sha256, plan.cycle.clock_rate, unix_now_s, cycle);
  Keeper keeper(config.keep, file.sha256, plan.cycle.clock_rate, cycle);

  std::atomic<bool> stop{false};
  std::atomic<bool> stop_history{false};
  const CyclePorts ports{frames,
                         commands,
                         snapshots,
                         history ? &history->ring() : nullptr,
                         history ? &history->lost() : nullptr,
                         &keeper.remembered()};
  std::thread serving([&] { server.run(); });
  std::optional<std::thread> acquiring;
  if (!plan.device.channels.empty()) acquiring.emplace([&] { device.run(stop); });
  std::optional<std::thread> keeping;
  if (history) keeping.emplace([&] { history->run(stop_history); });
  std::thread remembering([&] { keeper.run(stop); });
  std::thread cycling([&] { run_cycle(cycle, plan.cycle, clock, ports, stop); });

  spdlog::info("{}: {} nodes, period {} s, clock rate {}, Modbus/TCP on {}:{}", network.spindle, network.nodes.size(),
               plan.cycle.period_s, plan.cycle.clock_rate, plan.serve.address, server.port());
  spdlog::info("{}: SHA-256 {}, {}", config.network.path, file.sha256, signer(file));
  if (network.certificate.cases == 0) {
    spdlog::warn("{} is hand-written: its error is unknown, the quality bit \"uncertified\" is set",
                 config.network.path);
  }
  sd_notify(0, "READY=1");

  int signal = 0;
  sigwait(&stop_signals, &signal);
  sd_notify(0, "STOPPING=1");
  stop.store(true);
  server.stop();
  cycling.join();
  if (acquiring) acquiring->join();
  serving.join();
  stop_history.store(true);
  if (keeping) keeping->join();
  remembering.join();
  keeper.keep_last(cycle);
  spdlog::info("stopped by {}", signal == SIGTERM ? "SIGTERM" : "SIGINT");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app{"spindle-twind: thermal twin of a CNC spindle, served by Modbus/TCP"};
    std::string config_path;
    bool only_check = false;
    app.add_option("CONFIG", config_path, "configuration file (TOML)")->required();
    app.add_flag("--check", only_check, "read configuration and network, say whether they fit, and end");
    app.set_version_flag("--version", SPINDLE_TWIN_VERSION);
    app.failure_message([](const CLI::App*, const CLI::Error& error) {
      return std::string("spindle-twind: ") + error.what() + "; see spindle-twind --help\n";
    });
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      constexpr int usage_error = 2;
      return app.exit(error) == 0 ? 0 : usage_error;
    }
    return run(config_path, only_check);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spindle-twind: %s\n", error.what());
    return 1;
  }
}
