#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "firmware/cycle/exchange.hpp"
#include "firmware/run/prepare.hpp"

namespace spindle_twin::firmware {

/// Looks at the slot for new networks, off the cycle's thread: checks and prepares one, has it tried, writes it down as
/// the accepted one, puts it aside as NAME.rom.refused where it was refused or did worse. One file at a time, by name;
/// a file counts once two looks found it the same. Who takes the file away ends its trial.
class SlotWatch {
 public:
  /// `keep_now` is called behind an acceptance: checkpoint and orders are to be written at once.
  SlotWatch(PreparedSpindle& spindle, NetworkExchange& exchange, std::function<void()> keep_now);

  /// One look; a second apart. Never throws.
  void look();
  /// Until `stop` is set.
  void run(const std::atomic<bool>& stop);

 private:
  struct Stamp {
    std::uintmax_t bytes = 0;
    std::filesystem::file_time_type time;
    bool operator==(const Stamp&) const = default;
  };
  struct Candidate {
    std::string path;
    Stamp stamp;
    std::vector<std::uint8_t> bytes;
    std::unique_ptr<PreparedSpindle> spindle;
  };
  static std::optional<Stamp> stamp_of(const std::string& path);
  void look_once();
  void hear();
  void keep();
  void take_back();
  void accepted();
  void put_aside(const std::string& path, const std::string& reason);
  void look_for_file();
  void begin(const std::string& path, const Stamp& stamp);
  const PreparedSpindle& running() const { return accepted_ ? *accepted_ : spindle_; }

  PreparedSpindle& spindle_;
  NetworkExchange& exchange_;
  std::function<void()> keep_now_;
  std::unique_ptr<PreparedSpindle> accepted_;  ///< the one that runs, where it is not that of the start
  std::optional<Candidate> candidate_;
  bool written_ = false;  ///< the candidate's file is the accepted one, but the cycle has not gone over to it
  ExchangeNews news_;
  Snapshot newest_;
  std::map<std::string, Stamp> seen_;       ///< files of the last look
  std::map<std::string, Stamp> left_over_;  ///< refused ones that could not be put aside
  std::set<std::string> ignored_;           ///< that are taken for no network, in the last look
  std::string complaint_;                   ///< said last
};

}  // namespace spindle_twin::firmware
