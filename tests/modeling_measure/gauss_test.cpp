#include "modeling/measure/gauss.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace annulus {
namespace {

double Integrate(const std::vector<QuadratureNode>& nodes, double (*f)(double)) {
  double sum = 0.0;
  for (const QuadratureNode& node : nodes) sum += node.weight * f(node.x);
  return sum;
}

TEST(PiecewiseGauss, IsExactForPolynomialsOfDegreeSeven) {
  const std::vector<double> breaks{-1.0, 0.5, 3.0};
  const auto nodes = PiecewiseGauss(breaks);
  EXPECT_EQ(nodes.size(), 8U);
  EXPECT_NEAR(Integrate(nodes, [](double) { return 1.0; }), 4.0, 1e-14);
  EXPECT_NEAR(Integrate(nodes, [](double x) { return std::pow(x, 7); }), (std::pow(3.0, 8) - 1.0) / 8.0, 1e-10);
}

TEST(PiecewiseGauss, ConvergesOnASine) {
  std::vector<double> breaks;
  for (int k = 0; k <= 10; ++k) breaks.push_back(0.1 * k * std::acos(-1.0));
  EXPECT_NEAR(Integrate(PiecewiseGauss(breaks), [](double x) { return std::sin(x); }), 2.0, 1e-12);
}

TEST(ClipBreaks, KeepsTheBreaksInsideAndAddsTheEnds) {
  const std::vector<double> breaks{0.0, 1.0, 2.0, 3.0};
  EXPECT_THAT(ClipBreaks(breaks, 0.5, 2.5), testing::ElementsAre(0.5, 1.0, 2.0, 2.5));
  EXPECT_THAT(ClipBreaks(breaks, 1.0, 2.0), testing::ElementsAre(1.0, 2.0));
  EXPECT_THAT(ClipBreaks(breaks, 1.25, 1.5), testing::ElementsAre(1.25, 1.5));
}

}  // namespace
}  // namespace annulus
