#pragma once

#include <atomic>
#include <cstdint>
#include <utility>

#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/trial_score.hpp"

namespace spindle_twin::firmware {

/// Why a network was refused or given up.
enum class ExchangeReason : std::uint8_t { none, worse, in_doubt, failed, withdrawn };

/// What the thread that looks at the slot is told.
struct ExchangeNews {
  ExchangeState state = ExchangeState::none;
  ExchangeReason reason = ExchangeReason::none;
  double running_K = not_a_value;    ///< rms of reading minus prediction, of the network that was there before
  double candidate_K = not_a_value;  ///< likewise, of the new one
};

/// The running cycle, and during an exchange of networks another one beside it on the same inputs.
///
///   offered ─► trial ─► watching ─► to be kept ─► accepted      (what is shown: old, new, new, new)
///                │          │                                   (what is kept:  old, old, old, new)
///                ▼          ▼
///             refused   went back
///
/// What is shown changes without a step (Cycle::take_over). What is written to the disk stays that of the old network
/// until the new one's file is there, so a kill at any moment finds one network with its own state.
class NetworkExchange {
 public:
  /// `first` and every cycle offered must outlive their use here.
  NetworkExchange(Cycle& first, const ExchangePlan& plan) : plan_(plan), shown_(&first), kept_(&first) {}

  // The cycle's thread; the new cycle's first steps allocate, and no others.
  const Snapshot& step(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns, std::int64_t missed);
  void note_troubles(const Troubles& troubles);
  const OrderResults& order_results() const { return shown_->order_results(); }
  /// What is written to the disk; before and after the thread runs any thread may ask.
  const Cycle& kept() const { return *kept_; }
  /// True once behind an acceptance: orders and checkpoint are to be written anew.
  bool take_kept_changed() { return std::exchange(kept_changed_, false); }

  // The thread that looks at the slot.
  /// Where no exchange is under way: a cycle to be tried.
  void offer(Cycle& candidate) { offered_.store(&candidate, std::memory_order_release); }
  /// The candidate's file is gone: nothing of it is shown any more, soon.
  void withdraw() { withdrawn_.store(true, std::memory_order_release); }
  /// The candidate's file is on the disk as the network that is run from now on.
  void confirm() { confirmed_.store(true, std::memory_order_release); }
  /// A file that was refused before any cycle ran it.
  void note_refused() { refused_files_.fetch_add(1, std::memory_order_release); }
  /// False where nothing came since.
  bool read(ExchangeNews& news) { return news_.read(news); }
  /// The newest that was shown; false where nothing came since.
  bool read(Snapshot& newest) { return newest_.read(newest); }

 private:
  void listen();
  void step_shown(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns, std::int64_t missed);
  void step_beside(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns, std::int64_t missed);
  void judge_trial();
  void judge_watch();
  void show_other();
  void refuse(ExchangeReason reason);
  void go_back(ExchangeReason reason);
  void tell(ExchangeState state, ExchangeReason reason, bool candidate_is_shown);
  void publish();

  const ExchangePlan plan_;
  Cycle* shown_;
  Cycle* kept_;
  Cycle* beside_ = nullptr;  ///< the candidate in a trial, the old one behind it
  Snapshot snapshot_;
  Snapshot beside_snapshot_;
  TrialScore score_;
  ExchangeState state_ = ExchangeState::none;
  double judged_s_ = 0.0;    ///< of the trial, or of the watch, in which sensors were compared
  double settled_s_ = 0.0;   ///< so much of it does not count
  double advanced_s_ = 0.0;  ///< by the last step
  bool to_be_kept_ = false;
  bool kept_changed_ = false;
  std::uint32_t refused_seen_ = 0;
  std::atomic<Cycle*> offered_{nullptr};
  std::atomic<bool> withdrawn_{false};
  std::atomic<bool> confirmed_{false};
  std::atomic<std::uint32_t> refused_files_{0};
  Latest<ExchangeNews> news_;
  Latest<Snapshot> newest_;
};

}  // namespace spindle_twin::firmware
