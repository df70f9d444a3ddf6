#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/units.hpp"
#include "tests/rom/by_hand_texts.hpp"
#include "tests/support/texts.hpp"

/// Numbers of a hand-written network are taken up to the ends that its page says and not beyond, and what is left out
/// has the value that the page says.
namespace spindle_twin::rom::tests {
namespace by_hand_edges_test {

using spindle_twin::tests::refusal_of;
using spindle_twin::tests::with;

/// Two nodes of a shaft and one of air; everything with a number stands in it once.
const std::string everything = in_a_room("edges", R"([[node]]
name = "a"
part = "shaft"
capacity_J_per_K = 100.0
at = [10.0, 20.0]
[[node]]
name = "b"
part = "shaft"
mass_kg = 0.5
heat_capacity_J_per_kgK = 400.0
at = [30.0, -40.0]
[[node]]
name = "hall"
capacity_J_per_K = 7.0
[[conduction]]
between = ["a", "b"]
conductance_W_per_K = 2.0
[[gap_film]]
name = "around"
faces = [{ between = ["hall", "a"], area_mm2 = 200.0 }, { between = ["hall", "b"], area_mm2 = 300.0 }]
coefficient_W_per_m2K = 25.0
[[film]]
name = "to_room"
surrounding = "room"
faces = [{ node = "b", area_mm2 = 50000.0 }, { node = "a", area_mm2 = 700.0 }]
coefficient_W_per_m2K = 20.0
[[heat]]
name = "heater"
heat_W = 30.0
weights = { a = 0.5, b = 0.5 }
[[key_point]]
name = "middle"
weights = { a = 0.25, b = 0.75 }
[[deformation]]
name = "nose"
um_per_K = { a = 1.5, b = -0.5 }
[[contact_pressure]]
name = "seat"
assembly_pressure_Pa = 2e6
Pa_per_K = { a = 3e4 }
)");

std::string said_of(const std::string& text) {
  return refusal_of([&] { parse_by_hand(text, "net.toml"); });
}

Network read(const std::string& text) { return parse_by_hand(text, "net.toml"); }

std::string written(double value) {
  std::ostringstream text;
  text.precision(17);
  text << std::scientific << value;
  return text.str();
}

struct Ends {
  const char* given;  ///< with its number, that of `everything`
  const char* key;
  double least, most;
};

TEST(ByHandEdges, each_number_is_taken_at_its_ends_and_refused_beyond) {
  ASSERT_EQ(said_of(everything), "accepted");
  const std::vector<Ends> numbers = {
      {"capacity_J_per_K = 100.0", "capacity_J_per_K = ", 1e-6, 1e9},
      {"mass_kg = 0.5", "mass_kg = ", 1e-9, 1e6},
      {"heat_capacity_J_per_kgK = 400.0", "heat_capacity_J_per_kgK = ", 1.0, 1e5},
      {"at = [10.0,", "at = [", -1e5, 1e5},
      {"at = [30.0,", "at = [", -1e5, 1e5},
      {"conductance_W_per_K = 2.0", "conductance_W_per_K = ", 1e-9, 1e9},
      {"um_per_K = { a = 1.5", "um_per_K = { a = ", -1e6, 1e6},
      {"assembly_pressure_Pa = 2e6", "assembly_pressure_Pa = ", -1e12, 1e12},
      {"Pa_per_K = { a = 3e4", "Pa_per_K = { a = ", -1e12, 1e12},
      {"temperatures_degC = { room = 20.0", "temperatures_degC = { room = ", -273.1, 1000.0},
      {"reference_temperature_degC = 20.0", "reference_temperature_degC = ", -273.1, 1000.0},
  };
  for (const Ends& number : numbers) {
    const std::string comma = std::string(number.given).ends_with(',') ? "," : "";
    const auto with_value = [&](double value) {
      return said_of(with(everything, number.given, number.key + written(value) + comma));
    };
    EXPECT_EQ(with_value(number.least), "accepted") << number.key;
    EXPECT_EQ(with_value(number.most), "accepted") << number.key;
    const double margin = 0.4 * std::abs(number.least);
    EXPECT_NE(with_value(number.least - margin), "accepted") << number.key;
    EXPECT_NE(with_value(1.4 * number.most), "accepted") << number.key;
  }
  EXPECT_NE(said_of(with(everything, "{ room = 20.0", "{ room = -273.15")), "accepted") << "absolute zero";
  EXPECT_EQ(said_of(with(everything, "area_mm2 = 700.0", "area_mm2 = 1e9")), "accepted");
  EXPECT_NE(said_of(with(everything, "area_mm2 = 700.0", "area_mm2 = 1.4e9")), "accepted");
  EXPECT_EQ(said_of(with(everything, "heat_W = 30.0", "heat_W = 0.0")), "accepted");
  EXPECT_EQ(said_of(with(everything, "speed_rpm = 1000.0", "speed_rpm = 1000.0\nload = 0.0")), "accepted");
}

TEST(ByHandEdges, a_key_point_is_within_a_hundred_metres_as_a_node_is) {
  const auto at = [](const std::string& place) {
    return said_of(with(everything, "name = \"middle\"", "name = \"middle\"\nat = " + place)) == "accepted";
  };
  EXPECT_TRUE(at("[1e5, -1e5]"));
  EXPECT_TRUE(at("[-1e5, 1e5]"));
  for (const char* far : {"[1.4e5, 0.0]", "[-1.4e5, 0.0]", "[0.0, 1.4e5]", "[0.0, -1.4e5]"})
    EXPECT_FALSE(at(far)) << far;
}

TEST(ByHandEdges, a_file_that_is_not_there_or_is_a_folder_cannot_be_read) {
  for (const char* path : {"/nowhere/net.toml", "/"}) {
    EXPECT_EQ(refusal_of([&] { read_by_hand(path); }), std::string(path) + ": cannot be read as a file");
  }
}

TEST(ByHandEdges, weights_and_speed_laws_add_up_to_one_to_a_billionth) {
  for (const double part : {0.8, -0.8, 1.3, -1.3}) {
    const bool taken = std::abs(part) < 1.0;
    const std::string share = written(0.5 + part * 1e-9), rest = written(1.0 + part * 1e-9);
    EXPECT_EQ(said_of(with(everything, "{ a = 0.5, b = 0.5 }", "{ a = 0.5, b = " + share + " }")) == "accepted", taken);
    EXPECT_EQ(said_of(with(everything, "heat_W = 30.0", "heat_W = 30.0\nspeed_law = { constant = " + rest + " }")) ==
                  "accepted",
              taken);
  }
}

TEST(ByHandEdges, a_speed_law_is_the_sum_of_its_pieces_and_each_is_zero_unless_written) {
  const auto law_of = [](const std::string& law) {
    return read(with(everything, "heat_W = 30.0", "heat_W = 30.0\nspeed_law = " + law)).boundaries.sources[0].law;
  };
  const SpeedLaw power = law_of("{ speed_terms = [[0.75, 1.5], [0.25, 2.0]], zero_at_standstill = true }");
  EXPECT_EQ(power.constant, 0.0);
  EXPECT_EQ(power.load_squared, 0.0);
  EXPECT_TRUE(power.zero_at_standstill);
  ASSERT_EQ(power.speed_terms.size(), 2U);
  EXPECT_EQ(power.speed_terms[0].coefficient, 0.75);
  EXPECT_EQ(power.speed_terms[0].exponent, 1.5);
  EXPECT_EQ(power.speed_terms[1].coefficient, 0.25);
  EXPECT_EQ(power.speed_terms[1].exponent, 2.0);
  const SpeedLaw load = law_of("{ constant = 0.25, load_squared = 0.75 }");
  EXPECT_EQ(load.constant, 0.25);
  EXPECT_EQ(load.load_squared, 0.75);
  EXPECT_FALSE(load.zero_at_standstill);
  EXPECT_TRUE(load.speed_terms.empty());
}

TEST(ByHandEdges, a_heat_is_friction_where_its_law_knows_speed_and_no_load_unless_it_says_otherwise) {
  const auto friction = [](const std::string& law) {
    return read(with(everything, "heat_W = 30.0", "heat_W = 30.0\n" + law)).boundaries.sources[0].friction;
  };
  const std::string of_speed = "speed_law = { speed_terms = [[1.0, 1.0]] }\n";
  EXPECT_FALSE(friction(""));
  EXPECT_TRUE(friction(of_speed));
  EXPECT_FALSE(friction("speed_law = { speed_terms = [[0.5, 1.0]], load_squared = 0.5 }\n"));
  EXPECT_FALSE(friction(of_speed + "friction = false\n"));
  EXPECT_TRUE(friction("friction = true\n"));
}

TEST(ByHandEdges, places_are_in_metres_and_a_key_points_is_the_mean_of_its_nodes_unless_it_has_its_own) {
  const Network network = read(everything);
  EXPECT_NEAR(network.nodes[0].r_m, 0.010, 1e-15);
  EXPECT_NEAR(network.nodes[1].z_m, -0.040, 1e-15);
  EXPECT_EQ(network.nodes[2].r_m, 0.0);
  EXPECT_TRUE(network.nodes[2].part.empty());
  EXPECT_EQ(network.key_points[0].part, "shaft");
  EXPECT_NEAR(network.key_points[0].r_m, 0.25 * 0.010 + 0.75 * 0.030, 1e-15);
  EXPECT_NEAR(network.key_points[0].z_m, 0.25 * 0.020 - 0.75 * 0.040, 1e-15);
  const std::string own = with(everything, "{ a = 0.25, b = 0.75 }", "{ a = 0.3, hall = 0.7 }\nat = [1.0, -2.0]");
  const KeyPoint point = read(own).key_points[0];
  EXPECT_EQ(point.part, "") << "that of its heaviest node";
  EXPECT_NEAR(point.r_m, 0.001, 1e-15);
  EXPECT_NEAR(point.z_m, -0.002, 1e-15);
  for (const auto& [at, taken] :
       {std::pair{"[1e5, -1e5]", true}, {"[1.4e5, 0]", false}, {"[0, -1.4e5]", false}, {"[1.0]", false}}) {
    EXPECT_EQ(said_of(with(own, "[1.0, -2.0]", at)) == "accepted", taken) << at;
  }
}

TEST(ByHandEdges, faces_add_up_and_each_has_a_column_of_its_own) {
  const Network network = read(everything);
  const Conductance& around = network.boundaries.conductances[0];
  EXPECT_EQ(around.kind, ConductanceKind::air_film);
  EXPECT_NEAR(around.area_m2, 500e-6, 1e-18);
  EXPECT_EQ(around.part_a, -1) << "air is in no part";
  EXPECT_EQ(around.part_b, 0);
  const Eigen::MatrixXd around_m2 = network.factors_m[0] * network.factors_m[0].transpose();
  EXPECT_NEAR(around_m2(2, 2), 500e-6, 1e-15);
  EXPECT_NEAR(around_m2(2, 0), -200e-6, 1e-15);
  EXPECT_NEAR(around_m2(2, 1), -300e-6, 1e-15);
  EXPECT_NEAR(around_m2(0, 1), 0.0, 1e-18);
  const Conductance& film = network.boundaries.conductances[1];
  EXPECT_NEAR(film.area_m2, 50700e-6, 1e-15);
  EXPECT_EQ(film.environment, 0);
  EXPECT_EQ(film.part_a, 0);
  EXPECT_EQ(film.part_b, -1);
  const Eigen::MatrixXd film_m2 = network.factors_m[1] * network.factors_m[1].transpose();
  EXPECT_NEAR(film_m2(0, 0), 700e-6, 1e-15);
  EXPECT_NEAR(film_m2(1, 1), 50000e-6, 1e-15);
  EXPECT_NE(said_of(with(everything, "{ node = \"a\", area_mm2 = 700.0 }", "{ node = \"b\", area_mm2 = 1.0 }"))
                .find("is in this film twice"),
            std::string::npos);
  const std::string backwards = with(everything, R"({ between = ["hall", "a"], area_mm2 = 200.0 })",
                                     R"({ between = ["a", "hall"], area_mm2 = 200.0 })");
  EXPECT_EQ(read(backwards).boundaries.conductances[0].kind, ConductanceKind::air_film);
  EXPECT_EQ(read(backwards).boundaries.conductances[0].part_b, -1) << "its faces end at two sides";
}

TEST(ByHandEdges, watts_per_kelvin_stand_on_an_area_of_one_square_metre) {
  const std::string path =
      with(everything, "conductance_W_per_K = 2.0", "name = \"path\"\ncorrectable = true\nconductance_W_per_K = 2.0");
  const Network correctable = read(path), fixed = read(everything);
  const Conductance& conductance = correctable.boundaries.conductances[0];
  EXPECT_EQ(conductance.name, "path");
  EXPECT_EQ(conductance.kind, ConductanceKind::contact);
  EXPECT_EQ(conductance.nominal_W_per_m2K, 2.0);
  EXPECT_EQ(conductance.area_m2, 1.0);
  EXPECT_EQ(correctable.conduction_W_per_K, Eigen::MatrixXd::Zero(3, 3));
  const Eigen::MatrixXd exchange = 2.0 * correctable.factors_m[0] * correctable.factors_m[0].transpose();
  EXPECT_LT((exchange - fixed.conduction_W_per_K).cwiseAbs().maxCoeff(), 1e-14) << "the same heat as when it is fixed";
  EXPECT_NE(said_of(with(everything, "conductance_W_per_K = 2.0", "name = \"path\"\nconductance_W_per_K = 2.0"))
                .find("only of use, and then needed, with correctable"),
            std::string::npos);
  const std::string contact = with(everything, "[[gap_film]]",
                                   "[[contact]]\nname = \"seat\"\nbetween = [\"a\", \"b\"]\n"
                                   "conductance_W_per_K = 3.0\n[[gap_film]]");
  EXPECT_EQ(read(contact).boundaries.conductances[0].nominal_W_per_m2K, 3.0);
  EXPECT_EQ(read(contact).boundaries.conductances[0].area_m2, 1.0);
  EXPECT_EQ(read(contact).boundaries.conductances[0].part_a, 0);
  EXPECT_NE(said_of(with(contact, "conductance_W_per_K = 3.0", "conductance_W_per_K = 3.0\narea_mm2 = 5.0"))
                .find("area_mm2: cannot stand beside"),
            std::string::npos);
}

TEST(ByHandEdges, a_joint_fit_is_between_two_parts_whichever_is_the_first) {
  const auto fitted = [](const std::string& one, const std::string& other) {
    const std::string in_two_parts =
        with(everything, "name = \"b\"\npart = \"shaft\"", "name = \"b\"\npart = \"housing\"");
    return with(in_two_parts, "[[gap_film]]",
                "[[contact]]\nname = \"seat\"\nbetween = [\"" + one + "\", \"" + other +
                    "\"]\narea_mm2 = 9.0\nconductance_W_per_m2K = 9.0\njoint_fit = { assembly_pressure_Pa = 1e6, "
                    "pressure_per_inner_rise_Pa_per_K = 2.0, pressure_per_outer_rise_Pa_per_K = 3.0 }\n[[gap_film]]");
  };
  for (const auto& [one, other] : {std::pair{"a", "b"}, {"b", "a"}}) {
    const Network network = read(fitted(one, other));
    const Conductance& seat = network.boundaries.conductances[0];
    ASSERT_TRUE(seat.fit.has_value());
    EXPECT_EQ(seat.fit->pressure_per_inner_rise_Pa_per_K, 2.0);
    EXPECT_EQ(seat.fit->pressure_per_outer_rise_Pa_per_K, 3.0);
    EXPECT_EQ(seat.part_a + seat.part_b, 1);
  }
  for (const auto& [one, other] : {std::pair{"a", "hall"}, {"hall", "a"}}) {
    EXPECT_NE(said_of(fitted(one, other)).find("joint_fit: needs an inner and an outer part"), std::string::npos);
  }
}

TEST(ByHandEdges, the_first_node_needs_a_neighbour_as_any_other) {
  const std::string lonely = in_a_room("lonely", R"([[node]]
name = "a"
capacity_J_per_K = 100.0
[[node]]
name = "b"
capacity_J_per_K = 100.0
[[film]]
name = "to_room"
surrounding = "room"
node = "a"
area_mm2 = 100.0
coefficient_W_per_m2K = 20.0
)");
  EXPECT_NE(said_of(lonely).find("node.a.name: no conduction, contact or gap film connects"), std::string::npos);
}

TEST(ByHandEdges, a_part_is_weighed_by_its_capacities_and_its_extremes_are_its_nodes) {
  const Network network = read(everything);
  ASSERT_EQ(network.parts.size(), 1U) << "air is no part";
  EXPECT_NEAR(network.parts[0].mean_row[0], 100.0 / 300.0, 1e-15);
  EXPECT_NEAR(network.parts[0].mean_row[1], 200.0 / 300.0, 1e-15);
  EXPECT_EQ(network.parts[0].mean_row[2], 0.0);
  EXPECT_EQ(network.parts[0].candidate_rows, Eigen::MatrixXd(Eigen::MatrixXd::Identity(2, 3)));
}

TEST(ByHandEdges, what_the_operating_state_leaves_out_is_full_load) {
  const Network network = read(everything);
  EXPECT_TRUE(network.hand_written);
  EXPECT_EQ(network.boundaries.operating.load, 1.0);
  EXPECT_EQ(network.boundaries.operating.speed_rpm, 1000.0);
  EXPECT_EQ(network.boundaries.reference_speed_rpm, 1000.0);
  EXPECT_EQ(network.boundaries.reference_temperature_K, 20.0 + zero_degC_K);
  EXPECT_EQ(network.boundaries.operating.heat_W.size(), 0);
  EXPECT_FALSE(network.boundaries.sources[0].measured);
}

TEST(ByHandEdges, one_node_alone_with_a_film_is_a_network) {
  const std::string alone = in_a_room("alone", R"([[node]]
name = "a"
capacity_J_per_K = 100.0
[[film]]
name = "to_room"
surrounding = "room"
node = "a"
area_mm2 = 100.0
coefficient_W_per_m2K = 20.0
)");
  EXPECT_EQ(said_of(alone), "accepted");
  EXPECT_EQ(read(alone).conduction_W_per_K, Eigen::MatrixXd::Zero(1, 1));
}

}  // namespace by_hand_edges_test
}  // namespace spindle_twin::rom::tests
