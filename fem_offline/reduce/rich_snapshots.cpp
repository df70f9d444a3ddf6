#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double corner_share = 0.4;
constexpr int shifts_per_set = 9;
constexpr int sets_per_group = 10;

std::array<double, shifts_per_set> shift_ladder() {
  constexpr double low = 2e-4, high = 3.0;
  std::array<double, shifts_per_set> shifts{};
  for (int i = 1; i < shifts_per_set; ++i) {
    shifts[static_cast<std::size_t>(i)] = low * std::pow(high / low, static_cast<double>(i - 1) / (shifts_per_set - 2));
  }
  return shifts;
}

}  // namespace

Eigen::MatrixXd RichModel::assemble(const Eigen::VectorXd& conductance_W_per_m2K) const {
  Eigen::MatrixXd sum = conduction;
  for (std::size_t j = 0; j < conductance_terms.size(); ++j) {
    sum += conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * conductance_terms[j];
  }
  return sum;
}

RichModel project_model(const AffineModel& model, const Loads& loads, const Eigen::MatrixXd& basis, int threads) {
  RichModel rich;
  rich.conductance_terms.resize(model.conductance_terms_m2.size());
  const int terms = static_cast<int>(model.conductance_terms_m2.size());
  for_each_index(terms + 2, threads, [&](int index, int) {
    const SparseMatrix& full = index == 0   ? model.capacity_J_per_K
                               : index == 1 ? model.conduction_W_per_K
                                            : model.conductance_terms_m2[static_cast<std::size_t>(index - 2)];
    // Film and contact terms touch few unknowns: gather those rows before the dense product.
    std::vector<int> touched;
    std::vector<int> place(static_cast<std::size_t>(full.rows()), -1);
    for (int column = 0; column < full.outerSize(); ++column) {
      if (!SparseMatrix::InnerIterator(full, column)) continue;
      place[static_cast<std::size_t>(column)] = static_cast<int>(touched.size());
      touched.push_back(column);
    }
    const Eigen::MatrixXd rows = basis(touched, Eigen::all);
    Eigen::MatrixXd image = Eigen::MatrixXd::Zero(rows.rows(), rows.cols());
    std::vector<Eigen::Triplet<double>> entries;
    for (int column = 0; column < full.outerSize(); ++column) {
      for (SparseMatrix::InnerIterator item(full, column); item; ++item) {
        entries.emplace_back(place[static_cast<std::size_t>(item.row())], place[static_cast<std::size_t>(column)],
                             item.value());
      }
    }
    SparseMatrix compact(rows.rows(), rows.rows());
    compact.setFromTriplets(entries.begin(), entries.end());
    image.noalias() = compact * rows;
    Eigen::MatrixXd small = rows.transpose() * image;
    small = (0.5 * (small + small.transpose())).eval();
    (index == 0   ? rich.capacity
     : index == 1 ? rich.conduction
                  : rich.conductance_terms[static_cast<std::size_t>(index - 2)]) = small;
  });
  rich.loads = loads.project(basis);
  return rich;
}

Eigen::MatrixXd rich_snapshot_basis(const RichModel& rich, const rom::Boundaries& boundaries,
                                    const ReduceOptions& options, const Progress& progress) {
  const Eigen::Index states = rich.capacity.rows();
  const std::array<double, shifts_per_set> shifts = shift_ladder();
  const int groups = (options.rich_sets + sets_per_group - 1) / sets_per_group;
  std::vector<Eigen::MatrixXd> sums(static_cast<std::size_t>(groups));
  for_each_index(groups, options.threads, [&](int group, int worker) {
    Eigen::MatrixXd& sum = sums[static_cast<std::size_t>(group)];
    sum.setZero(states, states);
    const int last = std::min(options.rich_sets, (group + 1) * sets_per_group);
    for (int set = group * sets_per_group; set < last; ++set) {
      RandomStream random(options.seed, StreamPurpose::rich_snapshots, static_cast<std::uint32_t>(set));
      const bool corner = random.uniform(0.0, 1.0) < corner_share;
      const Eigen::VectorXd conductances = random_conductances(boundaries, options.box, corner, random);
      const Eigen::MatrixXd conduction = rich.assemble(conductances);
      const Eigen::MatrixXd primal = rich.loads.primal(conductances);
      Eigen::MatrixXd columns(states, primal.cols() + rich.loads.outputs.cols());
      columns << primal, rich.loads.outputs;
      for (const double shift : shifts) {
        const Eigen::LLT<Eigen::MatrixXd> factor(conduction + shift * rich.capacity);
        if (factor.info() != Eigen::Success)
          throw std::runtime_error("the reduced conduction matrix is not positive definite");
        const Eigen::MatrixXd snapshots = factor.solve(columns);
        sum.selfadjointView<Eigen::Lower>().rankUpdate(snapshots);
      }
      if (worker == 0 && progress) progress("network snapshots", static_cast<double>(set + 1) / options.rich_sets);
    }
  });
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(states, states);
  for (const Eigen::MatrixXd& sum : sums) moments += sum;

  // The first rows and columns belong to the bodies' own columns, which are in the basis whatever the snapshots say.
  const Eigen::Index fixed = rich.bodies, others = states - fixed;
  const Eigen::MatrixXd rest =
      Eigen::MatrixXd(moments.selfadjointView<Eigen::Lower>()).bottomRightCorner(others, others);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(rest);
  if (modes.info() != Eigen::Success) throw std::runtime_error("the snapshots' moments have no eigenvectors");
  Eigen::MatrixXd coordinates = Eigen::MatrixXd::Zero(states, states);
  coordinates.topLeftCorner(fixed, fixed).setIdentity();
  coordinates.bottomRightCorner(others, others) = modes.eigenvectors().rowwise().reverse();
  return coordinates;
}

}  // namespace spindle_twin::fem_offline
