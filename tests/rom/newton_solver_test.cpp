#include "rom/integrate/newton_solver.hpp"

#include <gtest/gtest.h>
#include <sundials/sundials_context.h>

#include <Eigen/QR>
#include <limits>
#include <random>

#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::rom::tests {
namespace newton_solver_test {

class Context {
 public:
  Context() { SUNContext_Create(nullptr, &context_); }
  ~Context() { SUNContext_Free(&context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  operator SUNContext() const { return context_; }

 private:
  SUNContext context_ = nullptr;
};

/// K̃ with rates over eight decades, as a network has them, and channels that feed one another.
struct Problem {
  Problem(Eigen::Index nodes, Eigen::Index segments, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    const Eigen::MatrixXd q =
        Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd::NullaryExpr(nodes, nodes, draw)).householderQ() *
        Eigen::MatrixXd::Identity(nodes, nodes);
    const Eigen::VectorXd rates_per_s =
        Eigen::ArrayXd::LinSpaced(nodes, -5.0, 3.0).unaryExpr([](double exponent) { return std::pow(10.0, exponent); });
    lower = q * rates_per_s.asDiagonal() * q.transpose();
    walls = 0.1 * Eigen::MatrixXd::NullaryExpr(nodes, segments, draw);
    coupling = Eigen::MatrixXd::NullaryExpr(segments, segments, draw).triangularView<Eigen::StrictlyLower>();
    load = Eigen::VectorXd::NullaryExpr(nodes, draw);
  }

  Eigen::MatrixXd newton_matrix(double gamma) const {
    const Eigen::Index n = lower.rows();
    return Eigen::MatrixXd::Identity(n, n) + gamma * (lower - walls * coupling * walls.transpose());
  }

  Eigen::MatrixXd lower, walls, coupling;
  Eigen::VectorXd load;
};

TEST(NewtonSolver, solves_as_the_matrix_written_out_for_every_step_length) {
  const Context context;
  for (const auto& [nodes, segments] : {std::pair{1, 0}, {2, 0}, {60, 0}, {60, 1}, {60, 9}, {130, 20}}) {
    const Problem problem(nodes, segments, 7);
    NewtonSolver solver(nodes, segments, context);
    solver.set_matrix(problem.lower, problem.walls);
    for (const double gamma : {1e-6, 1e-3, 0.3, 5.0, 400.0}) {
      ASSERT_TRUE(solver.set_step(gamma, problem.coupling));
      Eigen::VectorXd solution = problem.load;
      solver.solve(solution.data(), solution.data());
      const Eigen::MatrixXd matrix = problem.newton_matrix(gamma);
      const double left = (matrix * solution - problem.load).norm();
      EXPECT_LT(left, 1e-13 * matrix.norm() * solution.norm())
          << nodes << " nodes, " << segments << " segments, " << gamma;
    }
    EXPECT_EQ(solver.decompositions(), 1);
  }
}

TEST(NewtonSolver, solves_with_capacity_factors_as_the_matrix_written_out) {
  const Context context;
  for (const auto& [nodes, segments] : {std::pair{1, 0}, {60, 0}, {60, 9}}) {
    const Problem problem(nodes, segments, 11);
    const Eigen::VectorXd inverse_capacity = Eigen::VectorXd::LinSpaced(nodes, 0.3, 3.0);
    NewtonSolver solver(nodes, segments, context);
    solver.set_matrix(problem.lower, problem.walls, inverse_capacity);
    for (const double gamma : {1e-3, 0.3, 400.0}) {
      ASSERT_TRUE(solver.set_step(gamma, problem.coupling));
      Eigen::VectorXd solution(nodes);
      solver.solve(problem.load.data(), solution.data());
      const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(nodes, nodes);
      const Eigen::MatrixXd matrix =
          identity + inverse_capacity.asDiagonal() * (problem.newton_matrix(gamma) - identity);
      EXPECT_LT((matrix * solution - problem.load).norm(), 1e-13 * matrix.norm() * solution.norm())
          << nodes << " nodes, " << segments << " segments, " << gamma;
    }
  }
}

TEST(NewtonSolver, reads_the_lower_triangle_alone) {
  const Context context;
  const Problem problem(40, 0, 3);
  NewtonSolver whole(40, 0, context), half(40, 0, context);
  whole.set_matrix(problem.lower, problem.walls);
  Eigen::MatrixXd spoilt = problem.lower;
  spoilt.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
  half.set_matrix(spoilt, problem.walls);
  Eigen::VectorXd expected = problem.load, is = problem.load;
  ASSERT_TRUE(whole.set_step(0.1, problem.coupling));
  ASSERT_TRUE(half.set_step(0.1, problem.coupling));
  whole.solve(expected.data(), expected.data());
  half.solve(is.data(), is.data());
  EXPECT_EQ(is, expected);
}

TEST(NewtonSolver, says_that_a_matrix_is_singular) {
  const Context context;
  NewtonSolver solver(2, 1, context);
  // 1 + γ (k − x p²) = 0 at the first node.
  Eigen::MatrixXd walls = Eigen::MatrixXd::Zero(2, 1);
  walls(0, 0) = 1.0;
  solver.set_matrix(Eigen::MatrixXd::Identity(2, 2), walls);
  EXPECT_FALSE(solver.set_step(1.0, Eigen::MatrixXd::Constant(1, 1, 2.0)));
  EXPECT_TRUE(solver.set_step(1.0, Eigen::MatrixXd::Constant(1, 1, 0.5)));
  Eigen::Vector2d solution(3.0, 4.0);
  solver.solve(solution.data(), solution.data());
  EXPECT_LT((solution - Eigen::Vector2d(2.0, 2.0)).norm(), 1e-14) << "1 + 1 − 0.5 and 1 + 1";
  NewtonSolver plain(2, 0, context);
  plain.set_matrix(-Eigen::MatrixXd::Identity(2, 2), Eigen::MatrixXd(2, 0));
  EXPECT_FALSE(plain.set_step(1.0, Eigen::MatrixXd(0, 0))) << "1 + γ k = 0 without a circuit";
  EXPECT_TRUE(plain.set_step(0.5, Eigen::MatrixXd(0, 0)));
}

TEST(NewtonSolver, makes_no_heap_call_once_it_is_there) {
  const Context context;
  const Problem problem(210, 12, 5);
  NewtonSolver solver(210, 12, context);
  Eigen::VectorXd solution(210);
  const long before = heap_calls();
  solver.set_matrix(problem.lower, problem.walls);
  const bool regular = solver.set_step(0.5, problem.coupling);
  solver.solve(problem.load.data(), solution.data());
  EXPECT_EQ(heap_calls() - before, 0);
  EXPECT_TRUE(regular);
}

}  // namespace newton_solver_test
}  // namespace spindle_twin::rom::tests
