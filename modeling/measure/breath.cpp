#include "modeling/measure/breath.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/units.h"
#include "fitting/fit_segments.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/section.h"

namespace annulus {
namespace {

/// A second of time is so high on the surface that is fitted: then levels lie as far apart as those of a body scan.
constexpr double kHeightPerSecond = 150.0;
constexpr double kStep = 0.1;          // s, of the course
constexpr double kMargin = 0.2;        // s at either end, where the fit has returns on one side only
constexpr double kShortestTime = 3.0;  // s
constexpr double kMostTravel = 60.0;   // mm between the 5th and the 95th percentile of heights: aim errors, not a sweep
constexpr double kShortestBreath = 1.8;  // s
constexpr double kLongestBreath = 10.0;  // s

/// The girth over time, with what it depends on.
struct Course {
  std::vector<double> times;
  std::vector<Estimate> girths;

  [[nodiscard]] Eigen::VectorXd Values() const {
    Eigen::VectorXd values(static_cast<Eigen::Index>(girths.size()));
    for (std::size_t k = 0; k < girths.size(); ++k) values[static_cast<Eigen::Index>(k)] = girths[k].value;
    return values;
  }
  /// Σ weight · girth. What is unresolved of girths is the same at all times.
  [[nodiscard]] Estimate Sum(const Eigen::VectorXd& weights) const {
    Estimate sum;
    double unresolved = 0.0;
    for (std::size_t k = 0; k < girths.size(); ++k) {
      const double weight = weights[static_cast<Eigen::Index>(k)];
      if (weight == 0.0) continue;
      sum = Combine(1.0, sum, weight, girths[k]);
      unresolved += weight * girths[k].unresolved;
    }
    sum.unresolved = std::abs(unresolved);
    return sum;
  }
};

/// The samples with their time as height.
std::vector<SurfaceSample> OverTime(std::span<const SurfaceSample> samples) {
  std::vector<SurfaceSample> over_time(samples.begin(), samples.end());
  for (SurfaceSample& sample : over_time) {
    sample.z = kHeightPerSecond * sample.time_s;
    sample.ray_direction.z() = 0.0F;
  }
  return over_time;
}

double Percentile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// How much of the course's variance about a straight line a sine of this period explains, 0 … 1.
double ShareExplained(const std::vector<double>& times, const Eigen::VectorXd& values, double period_s) {
  const auto rows = static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd columns(rows, 4);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t = times[static_cast<std::size_t>(k)];
    const double phase = kTwoPi * t / period_s;
    columns.row(k) << 1.0, t, std::cos(phase), std::sin(phase);
  }
  const auto rest = [&](Eigen::Index count) {
    const Eigen::MatrixXd used = columns.leftCols(count);
    return (values - used * used.colPivHouseholderQr().solve(values)).squaredNorm();
  };
  const double line = rest(2);
  return line > 0.0 ? 1.0 - rest(4) / line : 0.0;
}

/// The period that explains most, s, and how much it explains.
std::pair<double, double> BestPeriod(const Course& course) {
  const double longest = std::min(kLongestBreath, 0.6 * (course.times.back() - course.times.front()));
  const Eigen::VectorXd values = course.Values();
  std::pair<double, double> best{0.0, 0.0};
  for (double period = kShortestBreath; period <= longest; period *= 1.01) {
    const double share = ShareExplained(course.times, values, period);
    if (share > best.second) best = {period, share};
  }
  return best;
}

/// Where the course is smallest within 0.4 of a period to either side: ends of expirations.
std::vector<std::size_t> Valleys(const Eigen::VectorXd& values, double period_s) {
  const auto reach = static_cast<Eigen::Index>(std::lround(0.4 * period_s / kStep));
  std::vector<std::size_t> valleys;
  for (Eigen::Index k = reach / 2; k < values.size() - reach / 2; ++k) {
    const Eigen::Index from = std::max<Eigen::Index>(0, k - reach);
    const Eigen::Index count = std::min(values.size(), k + reach + 1) - from;
    Eigen::Index smallest = 0;
    values.segment(from, count).minCoeff(&smallest);
    if (from + smallest == k) valleys.push_back(static_cast<std::size_t>(k));
  }
  return valleys;
}

/// Smallest, mean and largest girth as weights over the course, and what is left of it.
struct Breaths {
  std::size_t count = 0;  ///< Whole ones; 0: the weights are of the whole time.
  double seconds = 0.0;   ///< Of all together.
  Eigen::VectorXd min, mean, max;
  std::vector<double> curve;  ///< Mean girth at kPhases even phases from 0 to 1.
  double scatter_mm = 0.0;    ///< RMS of the girths about the mean breath; without breaths about their mean.
};

constexpr std::size_t kPhases = 41;

/// Values between which a place falls, by linear interpolation.
template <class Values>
double At(const Values& values, std::size_t count, double place) {
  const auto low = std::min(static_cast<std::size_t>(place), count - 2);
  const double share = place - static_cast<double>(low);
  using Index = decltype(values.size());
  return (1.0 - share) * values[static_cast<Index>(low)] + share * values[static_cast<Index>(low + 1)];
}

/// A breath's place in the course.
struct Span {
  std::size_t from = 0, to = 0;
};

void AddBreath(Breaths& breaths, const Eigen::VectorXd& values, const Span& span) {
  const auto from = static_cast<Eigen::Index>(span.from);
  const auto length = static_cast<Eigen::Index>(span.to - span.from);
  Eigen::Index top = 0;
  values.segment(from, length).maxCoeff(&top);
  breaths.min[from] += 0.5;
  breaths.min[from + length] += 0.5;
  breaths.max[from + top] += 1.0;
  breaths.mean.segment(from, length).array() += 1.0 / static_cast<double>(length);
  for (std::size_t phase = 0; phase < kPhases; ++phase) {
    const double share = static_cast<double>(phase) / static_cast<double>(kPhases - 1);
    const double place = static_cast<double>(from) + share * static_cast<double>(length);
    breaths.curve[phase] += At(values, static_cast<std::size_t>(values.size()), place);
  }
  breaths.seconds += kStep * static_cast<double>(length);
  ++breaths.count;
}

/// RMS of the girths about the mean breath, stretched to each breath's length.
double ScatterOf(const Breaths& breaths, const Eigen::VectorXd& values, const std::vector<std::size_t>& valleys) {
  double squares = 0.0;
  for (std::size_t k = 1; k < valleys.size(); ++k) {
    const auto length = static_cast<double>(valleys[k] - valleys[k - 1]);
    for (std::size_t at = valleys[k - 1]; at < valleys[k]; ++at) {
      const double phase = static_cast<double>(at - valleys[k - 1]) / length * static_cast<double>(kPhases - 1);
      const double error = values[static_cast<Eigen::Index>(at)] - At(breaths.curve, kPhases, phase);
      squares += error * error;
    }
  }
  return std::sqrt(squares / static_cast<double>(valleys.back() - valleys.front()));
}

/// Of the whole time, for somebody who does not breathe.
Breaths NoBreaths(const Eigen::VectorXd& values) {
  Breaths whole;
  whole.min = whole.max = Eigen::VectorXd::Zero(values.size());
  whole.mean = Eigen::VectorXd::Constant(values.size(), 1.0 / static_cast<double>(values.size()));
  Eigen::Index at = 0;
  values.minCoeff(&at);
  whole.min[at] = 1.0;
  values.maxCoeff(&at);
  whole.max[at] = 1.0;
  whole.scatter_mm = std::sqrt((values.array() - values.mean()).square().mean());
  return whole;
}

Breaths BreathsOf(const Eigen::VectorXd& values, double period_s) {
  const std::vector<std::size_t> valleys = Valleys(values, period_s);
  if (valleys.size() < 2) return NoBreaths(values);
  Breaths breaths;
  breaths.min = breaths.mean = breaths.max = Eigen::VectorXd::Zero(values.size());
  breaths.curve.assign(kPhases, 0.0);
  for (std::size_t k = 1; k < valleys.size(); ++k) AddBreath(breaths, values, {valleys[k - 1], valleys[k]});
  const double each = 1.0 / static_cast<double>(breaths.count);
  breaths.min *= each;
  breaths.mean *= each;
  breaths.max *= each;
  for (double& girth : breaths.curve) girth *= each;
  breaths.scatter_mm = ScatterOf(breaths, values, valleys);
  return breaths;
}

/// The girth every kStep seconds; fails where too much of a section was not seen.
Result<Course> CourseOf(const MeasuredSurface& body, BreathMeasures& measures) {
  Course course;
  const double first = body.surface().z_min() / kHeightPerSecond + kMargin;
  const double last = body.surface().z_max() / kHeightPerSecond - kMargin;
  for (int k = 0; first + k * kStep <= last; ++k) {
    const double time_s = first + k * kStep;
    auto section = SectionAt(body, kHeightPerSecond * time_s);
    if (!section) {
      return Fail(
          "measure the girth at z = " + NumberText(std::round(measures.z_mm)) + " mm over time",
          "at " + NumberText(std::round(10.0 * time_s) / 10.0) + " s a part of it was not seen, or it is not one loop",
          "choose a height clear of the armpits and of whatever hides it ([profile.breath] z_top_mm)");
    }
    course.times.push_back(time_s);
    measures.course.push_back({time_s, section->tape.value});
    measures.measured_share += section->measured_share;
    course.girths.push_back(std::move(section->tape));
  }
  measures.measured_share /= static_cast<double>(course.times.size());
  return course;
}

/// Fills in all that the course says.
void Judge(const MeasuredSurface& body, const Course& course, BreathMeasures& measures) {
  // What sway makes of the fit changes within a second or two, so that 20 s of somebody who holds the breath are some
  // fifteen independent numbers: the best of the periods then explains 0.1 to 0.3 of their variance.
  constexpr double kLeastShare = 0.5;
  constexpr double kLeastSigmas = 4.0;
  constexpr double kIndependent_s = 4.0;
  const Eigen::VectorXd values = course.Values();
  measures.lowest_mm = values.minCoeff();
  measures.highest_mm = values.maxCoeff();
  const auto take = [&](const Breaths& breaths) {
    const double stands = breaths.count > 0
                              ? static_cast<double>(breaths.count)
                              : std::max(1.0, kStep * static_cast<double>(values.size()) / kIndependent_s);
    std::vector<Uncertain> numbers = body.WithSigmas({course.Sum(breaths.min), course.Sum(breaths.mean),
                                                      course.Sum(breaths.max), course.Sum(breaths.max - breaths.min)});
    for (Uncertain& number : numbers) number.sigma = std::hypot(number.sigma, breaths.scatter_mm / std::sqrt(stands));
    measures.min_mm = numbers[0];
    measures.mean_mm = numbers[1];
    measures.max_mm = numbers[2];
    measures.amplitude_mm = numbers[3];
  };
  const auto [period_s, share] = BestPeriod(course);
  if (share >= kLeastShare) {
    const Breaths breaths = BreathsOf(values, period_s);
    take(breaths);
    if (breaths.count > 0 && measures.amplitude_mm.value > kLeastSigmas * measures.amplitude_mm.sigma) {
      measures.breathing = true;
      measures.breaths = breaths.count;
      measures.period_s = breaths.seconds / static_cast<double>(breaths.count);
      for (std::size_t phase = 0; phase < kPhases; ++phase) {
        const double time_s = measures.period_s * static_cast<double>(phase) / static_cast<double>(kPhases - 1);
        measures.curve.push_back({time_s, breaths.curve[phase]});
      }
      return;
    }
  }
  take(NoBreaths(values));
}

}  // namespace

Result<BreathMeasures> MeasureBreath(std::span<const SurfaceSample> samples, const TaskContext& context) {
  const std::string attempted = "measure a breath";
  std::vector<double> heights;
  double last = 0.0;
  for (const SurfaceSample& sample : samples) {
    heights.push_back(sample.z);
    last = std::max(last, sample.time_s);
  }
  if (!(last >= kShortestTime)) {
    return Fail(attempted, "the scan lasts " + NumberText(last) + " s", "scan with the profile breath");
  }
  if (Percentile(heights, 0.95) - Percentile(heights, 0.05) > kMostTravel) {
    return Fail(attempted, "the ring moved during the scan", "scan with the profile breath: the ring stands still");
  }
  const auto fit = FitBody(OverTime(samples), {}, context);
  if (!fit) return Fail(fit);
  const auto body = MeasuredSurface::FromModel(fit->model);
  if (!body) return Fail(body);
  BreathMeasures measures;
  measures.z_mm = Percentile(heights, 0.5);
  const auto course = CourseOf(*body, measures);
  if (!course) return Fail(course);
  Judge(*body, *course, measures);
  return measures;
}

}  // namespace annulus
