#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/order_desk.hpp"
#include "firmware/login/accounts.hpp"
#include "firmware/login/login_limit.hpp"
#include "firmware/login/sessions.hpp"
#include "firmware/show/http_answer.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Commands from the page; made once from the configuration.
struct CommandPlan {
  std::string accounts_path;      ///< the file that says who may log in
  std::vector<Account> accounts;  ///< and what it says
  double idle_s = 900.0;          ///< a session ends when nothing was commanded for so long
  double longest_s = 28800.0;     ///< and after so long in any case
  bool behind_tls = false;        ///< browsers come through a proxy by TLS: the cookie never goes another way

  bool operator==(const CommandPlan&) const = default;
};

/// Hands an order to a spindle; false: there is no room for it. Waits for the server of the registers.
using GiveOrder = std::function<bool(const Order&)>;

/// The spindle that is commanded.
struct Commanded {
  std::string name;  ///< among several; empty: the only one
  const std::vector<std::string>& deformations;
  const GiveOrder& give;
};

/// What a page may command, behind a login: who, in sessions that end, and each command in the log. A password is
/// tried, and an order handed over, by another thread (Page::work). Without a plan all of it is refused by 403. What is
/// asked without the header that only our own page can send is 403 too, as another page's request may carry the cookie
/// of a browser that is too old to keep it back. For the port's thread.
class PageCommands {
 public:
  PageCommands(std::optional<CommandPlan> plan, Clock& clock);

  bool enabled() const { return static_cast<bool>(desk_); }
  /// {"commands": true, "user": "anna"}; user null: nobody.
  Page session(const HttpRequest& request) const;
  /// 200 with the session's cookie, 401 for a wrong name or password, 429 after too many, 400 for another body.
  Page log_in(const HttpRequest& request);
  /// Ends the session's trials too.
  Page log_out(const HttpRequest& request);
  /// 202 {"order_id": 60001}, under which the registers (order_id, order_result) say what becomes of it; 401 without a
  /// session, 400 for another body, 503 while the queue of orders is full. That a trial goes on is 200 without a
  /// number, and 409 from any session but the one that began it: looking on does not keep a session, and whose has
  /// ended cannot keep a trial.
  Page command(const HttpRequest& request, const Commanded& spindle);

 private:
  /// What work in another thread shares with this one.
  struct Desk {
    CommandPlan plan;
    Sessions sessions;
    Clock& clock;
    std::string nobody;  ///< a hash that no password has: who is unknown takes as long
  };
  /// A value that a session tries at a spindle.
  struct Trial {
    std::string token;
    GiveOrder give;
  };
  std::optional<Page> refused(const HttpRequest& request) const;
  std::optional<std::string> user_of(const HttpRequest& request, bool used) const;
  Page go_on(const HttpRequest& request, const Commanded& spindle, const Order& order) const;
  void note_trial(const HttpRequest& request, const Commanded& spindle, const Order& order);

  std::shared_ptr<Desk> desk_;  ///< empty: commands are off
  Clock& clock_;
  LoginLimit limit_;
  LogLimit too_many_;
  std::uint16_t last_id_ = 0;
  std::map<std::string, Trial> trials_;  ///< by the spindle's name, the last of each
};

}  // namespace spindle_twin::firmware
