#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/keep/history_row.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/random_machine.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/support/recorded.hpp"

/// Lives of a twin beside a machine that is other than its network says: everything that it publishes, records and
/// learns in them is what it was when this was recorded.
namespace spindle_twin::firmware {
namespace cycle_recorded_lives_test {

/// Another processor's functions of libm round otherwise, and CVODE then iterates once more or less, within its
/// tolerance: with GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2 the lives keep within this.
constexpr tests::Tolerance tolerance{1e-4, 5e-6};
constexpr double ns_per_s = 1e9;

/// Count, mean, mean of magnitudes and last of the values of many columns.
class Columns {
 public:
  void add(const std::string& name, double value) {
    if (next_ == columns_.size()) columns_.push_back({name});
    Column& column = columns_[next_++];
    EXPECT_EQ(column.name, name);
    if (!std::isfinite(value)) return;
    ++column.count;
    column.sum += value * (1.0 + 1e-3 * static_cast<double>(rows_ % 101));  // so that order counts
    column.magnitudes += std::abs(value);
    column.last = value;
  }
  void end_row() {
    next_ = 0;
    ++rows_;
  }
  std::string text() const {
    std::string all;
    for (const Column& column : columns_) {
      char numbers[120];
      const double n = std::max(1, column.count);
      std::snprintf(numbers, sizeof numbers, " %d %.10g %.10g %.10g\n", column.count, column.sum / n,
                    column.magnitudes / n, column.last);
      if (column.count > 0) all += column.name + numbers;
    }
    return all;
  }

 private:
  struct Column {
    std::string name;
    int count = 0;
    double sum = 0.0, magnitudes = 0.0, last = 0.0;
  };
  std::vector<Column> columns_;
  std::size_t next_ = 0;
  int rows_ = 0;
};

std::vector<std::string> split(const std::string& header) {
  std::vector<std::string> names;
  std::istringstream stream(header);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

struct Setting {
  rom::Network network;
  DaemonLines lines = {};
  double run_s = 2.0 * 3600.0;
  double spread = 0.25;
  std::uint64_t seed = 1;
  bool troubled = true;
  bool orders = true;
};

/// What a PLC orders in a life: a tare and its end, touch-offs, sensors tared and acknowledged, correction and
/// compensation off for a while, latched faults taken back.
void order(PlcCommand& command, int n) {
  const auto at = [&](int cycle) { return n == cycle; };
  if (at(400) || at(2500)) {
    ++command.tare_orders;
    command.tare_order = at(400) ? TareOrder::take : TareOrder::clear;
  }
  if (at(700) || at(1900)) {
    ++command.displacements;
    command.displacement = {0, at(700) ? 1.5e-6 : -2e-6, 4e-7};
  }
  if (at(60) || at(1200) || at(2900)) {
    ++command.sensor_orders;
    command.sensor_order = at(60) ? SensorOrder::tare : at(1200) ? SensorOrder::acknowledge : SensorOrder::clear_tare;
  }
  if (at(2000)) ++command.acknowledgements;
  command.correction = n > 1400 && n < 1500 ? SwitchOrder::off : SwitchOrder::on;
  command.compensation = n > 1000 && n < 1100 ? SwitchOrder::off : SwitchOrder::on;
}

class Life {
 public:
  explicit Life(const Setting& setting)
      : setting_(setting),
        random_(setting.seed),
        machine_(made_other(setting.network, setting.spread, random_)),
        history_names_(split(history_header(setting.network))) {
    for (const std::string& name : setting.lines.sensors) {
      for (std::size_t k = 0; k < setting.network.key_points.size(); ++k) {
        if (setting.network.key_points[k].name == name) sensors_.push_back(k);
      }
    }
  }

  /// The life, a stop of half an hour, and another quarter of it from what was remembered.
  std::string run() {
    const std::vector<LogStep> log = random_log(setting_.network, 1.3 * setting_.run_s, random_);
    std::vector<TroubleEvent> troubles;
    if (setting_.troubled) troubles = random_troubles(sensors_, setting_.run_s, random_);
    TroubledDevice device(sensors_, troubles, random_());
    machine_.start(log.front().ambient_K);
    const CyclePlan plan = daemon_plan(setting_.network, setting_.lines);
    const auto stepper = [](const rom::Network& of) { return rom::make_runtime_stepper(of); };
    Remembered remembered;
    {
      Cycle cycle(setting_.network, plan, stepper);
      go(cycle, device, log, setting_.run_s);
      cycle.remember(remembered);
    }
    constexpr double gap_s = 1800.0;
    LogStep still = at_time(log, time_s_);
    still.speed_rpm = still.load = 0.0;
    machine_.advance(gap_s, still);
    Cycle again(setting_.network, plan, stepper);
    const Resumed resumed = again.resume(remembered, gap_s);
    go(again, device, log, 0.25 * setting_.run_s);
    return describe(troubles) + "\n" + columns_.text() + learning_.text() + "resumed " +
           std::to_string(static_cast<int>(resumed)) + "\n";
  }

 private:
  void go(Cycle& cycle, TroubledDevice& device, const std::vector<LogStep>& log, double for_s) {
    PlcCommand command;
    const double until_s = time_s_ + for_s;
    for (int n = 0; time_s_ < until_s; ++n) {
      const LogStep& step = at_time(log, time_s_);
      const auto now_ns = static_cast<std::int64_t>(ns_per_s * (1.0 + time_s_));
      if (setting_.orders) order(command, n);
      DeviceFrame frame = device.read(machine_.nodes_K(), step, time_s_, now_ns);
      add_channels(frame, step, now_ns, n);
      const int missed = n % 397 == 396 ? 2 : 0;
      record(cycle.step(frame, command, now_ns, missed), now_ns);
      if (n % 100 == 99 && cycle.parameters() != nullptr) record(cycle);
      machine_.advance(setting_.lines.period_s * (1 + missed), step);
      time_s_ += setting_.lines.period_s * (1 + missed);
    }
  }

  /// What a device tells besides sensors, speed, load and surroundings: current, power, flows, heats and a probe.
  static void add_channels(DeviceFrame& frame, const LogStep& step, std::int64_t now_ns, int n) {
    const double wave = std::sin(0.002 * n);
    for (std::size_t s = 4; s < signal_count; ++s) {
      const bool drive = s == 4 || s == 5;
      frame.signals[s] = {drive ? (s == 4 ? 10.0 : 900.0) * step.load : 0.05 * (1.0 + 0.3 * wave), now_ns};
    }
    frame.displacements[0] = {1e-6 * wave + 5e-6, now_ns};
  }

  void record(const Snapshot& snapshot, std::int64_t now_ns) {
    history_numbers(snapshot, numbers_);
    ASSERT_EQ(numbers_.size(), history_names_.size());
    for (std::size_t i = 0; i < numbers_.size(); ++i) columns_.add(history_names_[i], numbers_[i]);
    fill_image(snapshot, now_ns + 40'000'000, image_);
    for (std::size_t r = 0; r < register_entries.size(); ++r) {
      const RegisterEntry& entry = register_entries[r];
      if (entry.command) continue;
      // Whether growth is settled: where nothing is compensated a matter of its last digits for a few cycles.
      if (setting_.lines.tables.empty() && std::string(entry.name) == "compensation_bits") continue;
      for (int slot = 0; slot < static_cast<int>(entry.slots); ++slot) {
        columns_.add(std::string(entry.name) + "." + std::to_string(slot), get(image_, static_cast<Register>(r), slot));
      }
    }
    columns_.end_row();
  }

  /// What the estimator believes of the machine.
  void record(const Cycle& cycle) {
    cycle.remember(between_);
    const std::vector<correction::Parameter>& list = cycle.parameters()->list();
    for (std::size_t i = 0; i < list.size(); ++i) {
      const correction::ParameterEstimate& estimate = between_.parameters[i];
      learning_.add(list[i].name + " in deviations", estimate.value / estimate.deviation);
      learning_.add(list[i].name + " deviation", estimate.deviation);
      learning_.add(list[i].name + " prior", estimate.prior_deviation);
    }
    learning_.end_row();
  }

  const Setting& setting_;
  Random random_;
  RandomMachine machine_;
  std::vector<std::size_t> sensors_;
  std::vector<std::string> history_names_;
  std::vector<double> numbers_;
  RegisterImage image_{};
  Columns columns_, learning_;
  Remembered between_;
  double time_s_ = 0.0;
};

void expect_life_as_recorded(const std::string& name, const Setting& setting) {
  tests::expect_as_recorded("life_" + name + ".txt", Life(setting).run(), tolerance);
}

std::vector<std::string> key_points_of(const rom::Network& network, std::size_t every = 1) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < network.key_points.size(); k += every) names.push_back(network.key_points[k].name);
  return names;
}

Setting random_setting(std::uint64_t seed) {
  Random random(seed);
  Setting setting{random_network(random)};
  setting.lines.sensors = key_points_of(setting.network, 2);
  setting.lines.period_s = 2.0;
  setting.lines.offset_K = 0.1;
  setting.seed = seed;
  return setting;
}

Setting by_hand_setting(const std::string& name) {
  Setting setting{rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/" + name + ".toml")};
  setting.lines.sensors = key_points_of(setting.network);
  setting.lines.period_s = 2.0;
  return setting;
}

Setting certified_setting() {
  Setting setting{rom::read_network(SPINDLE_TWIN_SOURCE_DIR "/tests/rom/old_files/schema_4.rom")};
  setting.lines.sensors = key_points_of(setting.network, 2);
  setting.lines.period_s = 2.0;
  return setting;
}

TEST(RecordedLives, of_random_hand_written_networks_with_troubles) {
  for (const std::uint64_t seed : {9001, 9002, 9003, 9004}) {
    expect_life_as_recorded("random_" + std::to_string(seed), random_setting(seed));
  }
}

TEST(RecordedLives, of_a_hand_written_motor_spindle_of_laws) {
  Setting setting = by_hand_setting("motor_spindle_laws");
  setting.lines.signals = "current = { source = \"device\", register = 20, type = \"float32\" }\n";
  setting.lines.correction = "period_s = 8.0\nlag_s = 3.0\n[correction.prior]\nheat_common = 0.3\nheat = 0.2";
  setting.seed = 41;
  expect_life_as_recorded("motor_spindle_laws", setting);
}

TEST(RecordedLives, of_a_network_of_every_law_in_a_coolant_circuit) {
  Setting setting{rom::tests::make_network_with_laws()};
  setting.lines.sensors = key_points_of(setting.network);
  setting.lines.period_s = 2.0;
  setting.lines.signals = R"(flow.helix = { source = "device", register = 22, type = "float32" }
current = { source = "device", register = 24, type = "float32" }
power = { source = "device", register = 26, type = "float32" }
)";
  setting.run_s = 3600.0;
  setting.spread = 0.1;
  setting.seed = 43;
  expect_life_as_recorded("every_law", setting);
}

TEST(RecordedLives, of_a_certified_network_that_is_compensated_and_probed) {
  Setting setting = certified_setting();
  setting.lines.tables = R"(
[[displacement]]
output = "length"
register = 30
type = "float32"
sd_um = 1.0
interval_s = 60.0
[output]
slew_um_per_s = 0.05
limit_um = 12.0
[compensation]
sign = -1
step_um = 0.25
warning_um = 4.0
hold_min = 2.0
decay_min = 5.0
look_ahead_min = 10.0
settled_um = 0.8
[health.tare]
rest_s = 600.0
reference = "ambient"
)";
  setting.seed = 61;
  expect_life_as_recorded("certified", setting);
}

TEST(RecordedLives, by_the_published_law) {
  Setting setting = certified_setting();
  setting.lines.correction = "law = \"paper\"\nperiod_s = 40.0";
  setting.seed = 53;
  expect_life_as_recorded("paper", setting);
}

TEST(RecordedLives, without_correction) {
  Setting setting = by_hand_setting("motor_spindle");
  setting.lines.correction = "law = \"none\"";
  setting.seed = 59;
  expect_life_as_recorded("none", setting);
}

TEST(RecordedLives, of_a_healthy_machine) {
  Setting setting = by_hand_setting("motor_spindle");
  setting.troubled = false;
  setting.orders = false;
  setting.seed = 61;
  expect_life_as_recorded("healthy", setting);
}

}  // namespace cycle_recorded_lives_test
}  // namespace spindle_twin::firmware
