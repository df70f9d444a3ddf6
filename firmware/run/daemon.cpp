#include "firmware/run/daemon.hpp"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <future>
#include <utility>

#include "firmware/run/growth_page.hpp"
#include "firmware/run/history_page.hpp"
#include "firmware/show/scene_json.hpp"
#include "firmware/show/shown_names.hpp"
#include "firmware/watch/log.hpp"

namespace spindle_twin::firmware {

Daemon::Daemon(const DaemonConfig& config, const std::vector<std::unique_ptr<PreparedSpindle>>& spindles,
               const std::atomic<std::uint64_t>& log_lines_dropped)
    : serve_(config.serve), show_(config.show), plant_(config.plant), spindles_(spindles) {
  double slowest_s = 0.0;
  std::vector<const Pulse*> pulses;
  for (const auto& spindle : spindles) {
    runs_.push_back(std::make_unique<SpindleRun>(*spindle, clock_, log_lines_dropped));
    pulses.push_back(&runs_.back()->pulse());
    slowest_s = std::max(slowest_s, spindle->cycle_s());
  }
  manager_.emplace(std::move(pulses), slowest_s);
}

void Daemon::listen() {
  std::vector<SpindlePorts> ports;
  for (const auto& run : runs_) ports.push_back(run->ports());
  server_.emplace(serve_, clock_, ports);
  threads_.emplace_back([this] { server_->run(); });
  for (const auto& spindle : spindles_) {
    const LogName name(spindle->name);
    const CyclePlan& plan = spindle->plan.cycle;
    const std::string where =
        serve_.plain ? fmt::format("Modbus/TCP on {}:{}", serve_.address, server_->port()) : "Modbus/TCP by TLS only";
    spdlog::info("{}: {} nodes, period {} s, clock rate {}, {}{}", spindle->file.network.spindle,
                 spindle->file.network.nodes.size(), plan.period_s, plan.clock_rate, where,
                 spindle->name.empty() ? "" : fmt::format(", unit {}", spindle->unit));
  }
  if (serve_.tls) listen_by_tls();
  if (plant_.enabled) publish();
  if (show_.enabled) show();
}

void Daemon::listen_by_tls() {
  tls_.emplace(serve_, clock_, *server_);
  spdlog::info("Modbus/TCP by TLS on {}:{}, certificate valid until {}", serve_.tls->address, tls_->port(),
               tls_->valid_until());
  if (tls_->expired()) spdlog::warn("serve.tls.certificate is valid no more: clients will refuse it");
  threads_.emplace_back([this] { tls_->run(); });
}

void Daemon::show() {
  std::vector<SpindleToShow> shown;
  for (const auto& spindle : spindles_) {
    const rom::Network& network = spindle->file.network;
    auto history = history_page(spindle->config.history, network);
    const SceneSettings scene{show_.notice, static_cast<bool>(history), spindle->file.sha256,
                              spindle->plan.cycle.compensation};
    shown.push_back({spindle->name, spindle->unit, names_of(network), stale_after_s(spindle->cycle_s()),
                     scene_json(network, scene), std::move(history),
                     [this, number = shown.size()](const Order& order) { return server_->order(number, order); },
                     growth_page(spindle->config.history, network)});
  }
  shown_.emplace(show_, std::move(shown), clock_);
  if (published_) shown_->show_plant(published_->counts());
  threads_.emplace_back([this] { shown_->run(); });
  spdlog::info("http on {}:{}", show_.address, shown_->port());
}

void Daemon::publish() {
  std::vector<SpindleToPublish> published;
  for (const auto& spindle : spindles_) {
    published.push_back({spindle->name, names_of(spindle->file.network), stale_after_s(spindle->cycle_s())});
  }
  published_.emplace(plant_, published, clock_);
  publishes_ = std::thread([this] { published_->run(); });
  spdlog::info("plant: {}/{} publishes each {:g} s to {}:{}", plant_.group, plant_.node, plant_.period_s, plant_.host,
               plant_.port);
}

SpindleRun::ShownTo Daemon::shown_to(std::size_t spindle) {
  return {shown_ ? &shown_->tap(spindle) : nullptr, published_ ? &published_->tap(spindle) : nullptr};
}

void Daemon::start() {
  for (const auto& run : runs_) run->recall();
  listen();
  // One whose pause was long keeps no other waiting.
  std::vector<std::future<void>> begun;
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    begun.push_back(std::async(std::launch::async, [this, r] { runs_[r]->begin(shown_to(r)); }));
  }
  threads_.emplace_back([this] { manager_->run(stop_); });
  for (std::future<void>& each : begun) each.get();
  malloc_trim(0);  // what reading the networks took
}

void Daemon::end() {
  stop_.store(true);
  for (const auto& run : runs_) run->end();
}

void Daemon::stop() {
  end();
  if (tls_) tls_->stop();
  if (server_) server_->stop();
  if (shown_) shown_->stop();
  if (published_) published_->stop();
  for (std::thread& thread : std::exchange(threads_, {})) thread.join();
  for (const auto& run : runs_) run->stop();
  if (publishes_.joinable()) publishes_.join();
  tls_.reset();
  shown_.reset();  // its threads may hand orders to the server
  server_.reset();
}

}  // namespace spindle_twin::firmware
