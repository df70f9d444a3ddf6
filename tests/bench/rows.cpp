#include "tests/bench/rows.hpp"

#include <time.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "fem_offline/reduce/reduce.hpp"

namespace spindle_twin::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void RowPrinter::print(const Row& row) const {
  nlohmann::ordered_json line{{"run", run_},          {"group", row.group},  {"name", row.name},
                              {"kind", row.kind},     {"ours", row.ours_s},  {"other_name", row.other_name},
                              {"other", row.other_s}, {"unit", "s"},         {"clock", row.clock},
                              {"means", row.means},   {"detail", row.detail}};
  if (row.goal) line["goal"] = *row.goal;
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}

fem_offline::FeModel reference_model(double element_size_mm, bool thermal_only) {
  fem_offline::Spindle spindle =
      fem_offline::read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  spindle.mesh.element_size_m = 1e-3 * element_size_mm;
  if (thermal_only) {
    spindle.deformations.clear();
    spindle.contact_pressures.clear();
    spindle.stress_probes.clear();
    spindle.supports.clear();
  }
  return {spindle, fem_offline::build_section(spindle)};
}

rom::Network network_of_200_nodes() {
  constexpr double element_size_mm = 6.0;
  fem_offline::ReduceOptions reduce;
  reduce.nodes = 200;
  reduce.full_sets = 20;
  reduce.full_histories = 20;
  reduce.rich_states = 300;
  reduce.rich_sets = 60;
  return fem_offline::reduce_model(reference_model(element_size_mm, false).affine(), reduce);
}

Drive drive_at(int second) {
  constexpr std::array<double, 6> speed_rpm{6000, 9000, 3000, 12000, 0, 7500};
  constexpr std::array<double, 5> load{1.0, 0.4, 0.7, 0.0, 0.9};
  const auto block = static_cast<std::size_t>(second / held_s);
  return {speed_rpm[block % speed_rpm.size()], load[block % load.size()]};
}

double thread_seconds(int repeats, const std::function<void()>& work) {
  double least_s = std::numeric_limits<double>::max();
  for (int i = 0; i < repeats; ++i) {
    const double start_s = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    work();
    least_s = std::min(least_s, seconds_of(CLOCK_THREAD_CPUTIME_ID) - start_s);
  }
  return least_s;
}

double process_seconds(const std::function<void()>& work) {
  const double start_s = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  work();
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID) - start_s;
}

double bare_product_seconds(Eigen::Index rows) {
  constexpr int repeats = 5, products = 4000;
  // Of norm 1: numbers that fade away become slow before they are zero.
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(rows, rows);
  Eigen::VectorXd vector = Eigen::VectorXd::Ones(rows), product(rows);
  const double all_s = thread_seconds(repeats, [&] {
    for (int i = 0; i < products; ++i) {
      product.noalias() = dense * vector;
      vector.swap(product);
    }
  });
  return all_s / products;
}

std::string with_commas(long count) {
  std::string digits = std::to_string(count);
  for (auto place = static_cast<std::ptrdiff_t>(digits.size()) - 3; place > 0; place -= 3) {
    digits.insert(static_cast<std::size_t>(place), 1, ',');
  }
  return digits;
}

}  // namespace spindle_twin::bench
