#include "firmware/config/listeners.hpp"

namespace spindle_twin::firmware {
namespace {

bool is_same(const ListenPlace& one, const ListenPlace& other) {
  if (one.port == 0 || one.port != other.port) return false;
  return one.address == other.address || one.address == "0.0.0.0" || other.address == "0.0.0.0";
}

}  // namespace

void Listeners::add(const std::string& who, const ListenPlace& place, const rom::TomlTable& table) {
  for (const Listener& other : all_) {
    if (!is_same(place, other.place)) continue;
    table.fail("port", std::to_string(place.port) + " is that of " + other.who + " already; each needs one of its own");
  }
  all_.push_back({who, place});
}

}  // namespace spindle_twin::firmware
