#include "render/eye_view.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/bands.h"
#include "base/units.h"
#include "modeling/glasses/lens_sight.h"
#include "render/lens_coating.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kAttempt = "draw what the eye sees";
constexpr double kPupilBeforeCentre = kRotationCentreBehindCornea - kPupilBehindCornea;  // mm
/// Rays of one pupil point are followed at the corners of squares of so many pixels; between corners of one kind what
/// they see is interpolated, which is right to 0.1' at the edge of a strong lens.
constexpr int kTile = 8;
/// The ground edge of a lens, seen from inside the glass.
const LinearRgb kGroundEdge(0.23F, 0.24F, 0.25F);
/// Where most of a frame is, mm from the pupil: how far apart its copies from two pupil points lie.
constexpr double kFrameDistance = 17.0;

Status InRange(const std::string& what, double value, double low, double high) {
  if (value >= low && value <= high) return {};  // NaN is not
  return Fail(kAttempt, what + " is " + std::to_string(value), "give a value within its range");
}

Status Check(const SeeingEye& eye, const BeforeTheEye& before, const EyeViewOptions& options) {
  const double most_gaze = RadiansFromDegrees(60.0);
  RETURN_IF_ERROR(InRange("the gaze to the left, in rad,", eye.gaze.left, -most_gaze, most_gaze));
  RETURN_IF_ERROR(InRange("the gaze upwards, in rad,", eye.gaze.up, -most_gaze, most_gaze));
  RETURN_IF_ERROR(InRange("the pupil's diameter in mm", eye.pupil_diameter, 0.0, 9.0));
  for (const double power : eye.correction.reshaped()) {
    RETURN_IF_ERROR(InRange("a power of the eye's correction in D", power, -40.0, 40.0));
  }
  RETURN_IF_ERROR(InRange("the vertex distance in mm", eye.vertex_distance, 3.0, 40.0));
  RETURN_IF_ERROR(InRange("the picture's width in pixels", options.width, 16, 4096));
  RETURN_IF_ERROR(InRange("the picture's height in pixels", options.height, 16, 4096));
  RETURN_IF_ERROR(InRange("the field in rad", options.field, RadiansFromDegrees(1.0), RadiansFromDegrees(140.0)));
  RETURN_IF_ERROR(InRange("the number of rays", options.samples, 1, 1024));
  if (before.world == nullptr) return Fail(kAttempt, "there is no world to see", "give a scene");
  if (!before.lens) return {};
  RETURN_IF_ERROR(Validate(before.lens->outline));
  RETURN_IF_ERROR(InRange("the lens's index", before.lens->form.index, 1.0, 4.0));
  const LensFinish& finish = before.lens->finish;
  for (const LinearRgb& part : {finish.transmittance, finish.lower_transmittance}) {
    for (const float channel : part) RETURN_IF_ERROR(InRange("a transmittance of the lens", channel, 1e-6, 1.0));
  }
  if (!(finish.gradient_to <= finish.gradient_from)) {
    return Fail(kAttempt, "the tint's gradient runs upwards", "give its upper end first");
  }
  return {};
}

/// A ray out of the pupil, in the axes of the turned eye (left, up, forward), origin the centre of rotation.
struct PupilRay {
  Vector3d origin;
  Vector3d direction;  // unit
};

/// The eye as a camera.
class EyeCamera {
 public:
  EyeCamera(const SeeingEye& eye, const EyeViewOptions& options)
      : view_from_turned_(ViewFromTurned(eye.gaze)),
        width_(options.width),
        height_(options.height),
        per_pixel_(2.0 * std::tan(0.5 * options.field) / options.width) {
    // The correction brought to the centre of rotation, where it is the same in every direction of gaze.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> cornea(eye.correction);
    axes_ = cornea.eigenvectors();
    for (Eigen::Index i = 0; i < 2; ++i) {
      const double power = cornea.eigenvalues()[i];
      at_centre_[i] = power / (1.0 - kRotationCentreBehindCornea / 1000.0 * power);
    }
  }

  /// The ray of pixel position (x, y) from the pupil's point `q` (mm; left, up). All rays of one pixel meet at the far
  /// point in its direction.
  [[nodiscard]] PupilRay Ray(double x, double y, const Vector2d& q) const {
    const Vector3d d = Vector3d((0.5 * width_ - x) * per_pixel_, (0.5 * height_ - y) * per_pixel_, 1.0).normalized();
    // Two axes across the ray, turned from left and up the shortest way; q as the ray sees it.
    const double share = 1.0 / (1.0 + d.z());
    const Vector3d left(1.0 - share * d.x() * d.x(), -share * d.x() * d.y(), -d.x());
    const Vector3d up(-share * d.x() * d.y(), 1.0 - share * d.y() * d.y(), -d.y());
    const Vector2d across(q.x() * left.x() + q.y() * left.y(), q.x() * up.x() + q.y() * up.y());
    const double metres = kPupilBeforeCentre / 1000.0 * d.z();
    const Vector2d principal = axes_.transpose() * across;
    const Vector2d turned = axes_ * Vector2d(at_centre_[0] / (1.0 + metres * at_centre_[0]) * principal.x(),
                                             at_centre_[1] / (1.0 + metres * at_centre_[1]) * principal.y());
    const Vector3d direction = d + 0.001 * (turned.x() * left + turned.y() * up);
    return {{q.x(), q.y(), kPupilBeforeCentre}, direction.normalized()};
  }

  [[nodiscard]] const Eigen::Matrix3d& view_from_turned() const { return view_from_turned_; }
  /// Tangent per pixel.
  [[nodiscard]] double per_pixel() const { return per_pixel_; }
  [[nodiscard]] double strongest() const { return at_centre_.cwiseAbs().maxCoeff(); }

  /// A camera of the rasteriser at a point of the pupil.
  [[nodiscard]] Camera At(const Vector2d& q) const {
    Camera camera;
    camera.camera_from_station.row(0) = -view_from_turned_.col(0).transpose();
    camera.camera_from_station.row(1) = view_from_turned_.col(1).transpose();
    camera.camera_from_station.row(2) = view_from_turned_.col(2).transpose();
    camera.eye_in_station = view_from_turned_ * Vector3d(q.x(), q.y(), kPupilBeforeCentre);
    camera.half_height = 0.5 * height_ * per_pixel_;
    return camera;
  }

 private:
  Eigen::Matrix3d view_from_turned_;
  int width_;
  int height_;
  double per_pixel_;
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();
  Vector2d at_centre_ = Vector2d::Zero();
};

/// The near things from one point of the pupil: light and share covered, softened.
struct NearLayer {
  int width = 0;
  int height = 0;
  std::vector<Eigen::Vector4f> covered;  // rgb times share, share

  [[nodiscard]] Eigen::Vector4f At(double x, double y) const {
    const double u = std::clamp(x - 0.5, 0.0, width - 1.001);
    const double v = std::clamp(y - 0.5, 0.0, height - 1.001);
    const auto column = static_cast<std::size_t>(u);
    const auto row = static_cast<std::size_t>(v);
    const auto fu = static_cast<float>(u - static_cast<double>(column));
    const auto fv = static_cast<float>(v - static_cast<double>(row));
    const Eigen::Vector4f* upper = &covered[row * static_cast<std::size_t>(width) + column];
    const Eigen::Vector4f* lower = upper + width;
    return (1.0F - fv) * ((1.0F - fu) * upper[0] + fu * upper[1]) + fv * ((1.0F - fu) * lower[0] + fu * lower[1]);
  }
};

/// Mean over 2·radius + 1 neighbours along rows of `across` entries, `stride` apart; edges repeat.
void SoftenLines(std::vector<Eigen::Vector4f>& values, int lines, int across, int line_stride, int stride, int radius) {
  std::vector<Eigen::Vector4f> line(static_cast<std::size_t>(across));
  for (int i = 0; i < lines; ++i) {
    Eigen::Vector4f* start = values.data() + static_cast<std::ptrdiff_t>(i) * line_stride;
    const auto at = [&](int k) { return start[static_cast<std::ptrdiff_t>(std::clamp(k, 0, across - 1)) * stride]; };
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (int k = -radius; k <= radius; ++k) sum += at(k);
    for (int k = 0; k < across; ++k) {
      line[static_cast<std::size_t>(k)] = sum / static_cast<float>(2 * radius + 1);
      sum += at(k + radius + 1) - at(k - radius);
    }
    for (int k = 0; k < across; ++k) {
      // The running sum leaves 1e-6 where nothing is.
      start[static_cast<std::ptrdiff_t>(k) * stride] = line[static_cast<std::size_t>(k)].cwiseMax(0.0F);
    }
  }
}

Result<NearLayer> NearLayerOf(const Scene& near, const Camera& camera, const RenderOptions& options, int radius,
                              const TaskContext& task) {
  const auto layer = RenderLayer(near, camera, options, {{}, task.stop});
  if (!layer) return Fail(layer);
  NearLayer result{layer->width, layer->height, {}};
  result.covered.assign(static_cast<std::size_t>(layer->width) * static_cast<std::size_t>(layer->height),
                        Eigen::Vector4f::Zero());
  const SampleWindow& window = layer->window;
  for (int y = window.row; y < window.row_end(); ++y) {
    for (int x = window.column; x < window.column_end(); ++x) {
      const std::size_t from = window.Index(x, y);
      if (layer->depth[from] == kNoDepth) continue;
      result.covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(layer->width) + static_cast<std::size_t>(x)]
          << layer->rgb[from],
          1.0F;
    }
  }
  for (int pass = 0; pass < 2 && radius > 0; ++pass) {
    SoftenLines(result.covered, result.height, result.width, result.width, 1, radius);
    SoftenLines(result.covered, result.width, result.height, 1, result.width, radius);
  }
  return result;
}

/// What a corner's ray sees.
struct Corner {
  SightPath path = SightPath::kBeside;
  Vector3d out = Vector3d::UnitZ();  // view frame
  LinearRgb passed = LinearRgb::Ones();
  Vector2d on_layer = Vector2d::Zero();  // tangents of the ray in the turned eye: right, down
};

/// All that the picture's pixels share.
class EyePicture {
 public:
  EyePicture(const SeeingEye& eye, const BeforeTheEye& before, const EyeViewOptions& options)
      : before_(before), options_(options), camera_(eye, options) {
    if (before.lens) {
      LensPose pose;
      pose.view_from_lens = before.lens->station_from_lens.linear();
      pose.vertex_distance = eye.vertex_distance;
      sight_.emplace(before.lens->form, before.lens->outline, pose, nullptr);
      lens_from_view_ = before.lens->station_from_lens.inverse();
    }
    // A pinhole needs rays for smooth edges only.
    samples_ = eye.pupil_diameter > 0.0 ? options.samples : std::min(options.samples, 16);
    const double apart = samples_ > 1 ? 0.886 * eye.pupil_diameter / std::sqrt(samples_) : 0.0;
    uncorrected_spot_ = 0.001 * apart * camera_.strongest();
    pupil_radius_ = 0.5 * eye.pupil_diameter;
    near_spot_ = apart / kFrameDistance;
  }

  Result<RgbImage> Draw(const TaskContext& task) {
    RgbImage image = RgbImage::Filled(options_.width, options_.height, LinearRgb::Zero());
    for (int sample = 0; sample < samples_; ++sample) {
      task.Report("draw what the eye sees", sample, samples_);
      const Vector2d q = PupilPoint(sample);
      if (!before_.near.items.empty() && (sample == 0 || pupil_radius_ > 0.0)) RETURN_IF_ERROR(LookAtNear(q, task));
      FollowCorners(sample, q, task.stop);
      ForEachBand(TileRows(), options_.threads, task.stop, [&](int row) { AddRow(sample, q, row, image); });
      if (task.stop.stop_requested()) return Fail(kAttempt, "it was stopped", "start it again");
    }
    for (LinearRgb& pixel : image.rgb) pixel /= static_cast<float>(samples_);
    return image;
  }

 private:
  [[nodiscard]] int TileRows() const { return (options_.height + kTile - 1) / kTile; }
  [[nodiscard]] int TileColumns() const { return (options_.width + kTile - 1) / kTile; }

  /// Evenly over the pupil, in a spiral.
  [[nodiscard]] Vector2d PupilPoint(int sample) const {
    constexpr double kGoldenAngle = 2.399963229728653;
    const double radius = pupil_radius_ * std::sqrt((sample + 0.5) / samples_);
    return {radius * std::cos(kGoldenAngle * sample), radius * std::sin(kGoldenAngle * sample)};
  }
  /// Where in the pixel the sample lies, by the plastic number: even in any number.
  static Vector2d InPixel(int sample) {
    const double x = 0.5 + 0.7548776662466927 * sample;
    const double y = 0.5 + 0.5698402909980532 * sample;
    return {x - std::floor(x), y - std::floor(y)};
  }

  Status LookAtNear(const Vector2d& q, const TaskContext& task) {
    RenderOptions render;
    const bool sharp = pupil_radius_ == 0.0;
    render.width = sharp ? options_.width : (options_.width + 1) / 2;
    render.height = sharp ? options_.height : (options_.height + 1) / 2;
    render.supersampling = sharp ? 2 : 1;
    render.threads = options_.threads;
    near_scale_ = sharp ? 2.0 : 0.5;
    const double pixels = near_spot_ / camera_.per_pixel() * near_scale_;
    auto layer = NearLayerOf(before_.near, camera_.At(q), render, static_cast<int>(std::lround(0.5 * pixels)), task);
    if (!layer) return Fail(layer);
    near_ = std::move(*layer);
    return {};
  }

  [[nodiscard]] Corner CornerAt(double x, double y, const Vector2d& q) const {
    const PupilRay ray = camera_.Ray(x, y, q);
    const Eigen::Matrix3d& turned = camera_.view_from_turned();
    Corner corner;
    corner.on_layer = Vector2d(-ray.direction.x(), -ray.direction.y()) / ray.direction.z();
    corner.out = turned * ray.direction;
    if (!sight_) return corner;
    const Eigen::Matrix3d& rotation = lens_from_view_.linear();
    const SightRay seen = sight_->Follow(lens_from_view_ * (turned * ray.origin), rotation * corner.out);
    corner.path = seen.path;
    if (seen.path != SightPath::kLens) return corner;
    corner.passed = Passed(seen);
    corner.out = rotation.transpose() * seen.direction;
    return corner;
  }

  /// What of the light comes through: tint, its gradient, two boundaries.
  [[nodiscard]] LinearRgb Passed(const SightRay& seen) const {
    const LensFinish& finish = before_.lens->finish;
    const double index = before_.lens->form.index;
    const LinearRgb back = SplitAt(finish, LensPart::kBack, seen.back_cosine, true, index).passed;
    const LinearRgb front = SplitAt(finish, LensPart::kFront, seen.front_cosine, true, index).passed;
    return GlassTransmittance(finish, seen.front_point.y(), seen.back_point.y(), seen.length_in_glass())
        .cwiseProduct(back)
        .cwiseProduct(front);
  }

  void FollowCorners(int sample, const Vector2d& q, const std::stop_token& stop) {
    const int columns = TileColumns() + 1;
    corners_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(TileRows() + 1));
    const Vector2d in_pixel = InPixel(sample);
    ForEachBand(TileRows() + 1, options_.threads, stop, [&](int row) {
      for (int column = 0; column < columns; ++column) {
        corners_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] =
            CornerAt(column * kTile + in_pixel.x(), row * kTile + in_pixel.y(), q);
      }
    });
  }

  void AddRow(int sample, const Vector2d& q, int tile_row, RgbImage& image) const {
    const Vector2d in_pixel = InPixel(sample);
    const auto columns = static_cast<std::size_t>(TileColumns() + 1);
    for (int tile = 0; tile < TileColumns(); ++tile) {
      const Corner* upper = &corners_[static_cast<std::size_t>(tile_row) * columns + static_cast<std::size_t>(tile)];
      const Corner* lower = upper + columns;
      const bool alike = upper[0].path != SightPath::kEdge && upper[0].path == upper[1].path &&
                         upper[0].path == lower[0].path && upper[0].path == lower[1].path;
      for (int y = tile_row * kTile; y < std::min(options_.height, (tile_row + 1) * kTile); ++y) {
        for (int x = tile * kTile; x < std::min(options_.width, (tile + 1) * kTile); ++x) {
          const Vector2d share((x - tile * kTile) / static_cast<double>(kTile),
                               (y - tile_row * kTile) / static_cast<double>(kTile));
          image.rgb[image.Index(x, y)] +=
              SeenAt(alike ? Between(upper, lower, share) : CornerAt(x + in_pixel.x(), y + in_pixel.y(), q));
        }
      }
    }
  }

  static Corner Between(const Corner* upper, const Corner* lower, const Vector2d& share) {
    const double a = (1.0 - share.x()) * (1.0 - share.y());
    const double b = share.x() * (1.0 - share.y());
    const double c = (1.0 - share.x()) * share.y();
    const double d = share.x() * share.y();
    Corner corner;
    corner.path = upper[0].path;
    corner.out = a * upper[0].out + b * upper[1].out + c * lower[0].out + d * lower[1].out;
    corner.passed = static_cast<float>(a) * upper[0].passed + static_cast<float>(b) * upper[1].passed +
                    static_cast<float>(c) * lower[0].passed + static_cast<float>(d) * lower[1].passed;
    corner.on_layer = a * upper[0].on_layer + b * upper[1].on_layer + c * lower[0].on_layer + d * lower[1].on_layer;
    return corner;
  }

  [[nodiscard]] LinearRgb SeenAt(const Corner& seen) const {
    LinearRgb light = kGroundEdge;
    if (seen.path != SightPath::kEdge) {
      const double cosine = 1.0 / std::sqrt(1.0 + seen.on_layer.squaredNorm());
      const double pixel = 0.8 * camera_.per_pixel() * cosine * cosine;
      const double spot = seen.path == SightPath::kBeside ? std::max(pixel, uncorrected_spot_) : pixel;
      light = before_.world->Light(seen.out, spot).cwiseProduct(seen.passed);
    }
    if (near_.covered.empty()) return light;
    const Vector2d pixel = seen.on_layer / camera_.per_pixel() + 0.5 * Vector2d(options_.width, options_.height);
    const Eigen::Vector4f near = near_.At(near_scale_ * pixel.x(), near_scale_ * pixel.y());
    return near.head<3>() + (1.0F - std::min(near[3], 1.0F)) * light;
  }

  const BeforeTheEye& before_;
  EyeViewOptions options_;
  EyeCamera camera_;
  std::optional<LensSight> sight_;
  Eigen::Isometry3d lens_from_view_ = Eigen::Isometry3d::Identity();
  int samples_ = 1;
  double pupil_radius_ = 0.0;
  double uncorrected_spot_ = 0.0;  // rad between neighbouring rays of the naked eye
  double near_spot_ = 0.0;         // rad between a frame's copies
  double near_scale_ = 1.0;        // layer's pixels per pixel
  NearLayer near_;
  std::vector<Corner> corners_;
};

}  // namespace

Result<RgbImage> RenderEyeView(const SeeingEye& eye, const BeforeTheEye& before, const EyeViewOptions& options,
                               const TaskContext& task) {
  RETURN_IF_ERROR(Check(eye, before, options));
  return EyePicture(eye, before, options).Draw(task);
}

}  // namespace annulus
