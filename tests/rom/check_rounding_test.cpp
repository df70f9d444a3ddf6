#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "rom/file/rom_file.hpp"
#include "rom/laws/law_fields.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/texts.hpp"

/// A network keeps heat and weights to the rounding that its promise says, and not to twice as much; and what belongs
/// together is refused alone.
namespace spindle_twin::rom::tests {
namespace check_rounding_test {

std::string said(Network network, const std::function<void(Network&)>& change) {
  change(network);
  return spindle_twin::tests::refusal_of([&] { check_network(network, "x.rom"); });
}

Network plain() { return make_synthetic_network({3, 2, 2, true}, 5); }

/// `spoil` by `part` of what is still taken: 0.7 is, 1.4 is not.
void expect_taken_up_to_one(const std::string& refusal, const std::function<void(Network&, double)>& spoil) {
  for (const double part : {0.7, -0.7}) {
    EXPECT_EQ(said(plain(), [&](Network& network) { spoil(network, part); }), "accepted") << refusal << part;
  }
  for (const double part : {1.4, -1.4}) {
    const std::string found = said(plain(), [&](Network& network) { spoil(network, part); });
    EXPECT_NE(found.find(refusal), std::string::npos) << found;
  }
}

TEST(CheckNetwork, matrices_are_symmetric_and_conserve_heat_to_a_billionth_of_their_largest_entry) {
  constexpr double rounding = 1e-9;
  expect_taken_up_to_one("capacity_J_per_K: is not symmetric", [](Network& network, double part) {
    network.capacity_J_per_K(0, 3) += part * rounding * network.capacity_J_per_K.cwiseAbs().maxCoeff();
  });
  expect_taken_up_to_one("conduction_W_per_K: rows do not sum to zero", [](Network& network, double part) {
    network.conduction_W_per_K(2, 2) += part * rounding * network.conduction_W_per_K.cwiseAbs().maxCoeff();
  });
  expect_taken_up_to_one("columns do not sum to zero", [](Network& network, double part) {
    network.factors_m[0](0, 0) += part * rounding * network.factors_m[0].cwiseAbs().maxCoeff();
  });
  // Rows still sum to zero: what is taken from one neighbour is given to the other.
  expect_taken_up_to_one("conduction_W_per_K: is not symmetric", [](Network& network, double part) {
    const double change = part * rounding * network.conduction_W_per_K.cwiseAbs().maxCoeff();
    network.conduction_W_per_K(1, 2) += change;
    network.conduction_W_per_K(1, 1) -= change;
  });
}

TEST(CheckNetwork, heat_flows_from_warm_to_cold_to_a_billionth) {
  // A conduction between two nodes that nothing else conducts between, negative: it has the only negative eigenvalue.
  for (const double part : {0.7, 1.4}) {
    const std::string found = said(plain(), [&](Network& network) {
      network.conduction_W_per_K.setZero();
      network.conduction_W_per_K(0, 0) = network.conduction_W_per_K(1, 1) = 3.0;
      network.conduction_W_per_K(0, 1) = network.conduction_W_per_K(1, 0) = -3.0;
      const double conductance = -0.5e-9 * part * 3.0;  // two nodes: the eigenvalue is twice the conductance
      network.conduction_W_per_K(4, 4) = network.conduction_W_per_K(5, 5) = conductance;
      network.conduction_W_per_K(4, 5) = network.conduction_W_per_K(5, 4) = -conductance;
    });
    EXPECT_EQ(found.find("is not positive semidefinite") == std::string::npos, part < 1.0) << found;
  }
}

TEST(CheckNetwork, weights_sum_to_one_to_a_millionth) {
  constexpr double rounding = 1e-6;
  expect_taken_up_to_one("source bearing distribution: weights sum to",
                         [](Network& network, double part) { network.source_distribution(1, 0) += part * rounding; });
  expect_taken_up_to_one("row: weights sum to",
                         [](Network& network, double part) { network.key_points[1].row[0] += part * rounding; });
  expect_taken_up_to_one("mean row: weights sum to",
                         [](Network& network, double part) { network.parts[0].mean_row[0] += part * rounding; });
  expect_taken_up_to_one("candidate 1: weights sum to", [](Network& network, double part) {
    network.parts[0].candidate_rows(1, 0) += part * rounding;
  });
}

TEST(CheckNetwork, shares_of_a_limit_are_below_one_and_a_limit_says_whose_it_is) {
  const auto rule = [](double content, double confidence, double limit) {
    return said(plain(), [&](Network& network) {
      network.certificate.limit_rule = {content, confidence, false};
      network.certificate.deformations_m = {{3.0, 2.0, 1.0, limit}};
    });
  };
  EXPECT_EQ(rule(0.0, 0.0, 0.0), "accepted");
  EXPECT_EQ(rule(0.95, 0.99, 4.0), "accepted");
  EXPECT_EQ(rule(0.95, 0.0, 0.0), "accepted");
  EXPECT_EQ(rule(1e-12, 0.0, 4.0), "accepted") << "any share above none";
  for (const double none : {1.0, -1e-9, 1.5}) {
    EXPECT_NE(rule(none, 0.5, 0.0).find("that is no share below 1"), std::string::npos) << none;
    EXPECT_NE(rule(0.5, none, 0.0).find("that is no share below 1"), std::string::npos) << none;
  }
  EXPECT_NE(rule(0.0, 0.99, 4.0).find("has a limit without saying which share"), std::string::npos);
}

TEST(CheckNetwork, the_first_of_each_list_is_looked_at_as_any_other) {
  EXPECT_NE(said(plain(), [](Network& n) { n.parts[0].candidate_rows(0, 0) += 1.0; }).find("candidate 0: weights sum"),
            std::string::npos);
  EXPECT_NE(said(plain(), [](Network& n) { n.boundaries.operating.environment_K[0] = 0.0; }).find("operating_K"),
            std::string::npos);
}

TEST(CheckNetwork, each_matrix_has_its_rows_and_its_columns) {
  const auto refused = [](const std::function<void(Network&)>& change, const std::string& expected) {
    const std::string found = said(plain(), change);
    EXPECT_EQ(found, "x.rom: " + expected);
  };
  refused([](Network& n) { n.capacity_J_per_K.conservativeResize(13, 14); },
          "capacity_J_per_K: is 13 x 14, but must be 13 x 13");
  refused([](Network& n) { n.conduction_W_per_K.conservativeResize(12, 13); },
          "conduction_W_per_K: is 12 x 13, but must be 13 x 13");
  const std::string candidates =
      "part " + plain().parts[0].name + " candidates: must have at least one row and one column per node";
  refused([](Network& n) { n.parts[0].candidate_rows.resize(0, 13); }, candidates);
  refused([](Network& n) { n.parts[0].candidate_rows.conservativeResize(Eigen::NoChange, 12); }, candidates);
  refused(
      [](Network& n) {
        n.outlines = {{"x", Eigen::MatrixXd::Zero(3, 3)}};
      },
      "outline of x: must have r and z of at least three points");
  refused([](Network& n) { n.nodes.clear(); }, "nodes: none; at least one is needed");
  refused([](Network& n) { n.nodes.resize(2000, n.nodes[0]); },
          "capacity_J_per_K: is 13 x 13, but must be 2000 x 2000");
}

TEST(CheckNetwork, an_exchange_that_touches_nothing_conserves_heat) {
  EXPECT_EQ(said(plain(), [](Network& n) { n.factors_m[0].setZero(); }), "accepted");
}

TEST(CheckNetwork, a_law_of_speed_needs_a_reference_speed_however_small) {
  const auto at = [](double reference_rpm) {
    return said(plain(), [=](Network& n) { n.boundaries.reference_speed_rpm = reference_rpm; });
  };
  EXPECT_EQ(at(1e-3), "accepted");
  EXPECT_NE(at(0.0).find("reference_speed_rpm: must be positive where a law depends on speed"), std::string::npos);
}

TEST(CheckNetwork, what_may_not_stand_together_is_refused_together_alone) {
  const Network laws = make_network_with_laws();
  const auto heat = [&](const std::function<void(HeatSource&)>& change) {
    return said(laws, [&](Network& network) {
      for (HeatSource& source : network.boundaries.sources) {
        if (source.physics) return change(source);
      }
    });
  };
  EXPECT_EQ(heat([](HeatSource&) {}), "accepted");
  EXPECT_NE(heat([](HeatSource& source) { source.measured = true; }).find("measured: cannot follow a physical law"),
            std::string::npos);
  EXPECT_NE(heat([](HeatSource& source) { source.friction = true; }).find("friction: cannot be said of a physical"),
            std::string::npos);
  for (const bool measured : {false, true}) {
    EXPECT_EQ(heat([&](HeatSource& source) {
                source.physics.reset();
                source.measured = measured;
                source.friction = !measured;
              }),
              "accepted");
  }
  EXPECT_NE(heat([](HeatSource& source) {
              source.physics->law.mode = static_cast<LawMode>(law_modes.size());
            }).find("law mode: does not exist"),
            std::string::npos);
  EXPECT_EQ(heat([](HeatSource& source) { source.physics->law.mode = static_cast<LawMode>(law_modes.size() - 1); }),
            "accepted");
  EXPECT_NE(heat([](HeatSource& source) { source.physics->circuit = 0; }).find("law circuit: must be the circuit"),
            std::string::npos);
  EXPECT_NE(heat([](HeatSource& source) {
              source.physics->first = {0, 0, 300.0};
            }).find("must be a part's or an environment's, not both"),
            std::string::npos);
  EXPECT_NE(heat([](HeatSource& source) { source.physics->first.nominal_K = 0.0; }).find("above 0 K"),
            std::string::npos);
}

TEST(CheckNetwork, a_range_that_is_believed_may_be_one_number_but_not_upside_down) {
  EXPECT_EQ(said(plain(),
                 [](Network& network) {
                   network.boundaries.plausible = {{"load", between(2.0, 2.0)}};
                 }),
            "accepted");
  EXPECT_NE(said(plain(),
                 [](Network& network) {
                   network.boundaries.plausible = {{"load", between(2.0, 1.9)}};
                 })
                .find("plausible load: has no lowest <= highest"),
            std::string::npos);
}

}  // namespace check_rounding_test
}  // namespace spindle_twin::rom::tests
