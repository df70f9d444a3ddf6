#pragma once

#include <numeric>
#include <vector>

namespace spindle_twin::fem_offline {

/// Union-find.
class Groups {
 public:
  explicit Groups(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0); }
  int leader(int member) {
    while (leader_[member] != member) member = leader_[member] = leader_[leader_[member]];
    return member;
  }
  void join(int a, int b) { leader_[leader(a)] = leader(b); }

 private:
  std::vector<int> leader_;
};

}  // namespace spindle_twin::fem_offline
