#include "fem_offline/reduce/choose_size.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace spindle_twin::fem_offline {
namespace choose_size_test {

rom::Network network_of(int nodes) {
  rom::Network network;
  network.nodes.resize(static_cast<std::size_t>(nodes));
  return network;
}

/// Of a certificate whose largest error is so many times the tolerance; nothing where it is kept.
std::vector<MissedOutput> missed_by(double ratio) {
  if (ratio <= 1.0) return {};
  return {{MissedOutput::Kind::key_point, "inner", ratio, 1.0}};
}

struct Grown {
  int nodes = 0;
  std::vector<int> tried, rounds;
};

/// From 80 nodes; `ratio_of(nodes)` of each certificate, of a basis for at most `most` nodes.
template <typename Ratio>
Grown grow(int most, const Ratio& ratio_of) {
  Grown grown;
  GrowSteps steps;
  steps.network = [&](int nodes) {
    grown.tried.push_back(nodes);
    return network_of(std::min(nodes, most));
  };
  steps.certify = [&](rom::Network& network, int round) {
    grown.rounds.push_back(round);
    return missed_by(ratio_of(static_cast<int>(network.nodes.size())));
  };
  const rom::Network kept = grow_until_kept(network_of(80), missed_by(ratio_of(80)), 320, steps);
  grown.nodes = static_cast<int>(kept.nodes.size());
  return grown;
}

double usual_fall(int nodes, int enough) { return std::exp(0.02 * (enough - nodes)); }

TEST(GrowUntilKept, a_network_that_keeps_the_tolerance_stays) {
  const Grown grown = grow(320, [](int) { return 0.9; });
  EXPECT_EQ(grown.nodes, 80);
  EXPECT_TRUE(grown.tried.empty());
}

TEST(GrowUntilKept, errors_that_fall_as_usual_take_one_more_network) {
  const Grown grown = grow(320, [](int nodes) { return usual_fall(nodes, 118); });
  EXPECT_EQ(grown.tried, std::vector<int>{130});
  EXPECT_EQ(grown.rounds, std::vector<int>{1});
  EXPECT_EQ(grown.nodes, 130);
}

TEST(GrowUntilKept, errors_that_fall_more_slowly_take_more_until_one_keeps_it) {
  const Grown grown = grow(320, [](int nodes) { return std::sqrt(usual_fall(nodes, 200)); });
  EXPECT_EQ(grown.rounds.size(), grown.tried.size());
  EXPECT_EQ(grown.rounds.back(), static_cast<int>(grown.rounds.size()));
  EXPECT_EQ(grown.nodes, grown.tried.back());
  EXPECT_GE(grown.nodes, 200);
  EXPECT_LT(grown.nodes, 260);
}

TEST(GrowUntilKept, where_none_keeps_it_the_one_that_misses_least_is_given) {
  const Grown grown = grow(320, [](int nodes) { return nodes < 320 ? 1.2 : 1.3; });
  EXPECT_EQ(grown.tried.back(), 320);
  EXPECT_EQ(grown.nodes, 80);
}

TEST(GrowUntilKept, ends_where_the_basis_has_no_more) {
  const Grown grown = grow(100, [](int nodes) { return nodes < 100 ? 3.0 : 2.0; });
  EXPECT_EQ(grown.nodes, 100);
  EXPECT_EQ(grown.tried.size(), 2u);
  EXPECT_EQ(grown.rounds, std::vector<int>{1});
}

}  // namespace choose_size_test
}  // namespace spindle_twin::fem_offline
