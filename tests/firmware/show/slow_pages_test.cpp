#include "firmware/show/slow_pages.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace spindle_twin::firmware {
namespace show_slow_pages_test {

/// Work that lasts until it is let go, or told to stop.
class Gate {
 public:
  SlowWork work(const std::string& body = "open") {
    return [this, body](const std::atomic<bool>& stop) -> Page {
      ++begun;
      while (!open.load() && !stop.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return {200, "text/plain", body};
    };
  }
  void wait_until_begun(int count) const {
    while (begun.load() < count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::atomic<bool> open{false};
  std::atomic<int> begun{0};
};

bool is_ready(const SlowPages& pages, int within_ms) {
  pollfd polled{pages.ready(), POLLIN, 0};
  return poll(&polled, 1, within_ms) == 1;
}

SlowPages::Made next_made(SlowPages& pages) {
  constexpr int long_ms = 20000;
  while (is_ready(pages, long_ms)) {
    const std::vector<SlowPages::Made> made = pages.take();
    if (!made.empty()) return made.front();
  }
  return {};
}

TEST(SlowPages, each_page_comes_under_its_number_and_wakes_who_polls) {
  SlowPages pages;
  EXPECT_FALSE(is_ready(pages, 0));
  for (int n = 0; n < 20; ++n) {
    const std::string body = std::to_string(n);
    const auto number = pages.ask([body](const std::atomic<bool>&) { return Page{200, "text/plain", body}; });
    const SlowPages::Made made = next_made(pages);
    EXPECT_EQ(made.number, number);
    EXPECT_EQ(made.page.body, body);
    EXPECT_FALSE(is_ready(pages, 0));
  }
}

TEST(SlowPages, who_asks_does_not_wait_for_the_work) {
  Gate gate;
  SlowPages pages;
  EXPECT_TRUE(pages.ask(gate.work()));
  gate.wait_until_begun(1);
  EXPECT_TRUE(pages.take().empty());
  gate.open.store(true);
  EXPECT_EQ(next_made(pages).page.body, "open");
}

TEST(SlowPages, there_is_room_for_so_many_and_again_when_one_was_taken) {
  Gate gate;
  SlowPages pages;
  for (std::size_t n = 0; n < SlowPages::most_at_once; ++n) EXPECT_TRUE(pages.ask(gate.work()));
  gate.wait_until_begun(1);
  EXPECT_FALSE(pages.ask(gate.work()));
  gate.open.store(true);
  next_made(pages);
  EXPECT_TRUE(pages.ask(gate.work()));
}

TEST(SlowPages, what_is_made_and_not_taken_has_its_room_too) {
  Gate gate;
  gate.open.store(true);
  SlowPages pages;
  const int most = static_cast<int>(SlowPages::most_at_once);
  for (int n = 1; n < most; ++n) EXPECT_TRUE(pages.ask(gate.work()));
  gate.wait_until_begun(most - 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));  // handed over, most likely
  EXPECT_TRUE(pages.ask(gate.work())) << "there is room for one more";
  gate.wait_until_begun(most);
  EXPECT_FALSE(pages.ask(gate.work()));
  EXPECT_FALSE(pages.take().empty());
  EXPECT_TRUE(pages.ask(gate.work()));
}

TEST(SlowPages, what_nobody_waits_for_is_not_begun_and_what_was_begun_does_not_come) {
  Gate gate;
  SlowPages pages;
  const auto begun = pages.ask(gate.work("begun"));
  gate.wait_until_begun(1);
  const auto waiting = pages.ask(gate.work("waiting"));
  const auto wanted = pages.ask(gate.work("wanted"));
  pages.forget(*begun);
  pages.forget(*waiting);
  gate.open.store(true);
  EXPECT_EQ(next_made(pages).number, wanted);
  EXPECT_EQ(gate.begun.load(), 2);
  for (std::size_t n = 0; n < SlowPages::most_at_once; ++n)
    EXPECT_TRUE(pages.ask(gate.work())) << "all the room is there";
}

TEST(SlowPages, an_error_of_the_work_is_500_with_its_words_and_the_next_is_done) {
  SlowPages pages;
  pages.ask([](const std::atomic<bool>&) -> Page { throw std::runtime_error("the \"disk\" is gone"); });
  const Page page = next_made(pages).page;
  EXPECT_EQ(page.status, 500);
  EXPECT_EQ(page.body, "{\"error\":\"the \\\"disk\\\" is gone\"}\n");
  pages.ask([](const std::atomic<bool>&) { return Page{}; });
  EXPECT_EQ(next_made(pages).page.status, 200);
}

TEST(SlowPages, it_ends_while_work_is_under_way_and_more_waits) {
  Gate gate;
  {
    SlowPages pages;
    pages.ask(gate.work());
    gate.wait_until_begun(1);
    pages.ask(gate.work());
    pages.stop();
    EXPECT_FALSE(pages.ask(gate.work()));
  }
  EXPECT_EQ(gate.begun.load(), 1) << "what waited was not begun";
}

}  // namespace show_slow_pages_test
}  // namespace spindle_twin::firmware
