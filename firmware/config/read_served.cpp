#include "firmware/config/read_served.hpp"

#include "firmware/acquire/read_address.hpp"

namespace spindle_twin::firmware {

using rom::TomlTable;

std::string read_log_level(const TomlTable& root) {
  return root.choice_or("log_level", "info", {"debug", "info", "warning", "error"});
}

ServePlan read_serve(const TomlTable& table, Listeners& listeners) {
  ServePlan serve;
  serve.address = read_ipv4(table, serve.address);
  serve.port = static_cast<int>(table.integer_or("port", serve.port, 1, 65535));
  serve.connections = static_cast<int>(table.integer_or("connections", serve.connections, 1, 256));
  serve.connections_per_host =
      static_cast<int>(table.integer_or("connections_per_host", serve.connections_per_host, 1, 256));
  serve.idle_s = table.number_or("idle_s", serve.idle_s, rom::between(1.0, 86400.0));
  serve.frame_deadline_s = table.number_or("frame_deadline_s", serve.frame_deadline_s, rom::between(0.05, 60.0));
  serve.allow = read_allow(table);
  serve.write = read_allow_or(table, "allow_write", serve.allow);
  listeners.add("[serve]", {serve.address, serve.port}, table);
  return serve;
}

ShowPlan read_http(const std::optional<TomlTable>& table, Listeners& listeners) {
  ShowPlan show;
  if (!table) return show;
  show.enabled = true;
  show.address = read_ipv4(*table, show.address);
  show.port = static_cast<int>(table->integer_or("port", show.port, 1, 65535));
  show.allow = read_allow(*table);
  if (table->has("names")) show.names = table->strings("names");
  listeners.add("[http]", {show.address, show.port}, *table);
  return show;
}

}  // namespace spindle_twin::firmware
