#include "fitting/paper_knots.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/ensure.h"
#include "base/units.h"
#include "fitting/paper_surface.h"

namespace annulus {
namespace {

constexpr std::size_t kFewestFeatures = 3;        // fewer leave a curve too few knots
constexpr std::size_t kSamplesPerFeature = 6;     // of those found: a knot per two samples
constexpr std::size_t kSamplesPerAnyFeature = 4;  // of all: three knots per four samples

/// |f'| at the known estimates as a polyline over two turns (closed) or the whole curve (open).
struct Variation {
  std::vector<double> x;
  std::vector<double> speed;

  /// |f'| at x: linear between estimates, the nearest one beyond them.
  [[nodiscard]] double At(double where) const {
    if (x.empty()) return 0.0;
    const auto above = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), where) - x.begin());
    if (above == 0) return speed.front();
    if (above == x.size()) return speed.back();
    const double share = (where - x[above - 1]) / (x[above] - x[above - 1]);
    return speed[above - 1] + share * (speed[above] - speed[above - 1]);
  }
};

Variation VariationOf(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes) {
  Variation variation;
  for (int turn = samples.closed() ? -1 : 0; turn <= (samples.closed() ? 1 : 0); ++turn) {
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (!slopes[k].known) continue;
      variation.x.push_back(samples.x[k] + turn * samples.period);
      variation.speed.push_back(std::abs(slopes[k].first));
    }
  }
  return variation;
}

/// Where the integral of a line from `a` to `b` over a length h reaches `area` (between 0 and the whole), from 0 to h.
double InverseTrapezium(double a, double b, double h, double area) {
  const double growth = (b - a) / h;
  // area = a·t + growth·t²/2, in the form that does not cancel.
  const double root = std::sqrt(std::max(0.0, a * a + 2.0 * growth * area));
  return a + root > 0.0 ? std::min(h, 2.0 * area / (a + root)) : h;
}

/// Position of feature `k`, which may be one past the last of a closed curve.
double FeatureAt(const KnotPlan& plan, std::size_t k) {
  const std::size_t n = plan.features.size();
  return plan.features[k % n].x + (k >= n ? plan.period : 0.0);
}

std::size_t GapsOf(const KnotPlan& plan) { return plan.closed() ? plan.features.size() : plan.features.size() - 1; }

/// Knots by eq. 2.6.
std::vector<double> KnotsByVariation(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                                     const KnotPlan& plan) {
  std::vector<double> knots;
  for (std::size_t gap = 0; gap < GapsOf(plan); ++gap) {
    const double from = FeatureAt(plan, gap);
    const auto between = SplitByVariation(samples, slopes, from, FeatureAt(plan, gap + 1));
    knots.insert(knots.end(), {from, between[0], between[1]});
  }
  if (!plan.closed()) knots.push_back(plan.features.back().x);
  return knots;
}

/// Knots with the features where they are and those between them where the sum of squared second differences of all
/// knots is least: the evenest spacing that the features allow.
std::vector<double> EvenestKnots(const KnotPlan& plan) {
  const std::size_t gaps = GapsOf(plan);
  const std::size_t n = 3 * gaps + (plan.closed() ? 0 : 1);
  const auto unknowns = static_cast<Eigen::Index>(2 * gaps);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t centre = plan.closed() ? 0 : 1; centre < (plan.closed() ? n : n - 1); ++centre) {
    // One second difference: constant part and up to two unknowns.
    double constant = 0.0;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(unknowns);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = centre + n + k - 1;  // n is one turn
      const double factor = k == 1 ? -2.0 : 1.0;
      const double turn = plan.period * (static_cast<double>(at / n) - 1.0);
      const std::size_t knot = at % n;
      if (knot % 3 == 0) {
        constant += factor * (plan.features[knot / 3].x + turn);
      } else {
        row[static_cast<Eigen::Index>(2 * (knot / 3) + knot % 3 - 1)] += factor;
        constant += factor * turn;
      }
    }
    normal += row * row.transpose();
    right -= constant * row;
  }
  const Eigen::VectorXd free = normal.ldlt().solve(right);
  std::vector<double> knots;
  for (std::size_t k = 0; k < n; ++k) {
    knots.push_back(k % 3 == 0 ? plan.features[k / 3].x : free[static_cast<Eigen::Index>(2 * (k / 3) + k % 3 - 1)]);
  }
  return knots;
}

bool Rises(const std::vector<double>& knots, double period) {
  for (std::size_t k = 1; k < knots.size(); ++k) {
    if (!(knots[k] > knots[k - 1])) return false;
  }
  return period == 0.0 || knots.back() < knots.front() + period;
}

bool Keeps(const std::vector<double>& knots, double period, const KnotRules& rules) {
  return Rises(knots, period) && LeastSlope(knots, period).slope >= rules.least_slope;
}

std::vector<double> Blend(const std::vector<double>& a, const std::vector<double>& b, double share) {
  std::vector<double> blended;
  for (std::size_t k = 0; k < a.size(); ++k) blended.push_back(a[k] + share * (b[k] - a[k]));
  return blended;
}

/// The sample nearest to x that is not beyond it.
double SampleAt(const CurveSamples& samples, double x) {
  const double wrapped = samples.closed() && x >= samples.period ? x - samples.period : x;
  const auto above = std::upper_bound(samples.x.begin(), samples.x.end(), wrapped);
  return above == samples.x.begin() ? samples.x.back() : *(above - 1);
}

/// Places the knots by eq. 2.6, drawn towards the evenest spacing by the share with the least UniformMisfit. False if
/// none keeps the rules.
[[nodiscard]] bool KeepRules(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                             const KnotRules& rules, KnotPlan& plan) {
  const std::vector<double> by_variation = KnotsByVariation(samples, slopes, plan);
  const std::vector<double> evenest = EvenestKnots(plan);
  std::optional<double> lambda;
  double least = std::numeric_limits<double>::infinity();
  for (int eighths = 8; eighths >= 0; --eighths) {
    const std::vector<double> knots = Blend(by_variation, evenest, eighths / 8.0);
    if (!Keeps(knots, plan.period, rules)) continue;
    if (!lambda) lambda = ChooseLambda(KnotSplineBasis(knots, plan.period), samples);
    const double misfit = UniformMisfit(samples, knots, *lambda);
    if (!(misfit < least)) continue;
    least = misfit;
    plan.evened = eighths / 8.0;
    plan.knots = knots;
  }
  return std::isfinite(least);
}

void KeepMostSignificant(std::vector<FeaturePoint>& features, std::size_t most) {
  if (features.size() <= most) return;
  std::stable_sort(features.begin(), features.end(),
                   [](const FeaturePoint& a, const FeaturePoint& b) { return a.significance > b.significance; });
  features.resize(most);
  std::sort(features.begin(), features.end(), [](const FeaturePoint& a, const FeaturePoint& b) { return a.x < b.x; });
}

/// Makes the ends of an open curve features; those that come too near go.
void AddEnds(const CurveSamples& samples, std::vector<FeaturePoint>& features) {
  const double first = samples.x[kSamplesPerFeatureGap - 1];
  const double last = samples.x[samples.size() - kSamplesPerFeatureGap];
  std::erase_if(features, [&](const FeaturePoint& f) { return f.x <= first || f.x >= last; });
  features.insert(features.begin(), {FeatureKind::kEnd, samples.x.front(), 0.0});
  features.push_back({FeatureKind::kEnd, samples.x.back(), 0.0});
}

double GapLength(const KnotPlan& plan, std::size_t gap) { return FeatureAt(plan, gap + 1) - FeatureAt(plan, gap); }

/// Mean distance of samples.
double PitchOf(const CurveSamples& samples) {
  const double length = samples.closed() ? samples.period : samples.x.back() - samples.x.front();
  return length / static_cast<double>(samples.size() - (samples.closed() ? 0 : 1));
}

/// Puts an added feature at the sample in the middle of a gap. False if there would be too many, or too few samples
/// left on either side.
[[nodiscard]] bool Halve(const CurveSamples& samples, std::size_t gap, const KnotRules& rules, KnotPlan& plan) {
  if (plan.features.size() >= std::min(rules.most_features, samples.size() / kSamplesPerAnyFeature)) return false;
  const double from = FeatureAt(plan, gap);
  const double to = FeatureAt(plan, gap + 1);
  const double middle = SampleAt(samples, 0.5 * (from + to));
  const double least = (static_cast<double>(kSamplesPerFeatureGap) - 0.5) * PitchOf(samples);
  const double past = middle < from ? middle + plan.period : middle;
  if (past - from < least || to - past < least) return false;
  plan.features.push_back({FeatureKind::kAdded, middle, 0.0});
  std::sort(plan.features.begin(), plan.features.end(),
            [](const FeaturePoint& a, const FeaturePoint& b) { return a.x < b.x; });
  return true;
}

/// Halves every stretch that is too long.
void HalveLongGaps(const CurveSamples& samples, const KnotRules& rules, KnotPlan& plan) {
  const double pitch = PitchOf(samples);  // features stand at samples: one more is not too long
  const double longest =
      rules.longest_gap * (plan.closed() ? plan.period : samples.x.back() - samples.x.front()) + pitch;
  if (plan.features.empty()) plan.features.push_back({FeatureKind::kAdded, samples.x.front(), 0.0});
  for (bool halved = true; halved;) {
    std::size_t widest = 0;
    for (std::size_t gap = 1; gap < GapsOf(plan); ++gap) {
      if (GapLength(plan, gap) > GapLength(plan, widest) * (1.0 + 1e-9)) widest = gap;
    }
    halved = GapLength(plan, widest) > longest && Halve(samples, widest, rules, plan);
  }
}

/// Halves the longest of the gap in which a curve through the knots rises least, and the gaps beside it.
[[nodiscard]] bool HalveNear(const CurveSamples& samples, std::size_t gap, const KnotRules& rules, KnotPlan& plan) {
  const std::size_t gaps = GapsOf(plan);
  std::size_t longest = gap;
  const auto consider = [&](std::size_t other) {
    if (GapLength(plan, other) > GapLength(plan, longest)) longest = other;
  };
  if (plan.closed() || gap > 0) consider((gap + gaps - 1) % gaps);
  if (plan.closed() || gap + 1 < gaps) consider((gap + 1) % gaps);
  return Halve(samples, longest, rules, plan);
}

/// Removes the less significant feature of the closest pair; the ends of an open curve stay.
void DropOne(KnotPlan& plan) {
  const std::size_t n = plan.features.size();
  std::optional<std::size_t> victim;
  double shortest = 0.0;
  for (std::size_t gap = 0; gap < GapsOf(plan); ++gap) {
    const double length = FeatureAt(plan, gap + 1) - FeatureAt(plan, gap);
    if (victim && length >= shortest) continue;
    const std::size_t other = (gap + 1) % n;
    const bool first_fixed = plan.features[gap].kind == FeatureKind::kEnd;
    const bool second_fixed = plan.features[other].kind == FeatureKind::kEnd;
    if (first_fixed && second_fixed) continue;
    const bool first =
        second_fixed || (!first_fixed && plan.features[gap].significance < plan.features[other].significance);
    victim = first ? gap : other;
    shortest = length;
  }
  ENSURE(victim.has_value(), "there is a feature to drop");
  plan.features.erase(plan.features.begin() + static_cast<std::ptrdiff_t>(*victim));
  ++plan.dropped;
}

/// Equally spaced features: always keeps the rules.
void SpaceEqually(const CurveSamples& samples, const KnotRules& rules, KnotPlan& plan) {
  const auto gaps = static_cast<std::size_t>(std::ceil(1.0 / rules.longest_gap));
  plan.dropped += plan.features.size();
  plan.features.clear();
  const double from = samples.x.front();
  const double length = plan.closed() ? plan.period : samples.x.back() - from;
  for (std::size_t k = 0; k < gaps; ++k) {
    plan.features.push_back(
        {FeatureKind::kAdded, from + length * static_cast<double>(k) / static_cast<double>(gaps), 0.0});
  }
  if (!plan.closed()) {
    plan.features.front().kind = FeatureKind::kEnd;
    plan.features.push_back({FeatureKind::kEnd, samples.x.back(), 0.0});
  }
  plan.evened = 1.0;
  plan.knots = EvenestKnots(plan);
}

}  // namespace

std::array<double, 2> SplitByVariation(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes, double x0,
                                       double x3) {
  ENSURE(x0 < x3, "a gap has a length");
  const Variation variation = VariationOf(samples, slopes);
  std::vector<double> breaks{x0};
  for (const double x : variation.x) {
    if (x > x0 && x < x3) breaks.push_back(x);
  }
  breaks.push_back(x3);
  std::vector<double> total{0.0};
  for (std::size_t k = 1; k < breaks.size(); ++k) {
    const double mean = 0.5 * (variation.At(breaks[k - 1]) + variation.At(breaks[k]));
    total.push_back(total.back() + mean * (breaks[k] - breaks[k - 1]));
  }
  std::array<double, 2> split{x0 + (x3 - x0) / 3.0, x0 + 2.0 * (x3 - x0) / 3.0};
  constexpr double kRounding = 1e-9;  // of |f'|·x over the values: below, there is nothing to follow
  double largest = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (samples.weight[k] > 0.0) largest = std::max(largest, std::abs(samples.value[k]));
  }
  if (!(total.back() > kRounding * largest) || !std::isfinite(total.back())) return split;
  for (std::size_t part = 0; part < 2; ++part) {
    const double wanted = total.back() * static_cast<double>(part + 1) / 3.0;
    const auto above = std::lower_bound(total.begin() + 1, total.end() - 1, wanted);
    const auto k = static_cast<std::size_t>(above - total.begin());
    split[part] = breaks[k - 1] + InverseTrapezium(variation.At(breaks[k - 1]), variation.At(breaks[k]),
                                                   breaks[k] - breaks[k - 1], wanted - total[k - 1]);
  }
  return split;
}

double UniformMisfit(const CurveSamples& samples, const std::vector<double>& knots, double lambda) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  CurveFitter fitter(KnotSplineBasis(knots, samples.period), samples.x, lambda);
  const auto fit = fitter.Fit(samples.value, samples.weight);
  if (!fit) return kInfinite;
  Eigen::VectorXd radius(static_cast<Eigen::Index>(knots.size()));
  for (std::size_t k = 0; k < knots.size(); ++k) {
    radius[static_cast<Eigen::Index>(k)] = fitter.basis().Value(fit->coefficients, knots[k]);
  }
  // The curve as the surface will have it: a section of a body with two equal ones, or the outline of a body that is
  // the same in four directions.
  const std::vector<double> directions{0.0, 0.5 * kPi, kPi, 1.5 * kPi};
  const auto surface = samples.closed() ? PaperSurface::Through(knots, {0.0, 1.0}, radius.transpose().replicate(2, 1))
                                        : PaperSurface::Through(directions, knots, radius.replicate(1, 4));
  if (!surface) return kInfinite;
  double misfit = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (samples.weight[k] <= 0.0) continue;
    const double r = samples.closed() ? surface->Radius(samples.x[k], 0.0) : surface->Radius(0.0, samples.x[k]);
    misfit += samples.weight[k] * (r - samples.value[k]) * (r - samples.value[k]);
  }
  return misfit;
}

SlopeMinimum LeastSlope(const std::vector<double>& knots, double period) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  const bool closed = period > 0.0;
  // Closed: the control points of what is left of the knots after a straight line, so that it is periodic.
  const double step = closed ? period / static_cast<double>(n) : 0.0;
  Eigen::MatrixXd left(n, 1);
  for (Eigen::Index k = 0; k < n; ++k) left(k, 0) = knots[static_cast<std::size_t>(k)] - step * static_cast<double>(k);
  const Eigen::MatrixXd control = closed ? ClosedControlPoints(left) : OpenControlPoints(left);
  const auto slope = [&](Eigen::Index k) {  // at knot k
    return closed ? step + 0.5 * (control((k + 1) % n, 0) - control((k + n - 1) % n, 0))
                  : 0.5 * (control(k + 2, 0) - control(k, 0));
  };
  SlopeMinimum least;
  for (Eigen::Index k = 0; k < (closed ? n : n - 1); ++k) {
    const double from = knots[static_cast<std::size_t>(k)];
    const double to = k + 1 < n ? knots[static_cast<std::size_t>(k + 1)] : knots.front() + period;
    const double a = slope(k);
    const double b = slope(k + 1);
    // The slope over the interval is the parabola a + 2 (3 d - 2 a - b) t + 3 (a + b - 2 d) t².
    const double d = to - from;
    const double bend = 3.0 * (a + b - 2.0 * d);
    double lowest = std::min(a, b);
    if (bend > 0.0) {
      const double vertex = -(3.0 * d - 2.0 * a - b) / bend;
      if (vertex > 0.0 && vertex < 1.0) lowest = std::min(lowest, a - bend * vertex * vertex);
    }
    if (lowest / d < least.slope) least = {lowest / d, static_cast<std::size_t>(k)};
  }
  return least;
}

KnotPlan PlaceKnots(const CurveSamples& samples, const std::vector<SlopeEstimate>& slopes,
                    std::vector<FeaturePoint> features, const KnotRules& rules) {
  ENSURE(samples.size() >= 12, "a curve has enough samples for knots");
  KnotPlan found;
  found.period = samples.period;
  const std::size_t given = features.size();
  KeepMostSignificant(features, std::min(rules.most_features, samples.size() / kSamplesPerFeature));
  if (!found.closed()) AddEnds(samples, features);
  found.dropped = given - (features.size() - (found.closed() ? 0 : 2));
  found.features = std::move(features);
  while (true) {
    KnotPlan plan = found;
    HalveLongGaps(samples, rules, plan);
    while (plan.features.size() >= kFewestFeatures) {
      if (KeepRules(samples, slopes, rules, plan)) return plan;
      if (!HalveNear(samples, LeastSlope(EvenestKnots(plan), plan.period).interval / 3, rules, plan)) break;
    }
    if (found.features.size() <= (found.closed() ? 0 : 2)) break;
    DropOne(found);
  }
  SpaceEqually(samples, rules, found);
  return found;
}

}  // namespace annulus
