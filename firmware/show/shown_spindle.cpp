#include "firmware/show/shown_spindle.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <string>

#include "firmware/serve/fill_image.hpp"
#include "firmware/show/factor_json.hpp"
#include "firmware/show/flow_json.hpp"
#include "firmware/show/json_text.hpp"
#include "firmware/show/routes.hpp"
#include "firmware/show/state_json.hpp"

namespace spindle_twin::firmware {
namespace {

Page no_history() {
  return {404, "application/json", error_json("this spindle keeps no history in SQLite: history.path in its file")};
}

}  // namespace

double stale_after_s(double cycle_s) {
  constexpr double late_cycles = 3.0, least_s = 5.0;
  return std::max(least_s, late_cycles * cycle_s);
}

std::string error_json(const std::string& reason) { return "{\"error\":" + json_text(reason) + "}\n"; }

void ShownSpindle::renew(std::int64_t now_ns) {
  tap_.read(snapshot_);
  fill_image(snapshot_, now_ns, image_);
}

Page ShownSpindle::health(std::int64_t now_ns) const {
  const double age_s = 1e-9 * static_cast<double>(now_ns - snapshot_.time_ns);
  const bool is_usable = snapshot_.state == State::running || snapshot_.state == State::degraded;
  const std::string who = spindle_.name.empty() ? "" : spindle_.name + ": ";
  if (!is_usable) return {503, "application/json", error_json(who + "no prediction that may be used")};
  if (age_s > spindle_.stale_after_s) return {503, "application/json", error_json(who + "the cycle does not run")};
  return {200, "application/json", "{\"ok\":true}\n"};
}

Page ShownSpindle::history(const std::string& hours) const {
  if (!has_history()) return no_history();
  for (const int each : history_hours) {
    if (hours != std::to_string(each)) continue;
    Page page;
    page.work = [history = spindle_.history, each](const std::atomic<bool>& stop) { return history(each, stop); };
    return page;
  }
  return {400, "application/json", error_json(fmt::format("hours: allowed are {}", fmt::join(history_hours, ", ")))};
}

Page ShownSpindle::growth() const {
  if (!spindle_.growth) return no_history();
  Page page;
  page.work = spindle_.growth;
  return page;
}

std::string ShownSpindle::state() const {
  return state_json(image_, spindle_.names, factors_json(snapshot_, spindle_.names) + "," + flows_json(snapshot_));
}

std::string ShownSpindle::summary() const {
  std::string state;
  for (const CodeName& code : entry_of(Register::state).codes) {
    if (code.value == static_cast<unsigned>(snapshot_.state)) state = code.name;
  }
  return fmt::format("{{\"name\":{},\"unit\":{},\"spindle\":{},\"state\":{}}}", json_text(spindle_.name), spindle_.unit,
                     json_text(spindle_.names.spindle), json_text(state));
}

}  // namespace spindle_twin::firmware
