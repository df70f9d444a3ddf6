#include "firmware/run/slot_watch.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <thread>
#include <utility>

#include "firmware/cycle/start_field.hpp"
#include "firmware/keep/state_files.hpp"
#include "rom/file/whole_file.hpp"

namespace spindle_twin::firmware {
namespace {

namespace fs = std::filesystem;

std::string told(const ExchangeNews& news) {
  std::string errors = fmt::format("rms of reading minus prediction {:.3f} K, of the old network {:.3f} K",
                                   news.candidate_K, news.running_K);
  switch (news.reason) {
    case ExchangeReason::worse:
      return "it foretells the readings worse: " + errors;
    case ExchangeReason::in_doubt:
      return "readings contradict its estimate, and not that of the old network";
    case ExchangeReason::failed:
      return "it could not be integrated, or left all plausible temperatures";
    case ExchangeReason::withdrawn:
      return "its file was taken out of the slot, or changed";
    case ExchangeReason::none:
      break;
  }
  return errors;
}

bool predicts(const Snapshot& snapshot) {
  return snapshot.state == State::running || snapshot.state == State::degraded;
}

bool has_sensors(const Snapshot& snapshot) {
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    if (snapshot.sensor_quality[k] != SensorQuality::not_configured) return true;
  }
  return false;
}

bool is_new_network(const std::string& name) {
  return name.ends_with(".rom") && !name.starts_with("accepted-") && !name.starts_with("previous-");
}

/// What somebody may take for one that will be tried: a link, a folder, NAME.ROM.
bool looks_like_a_network(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return is_new_network(name);
}

}  // namespace

SlotWatch::SlotWatch(PreparedSpindle& spindle, NetworkExchange& exchange, std::function<void()> keep_now)
    : spindle_(spindle), exchange_(exchange), keep_now_(std::move(keep_now)) {
  remove_left_overs(accepted_path(spindle));
  remove_left_overs(previous_path(spindle));
}

std::optional<SlotWatch::Stamp> SlotWatch::stamp_of(const std::string& path) {
  std::error_code unknown;
  if (!fs::is_regular_file(fs::symlink_status(path, unknown))) return std::nullopt;
  Stamp stamp;
  stamp.bytes = fs::file_size(path, unknown);
  if (unknown) return std::nullopt;
  stamp.time = fs::last_write_time(path, unknown);
  return unknown ? std::nullopt : std::optional(stamp);
}

void SlotWatch::run(const std::atomic<bool>& stop) {
  constexpr std::chrono::milliseconds slice(50);
  constexpr int slices = 20;
  for (int n = 0; !stop.load(std::memory_order_acquire); ++n) {
    if (n % slices == 0) look();
    std::this_thread::sleep_for(slice);
  }
}

void SlotWatch::look() {
  std::string complaint;
  try {
    look_once();
  } catch (const std::exception& error) {
    complaint = error.what();
  }
  if (!complaint.empty() && complaint != complaint_) spdlog::error("exchange: {}; tried again", complaint);
  complaint_ = complaint;
}

void SlotWatch::look_once() {
  exchange_.read(newest_);
  hear();
  if (!candidate_) return look_for_file();
  if (news_.state == ExchangeState::keeping) return keep();
  if (stamp_of(candidate_->path) != candidate_->stamp) exchange_.withdraw();
}

void SlotWatch::hear() {
  if (!exchange_.read(news_) || !candidate_) return;
  const std::string& path = candidate_->path;
  switch (news_.state) {
    case ExchangeState::trial:
      spdlog::info("exchange: {}: SHA-256 {}, {}; its trial begins, {:g} min", path, candidate_->spindle->file.sha256,
                   signer(candidate_->spindle->file), spindle_.config.exchange.plan.trial_s / 60.0);
      return;
    case ExchangeState::watching:
      spdlog::info("exchange: {}: is shown from now on ({}); watched for {:g} min", path, told(news_),
                   spindle_.config.exchange.plan.watch_s / 60.0);
      return;
    case ExchangeState::accepted:
      return accepted();
    case ExchangeState::refused:
    case ExchangeState::went_back: {
      const bool shown = news_.state == ExchangeState::went_back;
      const Candidate gone = std::move(*candidate_);
      candidate_.reset();
      take_back();
      if (stamp_of(gone.path) != gone.stamp) {  // another one has its name by now, and its own trial
        spdlog::warn("exchange: {}: given up, {}", gone.path, told(news_));
        return;
      }
      put_aside(gone.path, (shown ? "the old network is shown again: " : "") + told(news_));
      return;
    }
    default:
      return;
  }
}

void SlotWatch::keep() {
  const std::string path = accepted_path(spindle_);
  const std::string previous = previous_path(spindle_);
  if (exists_as_file(path)) {
    const auto bytes = rom::read_whole_file(path, rom::rom_largest_file_bytes);
    if (bytes != candidate_->bytes) rom::write_whole_file(previous, bytes);
  } else {
    fs::remove(previous);
  }
  rom::write_whole_file(path, candidate_->bytes);
  written_ = true;
  exchange_.confirm();
}

/// The new network did worse while its file was being written.
void SlotWatch::take_back() {
  if (!std::exchange(written_, false)) return;
  const std::string previous = previous_path(spindle_);
  if (exists_as_file(previous)) {
    fs::rename(previous, accepted_path(spindle_));
  } else {
    fs::remove(accepted_path(spindle_));
  }
}

void SlotWatch::accepted() {
  spdlog::info("exchange: {}: accepted ({}), kept as {}; a restart runs it too", candidate_->path, told(news_),
               accepted_path(spindle_));
  written_ = false;
  keep_now_();
  std::error_code unknown;
  if (stamp_of(candidate_->path) == candidate_->stamp) fs::remove(candidate_->path, unknown);
  accepted_ = std::move(candidate_->spindle);
  candidate_.reset();
}

void SlotWatch::put_aside(const std::string& path, const std::string& reason) {
  std::error_code failed;
  if (const auto stamp = stamp_of(path)) {
    fs::rename(path, path + ".refused", failed);
    if (failed) left_over_[path] = *stamp;
  }
  spdlog::error("exchange: {}: refused, {}{}", path, reason,
                failed ? "; it cannot be renamed (" + failed.message() + ") and is left alone"
                       : "; put aside under its name and \".refused\"");
}

void SlotWatch::look_for_file() {
  std::map<std::string, Stamp> found;
  std::set<std::string> ignored;
  for (const auto& entry : fs::directory_iterator(spindle_.config.exchange.slot)) {
    const std::string path = entry.path().string(), name = entry.path().filename().string();
    const auto stamp = is_new_network(name) ? stamp_of(path) : std::nullopt;
    if (!stamp) {
      std::error_code gone;
      if (looks_like_a_network(name) && fs::exists(entry.symlink_status(gone))) ignored.insert(path);
      continue;
    }
    const auto left = left_over_.find(path);
    if (left == left_over_.end() || left->second != *stamp) found[path] = *stamp;
  }
  for (const std::string& path : ignored) {
    if (ignored_.contains(path)) continue;
    spdlog::warn("exchange: {}: left alone; a new network is a regular file, and its name ends in .rom", path);
  }
  ignored_ = std::move(ignored);
  const std::map<std::string, Stamp> before = std::exchange(seen_, found);
  if (!predicts(newest_)) return;  // there is nothing to compare with yet
  for (const auto& [path, stamp] : found) {
    const auto seen = before.find(path);
    if (seen != before.end() && seen->second == stamp) return begin(path, stamp);
  }
}

void SlotWatch::begin(const std::string& path, const Stamp& stamp) {
  try {
    Candidate candidate{path, stamp, rom::read_whole_file(path, rom::rom_largest_file_bytes), nullptr};
    const std::string sha256 = rom::decode_rom_file(candidate.bytes, path).sha256;
    if (sha256 == running().file.sha256) {
      fs::remove(path);
      spdlog::info("exchange: {}: that network runs already; removed from the slot", path);
      return;
    }
    candidate.spindle = prepare_with(running(), path);
    if (candidate.spindle->file.sha256 != sha256) return;  // it has just been replaced: the next look sees that
    if (!has_sensors(newest_)) {
      throw rom::InputError({path, 0}, "exchange",
                            "no sensor is configured, so nothing can judge it; allowed at a restart only");
    }
    Cycle& cycle = candidate.spindle->cycle;
    cycle.start_at(start_field(candidate.spindle->file.network, newest_));
    candidate_.emplace(std::move(candidate));
    exchange_.offer(cycle);
  } catch (const std::exception& error) {
    exchange_.note_refused();
    put_aside(path, error.what());
  }
}

}  // namespace spindle_twin::firmware
