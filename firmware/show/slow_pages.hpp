#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "firmware/serve/descriptor.hpp"
#include "firmware/show/http_answer.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Makes the pages that take their time, one after the other in a thread of its own, so that the thread that asks never
/// waits for a disk. Work that throws is answered by 500 with its error. All functions are for the one thread that
/// asks, but for stop(); none waits for work, but for the end of this, which waits for the one under way: that sees
/// that it is to stop.
class SlowPages {
 public:
  static constexpr std::size_t most_at_once = 32;  ///< of pages asked for and not taken: HttpServer::most_connections

  SlowPages();
  ~SlowPages();
  SlowPages(const SlowPages&) = delete;
  SlowPages& operator=(const SlowPages&) = delete;

  /// Readable when a page can be taken; for poll().
  int ready() const { return ready_.get(); }

  /// The number under which the page will come; nothing where there is no room, or after stop().
  std::optional<std::uint64_t> ask(SlowWork work);
  /// Nobody waits for that page any more. Work under way is still done.
  void forget(std::uint64_t number);

  struct Made {
    std::uint64_t number = 0;
    Page page = {};
  };
  /// The pages that have been made since, in their order.
  std::vector<Made> take();

  /// No page is begun any more. Any thread.
  void stop();

 private:
  struct Asked {
    std::uint64_t number = 0;
    SlowWork work;
  };
  void run();
  std::optional<Asked> next();
  Page make(const SlowWork& work);
  void hand_over(Made made);

  Descriptor ready_;
  std::atomic<bool> stop_{false};
  std::mutex guard_;
  std::condition_variable comes_;
  std::deque<Asked> asked_;         ///< guarded, as what follows
  std::set<std::uint64_t> wanted_;  ///< asked for, and neither taken nor forgotten
  bool is_busy_ = false;            ///< with work that was begun
  std::vector<Made> made_;
  std::uint64_t last_ = 0;
  LogLimit complaints_;  ///< of the thread
  std::thread thread_;
};

}  // namespace spindle_twin::firmware
