// MeasurePicture: from what was prepared to a figure, seen from somewhere.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/units.h"
#include "station/measure_pictures.h"

namespace annulus {
namespace {

constexpr double kMargin = 0.02;  // of the longer side, around the body
constexpr int kHatchPeriod = 8;   // pixels
constexpr float kHatch = 0.60F;

/// Pixels of a figure per mm of it: letters keep a size that can be read on small panels, and grow on large ones.
double FigureScale(int size) { return std::max(4.5, size / 160.0); }

/// What a set of points spans in the picture's plane, mm.
struct Extent {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;

  void Add(const Eigen::Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

/// A view as people say it.
std::string ViewText(const View& view) {
  const double azimuth = DegreesFromRadians(WrapAngle(view.azimuth));
  const double elevation = DegreesFromRadians(view.elevation);
  const std::string from = elevation == 0.0 ? ""
                                            : fmt::format(", {:.0f}° {}", std::abs(elevation),
                                                          elevation > 0.0 ? "from above" : "from below");
  constexpr double kClose = 0.5;
  if (std::abs(azimuth - 90.0) < kClose) return "from the front" + from;
  if (std::abs(azimuth - 270.0) < kClose) return "from behind" + from;
  if (std::abs(azimuth - 180.0) < kClose) return "from the left" + from;
  if (azimuth < kClose || azimuth > 360.0 - kClose) return "from the right" + from;
  return fmt::format("from θ\u00a0=\u00a0{:.0f}°", azimuth) + from;  // not to be parted
}

/// Where a point stands on an unrolled map, pixels.
Eigen::Vector2d UnrolledPlace(const Eigen::Vector3d& p, const UnrolledMap& map, const RgbImage& image) {
  const double theta = WrapAngle(std::atan2(p.y(), p.x()));
  return {theta / kTwoPi * image.width, (map.z_max - p.z()) / (map.z_max - map.z_min) * image.height};
}

/// The place at which a label's line ends: of what is seen, what lies farthest to a side. Where both sides are as far,
/// the side with fewer labels.
std::optional<Eigen::Vector2d> LabelPlace(const std::vector<OverlayRun>& runs, const MapPanel& panel) {
  std::optional<Eigen::Vector2d> left;
  std::optional<Eigen::Vector2d> right;
  for (const OverlayRun& run : runs) {
    if (!run.visible) continue;
    for (const Eigen::Vector2d& p : run.points) {
      if (!left || p.x() < left->x()) left = p;
      if (!right || p.x() > right->x()) right = p;
    }
  }
  if (!left || panel.unrolled) return right;
  const double middle = 0.5 * panel.image.width;
  const double further = (middle - left->x()) - (right->x() - middle);
  if (std::abs(further) > 0.05 * panel.image.width) return further > 0.0 ? left : right;
  const auto on_left = std::count_if(panel.labels.begin(), panel.labels.end(),
                                     [middle](const PanelLabel& label) { return label.at.x() < middle; });
  return 2 * on_left <= static_cast<std::ptrdiff_t>(panel.labels.size()) ? left : right;
}

}  // namespace

Result<MeasurePicture::Framed> MeasurePicture::FrameAll(const View& view) const {
  Eigen::AlignedBox3d box;
  for (const Panel& panel : panels_) {
    for (const MapMesh& mesh : panel.meshes) {
      for (const Eigen::Vector3d& p : mesh.mesh.vertices) box.extend(p);
    }
  }
  Framing framing;
  framing.projection = Projection::kOrthographic;
  auto camera = FrameCamera(box, view, framing);
  if (!camera) return Fail(camera);
  Extent extent;
  for (const Panel& panel : panels_) {
    for (const MapMesh& mesh : panel.meshes) {
      for (const Eigen::Vector3d& p : mesh.mesh.vertices) extent.Add(camera->ToCamera(p));
    }
  }
  // The eye moves to the middle of what is seen, and back until everything lies before it.
  const Eigen::Vector3d middle = 0.5 * (extent.low + extent.high);
  const Eigen::Vector3d shift(middle.x(), middle.y(), extent.low.z() - 100.0);
  camera->eye_in_station += camera->camera_from_station.transpose() * shift;
  const Eigen::Vector3d size = extent.high - extent.low;
  Framed framed{*camera, 0, 0, 0.0};
  framed.pixels_per_mm = options_.size * (1.0 - 2.0 * kMargin) / std::max({size.x(), size.y(), 1.0});
  const double border = 2.0 * kMargin * options_.size;
  framed.width = std::max(1, static_cast<int>(std::lround(size.x() * framed.pixels_per_mm + border)));
  framed.height = std::max(1, static_cast<int>(std::lround(size.y() * framed.pixels_per_mm + border)));
  framed.camera.half_height = 0.5 * framed.height / framed.pixels_per_mm;
  return framed;
}

/// As FrameAll, for all azimuths at once: the body turns about the upright line through the middle of its box.
Result<MeasurePicture::Framed> MeasurePicture::FrameTurning(const View& view) const {
  auto framed = FrameAll(view);
  if (!framed) return Fail(framed);
  Eigen::AlignedBox3d box;
  for (const Panel& panel : panels_) {
    for (const MapMesh& mesh : panel.meshes) {
      for (const Eigen::Vector3d& p : mesh.mesh.vertices) box.extend(p);
    }
  }
  const Eigen::Vector3d centre = box.center();
  double across = 0.0;
  double up = 0.0;
  for (const Panel& panel : panels_) {
    for (const MapMesh& mesh : panel.meshes) {
      for (const Eigen::Vector3d& p : mesh.mesh.vertices) {
        const double radius = (p - centre).head<2>().norm();
        across = std::max(across, radius);
        up = std::max(
            up, std::abs(p.z() - centre.z()) * std::cos(view.elevation) + radius * std::abs(std::sin(view.elevation)));
      }
    }
  }
  const double border = 2.0 * kMargin * options_.size;
  framed->pixels_per_mm = options_.size * (1.0 - 2.0 * kMargin) / (2.0 * std::max({across, up, 0.5}));
  framed->width = static_cast<int>(std::lround(2.0 * across * framed->pixels_per_mm + border));
  framed->height = static_cast<int>(std::lround(2.0 * up * framed->pixels_per_mm + border));
  framed->camera.half_height = 0.5 * framed->height / framed->pixels_per_mm;
  const double away = across + up + 100.0;
  framed->camera.eye_in_station = centre - away * framed->camera.camera_from_station.row(2).transpose();
  return framed;
}

void MeasurePicture::MarkOn(const Panel& panel, const Framed& framed, MapPanel& drawn) const {
  if (panel.unrolled) {
    for (const Tape& tape : panel.tapes) {
      std::vector<OverlayRun> runs;
      for (const auto& path : tape.paths) {
        runs.emplace_back();
        for (const Eigen::Vector3d& p : path) {
          const Eigen::Vector2d at = UnrolledPlace(p, *panel.unrolled, drawn.image);
          // A line that leaves at one side comes in at the other.
          const bool jumps =
              !runs.back().points.empty() && std::abs(runs.back().points.back().x() - at.x()) > 0.5 * drawn.image.width;
          if (jumps) runs.emplace_back();
          runs.back().points.push_back(at);
        }
      }
      for (const OverlayRun& run : runs) drawn.lines.push_back({run, tape.colour});
      if (const auto at = LabelPlace(runs, drawn)) drawn.labels.push_back({*at, tape.label, tape.colour});
    }
    for (const Mark& mark : panel.marks) {
      const Eigen::Vector2d at = UnrolledPlace(mark.position, *panel.unrolled, drawn.image);
      drawn.points.push_back({at, mark.colour, true});
      drawn.labels.push_back({at, mark.label, mark.colour});
    }
    return;
  }
  const Overlay overlay(framed.camera, drawn.image);
  for (const Mark& mark : panel.marks) {
    const auto point = overlay.Project(mark.position);
    if (!point) continue;
    const bool visible = !overlay.Hides(*point);
    drawn.points.push_back({point->at, mark.colour, visible});
    if (visible) drawn.labels.push_back({point->at, mark.label, mark.colour});
  }
  for (const Tape& tape : panel.tapes) {
    std::vector<OverlayRun> runs;
    for (const auto& path : tape.paths) {
      for (OverlayRun& run : overlay.Runs(path)) runs.push_back(std::move(run));
    }
    for (const OverlayRun& run : runs) drawn.lines.push_back({run, tape.colour});
    if (const auto at = LabelPlace(runs, drawn)) {
      drawn.labels.push_back({*at, tape.label, tape.colour});
    }
  }
}

MapPanel MeasurePicture::DrawUnrolled(const Panel& panel) const {
  const UnrolledMap& map = *panel.unrolled;
  const double share = std::clamp((map.z_max - map.z_min) / panel.girth, 0.25, 1.6);
  MapPanel drawn;
  drawn.image =
      RgbImage::Filled(options_.size, static_cast<int>(std::lround(options_.size * share)), LinearRgb::Ones());
  for (int y = 0; y < drawn.image.height; ++y) {
    const auto row = static_cast<Eigen::Index>(y) * map.values.rows() / drawn.image.height;
    for (int x = 0; x < drawn.image.width; ++x) {
      const auto column = static_cast<Eigen::Index>(x) * map.values.cols() / drawn.image.width;
      LinearRgb colour = legend_->colours.ColourOf(map.values(row, column));
      if (map.hatch(row, column) > 0.5 && (x + y) % kHatchPeriod == 0) colour *= kHatch;
      drawn.image.rgb[drawn.image.Index(x, y)] = colour;
    }
  }
  drawn.unrolled = {map.z_min, map.z_max};
  return drawn;
}

Result<MapPanel> MeasurePicture::DrawPanel(const Panel& panel, const Framed& framed, const TaskContext& task) const {
  MapPanel drawn;
  if (panel.unrolled) {
    drawn = DrawUnrolled(panel);
  } else {
    MapPictureOptions options;
    options.width = framed.width;
    options.height = framed.height;
    auto picture =
        RenderScalarMap(panel.meshes, legend_ ? legend_->colours : MapColours{}, framed.camera, options, task);
    if (!picture) return Fail(picture);
    drawn.image = std::move(picture->image);
    drawn.pixels_per_mm = framed.pixels_per_mm;
  }
  MarkOn(panel, framed, drawn);
  drawn.label_room_mm = label_room_mm_;
  return drawn;
}

Result<RgbImage> MeasurePicture::DrawFramed(const Framed& framed, const std::string& from,
                                            const TaskContext& task) const {
  std::vector<MapPanel> drawn;
  for (const Panel& panel : panels_) {
    auto one = DrawPanel(panel, framed, task);
    if (!one) return Fail(one);
    one->caption = panel.caption;
    if (!from.empty()) one->caption += (panel.caption.empty() ? "" : ", ") + from;
    drawn.push_back(std::move(*one));
  }
  const double scale = FigureScale(options_.size);
  return MapFigure(drawn, legend_, text_, scale).ToImage(scale);
}

Result<RgbImage> MeasurePicture::Draw(const View& view, const TaskContext& task) const {
  if (options_.form == PictureForm::kUnrolled) return DrawFramed({}, "", task);
  const auto framed = FrameAll(view);
  if (!framed) return Fail(framed);
  return DrawFramed(*framed, ViewText(view), task);
}

Result<std::vector<RgbImage>> MeasurePicture::DrawAround(const View& start, int count, const TaskContext& task) const {
  constexpr const char* kAttempted = "draw a turntable";
  if (options_.form == PictureForm::kUnrolled) {
    return Fail(kAttempted, "an unrolled map has no sides", "draw it on the body");
  }
  if (count < 1 || count > 720) return Fail(kAttempted, std::to_string(count) + " frames", "give 1 ... 720");
  MeasurePicture same_size = *this;
  std::vector<std::string> labels;
  for (const Panel& panel : panels_) {
    for (const Tape& tape : panel.tapes) labels.push_back(tape.label);
    for (const Mark& mark : panel.marks) labels.push_back(mark.label);
  }
  same_size.label_room_mm_ = LabelRoom(labels);
  std::vector<RgbImage> frames;
  const TaskContext quiet{{}, task.stop};
  for (int k = 0; k < count; ++k) {
    task.Report("drawing the turntable", k, count);
    View view = start;
    view.azimuth = WrapAngle(start.azimuth + kTwoPi * k / count);
    const auto framed = FrameTurning(view);
    if (!framed) return Fail(framed);
    auto frame = same_size.DrawFramed(
        *framed, fmt::format("from θ\u00a0=\u00a0{:.0f}°", DegreesFromRadians(view.azimuth)), quiet);
    if (!frame) return Fail(frame);
    frames.push_back(std::move(*frame));
  }
  task.Report("drawing the turntable", count, count);
  return frames;
}

}  // namespace annulus
