#include "modeling/flatten/pattern_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "modeling/flatten/geodesic_side.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kStepsOfCurve = 16;
constexpr double kMostSteps = 1e5;

tl::unexpected<Error> Refuse(const std::string& what, std::string seen, const char* advice) {
  return Fail("lay " + what + " on the body", std::move(seen), advice);
}

/// A dense course of a line with the numbers of its corners.
struct Course {
  std::vector<Vector2d> places;
  std::vector<std::size_t> corners;
};

Course Straight(const std::vector<Vector2d>& places) {
  Course course{places, {}};
  for (std::size_t k = 0; k < places.size(); ++k) course.corners.push_back(k);
  return course;
}

/// Through all places, tangents as between the neighbours.
Course Smooth(const std::vector<Vector2d>& places) {
  Course course{{places.front()}, {0}};
  const std::size_t last = places.size() - 1;
  for (std::size_t k = 0; k < last; ++k) {
    const Vector2d& a = places[k];
    const Vector2d& b = places[k + 1];
    const Vector2d leave = k == 0 ? Vector2d(b - a) : Vector2d(0.5 * (b - places[k - 1]));
    const Vector2d arrive = k + 1 == last ? Vector2d(b - a) : Vector2d(0.5 * (places[k + 2] - a));
    for (int step = 1; step <= kStepsOfCurve; ++step) {
      const double t = static_cast<double>(step) / kStepsOfCurve;
      const double s = 1.0 - t;
      course.places.push_back(s * s * (1.0 + 2.0 * t) * a + t * t * (1.0 + 2.0 * s) * b + s * s * t * leave -
                              t * t * s * arrive);
    }
  }
  course.corners.push_back(course.places.size() - 1);
  return course;
}

Result<Course> CourseOf(const PatternLine& line, const PatternBody& body) {
  if (line.places.size() < 2) return Refuse("line '" + line.id + "'", "it has one place", "give it two or more");
  std::vector<Vector2d> places;
  for (const PatternPlace& place : line.places) {
    auto at = PlaceOn(body, place);
    if (!at) return Fail(at);
    const SplineSurface& surface = body.segment.surface;
    if (!(at->y() >= surface.z_min() && at->y() <= surface.z_max())) {
      return Refuse("line '" + line.id + "'",
                    fmt::format("a place of it is at z = {:.1f} mm, the surface from {:.1f} to {:.1f} mm", at->y(),
                                surface.z_min(), surface.z_max()),
                    "keep the pattern's lines on what was scanned");
    }
    if (!places.empty()) at->x() += kTurn * std::round((places.back().x() - at->x()) / kTurn);  // the shorter way
    places.push_back(*at);
  }
  return line.course == PatternLine::Course::kSmooth && places.size() > 2 ? Smooth(places) : Straight(places);
}

/// Length from the start up to each place of a course.
std::vector<double> LengthsAlong(const Course& course, const SurfaceSegment& segment) {
  std::vector<double> along{0.0};
  for (std::size_t k = 0; k + 1 < course.places.size(); ++k) {
    along.push_back(along.back() + StraightLength(segment, course.places[k], course.places[k + 1]));
  }
  return along;
}

Vector2d At(const Course& course, const std::vector<double>& along, double length) {
  const auto after = std::upper_bound(along.begin(), along.end(), length);
  const std::size_t k = std::clamp<std::size_t>(static_cast<std::size_t>(after - along.begin()), 1, along.size() - 1);
  const double step = along[k] - along[k - 1];
  const double t = step > 0.0 ? std::clamp((length - along[k - 1]) / step, 0.0, 1.0) : 0.0;
  return (1.0 - t) * course.places[k - 1] + t * course.places[k];
}

Result<SampledLine> Sample(const PatternLine& line, const PatternBody& body, double element_mm,
                           const std::vector<double>& shares) {
  const auto course = CourseOf(line, body);
  if (!course) return Fail(course);
  const std::vector<double> along = LengthsAlong(*course, body.segment);
  const double length = along.back();
  if (!(length > 0.01 * element_mm && length / element_mm < kMostSteps)) {
    return Refuse("line '" + line.id + "'", fmt::format("it is {:g} mm long, elements {:g} mm", length, element_mm),
                  "let its places differ, and take elements that fit it");
  }
  std::vector<double> breaks;
  for (const std::size_t corner : course->corners) breaks.push_back(along[corner]);
  for (const double share : shares) breaks.push_back(share * length);
  std::sort(breaks.begin(), breaks.end());
  const auto same = [&](double a, double b) { return b - a < 1e-6 * length; };
  breaks.erase(std::unique(breaks.begin(), breaks.end(), same), breaks.end());
  SampledLine sampled{{course->places.front()}, {0.0}, length};
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double span = breaks[k + 1] - breaks[k];
    const double count = std::ceil(span / element_mm - 1e-9);
    for (double step = 1.0; step <= count; step += 1.0) {
      const double here = breaks[k] + span * step / count;
      sampled.places.push_back(At(*course, along, here));
      sampled.shares.push_back(here / length);
    }
  }
  sampled.places.back() = course->places.back();
  sampled.shares.back() = 1.0;
  return sampled;
}

/// The landmark's place; nothing for "".
Result<Vector2d> LandmarkOn(const PatternBody& body, const std::string& id) {
  const auto found = body.landmarks.find(id);
  if (found != body.landmarks.end()) return found->second;
  return Refuse("the pattern", "the body has no landmark '" + id + "'",
                "set it (annulus landmarks --set), or give the place by angle and height");
}

}  // namespace

Result<Vector2d> PlaceOn(const PatternBody& body, const PatternPlace& place) {
  Vector2d at(place.turn, place.up);
  if (!place.theta_of.empty()) {
    const auto landmark = LandmarkOn(body, place.theta_of);
    if (!landmark) return Fail(landmark);
    at.x() += landmark->x();
    if (!std::isfinite(at.x())) {
      return Refuse("the pattern", "'" + place.theta_of + "' is a level and has no angle", "name a point for theta");
    }
  }
  const SplineSurface& surface = body.segment.surface;
  if (place.z_of.empty()) {
    if (place.z_share) at.y() += surface.z_min() + *place.z_share * (surface.z_max() - surface.z_min());
    return at;
  }
  const auto landmark = LandmarkOn(body, place.z_of);
  if (!landmark) return Fail(landmark);
  at.y() += landmark->y();
  if (place.z_towards.empty()) return at;
  const auto other = LandmarkOn(body, place.z_towards);
  if (!other) return Fail(other);
  at.y() += place.z_share.value_or(0.5) * (other->y() - landmark->y());
  return at;
}

Result<std::vector<SampledLine>> SampleLines(const Pattern& pattern, const PatternBody& body) {
  std::vector<std::vector<double>> shares(pattern.lines.size());
  for (const PatternPiece& piece : pattern.pieces) {
    for (const PatternDart& dart : piece.darts) shares[dart.line].push_back(dart.share);
    for (const PatternDivision& division : piece.divisions) {
      for (const PatternDivision::End& end : division.ends) shares[end.line].push_back(end.share);
    }
  }
  std::vector<SampledLine> sampled;
  for (std::size_t k = 0; k < pattern.lines.size(); ++k) {
    auto line = Sample(pattern.lines[k], body, pattern.element_mm, shares[k]);
    if (!line) return Fail(line);
    sampled.push_back(std::move(*line));
  }
  return sampled;
}

}  // namespace annulus
