#include "host_tools/replay/replay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>

#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "host_tools/replay/errors.hpp"
#include "host_tools/replay/plan.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/replay/bits.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools {
namespace replay_test {

using firmware::CyclePlan;
using firmware::Snapshot;

class Replay : public ::testing::Test {
 protected:
  Replay() : network_(tests::small_network()) {}

  std::string write(const std::string& text) const { return folder_.write("log.csv", text); }

  Log log(const std::string& text) const { return read_log(write(text), network_, 60.0); }

  CyclePlan plan(const Log& of, const std::string& correction = "none") const {
    ReplayOptions options;
    options.correction = correction;
    return plan_replay(network_, of, options);
  }

  std::vector<Snapshot> run(const CyclePlan& with, const Log& of) const {
    std::vector<Snapshot> snapshots;
    replay(network_, with, of, [&](const ReplayedCycle& cycle) { snapshots.push_back(cycle.snapshot); });
    return snapshots;
  }

  ReplayErrors errors(const CyclePlan& with, const Log& of, double from_s = -1e300) const {
    ReplayErrors found(network_, with, of, from_s);
    replay(network_, with, of, [&](const ReplayedCycle& cycle) { found.add(cycle); });
    return found;
  }

  std::string refusal(const std::string& text) const {
    const std::string path = write(text);
    try {
      read_log(path, network_, 60.0);
    } catch (const rom::InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.rfind(path, 0), 0U) << message;
      return message.substr(path.size());
    }
    return "no error";
  }

  rom::Network network_;
  tests::TemporaryFolder folder_;
};

/// A daemon's life with all that can come: it waits for its sensors, readings go missing, grow old, are out of range,
/// cycles come late, speed and load jump, the PLC tares and switches the correction.
struct Life {
  CyclePlan plan;
  std::vector<Snapshot> snapshots;
  std::string history;
};

Life live(const rom::Network& network, unsigned seed, bool paper = true) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> noise_K(0.0, 0.03);
  Life life;
  life.plan.period_s = 1.0;
  life.plan.clock_rate = 60.0;
  for (std::size_t k = 0; k < 3; ++k) life.plan.sensors[k].configured = true;
  for (std::size_t s = 0; s < 4; ++s) life.plan.signals[s] = {firmware::SignalSource::device, 0.0, -1e5, 1e5, 0.0};
  life.plan.signals[2].value = life.plan.signals[3].value = 300.15;
  if (paper) {
    life.plan.paper = correction::PaperOptions{};
    life.plan.paper->groups = correction::common_heat_group(network);
  } else {
    life.plan.estimator = correction::EstimatorOptions{};
    life.plan.sensors[1].interval_s = 3.0;
    life.plan.sensors[2].lag_s = 4.0;
    life.plan.probes[1] = {true, 5e-7, -1e-4, 1e-4, 120.0, 3.0};
  }
  firmware::Cycle cycle(network, life.plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  life.history = firmware::history_header(network) + "\n";
  firmware::DeviceFrame frame;
  frame.connected = true;
  firmware::PlcCommand command;
  std::int64_t now_ns = 1'234'567'890'123;
  double speed_rpm = 6000.0, load = 1.0;
  constexpr int first_reading = 5;
  for (int n = 0; n < 1500; ++n) {
    const std::int64_t drawn = share(random) < 0.02 ? 1 + static_cast<std::int64_t>(5.0 * share(random)) : 0;
    const std::int64_t missed = n == first_reading ? 2 : drawn;  // before the cycle that starts the model too
    now_ns += 16'666'666 * (1 + missed) + (share(random) < 0.5 ? 1000 : -1000);
    if (share(random) < 0.003) speed_rpm = 12000.0 * share(random), load = share(random);
    const double rise_K = 6.0 * (1.0 - std::exp(-n / 400.0));
    for (std::size_t k = 0; k < 3; ++k) {
      if (n < first_reading || share(random) < 0.1) continue;  // an older reading stays
      const double odd = share(random);
      const double reading_K = odd < 0.01   ? firmware::not_a_value
                               : odd < 0.02 ? 450.0
                                            : 300.15 + rise_K + 0.1 * static_cast<double>(k) + noise_K(random);
      frame.sensors[k] = {reading_K, now_ns - static_cast<std::int64_t>(3e7 * share(random))};
    }
    if (n % 50 < 40) frame.displacements[1] = {1e-6 * noise_K(random) - 2e-6, now_ns - 100'000};
    frame.signals[0] = {speed_rpm, now_ns};
    frame.signals[1] = {load, now_ns};
    frame.signals[2] = {300.15 + 0.01 * noise_K(random), now_ns};
    frame.signals[3] = {300.15 + 0.1 * noise_K(random), now_ns};
    if (n == 700 || n == 1100) {
      ++command.tare_orders;
      command.tare_order = n == 700 ? firmware::TareOrder::take : firmware::TareOrder::clear;
    }
    if (n == 650 || n == 900) {
      ++command.displacements;
      command.displacement = {0, 1e-6 * share(random), 2e-7};
    }
    if (n == 800 || n == 1200 || n == 1300) {
      ++command.sensor_orders;
      command.sensor_order = n == 800    ? firmware::SensorOrder::acknowledge
                             : n == 1200 ? firmware::SensorOrder::clear_tare
                                         : firmware::SensorOrder::tare;
    }
    command.correction = n > 300 && n < 420 ? firmware::SwitchOrder::off : firmware::SwitchOrder::on;
    life.snapshots.push_back(cycle.step(frame, command, now_ns, missed));
    life.history += firmware::history_row(life.snapshots.back()) + "\n";
  }
  return life;
}

TEST_F(Replay, a_history_gives_the_daemons_own_predictions_to_the_bit) {
  for (const bool paper : {true, false}) {
    SCOPED_TRACE(paper ? "paper" : "estimator");
    const Life life = live(network_, 20240611, paper);
    ASSERT_GT(life.snapshots.back().correction_count, 5) << "the correction had to do something";
    ASSERT_GT(life.snapshots.back().overruns, 20U);
    ASSERT_GT(life.snapshots.back().displacement_count, paper ? -1 : 5) << "both touch-offs and a probe";
    const Log log = this->log(life.history);
    ASSERT_EQ(log.rows.size(), life.snapshots.size());
    EXPECT_EQ(log.cycle_s, 1.0);
    const std::vector<Snapshot> again = run(life.plan, log);
    ASSERT_EQ(again.size(), life.snapshots.size());
    for (std::size_t i = 0; i < again.size(); ++i) {
      ASSERT_EQ(bits_of(again[i]), bits_of(life.snapshots[i])) << "cycle " << i;
    }
  }
}

TEST_F(Replay, two_runs_are_the_same_to_the_bit_and_so_is_the_replay_of_a_replay) {
  const Log first = log(live(network_, 7).history);
  const CyclePlan with = plan(first, "paper");
  const std::vector<Snapshot> a = run(with, first), b = run(with, first);
  std::string written = replay_header(network_) + "\n";
  for (const Snapshot& snapshot : a) written += replay_row(snapshot, {0.1, firmware::not_a_value, 0.2}) + "\n";
  const std::vector<Snapshot> c = run(with, log(written));
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.size(), c.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(bits_of(a[i]), bits_of(b[i])) << "cycle " << i;
    ASSERT_EQ(bits_of(a[i]), bits_of(c[i])) << "cycle " << i;
  }
}

std::string plain_log(const std::function<double(double)>& inner_degC, double step_s, double end_s,
                      const std::function<double(double)>& nose_um) {
  std::ostringstream text;
  text.precision(17);
  text << "time_s,speed_rpm,load,coolant_degC,ambient_degC,measured.sleeve_inner_degC,measured.nose_um\n";
  for (double time_s = 0.0; time_s <= end_s; time_s += step_s) {
    text << 100.0 + time_s << ",6000,1,27,27," << inner_degC(time_s) << "," << nose_um(time_s) << "\n";
  }
  return text.str();
}

TEST_F(Replay, a_log_that_is_the_prediction_has_no_error_and_an_offset_comes_back_as_it_is) {
  const auto flat = [](double value) { return [value](double) { return value; }; };
  const Log drive = log(plain_log(flat(27.0), 1.0, 600.0, flat(0.0)));
  const std::vector<Snapshot> predicted = run(plan(drive), drive);
  ASSERT_EQ(predicted.size(), 601U) << "a cycle at every second, both ends included";
  EXPECT_DOUBLE_EQ(predicted.front().model_time_s, 101.0)
      << "a prediction is for the end of its period, in the log's time";
  const auto inner_degC = [&](double time_s) {
    return time_s == 0.0 ? 27.0 : predicted[static_cast<std::size_t>(time_s) - 1].predicted_K[0] - 273.15;
  };
  const auto nose_um = [&](double time_s) {
    return (time_s == 0.0 ? 0.0 : 1e6 * predicted[static_cast<std::size_t>(time_s) - 1].deformation_m[0]) - 0.25;
  };
  const Log own = log(plain_log(inner_degC, 10.0, 600.0, nose_um));
  const ReplayErrors found = errors(plan(own), own);
  ASSERT_EQ(found.sensors().size(), 1U);
  EXPECT_EQ(found.sensors()[0].twin.count, 60U) << "the first row has no prediction before it";
  EXPECT_LT(found.sensors()[0].twin.rms(), 1e-9);
  ASSERT_EQ(found.deformations().size(), 1U);
  EXPECT_NEAR(found.deformations()[0].twin.rms(), 0.25e-6, 1e-12);
  EXPECT_NEAR(found.deformations()[0].twin.worst, 0.25e-6, 1e-12);
  EXPECT_NEAR(found.deformations()[0].uncorrected.last, 0.25e-6, 1e-12);
  EXPECT_EQ(errors(plan(own), own, 500.0).sensors()[0].twin.count, 21U) << "from 500 s of the log's time on";
}

TEST_F(Replay, between_two_predictions_the_error_is_taken_linearly) {
  const auto flat = [](double value) { return [value](double) { return value; }; };
  const Log drive = log(plain_log(flat(27.0), 0.25, 30.0, flat(0.0)));
  const std::vector<Snapshot> predicted = run(plan(drive), drive);
  ReplayErrors found(network_, plan(drive), drive, -1e300);
  replay(network_, plan(drive), drive, [&](const ReplayedCycle& cycle) { found.add(cycle); });
  double worst_m = 0.0;  // the measured nose stays at 0, so the error is the prediction
  for (const Snapshot& snapshot : predicted) {
    if (snapshot.model_time_s <= 130.0) worst_m = std::max(worst_m, snapshot.deformation_m[0]);
  }
  EXPECT_DOUBLE_EQ(found.deformations()[0].twin.worst, worst_m);
  EXPECT_EQ(found.deformations()[0].twin.count, 4U * 29U + 1U) << "all readings from the first prediction's instant on";
}

TEST_F(Replay, a_sensor_that_is_not_used_judges_only) {
  firmware::Machine machine(network_, 0.5);
  std::ostringstream text;
  text << "time_s,speed_rpm,load,measured.sleeve_inner_degC,measured.sleeve_outer_degC\n";
  for (int s = 0; s <= 1200; ++s) {
    const Eigen::VectorXd& seen_K = machine.model.outputs.key_points_K;
    text << s << ",6000,1," << seen_K[0] - 273.15 << "," << (s == 600 ? 400.0 : seen_K[2] - 273.15) << "\n";
    machine.advance(1.0);
  }
  const Log log = this->log(text.str());
  ReplayOptions options;
  options.correction = "paper";
  options.sensors = {"sleeve_inner"};
  const ReplayErrors found = errors(plan_replay(network_, log, options), log);
  ASSERT_EQ(found.sensors().size(), 2U);
  EXPECT_TRUE(found.sensors()[0].used);
  EXPECT_FALSE(found.sensors()[1].used);
  EXPECT_EQ(found.sensors()[0].twin.count, 1200U);
  EXPECT_EQ(found.sensors()[1].twin.count, 1199U) << "400 degC is no reading of a sleeve";
  EXPECT_LT(found.sensors()[1].twin.rms(), 0.5 * found.sensors()[1].uncorrected.rms());
}

TEST_F(Replay, sensors_at_their_own_rates_hold_until_they_are_too_old) {
  std::string text = "time_s,speed_rpm,load,measured.sleeve_inner_degC,measured.sleeve_outer_degC\n";
  for (int s = 0; s <= 200; ++s) {
    text += std::to_string(s) + ",6000,1," + (s % 5 == 0 ? "28" : "") + "," + (s < 50 ? "27.5" : "") + "\n";
  }
  const Log slow = log(text);
  const std::vector<Snapshot> cycles = run(plan(slow, "paper"), slow);
  EXPECT_EQ(cycles[104].sensor_quality[0], firmware::SensorQuality::good);
  EXPECT_DOUBLE_EQ(cycles[104].measured_age_s[0], 4.0);
  EXPECT_EQ(cycles[104].sensor_quality[2], firmware::SensorQuality::good) << "55 s old, 60 s may be";
  EXPECT_EQ(cycles[150].sensor_quality[2], firmware::SensorQuality::stale);
}

TEST_F(Replay, bad_logs_are_refused_with_line_and_column) {
  EXPECT_EQ(refusal(""), ": empty; a header with the names of the columns is needed");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n"), ": holds no row");
  EXPECT_EQ(refusal("time_s;speed_rpm;load\n0;1;1\n"), ":1: columns must be separated by commas");
  EXPECT_EQ(refusal("time_s,load\n0,1\n"), ":1: speed_rpm: missing column");
  EXPECT_EQ(refusal("speed_rpm,load\n6000,1\n"), ":1: time_s: missing column");
  EXPECT_EQ(refusal("time_s,speed_rpm,load,measured.front_degC\n0,1,1,20\n"),
            ":1: measured.front_degC: unknown column; allowed: time_s, speed_rpm, load, coolant_degC, ambient_degC, "
            "current_A, power_W, measured.sleeve_inner_degC, measured.sleeve_middle_degC, measured.sleeve_outer_degC, "
            "measured.nose_um, "
            "measured.rear_um, and those of a history of spindle-twind");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n1,nan,1\n"),
            ":3: speed_rpm: 'nan' is not a finite number with a decimal point");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n1,,1\n"), ":3: speed_rpm: must not be empty");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n1,\"6,5\",1\n"), ":3: 4 values, but the header names 3 columns");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n5,1,1\n5,1,1\n"), ":4: time_s: times must rise from row to row");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n120,1,1\n"),
            ":3: time_s: 120 s after the row before; gaps may be 60 s long (--longest-gap-s)");
  EXPECT_EQ(refusal("time_s,speed_rpm,load,load\n0,1,1,1\n"), ":1: load: column given twice");
}

TEST_F(Replay, a_history_with_rows_missing_or_at_another_pace_is_refused) {
  std::istringstream history(live(network_, 5).history);
  std::vector<std::string> lines;
  for (std::string line; std::getline(history, line);) lines.push_back(line);
  const auto join = [](const std::vector<std::string>& from) {
    std::string text;
    for (const std::string& line : from) text += line + "\n";
    return text;
  };
  std::vector<std::string> torn = lines;
  torn.erase(torn.begin() + 100);
  EXPECT_EQ(refusal(join(torn)), ":101: sequence: 101 after 99: rows are missing");
  std::vector<std::string> jumped = lines;
  for (std::size_t i = 200; i < jumped.size(); ++i) jumped[i].insert(0, "1");  // 195 becomes 1195
  EXPECT_NE(refusal(join(jumped)).find(":201: time_s: must rise by one period"), std::string::npos);
  EXPECT_EQ(refusal(join({lines[0], lines[1]})), ": time_s: this history holds no two cycles with a prediction");
  std::vector<std::string> tail = {lines[0]};
  tail.insert(tail.end(), lines.begin() + 700, lines.end());
  EXPECT_EQ(refusal(join(tail)), "no error") << "what is left of a history starts anew from its sensors";
}

TEST_F(Replay, a_plan_that_the_log_cannot_serve_is_refused) {
  const auto message_of = [&](const std::string& text, ReplayOptions options) {
    const Log of = log(text);
    try {
      plan_replay(network_, of, options);
    } catch (const rom::InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const std::string bare = "time_s,speed_rpm,load\n0,6000,1\n1,6000,1\n";
  EXPECT_NE(message_of(bare, {}).find("--start-degC: is needed where no sensor tells"), std::string::npos);
  ReplayOptions started;
  started.start_degC = 27.0;
  EXPECT_EQ(message_of(bare, started), "no error");
  for (const char* law : {"paper", "estimator"}) {
    started.correction = law;
    EXPECT_NE(message_of(bare, started).find("needs at least one sensor in the log"), std::string::npos) << law;
  }
  ReplayOptions other;
  other.sensors = {"sleeve_outer"};
  EXPECT_NE(
      message_of("time_s,speed_rpm,load,measured.sleeve_inner_degC\n0,6000,1,27\n1,6000,1,27\n", other)
          .find("measured.sleeve_outer_degC: this sensor is configured, but the log has no reading of it; it has: "
                "sleeve_inner"),
      std::string::npos);
}

}  // namespace replay_test
}  // namespace spindle_twin::host_tools
