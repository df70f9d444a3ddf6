#include "firmware/config/check_ports.hpp"

#include <string>
#include <vector>

namespace spindle_twin::firmware {
namespace {

struct Listener {
  std::string who;
  ListenPlace place;
  rom::TomlTable table;
};

bool is_same(const ListenPlace& one, const ListenPlace& other) {
  if (one.port == 0 || one.port != other.port) return false;
  return one.address == other.address || one.address == "0.0.0.0" || other.address == "0.0.0.0";
}

}  // namespace

void check_ports(const rom::TomlTable& root, const Config& config) {
  std::vector<Listener> all{{"[serve]", {config.serve.address, config.serve.port}, root.table("serve")}};
  if (const auto http = root.optional_table("http")) {
    all.push_back({"[http]", {config.show.address, config.show.port}, *http});
  }
  const bool is_only = root.is_table("device");
  const std::vector<rom::TomlTable> tables =
      is_only ? std::vector<rom::TomlTable>{root.table("device")} : root.tables_or_empty("device");
  for (std::size_t d = 0; d < config.devices.size() && d < tables.size(); ++d) {
    const auto place = config.devices[d].driver->listens();
    if (place) all.push_back({"device \"" + config.devices[d].name + "\"", *place, tables[d]});
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!is_same(all[i].place, all[j].place)) continue;
      all[i].table.fail("port", std::to_string(all[i].place.port) + " is that of " + all[j].who +
                                    " already; each needs one of its own");
    }
  }
}

}  // namespace spindle_twin::firmware
