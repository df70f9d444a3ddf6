#pragma once

#include <string>
#include <vector>

#include "firmware/acquire/driver.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// Where the daemon listens: [serve], [http] and the devices that nodes connect to.
class Listeners {
 public:
  /// Throws rom::InputError at the key `port` of the table where somebody listens there already. An address of 0.0.0.0
  /// takes the port of all addresses; port 0 (tests) is a free one.
  void add(const std::string& who, const ListenPlace& place, const rom::TomlTable& table);

 private:
  struct Listener {
    std::string who;
    ListenPlace place;
  };
  std::vector<Listener> all_;
};

}  // namespace spindle_twin::firmware
