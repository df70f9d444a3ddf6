#pragma once

#include <poll.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/serve/acceptor.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/show/http_answer.hpp"
#include "firmware/show/metrics.hpp"
#include "firmware/show/show_plan.hpp"
#include "firmware/show/shown_spindle.hpp"
#include "firmware/show/slow_pages.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// Shows by HTTP what stands in the registers of each spindle, in the one thread that calls run(); the cycle thread
/// only leaves its snapshots. What is commanded behind a login goes the way of what PLCs write. Every socket is
/// non-blocking. A request has 2 s from its connection to its end and 8 KiB of room, of which 2 KiB behind its empty
/// line, an answer 5 s to be taken; the connection ends with it. Of 32 connections the oldest that is no viewer makes
/// room for a new one. An event stream gets the newest cycle, at most one event a second, only when the one before was
/// taken, and ends when that lasts 10 s; the ninth viewer gets 503. A page that takes its time is made by another
/// thread, and a command handed over by one more, one for each connection, which waits, a minute at most: then,
/// and without room, it is 503. So memory is bounded, and nobody waits for a client or a disk.
class HttpServer {
 public:
  static constexpr std::size_t most_connections = 32;
  static constexpr std::size_t most_viewers = 8;
  static constexpr std::size_t longest_request = 8192;  ///< bytes
  static constexpr std::size_t longest_body = 2048;     ///< of these

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
    Lane lane = Lane::disk;                 ///< who makes it
    std::uint32_t peer = 0;                 ///< IPv4 address, host byte order
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
  SlowPages& slow(Lane lane) { return *slow_[static_cast<std::size_t>(lane)]; }
  Page page(const HttpRequest& request);
  Page page_of(ShownSpindle& spindle, const std::string& what, const HttpRequest& request);
  Page metrics();
  Page all_healthy() const;
  Page list() const;
  std::size_t viewers() const;

  ShowPlan plan_;
  Clock& clock_;
  std::vector<std::unique_ptr<ShownSpindle>> spindles_;
  const ShownSpindle* asked_for_ = nullptr;  ///< by the last request for events
  Acceptor acceptor_;
  Descriptor wake_;
  HttpAnswerer answerer_;
  std::array<std::optional<SlowPages>, lanes> slow_;  ///< by Lane; where something needs it
  PageCommands commands_;
  HttpCounts counts_;
  const PlantCounts* plant_ = nullptr;
  std::vector<Connection> connections_;  ///< oldest first
  std::int64_t next_event_ns_ = 0;
};

}  // namespace spindle_twin::firmware
