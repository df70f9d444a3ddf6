#include <gtest/gtest.h>

#include "firmware/acquire/modbus_device.hpp"
#include "firmware/config/config.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace config_devices_test {

const std::string devices = R"(network = "small.rom"
[cycle]
clock_rate = 10.0
[serve]
port = 1502
[[device]]
name = "cabinet"
port = 1503
poll_s = 2.0
delay_s = 0.25
retry_s = 1.0
[[device]]
name = "nose"
driver = "modbus"
preset = "moxa_e1260"
[[sensor]]
key_point = "sleeve_inner"
device = "nose"
channel = 4
[[sensor]]
key_point = "sleeve_outer"
device = "cabinet"
register = 2
conversion = "pt100"
scale = 0.01
[signals]
speed = { source = "plc" }
load = { source = "device", device = "cabinet", register = 10, scale = 0.01, conversion = "4-20mA", at_4mA = 0.0, at_20mA = 2.0, mean_s = 5.0 }
coolant = { source = "constant", value = 27.0 }
ambient = { source = "constant", value = 22.0 }
)";

std::string with(const std::string& from, const std::string& to) { return tests::with(devices, from, to); }

std::string error_of(const std::string& text) {
  return tests::refusal_of([&] { bind_config(parse_config(text, "/etc/twin.toml"), tests::small_network()); });
}

TEST(Devices, each_has_its_own_period_delay_and_back_off_and_gives_the_channels_that_name_it) {
  const SpindlePlan plan = bind_config(parse_config(devices, "twin.toml"), tests::small_network());
  ASSERT_EQ(plan.devices.size(), 2U);
  const DevicePlan& cabinet = plan.devices[0];
  EXPECT_EQ(cabinet.name, "cabinet");
  EXPECT_DOUBLE_EQ(cabinet.poll_s, 0.2) << "model time at clock rate 10";
  EXPECT_DOUBLE_EQ(cabinet.delay_s, 0.25);
  EXPECT_DOUBLE_EQ(cabinet.retry_s, 1.0);
  EXPECT_EQ(cabinet.driver->where(), "127.0.0.1:1503");
  ASSERT_EQ(cabinet.channels.size(), 2U);
  EXPECT_EQ(cabinet.channels[0].kind, Channel::Kind::sensor);
  EXPECT_EQ(cabinet.channels[0].index, 2U);
  EXPECT_NEAR(convert(cabinet.channels[0].conversion, 13850.55).value, 373.15, 1e-3);
  EXPECT_EQ(cabinet.channels[1].kind, Channel::Kind::signal);
  EXPECT_DOUBLE_EQ(convert(cabinet.channels[1].conversion, 1200.0).value, 1.0) << "12 mA are half way";
  EXPECT_EQ(cabinet.channels[1].filter.kind, FilterPlan::Kind::mean);
  EXPECT_DOUBLE_EQ(cabinet.channels[1].filter.time_s, 0.5);
  ASSERT_EQ(plan.devices[1].channels.size(), 1U);
  EXPECT_EQ(plan.devices[1].channels[0].index, 0U);
  EXPECT_DOUBLE_EQ(plan.cycle.signals[1].stale_after_s, 3.0 * 2.0 + 2.5 + 7.5)
      << "three polls; delay and window make readings older";
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].stale_after_s, 3.0);
  EXPECT_NEAR(plan.cycle.sensors[2].resolution_K, 0.01 / 0.39083, 1e-9) << "one count of 0.01 ohm";
}

TEST(Devices, a_preset_knows_register_table_type_and_scale) {
  const SpindlePlan plan = bind_config(parse_config(devices, "twin.toml"), tests::small_network());
  const auto& nose = dynamic_cast<const ModbusPlan&>(*plan.devices[1].driver);
  ASSERT_EQ(nose.sources.size(), 1U);
  EXPECT_EQ(nose.sources[0].address, 1540);
  EXPECT_EQ(nose.sources[0].table, RegisterTable::input);
  EXPECT_EQ(nose.sources[0].type, RegisterType::int16);
  EXPECT_DOUBLE_EQ(convert(plan.devices[1].channels[0].conversion, 253.0).value, 298.45);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].resolution_K, 0.1);
  const SpindlePlan other =
      bind_config(parse_config(with("moxa_e1260", "isma_sfar_s_6ti"), "twin.toml"), tests::small_network());
  EXPECT_EQ(dynamic_cast<const ModbusPlan&>(*other.devices[1].driver).sources[0].address, 56);
}

TEST(Devices, the_one_table_of_before_needs_no_name) {
  const std::string text = R"(network = "small.rom"
[serve]
port = 1502
[device]
port = 1503
[[sensor]]
key_point = "sleeve_inner"
register = 0
[signals]
speed = { source = "plc" }
load = { source = "plc" }
coolant = { source = "constant", value = 27.0 }
ambient = { source = "constant", value = 22.0 }
)";
  const SpindlePlan plan = bind_config(parse_config(text, "twin.toml"), tests::small_network());
  ASSERT_EQ(plan.devices.size(), 1U);
  EXPECT_EQ(plan.devices[0].name, "device");
  EXPECT_EQ(plan.devices[0].channels.size(), 1U);
}

TEST(DeviceErrors, name_file_line_field_and_what_is_allowed) {
  EXPECT_EQ(error_of(with("device = \"nose\"\n", "device = \"nase\"\n")),
            "/etc/twin.toml:18: sensor[1].device: there is no device \"nase\"; there is cabinet, nose");
  EXPECT_EQ(error_of(with("device = \"nose\"\n", "")), "/etc/twin.toml:16: sensor[1].device: this key is required");
  EXPECT_EQ(error_of(with("name = \"nose\"", "name = \"cabinet\"")),
            "/etc/twin.toml:13: device[2].name: there is a device \"cabinet\" already");
  EXPECT_EQ(error_of(with("channel = 4", "channel = 6")).rfind("/etc/twin.toml:19: sensor[1].channel: must be", 0), 0U);
  EXPECT_EQ(error_of(with("driver = \"modbus\"", "driver = \"mod\"")).rfind("/etc/twin.toml:14: device[2].driver: ", 0),
            0U);
  EXPECT_EQ(error_of(with("preset = \"moxa_e1260\"", "preset = \"moxa\"")),
            "/etc/twin.toml:15: device[2].preset: must be one of moxa_e1260, isma_sfar_s_6ti, is \"moxa\"");
  EXPECT_EQ(error_of(with("conversion = \"4-20mA\"", "conversion = \"pt100\"")),
            "/etc/twin.toml:28: signals.load.conversion: \"pt100\" is of temperatures only");
  EXPECT_EQ(error_of(with("at_20mA = 2.0", "at_20mA = 0.0")),
            "/etc/twin.toml:28: signals.load.at_20mA: must differ from at_4mA");
  EXPECT_EQ(error_of(with("mean_s = 5.0", "mean_s = 5.0, low_pass_s = 1.0")),
            "/etc/twin.toml:28: signals.load.low_pass_s: either this or mean_s is possible");
}

TEST(Devices, no_port_is_listened_on_twice) {
  const std::string nodes = "[[device]]\nname = \"nodes\"\ndriver = \"stream\"\nport = ";
  const std::string sensor = "[[sensor]]\nkey_point = \"sleeve_inner\"\n";
  const auto with_nodes = [&](const std::string& keys) { return with(sensor, nodes + keys + "\n" + sensor); };
  EXPECT_EQ(error_of(with_nodes("1504")), "accepted");
  EXPECT_EQ(error_of(with_nodes("1502")),
            "/etc/twin.toml:19: device[3].port: 1502 is that of [serve] already; each needs one of its own");
  EXPECT_EQ(error_of(with_nodes("1502\naddress = \"0.0.0.0\"")),
            "/etc/twin.toml:19: device[3].port: 1502 is that of [serve] already; each needs one of its own");
  EXPECT_EQ(error_of(with_nodes("1502\naddress = \"127.0.0.2\"")), "accepted") << "another address";
  const std::string others = "[[device]]\nname = \"others\"\ndriver = \"stream\"\nport = 1504\n";
  EXPECT_EQ(error_of(with_nodes("1504\n" + others)),
            "/etc/twin.toml:23: device[4].port: 1504 is that of device \"nodes\" already; each needs one of its own");
  EXPECT_EQ(error_of(with_nodes("1504\n[http]\nport = 1504")),
            "/etc/twin.toml:19: device[3].port: 1504 is that of [http] already; each needs one of its own");
}

}  // namespace config_devices_test
}  // namespace spindle_twin::firmware
