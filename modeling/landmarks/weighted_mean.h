#pragma once

namespace annulus {

/// A weighted mean, summed up one value after another. NaN without weight.
struct WeightedMean {
  double weight = 0.0;
  double sum = 0.0;

  void Add(double w, double value) {
    weight += w;
    sum += w * value;
  }
  [[nodiscard]] double value() const { return sum / weight; }
};

}  // namespace annulus
