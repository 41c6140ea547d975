#include "station/paper_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "fitting/paper_model.h"
#include "render/camera.h"
#include "render/canvas.h"
#include "render/material.h"
#include "render/scene.h"
#include "render/xy_plot.h"

namespace annulus {
namespace {

constexpr int kPlotWidth = 640;
constexpr int kPlotHeight = 560;
constexpr int kSurfaceWidth = 640;
constexpr int kHeadHeight = 70;
constexpr int kTitleHeight = 64;    // over the surface
constexpr int kPointsPerSpan = 12;  // of a drawn curve

const LinearRgb kSampleColour = LinearFromHex(0xaab0b9);
const LinearRgb kCurveColour = LinearFromHex(0x1f4e8c);
const LinearRgb kPolygonColour = LinearFromHex(0xd98a1f);
const LinearRgb kFeatureColour = LinearFromHex(0xc0262d);
const LinearRgb kInflectionColour = LinearFromHex(0x2a8a4a);
const LinearRgb kKnotColour = LinearFromHex(0x3b82d6);
const LinearRgb kAddedColour = LinearFromHex(0x6b7280);
const LinearRgb kGateColour = LinearFromHex(0xc9b6e4);

template <class... Values>
std::string Format(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

/// The closed curve through `control` (eq. 2.9) as a polyline, or one point on it at u.
Eigen::Vector2d ClosedCurveAt(const std::vector<Eigen::Vector2d>& control, double u) {
  const std::size_t n = control.size();
  const auto span = static_cast<std::size_t>(u) % n;
  const double t = u - std::floor(u);
  const double s = 1.0 - t;
  const std::array<double, 4> weights{s * s * s / 6.0, (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
                                      (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0, t * t * t / 6.0};
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < 4; ++k) p += weights[k] * control[(span + k + n - 1) % n];
  return p;
}

std::vector<Eigen::Vector2d> Closed(std::vector<Eigen::Vector2d> points) {
  points.push_back(points.front());
  return points;
}

/// Where samples are used: (x, value) as `place` has it.
template <class Place>
std::vector<Eigen::Vector2d> UsedSamples(const CurveSamples& samples, Place place) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (samples.weight[k] > 0.0) points.push_back(place(samples.x[k], samples.value[k]));
  }
  return points;
}

/// Every third of `points`, or the others.
enum class KnotKind { kFeature, kBetween };
std::vector<Eigen::Vector2d> Pick(const std::vector<Eigen::Vector2d>& points, KnotKind kind) {
  std::vector<Eigen::Vector2d> picked;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if ((k % 3 == 0) == (kind == KnotKind::kFeature)) picked.push_back(points[k]);
  }
  return picked;
}

std::vector<XySeries> CurveSeries(std::vector<Eigen::Vector2d> samples, std::vector<Eigen::Vector2d> curve,
                                  std::vector<Eigen::Vector2d> polygon, const std::vector<Eigen::Vector2d>& knots) {
  return {{polygon, "control polygon", kPolygonColour, XyMark::kLine, 1},
          {std::move(polygon), "", kPolygonColour, XyMark::kSquare, 2},
          {std::move(samples), "samples", kSampleColour, XyMark::kDot, 3},
          {std::move(curve), "B-spline curve", kCurveColour, XyMark::kLine, 1},
          {Pick(knots, KnotKind::kBetween), "knots between", kKnotColour, XyMark::kDisc, 3},
          {Pick(knots, KnotKind::kFeature), "knots at features", kFeatureColour, XyMark::kDisc, 4}};
}

Result<RgbImage> CrossSection(const PaperModel& paper, const PaperSection& section) {
  const double z = paper.report.around.place;
  const std::vector<Eigen::Vector2d> control = paper.surface.SectionControlPoints(z);
  std::vector<Eigen::Vector2d> curve;
  std::vector<Eigen::Vector2d> knots;
  for (std::size_t k = 0; k <= control.size() * kPointsPerSpan; ++k) {
    curve.push_back(ClosedCurveAt(control, static_cast<double>(k) / kPointsPerSpan));
    if (k % kPointsPerSpan == 0 && k < control.size() * kPointsPerSpan) knots.push_back(curve.back());
  }
  const auto place = [](double theta, double r) { return Eigen::Vector2d(r * std::cos(theta), r * std::sin(theta)); };
  XyPlotStyle style;
  style.title = Format("(a) Cross-section at z = %.0f mm: %zu knots", z, knots.size());
  style.x_label = "x [mm]";
  style.y_label = "y [mm]";
  style.scale = AxisScale::kEqual;
  style.width = kPlotWidth;
  style.height = kPlotHeight;
  return RenderXyPlot(CurveSeries(UsedSamples(section.samples, place), std::move(curve), Closed(control), knots),
                      style);
}

Result<RgbImage> LongitudinalSection(const PaperModel& paper, const PaperSection& section) {
  const double theta = paper.report.along.place;
  std::vector<Eigen::Vector2d> polygon = paper.surface.MeridianControlPoints(theta);
  for (Eigen::Vector2d& w : polygon) w = w.reverse().eval();  // z to the right
  std::vector<Eigen::Vector2d> curve;
  std::vector<Eigen::Vector2d> knots;
  const double u = paper.surface.Solve(theta, paper.surface.z_min()).u;
  const std::size_t spans = paper.surface.z_knots().size() - 1;
  for (std::size_t k = 0; k <= spans * kPointsPerSpan; ++k) {
    const Eigen::Vector3d p = paper.surface.PointAt({u, static_cast<double>(k) / kPointsPerSpan});
    curve.emplace_back(p.z(), p.head<2>().norm());
    if (k % kPointsPerSpan == 0) knots.push_back(curve.back());
  }
  const auto place = [](double z, double r) { return Eigen::Vector2d(z, r); };
  XyPlotStyle style;
  style.title = Format("(c) Longitudinal section at theta = %.1f deg: %zu knots", DegreesFromRadians(WrapAngle(theta)),
                       knots.size());
  style.x_label = "z [mm]";
  style.y_label = "r [mm]";
  style.width = kPlotWidth;
  style.height = kPlotHeight;
  return RenderXyPlot(CurveSeries(UsedSamples(section.samples, place), std::move(curve), polygon, knots), style);
}

/// Series of the estimates of f' with what was made of them; x scaled by `factor`.
std::vector<XySeries> SlopeSeries(const PaperDirection& direction, const PaperSection& section, double factor) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> slope;
  std::vector<Eigen::Vector2d> gate;
  std::vector<Eigen::Vector2d> gate_below;
  for (std::size_t k = 0; k < section.samples.size(); ++k) {
    const SlopeEstimate& estimate = section.slopes[k];
    const double x = factor * section.samples.x[k];
    const double limit = direction.gate * direction.noise_sd * estimate.first_gain;
    slope.emplace_back(x, estimate.known ? estimate.first : nan);
    gate.emplace_back(x, estimate.known ? limit : nan);
    gate_below.emplace_back(x, estimate.known ? -limit : nan);
  }
  std::array<std::vector<Eigen::Vector2d>, 3> features;  // extrema, inflections, others
  for (const FeaturePoint& feature : direction.plan.features) {
    const auto at = std::lower_bound(section.samples.x.begin(), section.samples.x.end(), feature.x);
    const auto k = static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(at - section.samples.x.begin(), std::ssize(section.samples.x) - 1));
    const std::size_t kind = feature.kind == FeatureKind::kExtremum     ? 0
                             : feature.kind == FeatureKind::kInflection ? 1
                                                                        : 2;
    features[kind].emplace_back(factor * feature.x, section.slopes[k].known ? section.slopes[k].first : 0.0);
  }
  return {{gate, Format("noise gate, %.1f sd", direction.gate), kGateColour, XyMark::kLine, 1},
          {gate_below, "", kGateColour, XyMark::kLine, 1},
          {slope, "estimate of f', K = 5", kCurveColour, XyMark::kLine, 1},
          {features[2], "added or end", kAddedColour, XyMark::kDisc, 4},
          {features[1], "inflections, f'' = 0", kInflectionColour, XyMark::kSquare, 4},
          {features[0], "extrema, f' = 0", kFeatureColour, XyMark::kDisc, 4}};
}

XyPlotStyle SlopeStyle(std::string title, std::string x_label, std::string y_label,
                       std::optional<std::array<double, 2>> x_range) {
  XyPlotStyle style;
  style.title = std::move(title);
  style.x_label = std::move(x_label);
  style.y_label = std::move(y_label);
  style.x_range = x_range;
  style.width = kPlotWidth;
  style.height = kPlotHeight;
  return style;
}

/// A ribbon of a given width along places on the surface, lifted off it by its own half width.
TriangleMesh Ribbon(const PaperSurface& surface, const std::vector<SurfaceParameters>& places, double width) {
  TriangleMesh mesh;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Eigen::Vector3d along =
        surface.PointAt(places[std::min(k + 1, places.size() - 1)]) - surface.PointAt(places[k > 0 ? k - 1 : 0]);
    const SurfacePartials p = surface.Partials(places[k]);
    const Eigen::Vector3d normal = p.u.cross(p.v).normalized();
    const Eigen::Vector3d across = 0.5 * width * normal.cross(along).normalized();
    const Eigen::Vector3d middle = p.point + 0.5 * width * normal;
    mesh.vertices.push_back(middle - across);
    mesh.vertices.push_back(middle + across);
    if (k == 0) continue;
    const auto n = static_cast<std::uint32_t>(2 * k);
    mesh.faces.push_back({n - 2, n, n - 1});
    mesh.faces.push_back({n - 1, n, n + 1});
  }
  return mesh;
}

/// The knot lines of features, or those between, in both directions.
TriangleMesh KnotNet(const PaperSurface& surface, KnotKind kind, double width) {
  constexpr int kSteps = 6;  // per span
  const std::size_t m = surface.theta_knots().size();
  const std::size_t n = surface.z_knots().size();
  const auto wanted = [&](std::size_t k) { return (k % 3 == 0) == (kind == KnotKind::kFeature); };
  TriangleMesh net;
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<SurfaceParameters> line;
    for (std::size_t k = 0; k <= m * kSteps; ++k) {
      line.push_back({static_cast<double>(k) / kSteps, static_cast<double>(j)});
    }
    if (wanted(j)) Append(net, Ribbon(surface, line, width));
  }
  for (std::size_t i = 0; i < m; ++i) {
    std::vector<SurfaceParameters> line;
    for (std::size_t k = 0; k <= (n - 1) * kSteps; ++k) {
      line.push_back({static_cast<double>(i), static_cast<double>(k) / kSteps});
    }
    if (wanted(i)) Append(net, Ribbon(surface, line, width));
  }
  return net;
}

/// Patches of the surface as triangles, with its own normals.
SceneItem SurfaceItem(const PaperSurface& surface) {
  constexpr std::uint32_t kSteps = 8;  // per span
  const auto columns = static_cast<std::uint32_t>(surface.theta_knots().size()) * kSteps;
  const auto rows = static_cast<std::uint32_t>(surface.z_knots().size() - 1) * kSteps;
  SceneItem item;
  item.material = NeutralBodyMaterial();
  item.group = "surface";
  for (std::uint32_t row = 0; row <= rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const SurfacePartials p =
          surface.Partials({static_cast<double>(column) / kSteps, static_cast<double>(row) / kSteps});
      item.mesh.vertices.push_back(p.point);
      item.normals.emplace_back(p.u.cross(p.v).normalized());
      if (row == 0) continue;
      const std::uint32_t next = (column + 1) % columns;
      const std::uint32_t below = (row - 1) * columns;
      const std::uint32_t here = row * columns;
      item.mesh.faces.push_back({below + column, below + next, here + column});
      item.mesh.faces.push_back({here + column, below + next, here + next});
    }
  }
  return item;
}

Material InkMaterial(const LinearRgb& colour) {
  Material ink = NeutralBodyMaterial();  // no highlights on the lines
  ink.colour = colour;
  return ink;
}

Result<RgbImage> SurfaceWithNet(const PaperSurface& surface, const TaskContext& task) {
  const double width = (surface.z_max() - surface.z_min()) / 550.0;
  Scene scene;
  scene.items.push_back(SurfaceItem(surface));
  scene.items.push_back({KnotNet(surface, KnotKind::kBetween, 0.8 * width), InkMaterial(kKnotColour), "knots", {}});
  scene.items.push_back(
      {KnotNet(surface, KnotKind::kFeature, 1.1 * width), InkMaterial(kFeatureColour), "features", {}});
  RenderOptions options;
  options.width = kSurfaceWidth;
  options.height = 2 * kPlotHeight - kTitleHeight;
  options.backdrop = {LinearRgb::Ones(), LinearRgb::Ones()};
  options.supersampling = 3;
  Framing framing;
  framing.aspect = static_cast<double>(options.width) / options.height;
  framing.margin = 0.0;
  View view;
  view.azimuth = RadiansFromDegrees(115.0);
  view.elevation = RadiansFromDegrees(8.0);
  auto camera = FrameCamera(BoundsOf(scene), view, framing);
  if (!camera) return Fail(camera);
  double needed = 0.0;  // the box around a body is larger than the body
  for (const Eigen::Vector3d& vertex : scene.items.front().mesh.vertices) {
    const Eigen::Vector3d p = camera->ToCamera(vertex);
    needed = std::max(needed, std::max(std::abs(p.y()), std::abs(p.x()) / framing.aspect) / p.z());
  }
  camera->half_height = std::min(camera->half_height, 1.04 * needed);
  return Render(scene, *camera, options, task);
}

void Paste(const RgbImage& part, int left, int top, RgbImage& whole) {
  ENSURE(left + part.width <= whole.width && top + part.height <= whole.height, "a part lies within the sheet");
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) whole.rgb[whole.Index(left + x, top + y)] = part.rgb[part.Index(x, y)];
  }
}

RgbImage Heading(const ScanFit& fit, const PaperFitReport& report, int width) {
  Canvas canvas(width, kHeadHeight);
  canvas.Text("Surface by the method of paper 001, section 2", {66.0, 28.0}, 0.75, Anchor::kLeft);
  canvas.Text(Format("%zu x %zu knots; features found %zu around, %zu along; lambda %.3g rad^3 and %.3g mm^3; %zu "
                     "levels fitted, %zu outside, %zu bridged; RMS residual %.3f mm",
                     report.around.plan.knots.size(), report.along.plan.knots.size(), report.around.complexity.features,
                     report.along.complexity.features, report.around.lambda, report.along.lambda, report.levels,
                     report.levels_outside, report.levels_folded, fit.fit.summary.rms_mm),
              {66.0, 54.0}, 0.5, Anchor::kLeft);
  return canvas.ToImage();
}

RgbImage SurfaceTitle() {
  Canvas canvas(kSurfaceWidth, kTitleHeight);
  canvas.Text("(e) Surface P(u, v) with its net of knots", {40.0, 20.0}, kTitleText, Anchor::kLeft);
  canvas.FillRectangle({40.0, 34.0}, {58.0, 37.0}, kFeatureColour);
  canvas.Text("knot lines at features", {65.0, 40.0}, kSmallText, Anchor::kLeft);
  canvas.FillRectangle({240.0, 34.0}, {258.0, 37.0}, kKnotColour);
  canvas.Text("knot lines between", {265.0, 40.0}, kSmallText, Anchor::kLeft);
  return canvas.ToImage();
}

}  // namespace

Result<RgbImage> PaperFitImage(const ScanFit& fit, const TaskContext& task) {
  const SurfaceSegment& segment = fit.fit.model.main();
  ENSURE(segment.paper != nullptr && fit.fit.summary.paper.has_value(), "the fit is by the paper's method");
  const PaperModel& paper = *segment.paper;
  const PaperSections& sections = *fit.fit.summary.paper;
  const auto section = CrossSection(paper, sections.around);
  const auto longitudinal = LongitudinalSection(paper, sections.along);
  const auto around = RenderXyPlot(
      SlopeSeries(paper.report.around, sections.around, DegreesFromRadians(1.0)),
      SlopeStyle("(b) Slope of r(theta) and feature points", "theta [deg]", "f' [mm/rad]", {{0.0, 360.0}}));
  const auto along =
      RenderXyPlot(SlopeSeries(paper.report.along, sections.along, 1.0),
                   SlopeStyle("(d) Slope of r(z) and feature points", "z [mm]", "f' [mm/mm]", std::nullopt));
  const auto surface = SurfaceWithNet(paper.surface, task);
  for (const auto* part : {&section, &longitudinal, &around, &along, &surface}) {
    if (!*part) return Fail(*part);
  }
  RgbImage sheet = RgbImage::Filled(2 * kPlotWidth + kSurfaceWidth, kHeadHeight + 2 * kPlotHeight, LinearRgb::Ones());
  Paste(Heading(fit, paper.report, sheet.width), 0, 0, sheet);
  Paste(*section, 0, kHeadHeight, sheet);
  Paste(*around, kPlotWidth, kHeadHeight, sheet);
  Paste(*longitudinal, 0, kHeadHeight + kPlotHeight, sheet);
  Paste(*along, kPlotWidth, kHeadHeight + kPlotHeight, sheet);
  Paste(SurfaceTitle(), 2 * kPlotWidth, kHeadHeight, sheet);
  Paste(*surface, 2 * kPlotWidth, kHeadHeight + kTitleHeight, sheet);
  return sheet;
}

}  // namespace annulus
