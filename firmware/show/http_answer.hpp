#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace spindle_twin::firmware {

struct Page;
/// Makes a page in another thread; to end soon when `stop` is set. What it throws is answered by 500.
using SlowWork = std::function<Page(const std::atomic<bool>& stop)>;

/// Which thread makes it: one that waits for a disk does not hold up a command.
enum class Lane : std::uint8_t { disk, commands };
inline constexpr std::size_t lanes = 2;

/// What stands behind a path.
struct Page {
  int status = 200;
  std::string type = "application/json";
  std::string body = {};
  bool is_stream = false;   ///< nothing but the head is sent now; events follow
  SlowWork work = {};       ///< makes the page, of which nothing else is said here
  Lane lane = Lane::disk;   ///< of the work
  std::string cookie = {};  ///< to be set, with its attributes
};

/// One request, as far as a page wants to know of it.
struct HttpRequest {
  bool is_post = false;
  std::string path;
  std::string body;             ///< of a POST
  std::string cookie;           ///< all cookies, as they came
  bool is_from_a_page = false;  ///< X-Spindle-Twin: command, which no form and no link of another page can send, and no
                                ///< other Origin than this host
  std::uint32_t peer = 0;       ///< IPv4 address, host byte order
};

struct HttpAnswer {
  int status = 0;
  std::string bytes = {};  ///< head and body
  bool is_stream = false;  ///< the connection stays open for events
  SlowWork work = {};      ///< for the page without which there is no answer yet
  Lane lane = Lane::disk;
};

/// Makes of one whole request (its head up to the empty line, and of a POST what stands behind it) the bytes of the
/// answer. No socket, no thread: cpp-httplib parses and formats, in memory. GET, HEAD and POST are answered by `pages`,
/// others by 405; what is no HTTP by 400, and 421 what asks for a host that this is not: a page from elsewhere, whose
/// name somebody had resolve to this computer, would read the registers in its visitor's browser. Addresses, localhost,
/// the computer's own name and `names` are this one. Errors have the body {"error": ...}. Each answer ends its
/// connection. For one thread; allocates.
class HttpAnswerer {
 public:
  using Pages = std::function<Page(const HttpRequest& request)>;

  /// `pages` gives the page of a path, without the query; 405 where the path is not for this method.
  explicit HttpAnswerer(Pages pages, std::vector<std::string> names = {});
  ~HttpAnswerer();
  HttpAnswerer(const HttpAnswerer&) = delete;
  HttpAnswerer& operator=(const HttpAnswerer&) = delete;

  /// With the page that `work` of the same request made, if that was asked for. peer: who asks.
  HttpAnswer answer(const std::string& request, std::optional<Page> made = std::nullopt, std::uint32_t peer = 0);

  /// 431, for a request whose head does not end within the room that there is; 413 where `body` has none.
  static HttpAnswer too_long(bool body = false);

  /// How many bytes follow the head of a POST, by its Content-Length; 0 without one, for other methods, and where
  /// nothing can be posted: nobody waits for that.
  static std::size_t body_bytes(std::string_view head);

 private:
  class Library;
  std::unique_ptr<Library> library_;
};

}  // namespace spindle_twin::firmware
