#include "firmware/show/page_commands.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "firmware/login/password.hpp"
#include "firmware/serve/allow_list.hpp"
#include "firmware/show/json_text.hpp"
#include "firmware/show/order_request.hpp"
#include "firmware/show/shown_spindle.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr const char* cookie_name = "spindle_twin_session";
// Orders of the page are told from a PLC's by their numbers.
constexpr std::uint16_t first_id = 60001, last_id = 65534;

Page error_page(int status, const std::string& reason) { return {status, "application/json", error_json(reason)}; }

/// Of "a=1; spindle_twin_session=...".
std::string token_of(const std::string& cookies) {
  const std::string name = fmt::format("{}=", cookie_name);
  std::size_t at = 0;
  while (at < cookies.size()) {
    const std::size_t end = std::min(cookies.size(), cookies.find(';', at));
    if (cookies.compare(at, name.size(), name) == 0) return cookies.substr(at + name.size(), end - at - name.size());
    at = cookies.find_first_not_of("; ", end);
  }
  return {};
}

std::string cookie(const std::string& token, bool behind_tls) {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", cookie_name, token,
                     token.empty() ? "; Max-Age=0" : "", behind_tls ? "; Secure" : "");
}

}  // namespace

PageCommands::PageCommands(std::optional<CommandPlan> plan, Clock& clock) : clock_(clock) {
  if (!plan) return;
  const double idle_s = plan->idle_s, longest_s = plan->longest_s;
  desk_ = std::shared_ptr<Desk>(
      new Desk{*std::move(plan), Sessions(idle_s, longest_s), clock, hash_password("nobody has this password")});
}

std::optional<std::string> PageCommands::user_of(const HttpRequest& request, bool used) const {
  return desk_->sessions.user_of(token_of(request.cookie), clock_.now_ns(), used);
}

std::optional<Page> PageCommands::refused(const HttpRequest& request) const {
  if (!desk_) return error_page(403, "commands are off: the configuration has no [http.commands]");
  if (!request.is_post) return Page{405};
  if (!request.is_from_a_page) {
    return error_page(403, "the header X-Spindle-Twin must be \"command\", and the page must come from here");
  }
  return std::nullopt;
}

Page PageCommands::session(const HttpRequest& request) const {
  if (request.is_post) return {405};
  const auto user = desk_ ? user_of(request, false) : std::nullopt;
  return {200, "application/json",
          fmt::format("{{\"commands\":{},\"user\":{}}}\n", enabled(), user ? json_text(*user) : "null")};
}

Page PageCommands::log_in(const HttpRequest& request) {
  if (auto page = refused(request)) return *std::move(page);
  const std::string from = address_text(request.peer);
  LoginRequest login;
  try {
    login = read_login(request.body);
  } catch (const std::invalid_argument& error) {
    return error_page(400, error.what());
  }
  const double wait_s = limit_.wait_s(request.peer, clock_.now_ns());
  if (wait_s > 0.0) {
    const auto before = too_many_.pass(clock_.now_ns());
    if (before) spdlog::warn("http: too many logins, the last from {}{}", from, LogLimit::also(*before));
    return error_page(429, fmt::format("too many logins: try again in {} s", std::ceil(wait_s)));
  }
  Page page;
  page.lane = Lane::commands;
  page.work = [desk = desk_, login, from](const std::atomic<bool>&) {
    const auto& accounts = desk->plan.accounts;
    const auto account =
        std::find_if(accounts.begin(), accounts.end(), [&](const Account& each) { return each.user == login.user; });
    const bool is_known = account != accounts.end();
    if (!is_password(is_known ? account->hash : desk->nobody, login.password) || !is_known) {
      // A name that nobody has may be a password in the wrong field.
      spdlog::warn("http: login as {} from {} refused", is_known ? login.user : "nobody known", from);
      return error_page(401, "the name or the password is wrong");
    }
    spdlog::warn("http: {} logged in from {}", login.user, from);
    Page in{200, "application/json", fmt::format("{{\"commands\":true,\"user\":{}}}\n", json_text(login.user))};
    in.cookie = cookie(desk->sessions.begin(login.user, desk->clock.now_ns()), desk->plan.behind_tls);
    return in;
  };
  return page;
}

Page PageCommands::log_out(const HttpRequest& request) {
  if (auto page = refused(request)) return *std::move(page);
  const std::string token = token_of(request.cookie);
  std::vector<GiveOrder> tried;
  if (const auto user = user_of(request, false)) {
    desk_->sessions.end(token);
    spdlog::warn("http: {} logged out from {}", *user, address_text(request.peer));
    for (const auto& [name, trial] : trials_) {
      if (trial.token == token) tried.push_back(trial.give);
    }
    std::erase_if(trials_, [&](const auto& each) { return each.second.token == token; });
  }
  Page out{200, "application/json", "{\"commands\":true,\"user\":null}\n"};
  out.cookie = cookie("", desk_->plan.behind_tls);
  if (tried.empty()) return out;
  Page page;
  page.lane = Lane::commands;
  page.work = [tried, out](const std::atomic<bool>&) {
    // Where the queue is full the trial ends by itself, as nobody says any more that it goes on.
    for (const GiveOrder& give : tried) give({OrderKind::trial, 0, trial_ends, {}});
    return out;
  };
  return page;
}

Page PageCommands::go_on(const HttpRequest& request, const Commanded& spindle, const Order& order) const {
  const auto trial = trials_.find(spindle.name);
  if (trial == trials_.end() || trial->second.token != token_of(request.cookie)) {
    return error_page(409, "this session has begun no trial here, or another one has taken it over");
  }
  Page page;
  page.lane = Lane::commands;
  page.work = [give = spindle.give, order](const std::atomic<bool>&) {
    if (!give(order)) return error_page(503, "the queue of orders is full: try again in some seconds");
    return Page{200, "application/json", "{\"goes_on\":true}\n"};
  };
  return page;
}

void PageCommands::note_trial(const HttpRequest& request, const Commanded& spindle, const Order& order) {
  if (order.kind != OrderKind::trial) return;
  if (order.code == trial_begins) trials_[spindle.name] = {token_of(request.cookie), spindle.give};
  if (order.code == trial_ends) trials_.erase(spindle.name);
}

Page PageCommands::command(const HttpRequest& request, const Commanded& spindle) {
  if (auto page = refused(request)) return *std::move(page);
  const auto user = user_of(request, false);
  if (!user) return error_page(401, "log in first: nobody is logged in, or the session has ended");
  OrderRequest wanted;
  try {
    wanted = read_order(request.body, spindle.deformations);
  } catch (const std::invalid_argument& error) {
    return error_page(400, error.what());
  }
  if (wanted.order.kind == OrderKind::trial && wanted.order.code == trial_goes_on) {
    return go_on(request, spindle, wanted.order);
  }
  user_of(request, true);
  note_trial(request, spindle, wanted.order);
  last_id_ = last_id_ < first_id || last_id_ == last_id ? first_id : static_cast<std::uint16_t>(last_id_ + 1);
  wanted.order.id = last_id_;
  const std::string who = fmt::format("http: {}{} at {}: {}", spindle.name.empty() ? "" : spindle.name + ": ", *user,
                                      address_text(request.peer), wanted.said);
  Page page;
  page.lane = Lane::commands;
  page.work = [give = spindle.give, order = wanted.order, who](const std::atomic<bool>&) {
    if (!give(order)) {
      spdlog::warn("{}: not taken, the queue of orders is full", who);
      return error_page(503, "the queue of orders is full: try again in some seconds");
    }
    spdlog::warn("{}, order {}", who, order.id);
    return Page{202, "application/json", fmt::format("{{\"order_id\":{}}}\n", order.id)};
  };
  return page;
}

}  // namespace spindle_twin::firmware
