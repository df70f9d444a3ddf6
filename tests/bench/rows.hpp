#pragma once

#include <functional>
#include <string>

#include "fem_offline/model/build_model.hpp"

/// What the bench measures. Times are processor seconds, so that other work on the computer hardly moves the ratios.
namespace spindle_twin::bench {

/// The reference spindle with another element size. Without its deformations only the thermal part is built.
fem_offline::FeModel reference_model(double element_size_mm, bool thermal_only);

/// Processor seconds of this thread for one call, the least of `repeats`.
double thread_seconds(int repeats, const std::function<void()>& work);
/// Processor seconds of all threads for one call.
double process_seconds(const std::function<void()>& work);

void print_row(const std::string& what, double value, const std::string& unit, const std::string& goal = "");

/// Processor seconds of one transient step with its factor kept, at the operating state.
double step_seconds(const std::string& spindle_path);

/// Processor seconds of a network over a schedule in cycles of 1 s, without reading the file.
double schedule_seconds(const std::string& network_path, const std::string& schedule_path);

void print_fem_rows();
void print_network_rows();
void print_estimator_rows();

}  // namespace spindle_twin::bench
