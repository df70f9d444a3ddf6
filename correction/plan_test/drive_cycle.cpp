#include "correction/plan_test/drive_cycle.hpp"

#include <algorithm>
#include <array>

namespace spindle_twin::correction {
namespace {

constexpr double spectrum_stage_s = 180.0;
constexpr std::array spectrum_shares{0.25, 0.5, 0.75, 1.0, 0.0};

struct ServiceStage {
  double minutes, share;
};
constexpr std::array service_stages{ServiceStage{40, 0.5},  ServiceStage{30, 1.0},  ServiceStage{15, 0.0},
                                    ServiceStage{45, 0.75}, ServiceStage{30, 0.25}, ServiceStage{40, 1.0},
                                    ServiceStage{40, 0.5}};
constexpr double service_load = 0.5;

}  // namespace

rom::Schedule schedule_of(const DriveCycle& cycle, const DriveLimits& limits, const rom::Boundaries& boundaries) {
  rom::Schedule schedule;
  rom::OperatingState state = boundaries.operating;
  double time_s = 0.0;
  for (const Stage& stage : cycle) {
    state.speed_rpm = stage.speed_rpm;
    state.load = stage.speed_rpm > 0.0 ? limits.load : 0.0;
    schedule.rows.push_back({time_s, state, 0});
    time_s += stage.length_s;
  }
  schedule.rows.push_back({time_s, state, 0});
  schedule.end_s = time_s;
  return schedule;
}

DriveCycle joined(const DriveCycle& cycle) {
  DriveCycle result;
  for (const Stage& stage : cycle) {
    if (!result.empty() && result.back().speed_rpm == stage.speed_rpm) {
      result.back().length_s += stage.length_s;
    } else {
      result.push_back(stage);
    }
  }
  return result;
}

DriveCycle constant_cycle(double speed_rpm, double length_s) { return {{length_s, speed_rpm}}; }

DriveCycle spectrum_cycle(const DriveLimits& limits) {
  DriveCycle cycle;
  double left_s = limits.length_s;
  for (std::size_t k = 0; left_s > 0.0; ++k) {
    const double length_s = std::min(left_s, spectrum_stage_s);
    cycle.push_back({length_s, spectrum_shares[k % spectrum_shares.size()] * limits.top_rpm});
    left_s -= length_s;
  }
  return joined(cycle);
}

rom::Schedule usual_service(double top_rpm, const rom::Boundaries& boundaries) {
  DriveCycle cycle;
  for (const ServiceStage& stage : service_stages) cycle.push_back({60.0 * stage.minutes, stage.share * top_rpm});
  DriveLimits limits;
  limits.load = service_load;
  return schedule_of(cycle, limits, boundaries);
}

}  // namespace spindle_twin::correction
