#include <gtest/gtest.h>

#include <functional>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {
namespace exchange_files_refusal_test {

const std::string path = SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/two_rings.toml";

/// The refusal comes first, so that no coefficients are needed.
std::string error_of(const std::function<void(Spindle&)>& spoil) {
  Spindle spindle = read_spindle(path);
  spindle.file = "s.toml";
  spoil(spindle);
  try {
    make_deck_model(spindle, {});
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "no error";
}

const rom::SourceLine line_7{"s.toml", 7};

TEST(DeckRefusals, geometry_and_degree) {
  EXPECT_EQ(error_of([](Spindle& spindle) { spindle.geometry = Geometry::planar; }),
            "s.toml: geometry: only an axisymmetric description can be exported");
  EXPECT_EQ(error_of([](Spindle& spindle) { spindle.mesh.degree = 1; }),
            "s.toml: mesh.degree: only degree 2 can be exported (eight-node and six-node elements)");
}

TEST(DeckRefusals, radiation_start_temperatures_and_imposed_fields) {
  EXPECT_EQ(error_of([](Spindle& spindle) {
              spindle.films[0].condition = &face_condition("radiation");
              spindle.films[0].name = "glow";
              spindle.films[0].where = line_7;
            }),
            "s.toml:7: glow: radiation cannot be exported; state it as a film");
  EXPECT_EQ(error_of([](Spindle& spindle) {
              spindle.parts[0].initial_K = 300.0;
              spindle.parts[0].name = "ring";
              spindle.parts[0].where = line_7;
            }),
            "s.toml:7: ring: a part with a start temperature of its own cannot be exported");
  EXPECT_EQ(error_of([](Spindle& spindle) {
              spindle.imposed_temperature = ImposedTemperature{"1", line_7};
            }),
            "s.toml:7: imposed_temperature: cannot be exported: there is no heat to conduct");
}

}  // namespace exchange_files_refusal_test
}  // namespace spindle_twin::fem_offline
