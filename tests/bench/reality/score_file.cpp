#include "tests/bench/reality/score_file.hpp"

#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>

namespace spindle_twin::bench {
namespace {

constexpr const char* columns =
    "family,seed,cycle_s,error_um,deviation_um,inside,open_um,worst_um,failed_s,failed_at_end_s,degraded_s,"
    "ends_degraded,quality_at_end,faults,step_um_per_s,rejected,back_s,at_15_min_um,inside_from_1_min";

template <class Score, class Number>
void each_number(Score& score, const Number& number) {
  number(score.cycle_s);
  number(score.error_um);
  number(score.deviation_um);
  number(score.inside);
  number(score.open_um);
  number(score.worst_um);
  number(score.failed_s);
  number(score.failed_at_end_s);
  number(score.degraded_s);
  number(score.ends_degraded);
  number(score.quality_at_end);
  number(score.faults);
  number(score.step_um_per_s);
  number(score.rejected);
  number(score.back_s);
  number(score.at_15_min_um);
  number(score.inside_from_1_min);
}

}  // namespace

void write_scores(const std::string& path, const std::string& heading, const Scores& scores) {
  std::ofstream file(path);
  std::istringstream lines(heading);
  for (std::string line; std::getline(lines, line);) file << "# " << line << '\n';
  file << columns << '\n' << std::setprecision(5);
  for (const auto& [key, score] : scores) {
    file << key.first << ',' << key.second;
    each_number(score, [&](const auto& value) { file << ',' << value; });
    file << '\n';
  }
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

Scores read_scores(const std::string& path) {
  Scores scores;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#' || line == columns) continue;
    std::istringstream fields(line);
    std::string family;
    std::getline(fields, family, ',');
    RealityScore score;
    fields >> score.seed;
    each_number(score, [&](auto& value) {
      char comma = 0;
      fields >> comma >> value;
    });
    if (!fields) throw std::runtime_error(path + ": cannot read \"" + line + "\"");
    scores[{family, score.seed}] = score;
  }
  return scores;
}

}  // namespace spindle_twin::bench
