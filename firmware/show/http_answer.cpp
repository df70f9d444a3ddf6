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
#include <cstring>
#include <utility>

#include "firmware/show/json_text.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr int not_found = 404;
constexpr int wrong_method = 405;
constexpr int wrong_host = 421;
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

/// The name that a request's Host says, in small letters, without port and brackets.
std::string host_of(const httplib::Request& request) {
  std::string host = request.get_header_value("Host");
  const std::size_t end = host.starts_with('[') ? host.find(']') : host.find(':');
  host.resize(std::min(end, host.size()));
  if (host.starts_with('[')) host.erase(0, 1);
  std::transform(host.begin(), host.end(), host.begin(), [](unsigned char c) { return std::tolower(c); });
  return host;
}

bool is_address(const std::string& host) {
  in6_addr parsed{};
  return inet_pton(AF_INET, host.c_str(), &parsed) == 1 || inet_pton(AF_INET6, host.c_str(), &parsed) == 1;
}

std::string own_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string reason_of(int status, const std::string& path) {
  switch (status) {
    case not_found:
      return "there is nothing at " + path + "; see /routes";
    case wrong_method:
      return "only GET and HEAD are allowed: nothing can be changed here";
    case wrong_host:
      return "this is not the host that was asked for; its names are in http.names";
    default:
      return "this request is not understood";
  }
}

}  // namespace

class HttpAnswerer::Library final : public httplib::Server {
 public:
  Library(std::function<Page(const std::string& path)> pages, std::vector<std::string> names)
      : pages_(std::move(pages)), names_(std::move(names)) {
    names_.insert(names_.end(), {"", "localhost", own_name()});  // "": HTTP/1.0 says none
    // Before the library's own routing, which would read a body first.
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      show(request, response);
      return HandlerResponse::Handled;
    });
    set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
      status_ = response.status;
      if (!response.body.empty()) return;  // the page says itself what is wrong
      response.set_content("{\"error\":" + json_text(reason_of(response.status, request.path)) + "}\n",
                           "application/json");
    });
    set_default_headers({{"Cache-Control", "no-store"},
                         {"X-Content-Type-Options", "nosniff"},
                         {"Referrer-Policy", "no-referrer"},
                         {"Content-Security-Policy", what_a_page_may}});
  }

  HttpAnswer answer(const std::string& request, std::optional<Page> made) {
    MemoryStream stream(request);
    made_ = std::move(made);
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
    if (work_) return {0, {}, false, std::move(work_)};
    return {status_, std::move(stream.written), is_stream_};
  }

 private:
  void show(const httplib::Request& request, httplib::Response& response) {
    const bool is_head = request.method == "HEAD";
    if (!is_head && request.method != "GET") {
      response.status = wrong_method;
      response.set_header("Allow", "GET, HEAD");
      return;
    }
    const std::string host = host_of(request);
    if (!is_address(host) && std::find(names_.begin(), names_.end(), host) == names_.end()) {
      response.status = wrong_host;
      return;
    }
    const Page page = made_ ? *std::move(made_) : pages_(request.path);
    work_ = page.work;
    response.status = status_ = page.status;
    if (page.status == not_found && page.body.empty()) return;
    if (!page.is_stream) {
      response.set_content(page.body, page.type);
      return;
    }
    is_stream_ = !is_head;
    // Without a length the library sends the head alone; it has no socket to wait for.
    response.set_content_provider(page.type, [](std::size_t, httplib::DataSink&) { return false; });
  }

  std::function<Page(const std::string& path)> pages_;
  std::vector<std::string> names_;
  std::optional<Page> made_;
  SlowWork work_;
  int status_ = 0;
  bool is_stream_ = false;
};

HttpAnswerer::HttpAnswerer(std::function<Page(const std::string& path)> pages, std::vector<std::string> names)
    : library_(std::make_unique<Library>(std::move(pages), std::move(names))) {}
HttpAnswerer::~HttpAnswerer() = default;

HttpAnswer HttpAnswerer::answer(const std::string& request, std::optional<Page> made) {
  return library_->answer(request, std::move(made));
}

HttpAnswer HttpAnswerer::too_long() {
  const std::string body = "{\"error\":\"the request is too long\"}\n";
  return {431, fmt::format("HTTP/1.1 431 Request Header Fields Too Large\r\nConnection: close\r\n"
                           "Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{}",
                           body.size(), body)};
}

}  // namespace spindle_twin::firmware
