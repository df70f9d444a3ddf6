#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "firmware/config/daemon_config.hpp"
#include "firmware/plant/plant_publisher.hpp"
#include "firmware/run/spindle_run.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "firmware/serve/tls_front.hpp"
#include "firmware/show/http_server.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/service_manager.hpp"

namespace spindle_twin::firmware {

/// All spindles, and what shows them: Modbus, HTTP, the plant network and the service manager.
class Daemon {
 public:
  /// What is prepared must outlive this.
  Daemon(const DaemonConfig& config, const std::vector<std::unique_ptr<PreparedSpindle>>& spindles,
         const std::atomic<std::uint64_t>& log_lines_dropped);
  ~Daemon() { stop(); }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Clients are answered before the cycles run: a long pause since the checkpoint takes seconds to go through. Gives
  /// up where end() is called meanwhile, in another thread. Throws what could not be started.
  void start();
  /// No work is begun any more, and start() returns soon. Any thread.
  void end();
  /// Ends all threads and keeps what the cycles know. Not while start() runs.
  void stop();

 private:
  void listen();
  void listen_by_tls();
  void show();
  void publish();
  SpindleRun::ShownTo shown_to(std::size_t spindle);

  const ServePlan serve_;
  const ShowPlan show_;
  const PlantPlan plant_;
  const std::vector<std::unique_ptr<PreparedSpindle>>& spindles_;
  MonotonicClock clock_;
  std::vector<std::unique_ptr<SpindleRun>> runs_;
  std::optional<ModbusServer> server_;
  std::optional<TlsFront> tls_;
  std::optional<PlantPublisher> published_;
  std::optional<HttpServer> shown_;
  std::optional<ServiceManager> manager_;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
  std::thread publishes_;  ///< ends last: a name server may delay it
};

}  // namespace spindle_twin::firmware
