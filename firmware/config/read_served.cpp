#include "firmware/config/read_served.hpp"

#include <algorithm>
#include <cctype>

#include "firmware/acquire/read_address.hpp"
#include "firmware/config/read_files.hpp"
#include "firmware/login/accounts.hpp"
#include "firmware/plant/plant_metrics.hpp"
#include "firmware/serve/tls_identity.hpp"
#include "rom/units.hpp"

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

/// Part of a topic of MQTT, where some characters mean something else.
std::string read_topic_part(const TomlTable& table, const std::string& key, const std::string& name) {
  constexpr std::size_t longest = 64;
  const bool is_plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == ' ';
  });
  if (name.empty() || name.size() > longest || !is_plain) {
    table.fail(key, "must be 1 to 64 letters, digits, '_', '-', '.' or spaces, is \"" + name + "\"");
  }
  return name;
}

/// [plant.tls]. Its files are checked like those of [serve.tls]: the same three, of the other side.
std::optional<PlantTls> read_plant_tls(const std::optional<TomlTable>& table, const std::string& config_path) {
  if (!table) return std::nullopt;
  TlsPlan files;
  files.clients_ca = beside(config_path, table->string("ca"));
  files.certificate = beside(config_path, table->string("certificate"));
  files.key = beside(config_path, table->string("key"));
  try {
    const TlsIdentity identity(files);
  } catch (const TlsFileError& error) {
    table->fail(error.key == "clients_ca" ? "ca" : error.key, error.what());
  }
  return PlantTls{files.clients_ca, files.certificate, files.key};
}

/// [http.commands]; its accounts are read as --check does.
std::optional<CommandPlan> read_commands(const std::optional<TomlTable>& table, const std::string& config_path,
                                         const std::string& address) {
  if (!table) return std::nullopt;
  CommandPlan plan;
  constexpr double s_per_min = 60.0;
  plan.accounts_path = beside(config_path, table->string("accounts"));
  plan.idle_s = s_per_min * table->number_or("idle_min", plan.idle_s / s_per_min, rom::between(1.0, 1440.0));
  plan.longest_s = rom::seconds_per_hour *
                   table->number_or("longest_h", plan.longest_s / rom::seconds_per_hour, rom::between(0.1, 168.0));
  plan.behind_tls = table->boolean_or("behind_tls", plan.behind_tls);
  const bool unencrypted = table->boolean_or("unencrypted", false);
  if (!address.starts_with("127.") && !plan.behind_tls && !unencrypted) {
    table->fail("unencrypted",
                "must be true where passwords pass a network as they are: http.address is " + address +
                    "; better leave it at 127.0.0.1, put a proxy with TLS before it and set behind_tls = true");
  }
  check_is_there(plan.accounts_path, table->where("accounts"), table->path("accounts"));
  plan.accounts = read_accounts(plan.accounts_path);
  return plan;
}

std::vector<std::string> read_published(const TomlTable& table) {
  std::vector<std::string> registers = table.strings_or_empty("registers");
  for (const std::string& name : registers) {
    if (is_published(name)) continue;
    table.fail("registers",
               "\"" + name +
                   "\" is none; allowed are names of firmware/serve/registers.md, without _float32, but for "
                   "orders and repetitions");
  }
  return registers;
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

ShowPlan read_http(const TomlTable& root, const std::string& config_path, Listeners& listeners) {
  const std::optional<TomlTable> table = root.optional_table("http");
  ShowPlan show;
  if (!table) return show;
  show.enabled = true;
  show.address = read_ipv4(*table, show.address);
  show.port = static_cast<int>(table->integer_or("port", show.port, 1, 65535));
  show.allow = read_allow(*table);
  if (table->has("names")) show.names = table->strings("names");
  show.notice = table->string_or("notice", show.notice);
  constexpr std::size_t longest_notice = 300;
  if (show.notice.size() > longest_notice) table->fail("notice", "must be a text of at most 300 bytes");
  listeners.add("[http]", {show.address, show.port}, *table);
  show.commands = read_commands(table->optional_table("commands"), config_path, show.address);
  if (show.commands && read_log_level(root) == "error") {
    root.fail("log_level", "must be \"warning\" or lower beside [http.commands]: who commands stands in the log");
  }
  return show;
}

PlantPlan read_plant(const std::optional<TomlTable>& table, const std::string& config_path) {
  PlantPlan plant;
  if (!table) return plant;
  plant.enabled = true;
  plant.host = table->string("host");
  if (plant.host.empty()) table->fail("host", "must be the broker's name or IPv4 address, is empty");
  plant.tls = read_plant_tls(table->optional_table("tls"), config_path);
  plant.port = static_cast<int>(table->integer_or("port", plant.tls ? plant_tls_port : plant.port, 1, 65535));
  plant.group = read_topic_part(*table, "group", table->string_or("group", plant.group));
  plant.node = read_topic_part(*table, "node", table->string("node"));
  plant.period_s = table->number_or("period_s", plant.period_s, rom::between(0.1, 3600.0));
  plant.registers = read_published(*table);
  plant.queue = static_cast<int>(table->integer_or("queue", plant.queue, 1, 10000));
  return plant;
}

}  // namespace spindle_twin::firmware
