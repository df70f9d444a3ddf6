#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/serve/allow_list.hpp"
#include "firmware/show/page_commands.hpp"

namespace spindle_twin::firmware {

/// What the HTTP port needs; made once from the configuration.
struct ShowPlan {
  bool enabled = false;                                ///< nobody listens unless the configuration asks for it
  std::string address = "127.0.0.1";                   ///< IPv4 to listen on
  int port = 9502;                                     ///< 0 takes a free one (tests)
  std::vector<AddressRange> allow;                     ///< clients that are answered
  std::vector<std::string> names;                      ///< of this computer, beside its own name; small letters
  std::string notice;                                  ///< what the page says first: that the spindle is simulated
  std::optional<CommandPlan> commands = std::nullopt;  ///< empty: the page can change nothing

  bool operator==(const ShowPlan&) const = default;
};

}  // namespace spindle_twin::firmware
