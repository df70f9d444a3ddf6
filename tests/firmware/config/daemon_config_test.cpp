#include "firmware/config/daemon_config.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace config_daemon_config_test {

const std::string head = "[serve]\nport = 1502\n";

std::string spindle(const std::string& name, int unit, const std::string& config) {
  return "[[spindle]]\nname = \"" + name + "\"\nunit = " + std::to_string(unit) + "\nconfig = \"" + config + "\"\n";
}

/// Files of configurations in a folder of their own.
class DaemonConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("daemon_config." + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    for (const std::string& name : {std::string("left"), std::string("right")}) write(name + ".toml", of_one);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  DaemonConfig read(const std::string& list) const {
    write("list.toml", list);
    return read_daemon_config(folder_ / "list.toml");
  }
  std::string refusal(const std::string& list) const {
    return tests::refusal_of([&] { read(list); });
  }

  const std::string of_one =
      "network = \"small.rom\"\n[cycle]\nperiod_s = 2.0\n[start]\ntemperature_degC = 20.0\n[signals]\n"
      "speed = { source = \"plc\" }\nload = { source = \"plc\" }\ncoolant = { source = \"plc\" }\n"
      "ambient = { source = \"plc\" }\n";
  std::filesystem::path folder_;
};

TEST_F(DaemonConfigTest, a_state_file_in_a_folder_that_is_not_there_is_warned_of) {
  write("right.toml", of_one + "[checkpoint]\npath = \"nowhere/right.checkpoint\"\n");
  const DaemonConfig daemon = read(head + spindle("left", 1, "left.toml") + spindle("right", 2, "right.toml"));
  EXPECT_TRUE(unwritable_files(daemon.spindles[0].config).empty());
  const std::vector<rom::InputError> found = unwritable_files(daemon.spindles[1].config);
  ASSERT_EQ(found.size(), 2U) << "orders stand beside the checkpoint";
  EXPECT_NE(std::string(found[1].what()).find("right.checkpoint: could not be written by this user, its folder: "),
            std::string::npos)
      << found[1].what();
}

TEST_F(DaemonConfigTest, a_file_of_one_of_several_is_read_for_a_replay_and_a_list_of_them_is_not) {
  write("right.toml", of_one + "[serve]\nplc_timeout_s = 3.0\n");
  EXPECT_EQ(read_spindle_config(folder_ / "left.toml").cycle.period_s, 2.0);
  EXPECT_EQ(read_spindle_config(folder_ / "right.toml").cycle.plc_timeout_s, 3.0);
  write("alone.toml", of_one + "[serve]\nport = 1502\n");
  EXPECT_EQ(read_spindle_config(folder_ / "alone.toml").serve.port, 1502);
  write("list.toml", head + spindle("left", 1, "left.toml"));
  EXPECT_NE(tests::refusal_of([&] { read_spindle_config(folder_ / "list.toml"); }).find("the file of one of them"),
            std::string::npos);
}

TEST_F(DaemonConfigTest, what_one_spindle_writes_no_other_reads) {
  const std::string list = head + spindle("left", 1, "left.toml") + spindle("right", 2, "right.toml");
  EXPECT_EQ(refusal(list), "accepted") << "both read small.rom";
  for (const std::string& name : {std::string("left"), std::string("right")}) {
    const std::string other = name == "left" ? "right" : "left";
    for (const std::string& file : {other + ".toml", std::string("list.toml"), other + ".rom"}) {
      write(other + ".toml", tests::with(of_one, "small.rom", other + ".rom"));
      write(name + ".toml", of_one + "[checkpoint]\npath = \"" + file + "\"\n");
      EXPECT_NE(refusal(list).find("which would be written over"), std::string::npos) << name << " " << file;
      write(other + ".toml", of_one);
      write(name + ".toml", of_one);
    }
  }
}

TEST_F(DaemonConfigTest, a_list_has_one_server_and_each_spindle_its_own_file) {
  write("right.toml", of_one + "[serve]\nplc_timeout_s = 3.0\n[checkpoint]\npath = \"kept/right.checkpoint\"\n");
  const DaemonConfig daemon = read(head + spindle("left", 1, "left.toml") + spindle("right", 247, "right.toml"));
  EXPECT_EQ(daemon.serve.port, 1502);
  ASSERT_EQ(daemon.spindles.size(), 2U);
  EXPECT_EQ(daemon.spindles[0].name, "left");
  EXPECT_EQ(daemon.spindles[1].unit, 247);
  EXPECT_EQ(daemon.spindles[0].config.cycle.plc_timeout_s, 10.0);
  EXPECT_EQ(daemon.spindles[1].config.cycle.plc_timeout_s, 3.0);
  EXPECT_EQ(daemon.spindles[0].config.keep.orders_path, folder_ / "left.orders");
  EXPECT_EQ(daemon.spindles[1].config.keep.checkpoint_path, folder_ / "kept/right.checkpoint");
}

TEST_F(DaemonConfigTest, without_a_list_the_file_is_of_the_only_spindle) {
  const DaemonConfig daemon = read(of_one + head + "[http]\n");
  ASSERT_EQ(daemon.spindles.size(), 1U);
  EXPECT_EQ(daemon.spindles[0].name, "");
  EXPECT_EQ(daemon.serve.port, 1502);
  EXPECT_TRUE(daemon.show.enabled);
}

TEST_F(DaemonConfigTest, what_is_of_all_is_refused_in_the_file_of_one) {
  const std::string list = head + spindle("left", 1, "left.toml");
  for (const std::string& own : std::vector<std::string>{"log_level = \"debug\"\n", "[http]\n", "[plant]\n",
                                                         "[serve]\nport = 7\n", "[[spindle]]\n"}) {
    write("left.toml", own.starts_with('[') ? of_one + own : own + of_one);
    const std::string said = refusal(list);
    EXPECT_NE(said.find("left.toml:"), std::string::npos) << said;
    EXPECT_NE(said.find("is of all spindles and stands in"), std::string::npos) << said;
  }
}

TEST_F(DaemonConfigTest, two_spindles_share_no_name_unit_port_or_file) {
  const std::string left = head + spindle("left", 1, "left.toml");
  EXPECT_NE(refusal(left + spindle("left", 2, "right.toml")).find("the name left is that of"), std::string::npos);
  const std::string unit = refusal(left + spindle("right", 1, "right.toml"));
  EXPECT_NE(unit.find("list.toml:9: spindle[2].unit: unit 1 is that of \"left\" already"), std::string::npos) << unit;
  EXPECT_NE(refusal(left + spindle("right", 2, "left.toml")).find("left.orders is that of \"left\""),
            std::string::npos);
  write("left.toml", of_one + "[history]\npath = \"own.csv\"\n");
  write("right.toml", of_one + "[checkpoint]\npath = \"./x/../own.csv\"\n");
  const std::string file = refusal(left + spindle("right", 2, "right.toml"));
  EXPECT_NE(file.find("own.csv is that of \"left\" already"), std::string::npos) << file;
  const std::string stream = "[[device]]\nname = \"a\"\ndriver = \"stream\"\nport = 4711\n";
  write("left.toml", of_one + stream);
  write("right.toml", of_one + stream);
  const std::string port = refusal(left + spindle("right", 2, "right.toml"));
  EXPECT_NE(port.find("right.toml:"), std::string::npos) << port;
  EXPECT_NE(port.find("4711"), std::string::npos) << port;
}

TEST_F(DaemonConfigTest, names_and_units_are_those_that_paths_and_modbus_take) {
  for (const std::string& name : {std::string(), std::string("a b"), std::string("../x"), std::string(33, 'x')}) {
    const std::string said = refusal(head + spindle(name, 1, "left.toml"));
    EXPECT_NE(said.find("list.toml:4: spindle[1].name: must be 1 to 32 letters"), std::string::npos) << said;
  }
  for (const std::string& name : {std::string(32, 'x'), std::string("A-z_0")}) {
    EXPECT_EQ(refusal(head + spindle(name, 1, "left.toml")), "accepted") << name;
  }
  for (const int unit : {0, -1, 248, 255}) {
    const std::string said = refusal(head + spindle("left", unit, "left.toml"));
    EXPECT_NE(said.find("list.toml:5: spindle[1].unit"), std::string::npos) << said;
  }
  EXPECT_NE(refusal("spindle = 3\n" + head).find("spindle"), std::string::npos);
  EXPECT_NE(refusal(head + spindle("left", 1, "nowhere.toml")).find("nowhere.toml"), std::string::npos);
  EXPECT_NE(refusal(head + spindle("left", 1, "left.toml") + "[signals]\n").find("signals"), std::string::npos);
}

TEST_F(DaemonConfigTest, more_than_32_are_refused) {
  std::string list = head;
  for (int n = 1; n <= 33; ++n) {
    if (n == 33) {
      EXPECT_EQ(refusal(list), "accepted");
    }
    write(std::to_string(n) + ".toml", of_one);
    list += spindle("s" + std::to_string(n), n, std::to_string(n) + ".toml");
  }
  EXPECT_NE(refusal(list).find("at most 32 spindles are allowed"), std::string::npos);
}

}  // namespace config_daemon_config_test
}  // namespace spindle_twin::firmware
