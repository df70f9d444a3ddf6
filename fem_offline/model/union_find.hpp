#pragma once

#include <numeric>
#include <vector>

namespace spindle_twin::fem_offline {

/// Which of `count` things have been joined, directly or through others (union-find with path halving).
class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0); }
  int leader(int member) {
    while (leader_[member] != member) member = leader_[member] = leader_[leader_[member]];
    return member;
  }
  void join(int a, int b) { leader_[leader(a)] = leader(b); }

 private:
  std::vector<int> leader_;
};

}  // namespace spindle_twin::fem_offline
