#include <gtest/gtest.h>

#include <cmath>

#include "correction/identify/identify.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace identify_closed_form_test {

constexpr double rise_K = 4.0, tau_s = 40.0, expansion_m_per_K = 2e-6, prior = 0.5;

/// One node, whose heat alone is unknown; key point, part and node are one place, read three times.
struct OneNode {
  OneNode() {
    options.priors = constant_priors();
    options.priors.film = options.priors.contact = 0.0;
    options.correlation_s = 0.0;
    options.placements = 0;
  }
  Identification found(double end_s) const {
    return identify(network, sensor_places(network), rom::constant_schedule(network.boundaries, end_s), options);
  }
  double deviation(double end_s) const { return found(end_s).parameters.at(0).estimate.deviation; }
  static double sensitivity_K(double time_s) { return rise_K * (1.0 - std::exp(-time_s / tau_s)); }

  rom::Network network = rom::tests::make_single_node();
  IdentifyOptions options;
};

/// What readings tell of one parameter, each a sensitivity and a variance.
double information(const std::vector<std::pair<double, double>>& readings, double offset_K) {
  double squares = 0.0, products = 0.0, ones = 0.0;
  for (const auto& [sensitivity, variance] : readings) {
    squares += sensitivity * sensitivity / variance;
    products += sensitivity / variance;
    ones += 1.0 / variance;
  }
  // A constant error that the readings share: Sherman and Morrison.
  const double taken = offset_K * offset_K * products * products / (1.0 + offset_K * offset_K * ones);
  return squares - taken;
}

double deviation_of(double squares) { return 1.0 / std::sqrt(1.0 / (prior * prior) + squares); }

TEST(Identify, a_cycle_that_ends_between_two_readings_has_one_at_its_end) {
  const OneNode node;
  for (const double end_s : {20.0, 25.0}) {
    std::vector<std::pair<double, double>> readings;
    for (const double time_s : {10.0, 20.0, 25.0}) {
      if (time_s <= end_s) readings.emplace_back(OneNode::sensitivity_K(time_s), 0.03 * 0.03);
    }
    const Identification found = node.found(end_s);
    EXPECT_NEAR(found.growth_m, OneNode::sensitivity_K(end_s) * expansion_m_per_K, 1e-9);
    EXPECT_NEAR(found.prior_m, prior * OneNode::sensitivity_K(end_s) * expansion_m_per_K, 5e-9);
    const double expected = deviation_of(3.0 * information(readings, 0.0));
    EXPECT_NEAR(found.parameters.at(0).estimate.deviation, expected, 4e-3 * expected) << end_s;
  }
}

TEST(Identify, noise_and_floor_add_their_squares_and_readings_closer_than_they_last_share_them) {
  OneNode node;
  node.options.floor_K = 0.04;
  for (const double correlation_s : {0.0, 1.0, 5.0, 20.0, 60.0}) {
    node.options.correlation_s = correlation_s;
    std::vector<std::pair<double, double>> readings;
    for (int k = 1; k <= 60; ++k) {
      readings.emplace_back(OneNode::sensitivity_K(10.0 * k), 0.05 * 0.05 * std::max(1.0, correlation_s / 10.0));
    }
    const double expected = deviation_of(3.0 * information(readings, 0.0));
    EXPECT_NEAR(node.deviation(600.0), expected, 1e-3 * expected) << correlation_s;
  }
}

TEST(Identify, a_constant_error_of_each_sensor_is_not_averaged_away) {
  OneNode node;
  node.options.offset_deviation_K = 0.2;
  std::vector<std::pair<double, double>> readings;
  for (int k = 1; k <= 60; ++k) readings.emplace_back(OneNode::sensitivity_K(10.0 * k), 0.03 * 0.03);
  const double expected = deviation_of(3.0 * information(readings, 0.2));
  EXPECT_NEAR(node.deviation(600.0), expected, 2e-3 * expected);
}

TEST(Identify, of_more_readings_than_a_hundred_and_twenty_some_are_taken_as_one_of_their_weight) {
  OneNode node;
  node.options.sample_s = 1.0;
  std::vector<std::pair<double, double>> readings;
  for (int k = 3; k <= 249; k += 3) readings.emplace_back(OneNode::sensitivity_K(k), 0.03 * 0.03 / 3.0);
  readings.emplace_back(OneNode::sensitivity_K(250), 0.03 * 0.03);
  const double expected = deviation_of(3.0 * information(readings, 0.0));
  EXPECT_NEAR(node.deviation(250.0), expected, 2e-4 * expected);
}

TEST(Identify, surroundings_of_a_reading_are_those_of_the_middle_of_its_period) {
  OneNode node;
  rom::Schedule warming = rom::constant_schedule(node.network.boundaries, 600.0);
  warming.rows = {warming.rows.front(), warming.rows.front()};
  warming.rows.back().time_s = 600.0;
  warming.rows.back().state.environment_K.array() += 30.0;
  const Identification found = identify(node.network, {}, warming, node.options);
  // Behind a ramp by its time constant.
  EXPECT_NEAR(found.growth_m, (rise_K + 30.0 * (600.0 - tau_s) / 600.0) * expansion_m_per_K, 0.02 * expansion_m_per_K);
}

TEST(Identify, each_parameter_is_told_with_its_prior_and_where_it_was_linearised) {
  OneNode node;
  const Identification found = node.found(100.0);
  ASSERT_EQ(found.parameters.size(), 1U);
  EXPECT_EQ(found.parameters[0].kind, ParameterKind::heat);
  EXPECT_EQ(found.parameters[0].estimate.value, 0.0);
  EXPECT_EQ(found.parameters[0].estimate.prior_deviation, prior);
  EXPECT_TRUE(found.placements.empty());
  EXPECT_TRUE(found.first_placement.empty());
}

/// plates() for half an hour, and what a set of places knows of it.
struct Plates {
  explicit Plates(int placements) { options.placements = placements, options.priors = constant_priors(); }
  Identification of(const std::vector<SensorPlace>& sensors) const {
    return identify(network, sensors, rom::constant_schedule(network.boundaries, 1800.0), options);
  }
  std::vector<SensorPlace> places(const std::vector<std::string>& names) const {
    return find_places(network, names, "sensors");
  }
  rom::Network network = plates();
  IdentifyOptions options;
};

TEST(Identify, without_one_sensor_is_known_what_the_others_know) {
  const Plates plates(0);
  const std::vector<SensorPlace> all = plates.places({"point 0", "point 2", "point 3"});
  const Identification found = plates.of(all);
  ASSERT_EQ(found.without_m.size(), 3U);
  for (std::size_t left_out = 0; left_out < 3; ++left_out) {
    std::vector<SensorPlace> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    const double expected_m = plates.of(others).posterior_m;
    EXPECT_NEAR(found.without_m[left_out], expected_m, 1e-9 * expected_m) << left_out;
  }
}

TEST(Identify, each_open_place_is_told_with_what_it_would_leave_best_first) {
  Plates plates(2);
  plates.options.offset_deviation_K = 0.05;
  const std::vector<SensorPlace> one = plates.places({"point 1"});
  const Identification found = plates.of(one);
  ASSERT_EQ(found.placements.size(), 2U);
  ASSERT_EQ(found.first_placement.size(), sensor_places(plates.network).size());
  EXPECT_EQ(found.placements[0].place.name, found.first_placement[0].place.name);
  plates.options.placements = 0;
  for (std::size_t p = 0; p < found.first_placement.size(); ++p) {
    const Placement& next = found.first_placement[p];
    if (p % 9 != 0 && next.place.name != "point 0") continue;
    const double expected_m = plates.of({one[0], next.place}).posterior_m;
    EXPECT_NEAR(next.deformation_m, expected_m, 1e-6 * expected_m) << next.place.name;
    EXPECT_LE(found.first_placement[p > 0 ? p - 1 : 0].deformation_m, next.deformation_m);
  }
  const double two_m = plates.of({one[0], found.placements[0].place, found.placements[1].place}).posterior_m;
  EXPECT_NEAR(found.placements[1].deformation_m, two_m, 1e-6 * two_m);
}

TEST(Identify, nothing_is_put_on_a_part_that_is_closed) {
  Plates plates(1);
  plates.options.closed_parts = {plates.network.parts[0].name, plates.network.parts[2].name};
  const auto is_closed = [&](const SensorPlace& place) {
    return place.part == plates.options.closed_parts[0] || place.part == plates.options.closed_parts[1];
  };
  const Identification found = plates.of({});
  ASSERT_EQ(found.placements.size(), 1U);
  std::size_t open = 0;
  for (const SensorPlace& place : sensor_places(plates.network)) open += is_closed(place) ? 0 : 1;
  EXPECT_EQ(found.first_placement.size(), open);
  for (const Placement& placement : found.first_placement) EXPECT_FALSE(is_closed(placement.place));

  plates.options.closed_parts.clear();
  for (const rom::PartOutput& part : plates.network.parts) plates.options.closed_parts.push_back(part.name);
  plates.options.placements = 2;
  const Identification last = plates.of({});
  ASSERT_EQ(last.first_placement.size(), 1U) << "the air node is of no part";
  EXPECT_EQ(last.placements.size(), 2U) << "two in one place tell more than one";

  OneNode node;
  node.options.placements = 3;
  node.options.closed_parts = {"body"};
  EXPECT_TRUE(node.found(100.0).placements.empty()) << "there is no place left";
  node.options.closed_parts.clear();
  EXPECT_EQ(node.found(100.0).placements.size(), 3U) << "there are three";
}

TEST(Identify, where_nothing_is_said_readings_and_wishes_are_the_usual_ones) {
  const IdentifyOptions usual;
  EXPECT_EQ(usual.sample_s, 10.0);
  EXPECT_EQ(usual.noise_K, EstimatorOptions().noise_K);
  EXPECT_EQ(usual.correlation_s, EstimatorOptions().correlation_s);
  EXPECT_EQ(usual.offset_deviation_K, 0.0);
  EXPECT_EQ(usual.floor_K, 0.0);
  EXPECT_EQ(usual.placements, 3);
}

TEST(SensorPlaces, are_key_points_then_means_of_parts_then_nodes) {
  rom::Network network = plates();
  network.nodes[1].r_m = 0.25;
  network.nodes[1].z_m = 0.75;
  const std::vector<SensorPlace> places = sensor_places(network);
  const std::size_t points = network.key_points.size(), parts = network.parts.size();
  ASSERT_EQ(places.size(), points + parts + network.nodes.size());
  EXPECT_EQ(places[0].name, network.key_points[0].name);
  EXPECT_EQ(places[0].r_m, network.key_points[0].r_m);
  EXPECT_EQ(places[points].name, network.parts[0].name);
  EXPECT_EQ(places[points].part, network.parts[0].name);
  EXPECT_EQ(places[points].r_m, 0.0);
  EXPECT_EQ(places[points].z_m, 0.0);
  EXPECT_EQ(places[points].row, network.parts[0].mean_row);
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    const SensorPlace& place = places[points + parts + i];
    EXPECT_EQ(place.name, network.nodes[i].name);
    EXPECT_EQ(place.row, Eigen::VectorXd::Unit(place.row.size(), static_cast<Eigen::Index>(i)));
    EXPECT_EQ(place.r_m, network.nodes[i].r_m);
    EXPECT_EQ(place.z_m, network.nodes[i].z_m);
  }
  const std::vector<SensorPlace> asked = find_places(network, {network.nodes[4].name, "point 3"}, "sensors");
  ASSERT_EQ(asked.size(), 2U);
  EXPECT_EQ(asked[0].name, network.nodes[4].name);
  EXPECT_EQ(asked[1].name, "point 3");
}

TEST(SensorPlaces, that_are_unknown_are_refused_with_key_points_and_parts) {
  rom::Network network = plates();
  std::string allowed;
  for (const rom::KeyPoint& point : network.key_points) allowed += point.name + ", ";
  for (const rom::PartOutput& part : network.parts) allowed += part.name + ", ";
  try {
    find_places(network, {"point 0", "nowhere"}, "--sensors");
    ADD_FAILURE();
  } catch (const rom::InputError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("'nowhere' does not exist; allowed: " + allowed + "or the name of a node"), std::string::npos)
        << said;
  }
}

}  // namespace identify_closed_form_test
}  // namespace spindle_twin::correction::test
