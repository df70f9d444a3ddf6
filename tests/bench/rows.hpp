#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "fem_offline/model/build_model.hpp"
#include "rom/network.hpp"

/// What the bench measures, as rows of tests/bench/table. Times are processor seconds where a row does not say
/// otherwise, so that other work on the computer hardly moves the ratios.
namespace spindle_twin::bench {

/// Our time beside another one of the same run. The other is a peer, another way to the same result, or a bound: the
/// bare operation that ours stands on.
struct Row {
  std::string group;
  std::string name;
  std::string kind = "bound";  ///< or "peer"
  double ours_s = 0.0;
  std::string other_name;
  double other_s = 0.0;
  std::string means;                ///< what the ratio says, for the page
  std::optional<double> goal = {};  ///< of ours / other, at the most
  std::string clock = "processor";  ///< or "wall"
  bool detail = false;              ///< part of another row or between two: in the table, without a bar
};

/// Prints rows as lines of JSON that carry the run's name.
class RowPrinter {
 public:
  explicit RowPrinter(std::string run) : run_(std::move(run)) {}
  void print(const Row& row) const;

 private:
  std::string run_;
};

/// The reference spindle with another element size. Without its deformations only the thermal part is built.
fem_offline::FeModel reference_model(double element_size_mm, bool thermal_only);

/// The network of 200 nodes of the reference spindle, for the rows of the daemon's cycle.
rom::Network network_of_200_nodes();

/// A part program: another speed and load every held_s.
inline constexpr int held_s = 120;
struct Drive {
  double speed_rpm = 0.0;
  double load = 0.0;
};
Drive drive_at(int second);

/// Processor seconds of this thread for one call, the least of `repeats`.
double thread_seconds(int repeats, const std::function<void()>& work);
/// Processor seconds of all threads for one call.
double process_seconds(const std::function<void()>& work);
/// Seconds of one matrix-vector product with a full matrix of so many rows: the least that a step of a network costs.
double bare_product_seconds(Eigen::Index rows);

/// 12345 as "12,345".
std::string with_commas(long count);

/// Processor seconds of one transient step with its factor kept, at the operating state.
double step_seconds(const std::string& spindle_path);

/// What a bare CHOLMOD takes for the thermal matrix of a spindle as it is described, at its operating state.
struct FactorCost {
  long unknowns = 0;
  double factor_s = 0.0;  ///< one numeric factorisation, processor seconds
  double solve_s = 0.0;   ///< one back-substitution
  double bytes = 0.0;     ///< of the factor
};
FactorCost factor_cost(const std::string& spindle_path);

/// Processor seconds of a network over a schedule in cycles of 1 s, without reading the file.
double schedule_seconds(const std::string& network_path, const std::string& schedule_path);

void print_fem_rows(const RowPrinter& printer);
void print_network_rows(const RowPrinter& printer);
void print_estimator_rows(const RowPrinter& printer);
void print_cycle_rows(const RowPrinter& printer);
/// `daemon`: the program spindle-twind.
void print_register_rows(const RowPrinter& printer, const std::string& daemon);

}  // namespace spindle_twin::bench
