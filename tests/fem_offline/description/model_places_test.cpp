#include "fem_offline/description/model_places.hpp"

#include <gtest/gtest.h>

#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_model_places_test {

TEST(ModelPlaces, conductances_stand_as_contacts_gap_films_films) {
  Spindle spindle;
  spindle.contacts.resize(3);
  spindle.gap_films.resize(2);
  spindle.films.resize(4);
  EXPECT_EQ(conductance_of_contact(spindle, 2), 2U);
  EXPECT_EQ(conductance_of_gap_film(spindle, 0), 3U);
  EXPECT_EQ(conductance_of_gap_film(spindle, 1), 4U);
  EXPECT_EQ(conductance_of_film(spindle, 0), 5U);
  EXPECT_EQ(conductance_of_film(spindle, 3), 8U);
}

TEST(ModelPlaces, environments_leave_out_air_volumes) {
  Spindle spindle;
  for (const SurroundingKind kind : {SurroundingKind::ambient, SurroundingKind::air, SurroundingKind::coolant}) {
    spindle.surroundings.emplace_back();
    spindle.surroundings.back().kind = kind;
  }
  EXPECT_EQ(environment_of(spindle, 0), 0);
  EXPECT_EQ(environment_of(spindle, 1), -1);
  EXPECT_EQ(environment_of(spindle, 2), 1);
}

TEST(ModelPlaces, operating_state_has_each_environment_at_its_temperature) {
  const rom::OperatingState state = operating_state(parse_spindle(sample_text, "s.toml"));
  EXPECT_EQ(state.speed_rpm, 3000.0);
  EXPECT_EQ(state.load, 0.5);
  ASSERT_EQ(state.environment_K.size(), 2);
  EXPECT_DOUBLE_EQ(state.environment_K[0], 295.15);
  EXPECT_DOUBLE_EQ(state.environment_K[1], 291.15);
  EXPECT_EQ(state.flow_kg_per_s.size(), 0);
}

TEST(ModelPlaces, each_conductance_knows_its_table) {
  const Spindle spindle = parse_spindle(sample_text, "s.toml");
  EXPECT_EQ(where_of_conductance(spindle, 0).line, spindle.contacts[0].where.line);
  EXPECT_EQ(where_of_conductance(spindle, 1).line, spindle.films[0].where.line);
  EXPECT_EQ(where_of_conductance(spindle, 3).line, spindle.films[2].where.line);
}

}  // namespace description_model_places_test
}  // namespace spindle_twin::fem_offline
