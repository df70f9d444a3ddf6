#include "firmware/show/http_server.hpp"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "firmware/serve/listen.hpp"
#include "firmware/show/page_files.hpp"
#include "firmware/show/routes.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr std::int64_t ask_within_ns = 2 * ns_per_s;
constexpr std::int64_t made_within_ns = 60 * ns_per_s;
constexpr std::int64_t take_within_ns = 5 * ns_per_s;
constexpr std::int64_t leave_within_ns = 1 * ns_per_s;
constexpr std::int64_t viewer_takes_within_ns = 10 * ns_per_s;
static_assert(SlowPages::most_at_once == HttpServer::most_connections, "a viewer is not refused because of others");
constexpr std::size_t before_connections = 2 + lanes;  ///< in what is polled
constexpr int send_buffer_bytes = 32768;  ///< what a client that reads nothing may hold of the system's memory
constexpr int look_for_cycles_ms = 50;    ///< while somebody watches

template <class Routes>
std::string index_text(const Routes& routes) {
  std::size_t widest = 0;
  for (const Route& route : routes) widest = std::max(widest, std::string_view(route.path).size());
  std::string text = "spindle-twind " SPINDLE_TWIN_VERSION "\n\n";
  for (const Route& route : routes) text += fmt::format("{:<{}}{}\n", route.path, widest + 2, route.doc);
  return text;
}

}  // namespace

HttpServer::HttpServer(const ShowPlan& plan, std::vector<SpindleToShow> spindles, Clock& clock)
    : plan_(plan),
      clock_(clock),
      acceptor_(Descriptor(listen_on(plan.address, plan.port, "http")), plan.allow, clock, "http", "http.allow"),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      answerer_([this](const HttpRequest& request) { return page(request); }, plan.names),
      commands_(plan.commands, clock) {
  if (wake_.get() < 0) throw std::bad_alloc();
  connections_.reserve(most_connections);
  for (SpindleToShow& spindle : spindles) spindles_.push_back(std::make_unique<ShownSpindle>(std::move(spindle)));
  if (std::any_of(spindles_.begin(), spindles_.end(), [](const auto& each) { return each->has_history(); })) {
    slow_[static_cast<std::size_t>(Lane::disk)].emplace();
  }
  if (commands_.enabled()) slow_[static_cast<std::size_t>(Lane::commands)].emplace();
}

int HttpServer::port() const { return acceptor_.port(); }

void HttpServer::stop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);
  for (auto& each : slow_) {
    if (each) each->stop();
  }
}

std::size_t HttpServer::viewers() const {
  return static_cast<std::size_t>(std::count_if(connections_.begin(), connections_.end(),
                                                [](const Connection& each) { return each.stage == Stage::watching; }));
}

int HttpServer::poll_timeout_ms() const {
  if (viewers() > 0) return look_for_cycles_ms;
  std::int64_t first_ns = acceptor_.rests_until_ns();
  for (const Connection& connection : connections_) {
    if (first_ns == 0 || connection.deadline_ns < first_ns) first_ns = connection.deadline_ns;
  }
  if (first_ns == 0) return -1;
  return static_cast<int>(std::max<std::int64_t>(0, (first_ns - clock_.now_ns()) / 1'000'000 + 1));
}

/// Fills `polled`: wake, listener, slow pages, connections. False when it is time to stop.
bool HttpServer::wait(std::vector<pollfd>& polled) {
  polled.clear();
  polled.push_back({wake_.get(), POLLIN, 0});
  polled.push_back(acceptor_.polled());
  for (const auto& each : slow_) polled.push_back({each ? each->ready() : -1, POLLIN, 0});
  for (const Connection& connection : connections_) {
    int events = connection.stage == Stage::answering ? 0 : POLLIN;
    if (!connection.out.empty()) events |= POLLOUT;
    polled.push_back({connection.socket.get(), static_cast<short>(events), 0});
  }
  if (poll(polled.data(), polled.size(), poll_timeout_ms()) < 0) {
    for (pollfd& each : polled) each.revents = 0;
    if (errno == EINTR) return true;
    acceptor_.rest_behind_failed_poll(errno);
  }
  return polled[0].revents == 0;
}

void HttpServer::run() {
  std::vector<pollfd> polled;
  polled.reserve(before_connections + most_connections);
  while (wait(polled)) {
    for (std::size_t c = 0; c < connections_.size(); ++c) {
      const short events = polled[before_connections + c].revents;
      if (events != 0) look_at(connections_[c], events);
    }
    if (polled[2].revents != 0 || polled[3].revents != 0) answer_waiting();
    send_events();
    const std::int64_t now_ns = clock_.now_ns();
    for (Connection& connection : connections_) {
      if (connection.open && connection.deadline_ns != 0 && now_ns >= connection.deadline_ns) end_late(connection);
      if (!connection.open) forget(connection);
    }
    std::erase_if(connections_, [](const Connection& connection) { return !connection.open; });
    if (polled[1].revents != 0) accept_all();
  }
}

void HttpServer::end_late(Connection& connection) {
  if (connection.stage == Stage::waiting) {
    forget(connection);
    answer(connection, Page{503, "application/json", error_json("this page could not be made in time")});
    return;
  }
  connection.open = false;
  if (connection.stage != Stage::leaving) ++counts_.dropped;
}

void HttpServer::accept_all() {
  while (auto client = acceptor_.next()) {
    if (!make_room()) continue;
    setsockopt(client->socket.get(), SOL_SOCKET, SO_SNDBUF, &send_buffer_bytes, sizeof send_buffer_bytes);
    Connection& connection = connections_.emplace_back();
    connection.socket = std::move(client->socket);
    connection.deadline_ns = clock_.now_ns() + ask_within_ns;
    connection.peer = client->host;
  }
}

/// The oldest connection that is no viewer goes; there is always one, as there is less room for viewers.
bool HttpServer::make_room() {
  if (connections_.size() < most_connections) return true;
  const auto oldest = std::find_if(connections_.begin(), connections_.end(),
                                   [](const Connection& each) { return each.stage != Stage::watching; });
  if (oldest == connections_.end()) return false;
  if (oldest->stage != Stage::leaving) ++counts_.dropped;
  forget(*oldest);
  connections_.erase(oldest);
  return true;
}

void HttpServer::look_at(Connection& connection, short events) {
  if ((events & (POLLERR | POLLNVAL)) != 0) {
    connection.open = false;
    return;
  }
  if ((events & POLLOUT) != 0) flush(connection);
  if (!connection.open) return;
  if (connection.stage == Stage::answering) {
    if ((events & POLLHUP) != 0) connection.open = false;
    return;
  }
  if ((events & (POLLIN | POLLHUP)) != 0) take(connection);
}

/// Of who has asked already nothing more is read than that it is gone.
void HttpServer::take(Connection& connection) {
  std::array<char, 4096> part{};
  const ssize_t got = recv(connection.socket.get(), part.data(), part.size(), 0);
  if (got <= 0) {
    connection.open = got < 0 && (errno == EAGAIN || errno == EINTR);
    return;
  }
  if (connection.stage != Stage::asking) return;
  constexpr std::string_view empty_line = "\r\n\r\n";
  connection.in.append(part.data(), static_cast<std::size_t>(got));
  const std::size_t end = connection.in.find(empty_line);
  const bool has_head = end != std::string::npos;
  const std::size_t head = has_head ? end + empty_line.size() : connection.in.size();
  const std::size_t body = has_head ? HttpAnswerer::body_bytes(std::string_view(connection.in).substr(0, head)) : 0;
  if (head > longest_request || body > longest_body) {
    begin_answer(connection, HttpAnswerer::too_long(body > longest_body));
  } else if (has_head && connection.in.size() >= head + body) {
    connection.in.resize(head + body);
    answer(connection);
  }
}

/// At once, or where the page takes its time when that is `made`.
void HttpServer::answer(Connection& connection, std::optional<Page> made) {
  HttpAnswer answer = answerer_.answer(connection.in, std::move(made), connection.peer);
  if (answer.is_stream) connection.spindle = asked_for_;
  if (!answer.work) return begin_answer(connection, std::move(answer));
  connection.lane = answer.lane;
  if (const std::optional<std::uint64_t> number = slow(answer.lane).ask(std::move(answer.work))) {
    connection.number = *number;
    connection.stage = Stage::waiting;
    connection.deadline_ns = clock_.now_ns() + made_within_ns;
  } else {
    const std::string reason = fmt::format("{} such pages are asked for already", SlowPages::most_at_once);
    begin_answer(connection, answerer_.answer(connection.in, Page{503, "application/json", error_json(reason)}));
  }
}

void HttpServer::answer_waiting() {
  for (const Lane lane : {Lane::disk, Lane::commands}) {
    if (!slow_[static_cast<std::size_t>(lane)]) continue;
    for (SlowPages::Made& made : slow(lane).take()) {
      const auto asked = std::find_if(connections_.begin(), connections_.end(), [&](const Connection& each) {
        return each.open && each.stage == Stage::waiting && each.lane == lane && each.number == made.number;
      });
      if (asked != connections_.end()) answer(*asked, std::move(made.page));
    }
  }
}

/// Nobody waits for its page any more.
void HttpServer::forget(const Connection& connection) {
  if (connection.stage == Stage::waiting) slow(connection.lane).forget(connection.number);
}

void HttpServer::begin_answer(Connection& connection, HttpAnswer answer) {
  ++counts_.answers[answer.status];
  std::string().swap(connection.in);
  connection.out = std::move(answer.bytes);
  connection.stage = answer.is_stream ? Stage::watching : Stage::answering;
  connection.deadline_ns = clock_.now_ns() + (answer.is_stream ? viewer_takes_within_ns : take_within_ns);
  flush(connection);
}

void HttpServer::flush(Connection& connection) {
  while (!connection.out.empty()) {
    const ssize_t sent = send(connection.socket.get(), connection.out.data(), connection.out.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) {
      connection.open = sent < 0 && errno == EAGAIN;
      return;
    }
    connection.out.erase(0, static_cast<std::size_t>(sent));
  }
  if (connection.stage == Stage::watching) {
    connection.deadline_ns = 0;
  } else if (connection.stage == Stage::answering) {
    // What the client still sends would turn the end into a reset, which may overtake the answer.
    shutdown(connection.socket.get(), SHUT_WR);
    connection.stage = Stage::leaving;
    connection.deadline_ns = clock_.now_ns() + leave_within_ns;
  }
}

void HttpServer::send_events() {
  const std::int64_t now_ns = clock_.now_ns();
  if (viewers() == 0 || now_ns < next_event_ns_) return;
  renew();
  const auto is_due = [](const Connection& each) {
    return each.open && each.stage == Stage::watching && each.out.empty() && each.seen != each.spindle->sequence();
  };
  if (std::none_of(connections_.begin(), connections_.end(), is_due)) return;
  // In step with the cycles: counted from when it was due, so that looking late does not add up.
  next_event_ns_ = now_ns - next_event_ns_ < ns_per_s ? next_event_ns_ + ns_per_s : now_ns + ns_per_s;
  for (const auto& spindle : spindles_) {
    std::string event;
    for (Connection& connection : connections_) {
      if (connection.spindle != spindle.get() || !is_due(connection)) continue;
      if (event.empty()) {
        event = fmt::format("id: {}\nevent: state\ndata: {}\n\n", spindle->sequence(), spindle->state());
      }
      connection.seen = spindle->sequence();
      connection.out = event;
      connection.deadline_ns = now_ns + viewer_takes_within_ns;
      flush(connection);
    }
  }
}

void HttpServer::renew() {
  for (const auto& spindle : spindles_) spindle->renew(clock_.now_ns());
}

Page HttpServer::page(const HttpRequest& request) {
  const std::string& path = request.path;
  if (path == "/api/v1/login") return commands_.log_in(request);
  if (path == "/api/v1/logout") return commands_.log_out(request);
  if (path == "/api/v1/session") return commands_.session(request);
  const std::string command = "/command";
  if (request.is_post && !path.ends_with(command)) return {405};
  const bool is_one = spindles_.size() == 1 && spindles_[0]->name().empty();
  if (std::optional<Page> file = page_file(path)) return std::move(*file);
  if (path == "/api/v1/words") return {200, "application/json", words_json() + "\n"};
  if (path == "/routes") {
    return {200, "text/plain; charset=utf-8", is_one ? index_text(routes) : index_text(routes_of_several)};
  }
  renew();
  if (path == "/metrics") return metrics();
  if (path == "/healthz") return all_healthy();
  if (path == "/api/v1/spindles") return list();
  const std::string of_one = "/api/v1/";
  if (is_one) return path.starts_with(of_one) ? page_of(*spindles_[0], path.substr(of_one.size()), request) : Page{404};
  for (const auto& spindle : spindles_) {
    const std::string folder = "/api/v1/spindles/" + spindle->name() + "/";
    if (!path.starts_with(folder)) continue;
    const std::string what = path.substr(folder.size());
    return what == "healthz" ? spindle->health(clock_.now_ns()) : page_of(*spindle, what, request);
  }
  return {404};
}

Page HttpServer::page_of(ShownSpindle& spindle, const std::string& what, const HttpRequest& request) {
  if (what == "command") return commands_.command(request, spindle.commanded());
  if (what == "state") return {200, "application/json", spindle.state() + "\n"};
  if (what == "scene") return {200, "application/json", spindle.scene() + "\n"};
  const std::string history = "history/";
  if (what.starts_with(history)) return spindle.history(what.substr(history.size()));
  if (what == "growth") return spindle.growth();
  if (what != "events") return {404};
  if (viewers() >= most_viewers) return {503, "application/json", error_json("there are 8 viewers already")};
  asked_for_ = &spindle;
  return {200, "text/event-stream", "", true};
}

Page HttpServer::metrics() {
  counts_.connections = connections_.size();
  counts_.viewers = viewers();
  std::vector<ShownRegisters> all;
  for (const auto& spindle : spindles_) all.push_back(spindle->registers());
  return {200, "text/plain; version=0.0.4; charset=utf-8", metrics_text(all, counts_, plant_)};
}

/// The first that is not healthy says why.
Page HttpServer::all_healthy() const {
  Page page;
  for (const auto& spindle : spindles_) {
    page = spindle->health(clock_.now_ns());
    if (page.status != 200) break;
  }
  return page;
}

Page HttpServer::list() const {
  std::string json;
  for (const auto& spindle : spindles_) {
    if (!json.empty()) json += ',';
    json += spindle->summary();
  }
  return {200, "application/json", "{\"spindles\":[" + json + "]}\n"};
}

}  // namespace spindle_twin::firmware
