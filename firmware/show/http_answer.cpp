// The only source that includes httplib.h, which takes seconds to compile; firmware/CMakeLists.txt gives it the macros
// that Debian's library was built with. No Eigen here: <resolv.h>, which httplib.h brings, has macros of Eigen's names.
#include "firmware/show/http_answer.hpp"

#include <arpa/inet.h>
#include <httplib.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>

#include "firmware/show/json_text.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr int not_found = 404;
constexpr int wrong_method = 405;
constexpr int wrong_host = 421;
constexpr std::array<const char*, 3> posted_to{"/login", "/logout", "/command"};  ///< how their paths end
constexpr std::string_view end_of_head = "\r\n\r\n";
/// Load style, script and values from here, nothing from elsewhere; stand in nobody's frame.
constexpr const char* what_a_page_may =
    "default-src 'none'; style-src 'self'; script-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

/// A request that is there as a whole, and the answer as it grows.
class MemoryStream final : public httplib::Stream {
 public:
  explicit MemoryStream(const std::string& request) : request_(request) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    const std::size_t count = std::min(size, request_.size() - at_);
    std::memcpy(to, request_.data() + at_, count);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, std::size_t size) override {
    written.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

  std::string written;

 private:
  const std::string& request_;
  std::size_t at_ = 0;
};

/// A computer's name is the same in capital and in small letters (RFC 4343).
std::string in_small_letters(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

/// The name that a request's Host says, in small letters, without port and brackets.
std::string host_of(const httplib::Request& request) {
  std::string host = request.get_header_value("Host");
  const std::size_t end = host.starts_with('[') ? host.find(']') : host.find(':');
  host.resize(std::min(end, host.size()));
  if (host.starts_with('[')) host.erase(0, 1);
  return in_small_letters(std::move(host));
}

bool is_address(const std::string& host) {
  in6_addr parsed{};
  return inet_pton(AF_INET, host.c_str(), &parsed) == 1 || inet_pton(AF_INET6, host.c_str(), &parsed) == 1;
}

std::string own_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// An Origin is sent by browsers: the page that asks must have come from here, behind a proxy with TLS or not.
bool is_own_origin(const httplib::Request& request) {
  const std::string origin = request.get_header_value("Origin"), host = request.get_header_value("Host");
  return origin.empty() || origin == "http://" + host || origin == "https://" + host;
}

std::string reason_of(int status, const httplib::Request& request) {
  switch (status) {
    case not_found:
      return "there is nothing at " + request.path + "; see /routes";
    case wrong_method:
      return request.method == "GET" || request.method == "HEAD"
                 ? "only POST is allowed here"
                 : "only GET and HEAD are allowed: nothing can be changed here";
    case wrong_host:
      return "this is not the host that was asked for; its names are in http.names";
    default:
      return "this request is not understood";
  }
}

}  // namespace

class HttpAnswerer::Library final : public httplib::Server {
 public:
  Library(Pages pages, std::vector<std::string> names) : pages_(std::move(pages)), names_(std::move(names)) {
    names_.insert(names_.end(), {"", "localhost", own_name()});  // "": HTTP/1.0 says none
    for (std::string& name : names_) name = in_small_letters(std::move(name));
    // Before the library's own routing, which would read a body first.
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      show(request, response);
      return HandlerResponse::Handled;
    });
    set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
      status_ = response.status;
      if (!response.body.empty()) return;  // the page says itself what is wrong
      response.set_content("{\"error\":" + json_text(reason_of(response.status, request)) + "}\n", "application/json");
    });
    set_default_headers({{"Cache-Control", "no-store"},
                         {"X-Content-Type-Options", "nosniff"},
                         {"Referrer-Policy", "no-referrer"},
                         {"Content-Security-Policy", what_a_page_may}});
  }

  HttpAnswer answer(const std::string& request, std::optional<Page> made, std::uint32_t peer) {
    MemoryStream stream(request);
    made_ = std::move(made);
    const std::size_t head = request.find(end_of_head);
    body_ = head == std::string::npos ? "" : std::string_view(request).substr(head + end_of_head.size());
    peer_ = peer;
    work_ = {};
    bool closed = false;
    status_ = 0;
    is_stream_ = false;
    process_request(stream, true, closed, [](httplib::Request& parsed) {
      // Parts of a page that changes each cycle mean nothing, and packing costs more than the loopback.
      parsed.ranges.clear();
      parsed.headers.erase("Range");
      parsed.headers.erase("Accept-Encoding");
    });
    if (work_) return {0, {}, false, std::move(work_), lane_};
    return {status_, std::move(stream.written), is_stream_};
  }

 private:
  HttpRequest told(const httplib::Request& request) const {
    HttpRequest told{request.method == "POST", request.path, {}, request.get_header_value("Cookie")};
    if (told.is_post) told.body = body_;
    told.is_from_a_page = request.get_header_value("X-Spindle-Twin") == "command" && is_own_origin(request);
    told.peer = peer_;
    return told;
  }

  void show(const httplib::Request& request, httplib::Response& response) {
    const bool is_head = request.method == "HEAD";
    const bool is_read = is_head || request.method == "GET";
    if (!is_read && request.method != "POST") {
      response.status = wrong_method;
      response.set_header("Allow", "GET, HEAD");
      return;
    }
    const std::string host = host_of(request);
    if (!is_address(host) && std::find(names_.begin(), names_.end(), host) == names_.end()) {
      response.status = wrong_host;
      return;
    }
    const Page page = made_ ? *std::move(made_) : pages_(told(request));
    work_ = page.work;
    lane_ = page.lane;
    response.status = status_ = page.status;
    if (!page.cookie.empty()) response.set_header("Set-Cookie", page.cookie);
    if (page.status == wrong_method) {
      response.set_header("Allow", is_read ? "POST" : "GET, HEAD");
      return;
    }
    if (page.status == not_found && page.body.empty()) return;
    if (!page.is_stream) {
      response.set_content(page.body, page.type);
      return;
    }
    is_stream_ = !is_head;
    // Without a length the library sends the head alone; it has no socket to wait for.
    response.set_content_provider(page.type, [](std::size_t, httplib::DataSink&) { return false; });
  }

  Pages pages_;
  std::vector<std::string> names_;
  std::optional<Page> made_;
  std::string_view body_;  ///< of the request that is answered
  std::uint32_t peer_ = 0;
  SlowWork work_;
  Lane lane_ = Lane::disk;
  int status_ = 0;
  bool is_stream_ = false;
};

HttpAnswerer::HttpAnswerer(Pages pages, std::vector<std::string> names)
    : library_(std::make_unique<Library>(std::move(pages), std::move(names))) {}
HttpAnswerer::~HttpAnswerer() = default;

HttpAnswer HttpAnswerer::answer(const std::string& request, std::optional<Page> made, std::uint32_t peer) {
  return library_->answer(request, std::move(made), peer);
}

std::size_t HttpAnswerer::body_bytes(std::string_view head) {
  constexpr std::string_view post = "POST ";
  if (!head.starts_with(post)) return 0;
  const std::string_view path = head.substr(post.size(), head.find_first_of(" ?\r", post.size()) - post.size());
  if (std::none_of(posted_to.begin(), posted_to.end(), [&](const char* end) { return path.ends_with(end); })) return 0;
  constexpr std::string_view name = "\r\ncontent-length:";
  const auto is_same = [](unsigned char one, unsigned char other) { return std::tolower(one) == other; };
  const auto found = std::search(head.begin(), head.end(), name.begin(), name.end(), is_same);
  if (found == head.end()) return 0;
  std::string_view value = head.substr(static_cast<std::size_t>(found - head.begin()) + name.size());
  value.remove_prefix(std::min(value.size(), value.find_first_not_of(' ')));
  std::size_t bytes = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), bytes);
  return error == std::errc::result_out_of_range ? std::numeric_limits<std::size_t>::max() / 2 : bytes;
}

HttpAnswer HttpAnswerer::too_long(bool body) {
  const std::string text = "{\"error\":\"the request is too long\"}\n";
  const int status = body ? 413 : 431;
  return {status,
          fmt::format("HTTP/1.1 {} {}\r\nConnection: close\r\n"
                      "Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{}",
                      status, body ? "Payload Too Large" : "Request Header Fields Too Large", text.size(), text)};
}

}  // namespace spindle_twin::firmware
