#include "host_tools/calibrate/calibration_page.hpp"

#include <cmath>

#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;
using correction::TestReading;

double rounded(double value) { return std::round(1e4 * value) / 1e4; }

bool is_probe(const correction::CalibrateOptions& options, const correction::ChannelFit& channel) {
  return channel.channel >= static_cast<int>(options.sensors.size());
}

/// How well channels are met, one after the other.
Json fits_json(const correction::CalibrateOptions& options, const std::vector<correction::ChannelFit>& channels) {
  Json list = Json::array();
  for (const correction::ChannelFit& channel : channels) {
    const bool probe = is_probe(options, channel);
    const double scale = probe ? rom::um_per_m : 1.0;
    list.push_back({{"name", channel.name},
                    {"log", channel.test + 1},
                    {"unit", probe ? "µm" : "K"},
                    {"readings", channel.readings},
                    {"rms", scale * channel.rms},
                    {"expected_rms", scale * channel.expected_rms},
                    {"autocorrelation", channel.lag_1},
                    {"outliers", channel.outliers}});
    if (!channel.held_out) continue;
    list.back()["mean"] = scale * channel.held_out->off;
    list.back()["mean_deviation"] = scale * channel.held_out->deviation;
  }
  return list;
}

/// One channel of one test.
Json channel_json(const correction::CalibrationResult& result, const correction::ChannelFit& channel, bool probe) {
  const double scale = probe ? rom::um_per_m : 1.0, shift = probe ? 0.0 : -rom::zero_degC_K;
  Json json{{"name", channel.name},
            {"unit", probe ? "µm" : "K"},
            {"rms", scale * channel.rms},
            {"expected_rms", scale * channel.expected_rms}};
  Json time_s = Json::array(), measured = time_s, before = time_s, after = time_s, left = time_s, sd = time_s;
  const std::vector<TestReading>& readings = result.fit.readings[channel.test].readings;
  const std::vector<TestReading>& prior = result.before[channel.test].readings;
  double zero = 0.0;
  for (std::size_t r = 0; r < readings.size(); ++r) {
    if (readings[r].channel != channel.channel) continue;
    const auto row = static_cast<Eigen::Index>(r);
    if (time_s.empty() && probe) zero = prior[r].residual;
    const double remains = result.fit.left[channel.test][row];
    time_s.push_back(readings[r].time_s);
    measured.push_back(rounded(scale * readings[r].value + shift));
    before.push_back(rounded(scale * (prior[r].value - prior[r].residual + zero) + shift));
    after.push_back(rounded(scale * (readings[r].value - remains) + shift));
    left.push_back(rounded(scale * remains));
    sd.push_back(rounded(scale * std::sqrt(result.fit.expected[channel.test](row, row))));
  }
  json.update(
      {{"time_s", time_s}, {"measured", measured}, {"before", before}, {"after", after}, {"left", left}, {"sd", sd}});
  return json;
}

}  // namespace

Json calibration_page_data(const rom::Network& network, const correction::CalibrateOptions& options,
                           const correction::CalibrationResult& result) {
  const correction::Calibration& calibration = result.calibration;
  Json data{{"spindle", network.spindle},
            {"tested_s", calibration.tested_s},
            {"chi_square_per_reading", result.fit.chi_square_per_reading},
            {"promised_um", rom::um_per_m * calibration.promised_m},
            {"misfits", result.misfits},
            {"fit", fits_json(options, result.fit.channels)},
            {"held_out", fits_json(options, result.held_out.channels)}};
  for (std::size_t test = 0; test < calibration.logs.size(); ++test) {
    Json channels = Json::array();
    for (const correction::ChannelFit& channel : result.fit.channels) {
      if (channel.test != test) continue;
      channels.push_back(channel_json(result, channel, is_probe(options, channel)));
    }
    data["tests"].push_back({{"log", calibration.logs[test]}, {"channels", channels}});
  }
  for (std::size_t i = 0; i < calibration.names.size(); ++i) {
    const auto slot = static_cast<Eigen::Index>(i);
    data["parameters"].push_back({{"name", calibration.names[i]},
                                  {"prior", calibration.prior_mean[slot]},
                                  {"prior_deviation", calibration.prior_deviation[slot]},
                                  {"value", calibration.mean[slot]},
                                  {"deviation", calibration.root.row(slot).norm()}});
  }
  return data;
}

}  // namespace spindle_twin::host_tools
