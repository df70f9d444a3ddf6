#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/acquire/device_thread.hpp"
#include "firmware/config/config.hpp"
#include "firmware/config/expect_of_sensors.hpp"
#include "firmware/config/load_network.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/event_log.hpp"
#include "firmware/keep/history_writer.hpp"
#include "firmware/keep/keeper.hpp"
#include "firmware/keep/order_keeper.hpp"
#include "firmware/keep/state_files.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "firmware/show/http_server.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log.hpp"
#include "firmware/watch/memory_lock.hpp"
#include "firmware/watch/service_manager.hpp"

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

/// The files that this configuration has written.
std::vector<std::string> state_files(const Config& config) {
  std::vector<std::string> files;
  for (const std::string& path :
       {config.keep.orders_path, config.keep.checkpoint_path, config.history.path, config.keep.parameters_path}) {
    if (!path.empty()) files.push_back(path);
  }
  return files;
}

std::string signer(const rom::RomFile& file) {
  return file.signed_by ? "signed by " + rom::to_hex(*file.signed_by) : "not signed";
}

/// A number that passed for itself may still be none together with the others, or with this network.
void make_cycle(const Config& config, const rom::Network& network, const CyclePlan& plan, std::optional<Cycle>& cycle) {
  try {
    cycle.emplace(network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  } catch (const std::exception& error) {
    throw rom::InputError({config.path, 0}, "correction, health", error.what());
  }
}

/// All parts and the threads that they run in.
class Daemon {
 public:
  Daemon(const Config& config, const rom::RomFile& file, const DaemonPlan& plan, Cycle& cycle, Troubles& troubles)
      : config_(config),
        file_(file),
        plan_(plan),
        cycle_(cycle),
        troubles_(troubles),
        order_keeper_(config.keep.orders_path, file.sha256, desk_, troubles),
        events_(file.network) {
    for (std::size_t d = 0; d < plan.devices.size(); ++d) {
      if (plan.devices[d].channels.empty()) continue;
      devices_.push_back(std::make_unique<DeviceThread>(plan.devices[d], d, clock_, readings_.of(d)));
    }
    if (!config.history.path.empty()) history_ = make_history(config.history, file.network, troubles);
  }
  ~Daemon() { stop(); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Clients are answered before the cycle runs: a long pause since the checkpoint takes seconds to go through. Gives
  /// up where end() is called meanwhile, in another thread.
  void start() {
    const std::optional<Checkpoint> checkpoint = look_for_checkpoint(config_.keep);
    const StandingOrders orders = recall_orders(config_.keep.orders_path, file_.sha256, checkpoint);
    order_keeper_.begin_with(orders);
    server_.emplace(plan_.serve, clock_, snapshots_, signals_, desk_);
    run([this] { server_->run(); });
    spdlog::info("{}: {} nodes, period {} s, clock rate {}, Modbus/TCP on {}:{}", file_.network.spindle,
                 file_.network.nodes.size(), plan_.cycle.period_s, plan_.cycle.clock_rate, plan_.serve.address,
                 server_->port());
    if (plan_.show.enabled) {
      shown_.emplace(plan_.show, names_of(file_.network), clock_);
      run([this] { shown_->run(); });
      spdlog::info("http on {}:{}", plan_.show.address, shown_->port());
    }
    const Resumed resumed = resume_from_checkpoint(
        config_.keep, checkpoint, {file_.sha256, plan_.cycle.clock_rate, unix_now_s()}, cycle_, &stop_);
    if (resumed == Resumed::given_up) return;
    cycle_.stand_by_orders(orders);
    keeper_.emplace(config_.keep, file_.sha256, plan_.cycle.clock_rate, cycle_, &order_keeper_, &troubles_);

    for (const auto& device : devices_) run([this, &device] { device->run(stop_); });
    if (history_) after_cycle([this] { history_->run(stop_after_cycle_); });
    after_cycle([this] { order_keeper_.run(stop_after_cycle_); });
    after_cycle([this] { events_.run(stop_after_cycle_); });
    run([this] { keeper_->run(stop_); });
    run([this] { manager_.run(stop_); });
    run([this] { run_cycle(cycle_, plan_.cycle, clock_, ports(), stop_); });
  }

  /// No work is begun any more, and start() returns soon.
  void end() { stop_.store(true); }

  /// Ends all threads and keeps what the cycle knows. Not while start() runs.
  void stop() {
    end();
    if (!server_) return;
    server_->stop();
    if (shown_) shown_->stop();
    for (std::thread& thread : threads_) thread.join();
    stop_after_cycle_.store(true);
    for (std::thread& thread : after_cycle_) thread.join();
    if (keeper_) keeper_->keep_last(cycle_);
    server_.reset();
  }

 private:
  template <class Work>
  void run(Work work) {
    threads_.emplace_back(std::move(work));
  }
  template <class Work>
  void after_cycle(Work work) {
    after_cycle_.emplace_back(std::move(work));
  }
  CyclePorts ports() {
    return {readings_,
            signals_,
            snapshots_,
            history_ ? &history_->ring() : nullptr,
            history_ ? &history_->lost() : nullptr,
            &keeper_->remembered(),
            &desk_,
            &events_.tap(),
            &troubles_,
            &pulse_,
            shown_ ? &shown_->tap() : nullptr};
  }

  const Config& config_;
  const rom::RomFile& file_;
  const DaemonPlan& plan_;
  Cycle& cycle_;
  Troubles& troubles_;
  MonotonicClock clock_;
  DeviceInbox readings_;
  Latest<PlcSignals> signals_;
  Latest<Snapshot> snapshots_;
  OrderDesk desk_;
  OrderKeeper order_keeper_;
  std::vector<std::unique_ptr<DeviceThread>> devices_;
  EventLog events_;
  std::unique_ptr<HistoryWriter> history_;
  std::optional<ModbusServer> server_;
  std::optional<HttpServer> shown_;
  std::optional<Keeper> keeper_;
  Pulse pulse_;
  ServiceManager manager_{pulse_, plan_.cycle.period_s / plan_.cycle.clock_rate};
  std::atomic<bool> stop_{false};
  std::atomic<bool> stop_after_cycle_{false};
  std::vector<std::thread> threads_;
  std::vector<std::thread> after_cycle_;  ///< until nothing more comes from the cycle
};

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

int run(const std::string& config_path, bool only_check) {
  const Config config = read_config(config_path);
  const rom::RomFile file = load_network(config.network);
  const rom::Network& network = file.network;
  const DaemonPlan plan = bind_config(config, network);
  std::optional<Cycle> made;
  make_cycle(config, network, plan.cycle, made);
  Cycle& cycle = *made;
  if (only_check) {
    std::printf("%s: ok, %s with %zu nodes, %s, %s\n", config_path.c_str(), network.spindle.c_str(),
                network.nodes.size(), network.certificate.cases > 0 ? "certified" : "hand-written without certificate",
                signer(file).c_str());
    std::fputs(expect_of_sensors(network, plan.cycle).c_str(), stdout);
    return 0;
  }
  const std::vector<std::string> files = state_files(config);
  const StateLock lock(files);
  const sigset_t signals = block_signals();
  Troubles troubles;
  const Log log(config.log_level, STDERR_FILENO, troubles.log_lines_dropped);
  lock_memory(lockable_bytes());
  for (const std::string& path : files) {
    if (const int removed = remove_left_overs(path)) spdlog::info("{}: {} unfinished files removed", path, removed);
  }
  Daemon daemon(config, file, plan, cycle, troubles);
  spdlog::info("{}: SHA-256 {}, {}", config.network.path, file.sha256, signer(file));
  if (network.certificate.cases == 0) {
    spdlog::warn("{} is hand-written: its error is unknown, the quality bit \"uncertified\" is set",
                 config.network.path);
  }
  const int signal = run_until_signal(daemon, signals);
  spdlog::info("stopped by {}", name_of(signal));
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
