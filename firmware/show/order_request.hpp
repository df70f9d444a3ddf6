#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/cycle/order_desk.hpp"

namespace spindle_twin::firmware {

/// What a page orders: the same that a PLC orders by registers, and what to call it in the log.
struct OrderRequest {
  Order order = {};
  std::string said;  ///< "tare take"
};

/// Who logs in.
struct LoginRequest {
  std::string user;
  std::string password;
};

/// Of a body as {"command": "tare", "value": "take"}: tare (take, clear), sensors (tare, clear_tare, acknowledge),
/// correction and compensation (on, off, as_configured), acknowledge (without value), or {"command": "length", "um":
/// 3.2, "sd_um": 1.0, "output": "nose"}, the output one of `deformations` and the first without one; {"command":
/// "trial", "um": 10}, or with the value `end` or `go_on` in place of `um`. Throws std::invalid_argument saying what is
/// wrong and what is allowed, also for keys that nothing knows.
OrderRequest read_order(std::string_view body, const std::vector<std::string>& deformations);

/// Of a body as {"user": "anna", "password": "..."}. Throws likewise.
LoginRequest read_login(std::string_view body);

}  // namespace spindle_twin::firmware
