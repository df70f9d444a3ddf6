#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/integrate/law_terms.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/integrate/right_hand_side.hpp"
#include "rom/laws/channel_law.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

/// What laws read of a network's state is what its outputs say of the same temperatures.
namespace spindle_twin::rom::tests {
namespace law_readings_test {

BoundaryValues warm_values(const Network& network) {
  OperatingState state = network.boundaries.operating;
  state.speed_rpm = 5200.0;
  state.load = 0.7;
  state.environment_K.array() += 5.0;  // not the reference temperature
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  factors.heat *= 0.9;
  factors.conductance *= 1.2;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, factors, values);
  return values;
}

Eigen::VectorXd temperatures_of(const Network& network) {
  return Eigen::VectorXd::LinSpaced(network.capacity_J_per_K.rows(), 302.0, 324.0);
}

/// A law's value with everything that it reads taken from the outputs.
double value_by_outputs(const BoundLaw& bound, const BoundaryValues& values, const NetworkOutputs& outputs) {
  LawState state = nominal_state(bound, values.laws, values.environment_K);
  if (bound.first.part >= 0) state[LawInput::first_K] = outputs.part_mean_K[bound.first.part];
  if (bound.second.part >= 0) state[LawInput::second_K] = outputs.part_mean_K[bound.second.part];
  if (bound.pressure >= 0) state[LawInput::pressure_Pa] = outputs.contact_pressures_Pa[bound.pressure];
  if (bound.displacement >= 0) {
    state[LawInput::displacement_m] = bound.displacement_sign * outputs.deformations_m[bound.displacement];
  }
  return evaluate(bound.law, state).value;
}

TEST(LawReadings, are_part_means_pressures_and_displacements_of_the_outputs) {
  const Network network = make_network_with_laws();
  const auto shared = share(network);
  const Eigen::VectorXd temperatures_K = temperatures_of(network);
  NetworkOutputs outputs = make_network_outputs(network);
  evaluate_outputs(network, temperatures_K, outputs);
  ASSERT_GT(std::abs(outputs.contact_pressures_Pa[0] - 2e6), 1e4) << "far from what the law has as its nominal one";
  const BoundaryValues values = warm_values(network);
  BoundaryValues by_temperatures = values, by_readings = values, with_slopes = values;
  const LawTerms& laws = shared->laws();
  laws.at_temperatures(temperatures_K, by_temperatures);
  Eigen::VectorXd x(shared->nodes());
  shared->to_internal(temperatures_K, x);
  const Eigen::VectorXd readings = laws.rows().transpose() * x + laws.offset();
  laws.evaluate(readings, by_readings);
  Eigen::MatrixXd slopes(laws.count(), static_cast<Eigen::Index>(law_readings));
  laws.evaluate(readings, with_slopes, slopes);
  int segments = 0;
  for (const LawTerm& term : laws.list()) {
    double expected = value_by_outputs(term.bound, values, outputs);
    const auto is = [&](const BoundaryValues& found) {
      return term.source >= 0 ? found.heat_W[term.source] : found.conductance_W_per_m2K[term.conductance];
    };
    expected *= term.source >= 0 ? 0.9 : 1.2;
    if (term.segment >= 0) {
      ++segments;
      const double area_m2 = network.boundaries.conductances[static_cast<std::size_t>(term.conductance)].area_m2;
      expected = channel_W_per_m2K(expected, area_m2, std::abs(values.coolant_W_per_K[0]));
    }
    EXPECT_NEAR(is(by_temperatures), expected, 1e-9 * expected) << term.source << " " << term.conductance;
    EXPECT_NEAR(is(by_readings), expected, 1e-9 * expected) << term.source << " " << term.conductance;
    EXPECT_EQ(is(with_slopes), is(by_readings));
  }
  EXPECT_EQ(segments, 4);
}

TEST(LawReadings, of_one_thing_is_one_row_however_many_laws_read_it) {
  const Eigen::MatrixXd rows = share(make_network_with_laws())->laws().rows();
  for (Eigen::Index a = 0; a < rows.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) EXPECT_NE(rows.col(a), rows.col(b)) << a << " " << b;
  }
  EXPECT_EQ(rows.cols(), 4 + 1 + 1) << "four parts, a pressure, a displacement";
}

TEST(LawReadings, of_what_does_not_exist_are_refused) {
  const Network good = make_copper_node();
  using Change = std::function<void(BoundLaw&, Network&)>;
  const std::vector<Change> changes = {
      [](BoundLaw& law, Network& n) { law.first.part = static_cast<int>(n.parts.size()); },
      [](BoundLaw& law, Network& n) { law.second.part = static_cast<int>(n.parts.size()); },
      [](BoundLaw& law, Network& n) {
        law.first = {-1, static_cast<int>(n.boundaries.environments.size()), 300.0};
      },
      [](BoundLaw& law, Network& n) { law.pressure = static_cast<int>(n.contact_pressures.size()); },
      [](BoundLaw& law, Network& n) { law.displacement = static_cast<int>(n.deformations.size()); },
      [](BoundLaw& law, Network& n) { law.circuit = static_cast<int>(n.boundaries.circuits.size()); },
      [](BoundLaw& law, Network& n) {
        law.displacement = 0;
        n.deformations.clear();
      },
      [](BoundLaw& law, Network& n) {
        law.second.environment = 0;
        n.boundaries.environments.clear();
        n.boundaries.conductances[0].environment = -1;
      },
      [](BoundLaw&, Network& n) { n.boundaries.conductances[0].environment = 1; },
  };
  EXPECT_NO_THROW(NetworkOperator{good});
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Network network = good;
    changes[i](*network.boundaries.sources[0].physics, network);
    EXPECT_THROW(NetworkOperator{network}, std::invalid_argument) << "change " << i;
  }
  EXPECT_THROW(NetworkOperator{Network{}}, std::invalid_argument) << "no node at all";
}

/// The slopes of conductances depend on how far surroundings are from the reference temperature.
TEST(LawReadings, jacobian_is_that_of_the_right_hand_side_in_surroundings_of_any_temperature) {
  for (const bool one_node : {false, true}) {
    const Network network = one_node ? make_copper_node() : make_network_with_laws();
    const auto shared = share(network);
    const Eigen::Index n = shared->nodes();
    const BoundaryValues values = warm_values(network);
    RightHandSide rhs(shared);
    Eigen::VectorXd x(n), up(n), down(n);
    shared->to_internal(temperatures_of(network), x);
    rhs.follow(values, x.data());
    Eigen::MatrixXd jacobian(n, n);
    rhs.linearise(x.data(), jacobian);
    const double step = 0.01 * shared->internal_per_kelvin();
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::VectorXd moved = x;
      moved[k] = x[k] + step;
      rhs.evaluate(moved.data(), up.data());
      moved[k] = x[k] - step;
      rhs.evaluate(moved.data(), down.data());
      const Eigen::VectorXd expected = (down - up) / (2.0 * step);
      EXPECT_LT((jacobian.col(k) - expected).norm(), 1e-6 * jacobian.col(k).norm()) << "column " << k;
    }
  }
}

}  // namespace law_readings_test
}  // namespace spindle_twin::rom::tests
