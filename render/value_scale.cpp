#include "render/value_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"
#include "render/canvas.h"

namespace annulus {
namespace {

/// Finite values in rising order.
std::vector<WeightedValue> Sorted(std::span<const WeightedValue> values) {
  std::vector<WeightedValue> sorted;
  for (const WeightedValue& one : values) {
    if (std::isfinite(one.value) && one.weight > 0.0) sorted.push_back(one);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const WeightedValue& a, const WeightedValue& b) { return a.value < b.value; });
  return sorted;
}

/// The value that `share` of the weight does not exceed; `sorted` is not empty.
double Quantile(const std::vector<WeightedValue>& sorted, double weight, double share) {
  double sum = 0.0;
  for (const WeightedValue& one : sorted) {
    sum += one.weight;
    if (sum >= share * weight * (1.0 - 1e-12)) return one.value;
  }
  return sorted.back().value;
}

/// What does not depend on the scale.
ValueRange Summary(const std::vector<WeightedValue>& sorted) {
  ValueRange range;
  for (const WeightedValue& one : sorted) {
    range.weight += one.weight;
    range.mean += one.weight * one.value;
    range.rms += one.weight * one.value * one.value;
  }
  if (sorted.empty()) return range;
  range.mean /= range.weight;
  range.rms = std::sqrt(range.rms / range.weight);
  range.least = sorted.front().value;
  range.greatest = sorted.back().value;
  return range;
}

void SetScale(ValueRange& range, const std::vector<WeightedValue>& sorted, double minimum, double maximum) {
  range.minimum = minimum;
  range.maximum = maximum;
  for (const WeightedValue& one : sorted) {
    if (one.value < minimum) range.below += one.weight / range.weight;
    if (one.value > maximum) range.above += one.weight / range.weight;
  }
}

}  // namespace

LinearRgb ValueScale::ColourOf(double value) const {
  if (under && value < minimum) return *under;
  if (over && value > maximum) return *over;
  return MapColour(map, (value - minimum) / (maximum - minimum));
}

double ValueScale::ValueOf(const LinearRgb& colour) const {
  constexpr int kSteps = 2048;
  double best = std::numeric_limits<double>::infinity();
  double share = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double at = static_cast<double>(k) / kSteps;
    const LinearRgb pure = MapColour(map, at);
    const float shade = std::clamp(pure.dot(colour) / pure.squaredNorm(), kMapShade, 1.0F);
    const double apart = static_cast<double>((shade * pure - colour).squaredNorm());
    if (apart < best) {
      best = apart;
      share = at;
    }
  }
  return minimum + share * (maximum - minimum);
}

ValueRange RangeByRule(std::span<const WeightedValue> values, ScaleRule rule, double share) {
  ENSURE(share > 0.5 && share <= 1.0, "a scale holds most of the values");
  const std::vector<WeightedValue> sorted = Sorted(values);
  ValueRange range = Summary(sorted);
  if (sorted.empty()) return range;
  if (rule != ScaleRule::kPercentiles) {
    std::vector<WeightedValue> amounts = sorted;
    for (WeightedValue& one : amounts) one.value = std::abs(one.value);
    amounts = Sorted(amounts);
    const double amount = Quantile(amounts, range.weight, share);
    const double step = amount > 0.0 ? NiceStep(amount, 5) : 0.1;
    const double end = amount > 0.0 ? step * std::ceil(amount / step - 1e-9) : 1.0;
    SetScale(range, sorted, rule == ScaleRule::kAboutZero ? -end : 0.0, end);
    return range;
  }
  const double low = Quantile(sorted, range.weight, 1.0 - share);
  const double high = Quantile(sorted, range.weight, share);
  // All values alike: a scale as wide as the value, or 1, around it.
  const double width = high > low ? high - low : std::max(std::abs(high), 1.0);
  const double step = NiceStep(width, 8);
  const double from = high > low ? low : low - 0.5 * width;
  SetScale(range, sorted, step * std::floor(from / step + 1e-9), step * std::ceil((from + width) / step - 1e-9));
  return range;
}

ValueRange RangeGiven(std::span<const WeightedValue> values, double minimum, double maximum) {
  ENSURE(minimum < maximum, "a scale has two ends");
  const std::vector<WeightedValue> sorted = Sorted(values);
  ValueRange range = Summary(sorted);
  SetScale(range, sorted, minimum, maximum);
  return range;
}

}  // namespace annulus
