#include "firmware/config/read_served.hpp"

#include "firmware/acquire/read_address.hpp"
#include "firmware/config/read_files.hpp"
#include "firmware/serve/tls_identity.hpp"

namespace spindle_twin::firmware {

using rom::TomlTable;

namespace {

/// [serve.tls]. Its files are read as the daemon will read them, so that --check finds what is wrong with them.
std::optional<TlsPlan> read_tls(const std::optional<TomlTable>& table, const std::string& config_path,
                                const ServePlan& serve, Listeners& listeners) {
  if (!table) return std::nullopt;
  TlsPlan tls;
  tls.address = read_ipv4(*table, serve.address);
  tls.port = static_cast<int>(table->integer_or("port", tls.port, 1, 65535));
  tls.certificate = beside(config_path, table->string("certificate"));
  tls.key = beside(config_path, table->string("key"));
  tls.clients_ca = beside(config_path, table->string("clients_ca"));
  if (table->has("revoked")) tls.revoked = beside(config_path, table->string("revoked"));
  if (table->has("write_roles")) tls.write_roles = table->strings_or_empty("write_roles");
  listeners.add("[serve.tls]", {tls.address, tls.port}, *table);
  try {
    const TlsIdentity identity(tls);
  } catch (const TlsFileError& error) {
    table->fail(error.key, error.what());
  }
  return tls;
}

}  // namespace

std::string read_log_level(const TomlTable& root) {
  return root.choice_or("log_level", "info", {"debug", "info", "warning", "error"});
}

ServePlan read_serve(const TomlTable& table, const std::string& config_path, Listeners& listeners) {
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
  serve.plain = table.boolean_or("plain", serve.plain);
  if (serve.plain) listeners.add("[serve]", {serve.address, serve.port}, table);
  serve.tls = read_tls(table.optional_table("tls"), config_path, serve, listeners);
  if (!serve.plain && !serve.tls) table.fail("plain", "is false, but there is no [serve.tls]: nobody could ask");
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
