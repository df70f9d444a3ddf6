#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rom/read/strict_toml.hpp"

namespace spindle_twin::rom {

/// The names given so far in one list, each with its place in the list.
class Names {
 public:
  explicit Names(std::string kind) : kind_(std::move(kind)) {}

  std::string add(const TomlTable& table) {
    std::string name = table.name();
    table.show_as(name);
    const auto [known, fresh] = places_.try_emplace(name, Entry{places_.size(), table.where("name").line});
    if (!fresh) {
      table.fail("name", "the name \"" + name + "\" is taken by the " + kind_ + " of line " +
                             std::to_string(known->second.line));
    }
    return name;
  }

  std::size_t find(const TomlTable& table, const std::string& key, const std::string& name) const {
    const auto known = places_.find(name);
    if (known != places_.end()) return known->second.place;
    std::string all;
    for (const auto& [other, entry] : places_) all += (all.empty() ? "" : ", ") + other;
    table.fail(key, "there is no " + kind_ + " \"" + name + "\"; there are: " + (all.empty() ? "none" : all));
  }

  std::size_t find(const TomlTable& table, const std::string& key) const { return find(table, key, table.string(key)); }

  std::vector<std::size_t> find_all(const TomlTable& table, const std::string& key,
                                    const std::vector<std::string>& names) const {
    std::vector<std::size_t> found;
    for (const auto& name : names) {
      const std::size_t place = find(table, key, name);
      if (std::find(found.begin(), found.end(), place) != found.end()) {
        table.fail(key, "\"" + name + "\" is listed twice");
      }
      found.push_back(place);
    }
    return found;
  }

  std::pair<std::size_t, std::size_t> find_pair(const TomlTable& table, const std::string& key) const {
    const auto names = table.strings(key);
    if (names.size() != 2) table.fail(key, "must be the names of two different " + kind_ + "s");
    const auto both = find_all(table, key, names);
    return {both[0], both[1]};
  }

 private:
  struct Entry {
    std::size_t place;
    int line;
  };
  std::string kind_;
  std::map<std::string, Entry> places_;
};

}  // namespace spindle_twin::rom
