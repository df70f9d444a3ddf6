#pragma once

#include <array>

namespace spindle_twin::firmware {

/// What the HTTP port answers; the page at / lists it.
struct Route {
  const char* path;
  const char* doc;
};
inline constexpr std::array<Route, 5> routes{{
    {"/", "this list"},
    {"/healthz", "200 while the prediction may be used (state running or degraded), 503 while it may not"},
    {"/api/v1/state", "every register of the map as JSON, of one cycle"},
    {"/api/v1/events", "the same as server-sent events, at most one a second"},
    {"/metrics", "the same for Prometheus, text format 0.0.4"},
}};

}  // namespace spindle_twin::firmware
