#pragma once

#include <array>

namespace spindle_twin::firmware {

/// What the HTTP port answers; /routes lists it.
struct Route {
  const char* path;
  const char* doc;
};
inline constexpr std::array<Route, 16> routes{{
    {"/", "the live page, for a browser; it loads /live_page.css and /live_page.js"},
    {"/commissioning", "the page of commissioning; it loads /commissioning.css and /commissioning.js"},
    {"/routes", "this list"},
    {"/healthz", "200 while the prediction may be used (state running or degraded), 503 while it may not"},
    {"/api/v1/spindles", "the spindle's unit and state, as a list of one"},
    {"/api/v1/words", "what the codes and bits of the registers mean"},
    {"/api/v1/scene",
     "of the network that the daemon began with: outlines, key points, names of the heat flows, its hash; the notice"},
    {"/api/v1/state", "every register of the map as JSON, heat flows and bands of the factors, of one cycle"},
    {"/api/v1/events", "the same as server-sent events, at most one a second"},
    {"/api/v1/session", "whether commands are on, and who is logged in"},
    {"/api/v1/login", "POST: a session for commands, where [http.commands] is configured; else 403"},
    {"/api/v1/logout", "POST: its end"},
    {"/api/v1/command", "POST: an order, as a PLC writes it by registers; 401 without a session"},
    {"/api/v1/history/{HOURS}",
     "the last 1, 8, 24 or 168 hours of a history in SQLite, thinned; 400 of other hours, 404 without one"},
    {"/api/v1/growth", "whether the compensation helps: growth at the touch-offs in that history, week by week"},
    {"/metrics", "the registers for Prometheus, text format 0.0.4"},
}};

/// What may stand in the place of {HOURS}.
inline constexpr std::array<int, 4> history_hours{1, 8, 24, 168};

/// Of a daemon with several spindles, whose names stand in the place of {NAME}.
inline constexpr std::array<Route, 17> routes_of_several{{
    {"/", "the live page, for a browser; it loads /live_page.css and /live_page.js"},
    {"/commissioning", "the page of commissioning; it loads /commissioning.css and /commissioning.js"},
    {"/routes", "this list"},
    {"/healthz", "200 while the predictions of all spindles may be used, 503 while one may not"},
    {"/api/v1/spindles", "the names of the spindles, their units and states"},
    {"/api/v1/words", "what the codes and bits of the registers mean"},
    {"/api/v1/session", "whether commands are on, and who is logged in"},
    {"/api/v1/login", "POST: a session for commands, where [http.commands] is configured; else 403"},
    {"/api/v1/logout", "POST: its end"},
    {"/api/v1/spindles/{NAME}/command", "POST: an order, as a PLC writes it by registers; 401 without a session"},
    {"/api/v1/spindles/{NAME}/healthz", "200 while the prediction of this spindle may be used, else 503"},
    {"/api/v1/spindles/{NAME}/scene",
     "of the network that it began with: outlines, key points, names of the heat flows, its hash"},
    {"/api/v1/spindles/{NAME}/state",
     "every register of its map as JSON, heat flows and bands of the factors, of one cycle"},
    {"/api/v1/spindles/{NAME}/events", "the same as server-sent events, at most one a second"},
    {"/api/v1/spindles/{NAME}/history/{HOURS}",
     "its last 1, 8, 24 or 168 hours of a history in SQLite, thinned; 400 of other hours, 404 without one"},
    {"/api/v1/spindles/{NAME}/growth", "whether its compensation helps, from that history, week by week"},
    {"/metrics", "the registers of all spindles for Prometheus, text format 0.0.4, with the label spindle_name"},
}};

}  // namespace spindle_twin::firmware
