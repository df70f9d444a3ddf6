#pragma once

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <string>

namespace spindle_twin::firmware {

/// While it lives, it takes the lines of the log, from any thread: level, blank, text. The tests' own logger comes
/// back.
class Logged {
 public:
  Logged() {
    lines_->set_pattern("%l %v");
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("", lines_));
  }
  ~Logged() { spdlog::set_default_logger(before_); }
  Logged(const Logged&) = delete;
  Logged& operator=(const Logged&) = delete;
  std::string text() const { return lines_->text(); }

 private:
  class Lines final : public spdlog::sinks::base_sink<std::mutex> {
   public:
    std::string text() {
      const std::lock_guard lock(mutex_);
      return text_;
    }

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      spdlog::memory_buf_t line;
      formatter_->format(message, line);
      text_.append(line.data(), line.size());
    }
    void flush_() override {}
    std::string text_;
  };

  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::shared_ptr<Lines> lines_ = std::make_shared<Lines>();
};

}  // namespace spindle_twin::firmware
