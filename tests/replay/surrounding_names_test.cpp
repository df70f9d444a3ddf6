#include <gtest/gtest.h>

#include "host_tools/replay/log.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools {
namespace surrounding_names_test {

struct Named : testing::Test {
  Named() {
    for (rom::Environment& each : network.boundaries.environments) {
      each.name = each.kind == rom::EnvironmentKind::coolant ? "water" : "room";
    }
  }
  Log read(const std::string& columns, const std::string& row) const {
    return read_log(
        folder.write("log.csv", "time_s,speed_rpm,load," + columns + "\n0,1000,1," + row + "\n1,1000,1," + row + "\n"),
        network, 60.0);
  }
  std::string refusal(const std::string& columns, const std::string& row) const {
    try {
      read(columns, row);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  tests::TemporaryFolder folder;
  rom::Network network = tests::small_network();
};

TEST_F(Named, a_surrounding_that_is_alone_of_its_kind_goes_by_its_own_name_too) {
  const Log own = read("room_degC,water_degC", "23,18"), signals = read("ambient_degC,coolant_degC", "23,18");
  EXPECT_EQ(own.has_signal, signals.has_signal);
  EXPECT_EQ(own.rows[1].signals[2], signals.rows[1].signals[2]);
  EXPECT_EQ(own.rows[1].signals[3], signals.rows[1].signals[3]);
  EXPECT_DOUBLE_EQ(own.rows[1].signals[3], 296.15);
}

TEST_F(Named, two_words_for_one_signal_are_refused_with_the_column_that_counts) {
  EXPECT_EQ(refusal("room_degC,ambient_degC", "23,23"),
            folder.file("log.csv") +
                ":1: room_degC: is there beside ambient_degC; the column ambient_degC says it for all of them");
  rom::Environment another = network.boundaries.environments[0];
  another.name = "hall";
  another.kind = rom::EnvironmentKind::ambient;
  network.boundaries.environments.push_back(another);
  EXPECT_EQ(refusal("room_degC", "23"),
            folder.file("log.csv") +
                ":1: room_degC: is one of several surroundings that the daemon reads as one signal; "
                "the column ambient_degC says it for all of them");
}

}  // namespace surrounding_names_test
}  // namespace spindle_twin::host_tools
