#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace spindle_twin::firmware {

struct Page;
/// Makes a page in another thread; to end soon when `stop` is set. What it throws is answered by 500.
using SlowWork = std::function<Page(const std::atomic<bool>& stop)>;

/// What stands behind a path.
struct Page {
  int status = 200;
  std::string type = "application/json";
  std::string body = {};
  bool is_stream = false;  ///< nothing but the head is sent now; events follow
  SlowWork work = {};      ///< makes the page, of which nothing else is said here
};

struct HttpAnswer {
  int status = 0;
  std::string bytes = {};  ///< head and body
  bool is_stream = false;  ///< the connection stays open for events
  SlowWork work = {};      ///< for the page without which there is no answer yet
};

/// Makes of one whole request (up to its empty line; a body is left alone) the bytes of the answer. No socket, no
/// thread: cpp-httplib parses and formats, in memory. Only GET and HEAD are answered by `pages`, others by 405; what is
/// no HTTP by 400, and 421 what asks for a host that this is not: a page from elsewhere, whose name somebody had
/// resolve to this computer, would read the registers in its visitor's browser. Addresses, localhost, the computer's
/// own name and `names` are this one. Errors have the body {"error": ...}. Each answer ends its connection. For one
/// thread; allocates.
class HttpAnswerer {
 public:
  /// `pages` gives the page of a path, without the query.
  explicit HttpAnswerer(std::function<Page(const std::string& path)> pages, std::vector<std::string> names = {});
  ~HttpAnswerer();
  HttpAnswerer(const HttpAnswerer&) = delete;
  HttpAnswerer& operator=(const HttpAnswerer&) = delete;

  /// With the page that `work` of the same request made, if that was asked for.
  HttpAnswer answer(const std::string& request, std::optional<Page> made = std::nullopt);

  /// 431, for a request whose end does not come within the room that there is.
  static HttpAnswer too_long();

 private:
  class Library;
  std::unique_ptr<Library> library_;
};

}  // namespace spindle_twin::firmware
