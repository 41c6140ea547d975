#include "modeling/exchange/dcs.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/ensure.h"
#include "base/units.h"
#include "modeling/exchange/dcs_records.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr std::array<std::size_t, 7> kCounts{400, 800, 1000, 2000, 4000, 8000, 16000};
/// Outlines this near to each other's mirror image are meant to be it, mm.
constexpr double kMirrored = 1e-6;
constexpr std::size_t kRadiiPerLine = 10;

double Rounded(double value) { return std::round(100.0 * value) / 100.0; }

double DistanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

/// The trace's polygon, for distances from points near it.
class TracePolygon {
 public:
  explicit TracePolygon(const std::vector<double>& radii) : points_(OutlineFromRadii(radii).points) {}

  /// From a point about the box centre. Only the segments at about its angle are looked at: the answer is never too
  /// small.
  [[nodiscard]] double Distance(const Vector2d& p) const {
    const auto count = static_cast<std::ptrdiff_t>(points_.size());
    double turn = std::atan2(p.y(), p.x()) / kTwoPi;
    if (turn < 0.0) turn += 1.0;
    const auto at = static_cast<std::ptrdiff_t>(turn * static_cast<double>(count));
    double nearest = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t k = at - kReach; k <= at + kReach; ++k) {
      const auto a = static_cast<std::size_t>((k + count) % count);
      const auto b = static_cast<std::size_t>((k + 1 + count) % count);
      nearest = std::min(nearest, DistanceToSegment(p, points_[a], points_[b]));
    }
    return nearest;
  }

 private:
  static constexpr std::ptrdiff_t kReach = 12;
  std::vector<Vector2d> points_;
};

DcsEye BoxedEye(const LensOutline& outline) {
  const LensBox box = BoxOf(outline);
  DcsEye eye;
  eye.hbox = Rounded(box.a);
  eye.vbox = Rounded(box.b);
  eye.fed = Rounded(box.ed);
  eye.circ = Rounded(box.circumference);
  return eye;
}

std::vector<double> RoundedRadii(const LensOutline& outline, std::size_t count) {
  std::vector<double> radii = RadiiOf(outline, count);
  for (double& radius : radii) radius = Rounded(radius);
  return radii;
}

/// R seen for the other eye: L[n/2 - i] = R[i].
std::vector<double> MirroredRadii(const std::vector<double>& right) {
  const std::size_t n = right.size();
  std::vector<double> left(n);
  for (std::size_t i = 0; i < n; ++i) left[(n + n / 2 - i) % n] = right[i];
  return left;
}

bool AreMirrorImages(const LensOutline& right, const LensOutline& left) {
  const std::vector<double> a = RadiiOf(right, kCounts.front());
  const std::vector<double> b = RadiiOf(Mirrored(left), kCounts.front());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > kMirrored) return false;
  }
  return true;
}

bool BoxFits(const DcsEye& eye) {
  const LensBox box = BoxOf(OutlineFromRadii(eye.radii));
  return std::abs(box.a - eye.hbox) <= kDcsBoxTolerance && std::abs(box.b - eye.vbox) <= kDcsBoxTolerance;
}

bool Fits(const DcsEye& eye, const LensOutline& outline) {
  return OutlineDeviation(eye, outline) <= kDcsOutlineTolerance && BoxFits(eye);
}

}  // namespace

double OutlineDeviation(const DcsEye& eye, const LensOutline& outline) {
  const TracePolygon trace(eye.radii);
  const Vector2d centre = BoxOf(outline).centre;
  double largest = 0.0;
  for (std::size_t k = 0; k < outline.points.size(); ++k) {
    const Vector2d a = outline.points[k] - centre;
    const Vector2d b = outline.points[(k + 1) % outline.points.size()] - centre;
    largest = std::max({largest, trace.Distance(a), trace.Distance(0.5 * (a + b))});
  }
  return largest;
}

Result<DcsTrace> TraceOutlines(const LensOutline& right, const LensOutline& left) {
  RETURN_IF_ERROR(Validate(right));
  RETURN_IF_ERROR(Validate(left));
  const bool mirrored = AreMirrorImages(right, left);
  DcsTrace trace{BoxedEye(right), BoxedEye(left)};
  if (mirrored) trace.left = trace.right;
  for (const std::size_t count : kCounts) {
    trace.right.radii = RoundedRadii(right, count);
    trace.left.radii = mirrored ? MirroredRadii(trace.right.radii) : RoundedRadii(left, count);
    if (Fits(trace.right, right) && Fits(trace.left, left)) return trace;
  }
  const double deviation = std::max(OutlineDeviation(trace.right, right), OutlineDeviation(trace.left, left));
  return Fail("trace the lenses",
              fmt::format("with {} radii the outline is still {:.3f} mm off", kCounts.back(), deviation),
              "round the frame's sharpest corner: no wheel grinds it");
}

std::string DcsText(const DcsJob& job) {
  ENSURE(!job.right.radii.empty() && !job.left.radii.empty(), "a trace has radii");
  std::string text = "REQ=FIL\r\n";
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "JOB={}\r\nDO=B\r\nFTYP={}\r\nETYP={}\r\n", DcsPrintable(job.job), static_cast<int>(job.frame),
                 static_cast<int>(job.edge));
  for (const DcsLength& record : kDcsLengths) {
    if (record.label == "FED") fmt::format_to(out, "DBL={:.2f}\r\n", job.dbl);
    fmt::format_to(out, "{}={:.2f};{:.2f}\r\n", record.label, job.right.*record.member, job.left.*record.member);
  }
  for (const DcsOptional& record : kDcsOptionals) {
    const auto& right = job.right.*record.member;
    const auto& left = job.left.*record.member;
    if (!right && !left) continue;
    const auto value = [](const std::optional<double>& v) { return v ? fmt::format("{:.2f}", *v) : std::string(); };
    fmt::format_to(out, "{}={};{}\r\n", record.label, value(right), value(left));
  }
  if (!job.lens_name.empty()) fmt::format_to(out, "LNAM={0};{0}\r\n", DcsPrintable(job.lens_name));
  if (!job.confirmed_by.empty()) fmt::format_to(out, "_CONFIRMED={}\r\n", DcsPrintable(job.confirmed_by));
  for (const bool is_right : {true, false}) {
    const std::vector<double>& radii = is_right ? job.right.radii : job.left.radii;
    fmt::format_to(out, "TRCFMT=1;{};E;{};F\r\n", radii.size(), is_right ? 'R' : 'L');
    for (std::size_t i = 0; i < radii.size(); ++i) {
      fmt::format_to(out, "{}{}{}", i % kRadiiPerLine == 0 ? "R=" : ";", std::lround(100.0 * radii[i]),
                     i % kRadiiPerLine == kRadiiPerLine - 1 || i + 1 == radii.size() ? "\r\n" : "");
    }
  }
  return text;
}

}  // namespace annulus
