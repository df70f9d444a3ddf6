#pragma once

#include <functional>
#include <string>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/show/http_answer.hpp"
#include "firmware/show/metrics.hpp"
#include "firmware/show/page_commands.hpp"
#include "firmware/show/shown_names.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// What the HTTP port is told of a spindle.
struct SpindleToShow {
  std::string name;            ///< among several; empty: the only one
  int unit = 1;                ///< by which Modbus clients ask for it
  ShownNames names;            ///< of its network
  double stale_after_s = 5.0;  ///< clock time; a cycle older than that is no longer healthy
  std::string scene = "{}";    ///< scene_json()
  /// Makes the page of its last hours, as many as are asked for; empty: no history is kept that could be asked.
  std::function<Page(int hours, const std::atomic<bool>& stop)> history = {};
  GiveOrder order = {};  ///< hands an order to it
  /// Makes the page of what the compensation has been worth, likewise.
  std::function<Page(const std::atomic<bool>& stop)> growth = {};
};

/// A cycle is called dead that is three periods late, or five seconds where that is longer.
double stale_after_s(double cycle_s);

/// One spindle as the HTTP port shows it. tap() is for its cycle, all else for the port's thread.
class ShownSpindle {
 public:
  explicit ShownSpindle(SpindleToShow spindle) : spindle_(std::move(spindle)) {}

  Latest<Snapshot>& tap() { return tap_; }
  const std::string& name() const { return spindle_.name; }
  /// Takes the newest cycle.
  void renew(std::int64_t now_ns);
  /// Number of the cycle taken.
  std::uint64_t sequence() const { return snapshot_.sequence; }
  /// 200, or 503 with the reason.
  Page health(std::int64_t now_ns) const;
  /// All its registers on one line, and what no register has: what is known of the correction factors, and the heat
  /// flows.
  std::string state() const;
  const std::string& scene() const { return spindle_.scene; }
  /// The page of its last hours, to be made by another thread; `hours` as it stands in the path. 400 with what is
  /// allowed, 404 where no history is kept that could be asked.
  Page history(const std::string& hours) const;
  /// The page of what the compensation has been worth, likewise.
  Page growth() const;
  Commanded commanded() const { return {spindle_.name, spindle_.names.deformations, spindle_.order}; }
  bool has_history() const { return static_cast<bool>(spindle_.history); }
  /// {"name": ..., "unit": ..., "spindle": ..., "state": ...}
  std::string summary() const;
  ShownRegisters registers() const { return {image_, spindle_.names, spindle_.name}; }

 private:
  SpindleToShow spindle_;
  Latest<Snapshot> tap_;
  Snapshot snapshot_;
  RegisterImage image_{};
};

/// {"error": reason} as a line.
std::string error_json(const std::string& reason);

}  // namespace spindle_twin::firmware
