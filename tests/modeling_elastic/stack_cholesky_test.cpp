#include "modeling/elastic/stack_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/modeling_elastic/elastic_check.h"

namespace annulus {
namespace {

/// Random positive definite matrices of piles and their sum as one dense matrix.
struct Sums {
  GridShape shape;
  std::vector<Eigen::MatrixXd> pile;
  Eigen::MatrixXd whole;

  explicit Sums(const GridShape& s) : shape(s) {
    const auto per_stack = static_cast<Eigen::Index>(3 * s.layers);
    const auto size = static_cast<Eigen::Index>(3 * s.nodes());
    whole = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t p = 0; p < s.piles(); ++p) {
      Eigen::MatrixXd half(4 * per_stack, 4 * per_stack);
      for (Eigen::Index k = 0; k < half.size(); ++k) {
        half.data()[k] = test::Wobble(p * 7919 + static_cast<std::size_t>(k));
      }
      pile.push_back(half * half.transpose() + Eigen::MatrixXd::Identity(half.rows(), half.rows()));
      const auto stacks = s.StacksOf(p);
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          whole.block(static_cast<Eigen::Index>(stacks[a]) * per_stack,
                      static_cast<Eigen::Index>(stacks[b]) * per_stack, per_stack, per_stack) +=
              pile[p].block(static_cast<Eigen::Index>(a) * per_stack, static_cast<Eigen::Index>(b) * per_stack,
                            per_stack, per_stack);
        }
      }
    }
  }
};

TEST(StackCholesky, SolvesAsADenseCholesky) {
  for (const GridShape& shape : {GridShape{5, 4, 2, GridClosure::kOpen}, GridShape{13, 9, 3, GridClosure::kOpen},
                                 GridShape{3, 2, 2, GridClosure::kClosed}, GridShape{14, 6, 3, GridClosure::kClosed}}) {
    const Sums sums(shape);
    std::vector<char> held(3 * shape.nodes(), 0);
    Eigen::MatrixXd expected = sums.whole;
    Eigen::MatrixXd right(expected.rows(), 2);
    for (Eigen::Index k = 0; k < right.size(); ++k) right.data()[k] = test::Wobble(static_cast<std::size_t>(k));
    Eigen::MatrixXd dense_right = right;
    for (std::size_t k = 0; k < held.size(); ++k) {
      if (k % 11 != 0 && k % 17 != 3) continue;
      held[k] = 1;
      const auto at = static_cast<Eigen::Index>(k);
      expected.row(at).setZero();
      expected.col(at).setZero();
      expected(at, at) = 1.0;
      dense_right.row(at).setZero();
    }
    StackCholesky factor(std::make_shared<const StackTree>(shape, held));
    for (int n = 0; n < 2; ++n) {  // the second time into the same memory
      ASSERT_TRUE(factor.Factor([&](std::size_t pile) { return sums.pile[pile].data(); }));
      const Eigen::MatrixXd solved = expected.llt().solve(dense_right);
      EXPECT_LE((factor.Solve(right) - solved).cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_LE((factor.Solve(Eigen::VectorXd(right.col(1))) - solved.col(1)).cwiseAbs().maxCoeff(), 1e-10);
    }
  }
}

TEST(StackCholesky, GivesNothingForAnIndefiniteMatrix) {
  const GridShape shape{5, 4, 2, GridClosure::kOpen};
  Sums sums(shape);
  sums.pile[3] = -100.0 * Eigen::MatrixXd::Identity(24, 24);
  const std::vector<char> held(3 * shape.nodes(), 0);
  StackCholesky factor(std::make_shared<const StackTree>(shape, held));
  EXPECT_FALSE(factor.Factor([&](std::size_t pile) { return sums.pile[pile].data(); }));
}

}  // namespace
}  // namespace annulus
