#include "fem_offline/description/face_conditions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "fem_offline/description/model_places.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_face_conditions_test {

const std::string gap_and_circuit = R"([[gap_film]]
name = "slit"
between = ["shaft", "sleeve"]
coefficient_W_per_m2K = 90
region = [38, 40, 40, 60]
[[radiation]]
name = "glow"
surrounding = "room"
emissivity = 0.5
mean_temperature_degC = 30
regions = [[40, 50, 0, 40]]
[[coolant_circuit]]
name = "jacket"
inlet = "water"
flow_kg_per_s = 0.1
heat_capacity_J_per_kgK = 4180
coefficient_W_per_m2K = 400
segments = [{ name = "first", regions = [[38, 40, 40, 50]] }, { name = "second", regions = [[38, 40, 50, 60]] }]
)";

TEST(FaceConditions, each_table_has_one_row_and_an_unknown_one_none) {
  std::set<std::string_view> tables;
  for (const FaceCondition& row : face_conditions()) {
    EXPECT_TRUE(tables.insert(row.table).second) << row.table;
    EXPECT_EQ(&face_condition(row.table), &row);
    EXPECT_NE(row.read, nullptr) << row.table;
  }
  EXPECT_THROW(face_condition("magic"), std::logic_error);
}

TEST(FaceConditions, a_film_knows_the_table_that_it_comes_from) {
  const Spindle spindle = parse_spindle(sample_text + gap_and_circuit, "s.toml");
  std::vector<std::string_view> tables;
  for (const Film& film : spindle.films) tables.push_back(film.condition->table);
  EXPECT_EQ(tables,
            (std::vector<std::string_view>{"film", "film", "film", "radiation", "coolant_circuit", "coolant_circuit"}));
  EXPECT_EQ(Film().condition, &face_condition("film"));
}

TEST(FaceConditions, items_that_conduct_stand_as_the_conductances_do) {
  const Spindle spindle = parse_spindle(sample_text + gap_and_circuit, "s.toml");
  std::size_t conductance = 0;
  for (const FaceItem& item : face_items(spindle)) {
    const Assembles assembles = item.condition->assembles;
    if (assembles != Assembles::conductance && assembles != Assembles::held_temperature) continue;
    const std::size_t place = item.condition->piece == PieceKind::contact ? conductance_of_contact(spindle, item.index)
                              : item.condition->piece == PieceKind::gap   ? conductance_of_gap_film(spindle, item.index)
                                                                          : conductance_of_film(spindle, item.index);
    EXPECT_EQ(place, conductance++) << item.name;
  }
  EXPECT_EQ(conductance, conductance_of_film(spindle, spindle.films.size()));
}

TEST(FaceConditions, an_item_holds_the_faces_that_its_table_asks_for) {
  const Spindle spindle = parse_spindle(sample_text + gap_and_circuit, "s.toml");
  const std::vector<FaceItem> items = face_items(spindle);
  const auto item = [&](const std::string& name) -> const FaceItem& {
    return *std::find_if(items.begin(), items.end(), [&](const FaceItem& one) { return one.name == name; });
  };
  EXPECT_EQ(item("shaft-sleeve").parts, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(item("slit").parts, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(item("outside").parts, std::vector<std::size_t>{1});
  EXPECT_TRUE(item("ends").parts.empty());
  EXPECT_EQ(item("ends").regions.size(), 2U);
  EXPECT_EQ(item("lagging").condition, &face_condition("adiabatic"));
  EXPECT_EQ(item("friction").parts, std::vector<std::size_t>{1});
  EXPECT_DOUBLE_EQ(item("friction").regions.at(0).z0_m, 0.060);
  EXPECT_EQ(items.size(), 10U) << "a contact, a gap film, six films, an adiabatic region, one share on a face";
}

}  // namespace description_face_conditions_test
}  // namespace spindle_twin::fem_offline
