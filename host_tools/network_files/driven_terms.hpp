#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "host_tools/network_files/schedule_course.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// Heat that leaves the nodes of a network through what follows a schedule:
///   a(t) (matrix T − Σ_e from_environment.col(e) T_e)   [W]
struct DrivenTerm {
  std::string what;                  ///< for people
  std::vector<double> course;        ///< a at every row of the schedule
  Eigen::MatrixXd matrix;            ///< nodes x nodes, symmetric
  Eigen::MatrixXd from_environment;  ///< nodes x environments
};

struct DrivenTerms {
  Eigen::VectorXd held_W_per_m2K;  ///< of every conductance, what stays the same along the schedule
  std::vector<DrivenTerm> terms;   ///< the rest
};

/// Splits the conductances of a course. Either a term is one conductance, a its W/m²K; or, where that gives more
/// entries of matrices, conductances are their means over the time of the schedule, and terms what they do besides,
/// together: of gⱼ(t) − mean = Σ_m Uⱼₘ aₘ(t) (singular values) one term per m. Speed laws of one speed have few of
/// these, whatever the number of conductances. A circuit's segments count as films to its inlet.
DrivenTerms driven_terms(const rom::Network& network, const ScheduleCourse& course);

}  // namespace spindle_twin::host_tools
