#pragma once

#include <poll.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/serve/descriptor.hpp"
#include "firmware/show/http_answer.hpp"
#include "firmware/show/metrics.hpp"
#include "firmware/show/show_plan.hpp"
#include "firmware/show/shown_spindle.hpp"
#include "firmware/show/slow_pages.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Shows by HTTP what stands in the registers of each spindle, read-only, in the one thread that calls run(); the cycle
/// thread only leaves its snapshots. Every socket is non-blocking. A request has 2 s from its connection to its empty
/// line and 8 KiB of room, an answer 5 s to be taken; the connection ends with it. Of 32 connections the oldest that is
/// no viewer makes room for a new one. An event stream gets the newest cycle, at most one event a second, only when the
/// one before was taken, and ends when that lasts 10 s; the ninth viewer gets 503. A page that takes its time is made
/// by another thread, 8 at once, while its connection waits, a minute at most: then, and without room, it is 503. So
/// memory is bounded, and nobody waits for a client or a disk.
class HttpServer {
 public:
  static constexpr std::size_t most_connections = 32;
  static constexpr std::size_t most_viewers = 8;
  static constexpr std::size_t longest_request = 8192;  ///< bytes

  /// Listens. One spindle without a name is at routes, several with names at routes_of_several. Throws rom::InputError
  /// naming address and port if listening is not possible.
  HttpServer(const ShowPlan& plan, std::vector<SpindleToShow> spindles, Clock& clock);

  int port() const;
  /// Shown by /metrics from now on; must outlive this. Before run().
  void show_plant(const PlantCounts& counts) { plant_ = &counts; }
  /// Of the spindle of this number; for its cycle.
  Latest<Snapshot>& tap(std::size_t spindle) { return spindles_[spindle]->tap(); }
  /// Until stop(); a failing poll() is tried again.
  void run();
  /// Ends run(), open event streams or not; from any thread.
  void stop();

 private:
  enum class Stage { asking, waiting, answering, watching, leaving };
  struct Connection {
    Descriptor socket;
    Stage stage = Stage::asking;
    std::int64_t deadline_ns = 0;           ///< of the stage; of a viewer only while it owes us a read
    std::string in;                         ///< the request; of one that waits until its page is made
    std::uint64_t number = 0;               ///< of that page
    std::string out;                        ///< not sent yet
    const ShownSpindle* spindle = nullptr;  ///< of a viewer
    std::uint64_t seen = 0;                 ///< by a viewer: the last cycle that it was sent
    bool open = true;
  };

  bool wait(std::vector<pollfd>& polled);
  int poll_timeout_ms() const;
  void accept_all();
  bool make_room();
  void look_at(Connection& connection, short events);
  void take(Connection& connection);
  void answer(Connection& connection, std::optional<Page> made = std::nullopt);
  void answer_waiting();
  void forget(const Connection& connection);
  void end_late(Connection& connection);
  void begin_answer(Connection& connection, HttpAnswer answer);
  void flush(Connection& connection);
  void send_events();
  void renew();
  Page page(const std::string& path);
  Page page_of(ShownSpindle& spindle, const std::string& what);
  Page metrics();
  Page all_healthy() const;
  Page list() const;
  std::size_t viewers() const;

  ShowPlan plan_;
  Clock& clock_;
  std::vector<std::unique_ptr<ShownSpindle>> spindles_;
  const ShownSpindle* asked_for_ = nullptr;  ///< by the last request for events
  Descriptor listener_;
  Descriptor wake_;
  HttpAnswerer answerer_;
  std::optional<SlowPages> slow_;  ///< where a spindle has such pages
  HttpCounts counts_;
  const PlantCounts* plant_ = nullptr;
  std::vector<Connection> connections_;  ///< oldest first
  std::int64_t next_event_ns_ = 0;
  std::int64_t accept_from_ns_ = 0;  ///< no descriptor is free until then
  LogLimit strangers_, troubles_;
};

}  // namespace spindle_twin::firmware
