#include "firmware/show/order_request.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "correction/growth/growth_reading.hpp"
#include "firmware/login/password.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

using JsonBody = nlohmann::json;

/// An object whose keys are taken out one by one; who is left over is unknown.
class Body {
 public:
  explicit Body(std::string_view text) : object_(JsonBody::parse(text, nullptr, false)) {
    if (!object_.is_object()) throw std::invalid_argument("the body must be a JSON object");
  }
  std::string text(const std::string& key, const std::string& allowed) {
    const JsonBody value = take(key);
    if (!value.is_string()) throw std::invalid_argument(key + ": must be " + allowed);
    return value.get<std::string>();
  }
  std::optional<std::string> text_if_any(const std::string& key, const std::string& allowed) {
    return object_.contains(key) ? std::optional(text(key, allowed)) : std::nullopt;
  }
  double number(const std::string& key, double least, double most) {
    const JsonBody value = take(key);
    const double number = value.is_number() ? value.get<double>() : not_a_value;
    if (number >= least && number <= most) return number;
    throw std::invalid_argument(fmt::format("{}: must be a number from {} to {}", key, least, most));
  }
  bool has(const std::string& key) const { return object_.contains(key); }
  void finish() const {
    if (!object_.empty()) throw std::invalid_argument("there is no key \"" + object_.begin().key() + "\" here");
  }

 private:
  JsonBody take(const std::string& key) {
    const auto found = object_.find(key);
    if (found == object_.end()) return {};
    JsonBody value = std::move(*found);
    object_.erase(found);
    return value;
  }

  JsonBody object_;
};

/// What may be ordered by one word; the numbers are those of the registers.
struct WordOrder {
  OrderKind kind;
  std::vector<std::pair<const char*, std::uint16_t>> words;
};

const std::map<std::string, WordOrder>& word_orders() {
  static const std::vector<std::pair<const char*, std::uint16_t>> switches{
      {"on", 1}, {"off", 0}, {"as_configured", not_present_code}};
  static const std::map<std::string, WordOrder> orders{
      {"tare", {OrderKind::tare, {{"take", 1}, {"clear", 2}}}},
      {"sensors", {OrderKind::sensors, {{"tare", 1}, {"clear_tare", 2}, {"acknowledge", 3}}}},
      {"correction", {OrderKind::correction, switches}},
      {"compensation", {OrderKind::compensation, switches}},
  };
  return orders;
}

OrderRequest by_word(const std::string& command, const WordOrder& known, Body& body) {
  std::string allowed;
  for (const auto& [word, code] : known.words) allowed += (allowed.empty() ? "" : ", ") + std::string(word);
  const std::string value = body.text("value", "one of " + allowed);
  for (const auto& [word, code] : known.words) {
    if (value == word) return {{known.kind, 0, code, {}}, fmt::format("{} {}", command, value)};
  }
  throw std::invalid_argument("value: must be one of " + allowed);
}

OrderRequest of_length(const std::vector<std::string>& deformations, Body& body) {
  using rom::m_per_um;
  constexpr double most_um = correction::largest_growth_um;
  constexpr double least_sd_um = correction::least_growth_deviation_um;
  constexpr double most_sd_um = correction::most_growth_deviation_um;
  const double um = body.number("um", -most_um, most_um);
  const double sd_um = body.number("sd_um", least_sd_um, most_sd_um);
  const std::string allowed = fmt::format("one of {}", fmt::join(deformations, ", "));
  std::size_t output = 0;
  if (const auto name = body.text_if_any("output", allowed)) {
    const auto found = std::find(deformations.begin(), deformations.end(), *name);
    if (found == deformations.end()) throw std::invalid_argument("output: must be " + allowed);
    output = static_cast<std::size_t>(found - deformations.begin());
  }
  return {{OrderKind::length, 0, 1, {output, m_per_um * um, m_per_um * sd_um}},
          fmt::format("length {} um, sd {} um, output {}", um, sd_um, output)};
}

/// More than any growth that is to be tried: who takes micrometres for millimetres goes a thousand times as far.
constexpr double most_tried_um = 50.0;

OrderRequest of_trial(Body& body) {
  OrderRequest request{{OrderKind::trial, 0, trial_begins, {}}, ""};
  if (body.has("um")) {
    const double um = body.number("um", -most_tried_um, most_tried_um);
    request.order.trial_m = rom::m_per_um * um;
    request.said = fmt::format("trial {} um", um);
    return request;
  }
  const std::string value = body.text("value", "end or go_on, or um the value to try");
  if (value != "end" && value != "go_on") throw std::invalid_argument("value: must be end or go_on");
  request.order.code = value == "end" ? trial_ends : trial_goes_on;
  request.said = "trial " + value;
  return request;
}

}  // namespace

OrderRequest read_order(std::string_view body, const std::vector<std::string>& deformations) {
  constexpr const char* allowed = "one of tare, sensors, correction, compensation, length, trial, acknowledge";
  Body told(body);
  const std::string command = told.text("command", allowed);
  const auto known = word_orders().find(command);
  OrderRequest request;
  if (known != word_orders().end()) {
    request = by_word(command, known->second, told);
  } else if (command == "length") {
    request = of_length(deformations, told);
  } else if (command == "trial") {
    request = of_trial(told);
  } else if (command == "acknowledge") {
    request = {{OrderKind::acknowledge, 0, 1, {}}, command};
  } else {
    throw std::invalid_argument(std::string("command: must be ") + allowed);
  }
  told.finish();
  return request;
}

LoginRequest read_login(std::string_view body) {
  Body told(body);
  LoginRequest login{told.text("user", "a name"), told.text("password", "a text")};
  told.finish();
  if (!is_user_name(login.user)) throw std::invalid_argument("user: must be 1 to 32 letters, digits, '_', '-' or '.'");
  if (login.password.size() > longest_password) throw std::invalid_argument("password: must have at most 128 bytes");
  return login;
}

}  // namespace spindle_twin::firmware
