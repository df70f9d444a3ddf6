#include "host_tools/network_files/driven_terms.hpp"

#include <Eigen/QR>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;

constexpr double smallest_course_share = 1e-9;  // of the largest diagonal entry of R

class Split {
 public:
  Split(const rom::Network& network, const ScheduleCourse& course) : network_(network), course_(course) {
    const auto rows = static_cast<Index>(course.values.size());
    const auto all = static_cast<Index>(network.factors_m.size());
    along_W_per_m2K_.resize(all, rows);
    for (Index row = 0; row < rows; ++row) {
      along_W_per_m2K_.col(row) = course.values[static_cast<std::size_t>(row)].conductance_W_per_m2K;
    }
    for (Index j = 0; j < all; ++j) {
      const bool held = (along_W_per_m2K_.row(j).array() == along_W_per_m2K_(j, 0)).all();
      if (!held && network.factors_m[static_cast<std::size_t>(j)].squaredNorm() > 0.0) moving_.push_back(j);
    }
  }

  DrivenTerms by_conductance() const;
  DrivenTerms by_course() const;

 private:
  DrivenTerm empty_term(const std::string& what) const {
    const Index nodes = network_.capacity_J_per_K.rows();
    return {what,
            {},
            Eigen::MatrixXd::Zero(nodes, nodes),
            Eigen::MatrixXd::Zero(nodes, static_cast<Index>(network_.boundaries.environments.size()))};
  }
  void add(Index conductance, double times, DrivenTerm& term) const;

  const rom::Network& network_;
  const ScheduleCourse& course_;
  Eigen::MatrixXd along_W_per_m2K_;  // one row per conductance, one column per row of the schedule
  std::vector<Index> moving_;        // conductances that do not stay as they are
};

void Split::add(Index conductance, double times, DrivenTerm& term) const {
  const auto j = static_cast<std::size_t>(conductance);
  const Eigen::MatrixXd& factor = network_.factors_m[j];
  term.matrix += times * factor * factor.transpose();
  const int environment = network_.boundaries.conductances[j].environment;
  if (environment < 0) return;
  term.from_environment.col(environment) += times * factor * factor.colwise().sum().transpose();
}

DrivenTerms Split::by_conductance() const {
  DrivenTerms driven{along_W_per_m2K_.col(0), {}};
  for (const Index j : moving_) {
    driven.held_W_per_m2K[j] = 0.0;
    DrivenTerm term = empty_term(network_.boundaries.conductances[static_cast<std::size_t>(j)].name + ", W/m2K");
    for (Index row = 0; row < along_W_per_m2K_.cols(); ++row) term.course.push_back(along_W_per_m2K_(j, row));
    add(j, 1.0, term);
    driven.terms.push_back(std::move(term));
  }
  return driven;
}

DrivenTerms Split::by_course() const {
  DrivenTerms driven{along_W_per_m2K_.col(0), {}};
  const Eigen::VectorXd mean_W_per_m2K = course_.mean_conductances();
  const auto count = static_cast<Index>(moving_.size());
  // In W/K, so that conductances count by what they let pass.
  Eigen::VectorXd scale_m2(count);
  Eigen::MatrixXd moves_W_per_K(count, along_W_per_m2K_.cols());
  for (Index i = 0; i < count; ++i) {
    const Index j = moving_[static_cast<std::size_t>(i)];
    driven.held_W_per_m2K[j] = mean_W_per_m2K[j];
    scale_m2[i] = network_.factors_m[static_cast<std::size_t>(j)].squaredNorm();
    moves_W_per_K.row(i) = scale_m2[i] * (along_W_per_m2K_.row(j).array() - mean_W_per_m2K[j]);
  }
  // Orthonormal directions, each of what the ones before it leave most of.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> courses(moves_W_per_K);
  const Eigen::VectorXd strength = courses.matrixQR().diagonal().cwiseAbs();
  const Eigen::MatrixXd directions = courses.householderQ() * Eigen::MatrixXd::Identity(count, strength.size());
  for (Index m = 0; m < strength.size() && strength[m] > smallest_course_share * strength[0]; ++m) {
    DrivenTerm term = empty_term("what films and contacts do together about their means");
    // Row by row from a vector of its own: rows that are the same give the same bits, and so no jump.
    for (Index row = 0; row < moves_W_per_K.cols(); ++row) {
      const Eigen::VectorXd at_row = moves_W_per_K.col(row);
      term.course.push_back(directions.col(m).dot(at_row));
    }
    for (Index i = 0; i < count; ++i) {
      add(moving_[static_cast<std::size_t>(i)], directions(i, m) / scale_m2[i], term);
    }
    driven.terms.push_back(std::move(term));
  }
  return driven;
}

Index entries_of(const DrivenTerms& driven) {
  Index count = 0;
  for (const DrivenTerm& term : driven.terms) count += (term.matrix.array() != 0.0).count();
  return count;
}

}  // namespace

DrivenTerms driven_terms(const rom::Network& network, const ScheduleCourse& course) {
  const Split split(network, course);
  DrivenTerms by_conductance = split.by_conductance();
  if (by_conductance.terms.size() < 2) return by_conductance;
  DrivenTerms by_course = split.by_course();
  return entries_of(by_course) < entries_of(by_conductance) ? by_course : by_conductance;
}

}  // namespace spindle_twin::host_tools
