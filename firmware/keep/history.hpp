#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/keep/history_row.hpp"
#include "firmware/keep/history_writer.hpp"

namespace spindle_twin::firmware {

/// The files of a history that are no longer written, oldest first: of twin.csv these are twin.000001.csv and so on.
std::vector<std::string> earlier_histories(const std::string& path);
/// What the file that is written now would be called among them.
std::string next_earlier_history(const std::string& path);

/// Removes the oldest of them until they are at most `most_bytes` together; returns what they are then.
std::uint64_t remove_oldest_histories(const std::string& path, std::uint64_t most_bytes);

/// A history in CSV files. Each start, each gap and each segment_bytes begin a file; the one before gets the next
/// number, and the oldest go when all together are more than most_bytes. So every file replays by itself. Rows are
/// written whole: what a full disk or a power cut leaves of one is cut off.
class History final : public HistoryWriter {
 public:
  History(HistoryPlan plan, const rom::Network& network, Troubles& troubles);
  ~History() override;

 protected:
  void drain() override;

 private:
  bool begin_file();
  /// Somebody has emptied it ("> twin.csv", a rotation that copies and truncates).
  bool is_cut() const;
  void write_rows(const std::string& rows, std::uint64_t count);
  void close_file();
  void fail(const char* what);

  HistoryPlan plan_;
  std::string header_;
  int file_ = -1;
  std::uint64_t written_ = 0;   ///< bytes of whole rows
  std::uint64_t sequence_ = 0;  ///< of the last row
};

}  // namespace spindle_twin::firmware
