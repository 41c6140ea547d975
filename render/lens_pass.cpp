#include "render/lens_pass.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "base/bands.h"
#include "render/ray_march.h"
#include "render/sheet_lens.h"
#include "render/studio.h"
#include "render/surface_sampler.h"

namespace annulus {
namespace {

constexpr std::size_t kFragmentsPerTask = 2048;
/// Neighbours of a place belong to the same surface if their depths differ by less than this many samples' sizes.
constexpr double kSameSurface = 6.0;

/// The fragments of one lens, by sample, far to near.
struct Sheet {
  std::size_t item = 0;
  std::vector<Fragment> fragments;
  double mean_depth = 0.0;
};

/// The lenses in sight, the farthest first, then in the order of the scene.
std::vector<Sheet> SheetsOf(const PreparedScene& lenses, const std::vector<Fragment>& fragments) {
  std::vector<Sheet> sheets(lenses.items.size());
  for (std::size_t k = 0; k < sheets.size(); ++k) sheets[k].item = k;
  for (const Fragment& fragment : fragments) {
    Sheet& sheet = sheets[lenses.ItemOf(fragment.face)];
    sheet.fragments.push_back(fragment);
    sheet.mean_depth += static_cast<double>(fragment.depth);
  }
  std::erase_if(sheets, [](const Sheet& sheet) { return sheet.fragments.empty(); });
  for (Sheet& sheet : sheets) sheet.mean_depth /= static_cast<double>(sheet.fragments.size());
  std::stable_sort(sheets.begin(), sheets.end(),
                   [](const Sheet& a, const Sheet& b) { return a.mean_depth > b.mean_depth; });
  return sheets;
}

SampleWindow WindowOf(const std::vector<Fragment>& fragments, const PixelSamples& grid) {
  if (fragments.empty()) return {};
  const auto width = static_cast<std::uint32_t>(grid.width);
  int left = grid.width;
  int right = 0;
  for (const Fragment& fragment : fragments) {
    left = std::min(left, static_cast<int>(fragment.sample % width));
    right = std::max(right, static_cast<int>(fragment.sample % width));
  }
  const int step = grid.supersampling;
  const int top = static_cast<int>(fragments.front().sample / width) / step * step;
  const int bottom = (static_cast<int>(fragments.back().sample / width) / step + 1) * step;
  left = left / step * step;
  right = (right / step + 1) * step;
  return {left, top, right - left, bottom - top};
}

double FarthestOf(const Layer& layer) {
  float farthest = 0.0F;
  for (const float depth : layer.depth) {
    if (depth != kNoDepth) farthest = std::max(farthest, depth);
  }
  return farthest;
}

/// What one lens does to the samples behind it.
class SheetPass {
 public:
  /// Borrows its arguments. `behind` must not change while samples are asked for.
  SheetPass(const PreparedScene& lenses, const OpaquePicture& picture, const LensPicture& behind,
            const SheetLens& optics)
      : picture_(picture), behind_(behind), optics_(optics), sampler_(lenses, picture.grid) {}

  /// What is seen through all layers of the sheet at one sample. `farthest` as for MarchRay.
  [[nodiscard]] SeenLight Through(std::span<const Fragment> layers, double farthest) {
    const int x = ColumnOf(layers.front());
    const int y = RowOf(layers.front());
    SeenLight seen = BehindAt(x, y);
    const Fragment& last = layers.back();
    const SurfacePoint nearest = sampler_.At(x, y, last.face, last.depth);
    if (!optics_.IsPlano()) seen = Refracted(nearest, seen, farthest);
    for (const Fragment& fragment : layers.first(layers.size() - 1)) {
      Filter(sampler_.At(x, y, fragment.face, fragment.depth), seen);
    }
    Filter(nearest, seen);
    return seen;
  }
  [[nodiscard]] int ColumnOf(const Fragment& fragment) const {
    return static_cast<int>(fragment.sample % static_cast<std::uint32_t>(picture_.grid.width));
  }
  [[nodiscard]] int RowOf(const Fragment& fragment) const {
    return static_cast<int>(fragment.sample / static_cast<std::uint32_t>(picture_.grid.width));
  }

 private:
  /// Lets the light pass one layer of the sheet.
  static void Filter(const SurfacePoint& point, SeenLight& seen) {
    seen.light =
        seen.light.cwiseProduct(Transmittance(*point.material, point.solid.z())) + LensHighlight(point.shading);
  }

  static LinearRgb Transmittance(const Material& material, float height) {
    if (!(material.gradient_from > material.gradient_to)) return material.transmittance;
    const float share =
        std::clamp((material.gradient_from - height) / (material.gradient_from - material.gradient_to), 0.0F, 1.0F);
    return material.transmittance + share * (material.lower_transmittance - material.transmittance);
  }

  [[nodiscard]] SeenLight BehindAt(int x, int y) const {
    return behind_.window.Contains(x, y) ? behind_.seen[behind_.window.Index(x, y)] : picture_.At(x, y);
  }

  /// The light from the end of the refracted ray; `straight` at the sample itself.
  [[nodiscard]] SeenLight Refracted(const SurfacePoint& point, const SeenLight& straight, double farthest) const {
    const Eigen::Vector3f& n = point.shading.normal;
    const Eigen::Vector3f& to_eye = point.shading.to_eye;
    const Eigen::Vector3d normal(n.x(), n.y(), -n.z());
    const Eigen::Vector3d direction = Eigen::Vector3d(-to_eye.x(), -to_eye.y(), to_eye.z()).normalized();
    const std::optional<Eigen::Vector3d> onward = optics_.Refract(point.position, normal.normalized(), direction);
    if (!onward) {
      const Eigen::Vector3f mirrored = 2.0F * n.dot(to_eye) * n - to_eye;
      return {StudioWalls(mirrored, 0.05F), straight.cover};
    }
    const MarchEnd end = MarchRay(picture_, point.position, *onward, farthest);
    return end.kind == MarchEnd::Kind::kMissed ? BackdropSeen(end) : Blended(end, straight);
  }

  /// The backdrop where a ray that meets nothing points, through what other lens may stand before it.
  [[nodiscard]] SeenLight BackdropSeen(const MarchEnd& end) const {
    const auto x = static_cast<int>(std::floor(end.x + 0.5));
    const auto y = static_cast<int>(std::floor(end.y + 0.5));
    if (behind_.window.Contains(x, y) && picture_.DepthAt(x, y) == kNoDepth) return BehindAt(x, y);
    const double side = picture_.options.supersampling;
    const double centre = 0.5 * (side - 1.0);  // of a pixel, in samples
    return {BackdropAt(picture_.options, (end.x - centre) / side, (end.y - centre) / side), 0.0F};
  }

  /// Bilinear between the samples around the place that show the same surface.
  [[nodiscard]] SeenLight Blended(const MarchEnd& end, const SeenLight& straight) const {
    const auto left = static_cast<int>(std::floor(end.x));
    const auto top = static_cast<int>(std::floor(end.y));
    const double right_share = end.x - left;
    const double lower_share = end.y - top;
    const float depth = end.kind == MarchEnd::Kind::kMet ? end.depth : NearestDepth(end);
    const double scale = picture_.grid.projection == Projection::kPerspective ? static_cast<double>(depth) : 1.0;
    const double limit = kSameSurface * picture_.grid.Pitch() * scale;
    SeenLight sum;
    float total = 0.0F;
    for (int k = 0; k < 4; ++k) {
      const int x = left + k % 2;
      const int y = top + k / 2;
      if (x < 0 || y < 0 || x >= picture_.grid.width || y >= picture_.grid.height) continue;
      const float stored = picture_.DepthAt(x, y);
      if (stored != depth && !(std::abs(static_cast<double>(stored) - static_cast<double>(depth)) <= limit)) continue;
      const double weight =
          (k % 2 == 0 ? 1.0 - right_share : right_share) * (k / 2 == 0 ? 1.0 - lower_share : lower_share);
      const SeenLight seen = BehindAt(x, y);
      sum.light += static_cast<float>(weight) * seen.light;
      sum.cover += static_cast<float>(weight) * seen.cover;
      total += static_cast<float>(weight);
    }
    if (!(total > 1e-3F)) return straight;
    return {sum.light / total, std::min(1.0F, sum.cover / total)};
  }

  [[nodiscard]] float NearestDepth(const MarchEnd& end) const {
    return picture_.DepthAt(static_cast<int>(std::floor(end.x + 0.5)), static_cast<int>(std::floor(end.y + 0.5)));
  }

  const OpaquePicture& picture_;
  const LensPicture& behind_;
  const SheetLens& optics_;
  SurfaceSampler sampler_;
};

/// Where each run of fragments of one sample begins, and one past the last.
std::vector<std::size_t> RunsOf(const std::vector<Fragment>& fragments) {
  std::vector<std::size_t> runs;
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    if (k == 0 || fragments[k].sample != fragments[k - 1].sample) runs.push_back(k);
  }
  runs.push_back(fragments.size());
  return runs;
}

}  // namespace

LensPicture DrawLenses(const PreparedScene& lenses, const OpaquePicture& picture, LensMedium medium,
                       const std::stop_token& stop) {
  const PixelSamples& grid = picture.grid;
  const std::vector<Fragment> fragments =
      RasterizeAll(lenses.mesh, grid, {picture.layer.window, picture.layer.depth}, stop);
  LensPicture drawn;
  drawn.window = WindowOf(fragments, grid);
  drawn.seen.resize(drawn.window.Count());
  ForEachBand(drawn.window.height, grid.threads, stop, [&](int row) {
    const int y = drawn.window.row + row;
    for (int x = drawn.window.column; x < drawn.window.column_end(); ++x) {
      drawn.seen[drawn.window.Index(x, y)] = picture.At(x, y);
    }
  });
  const double farthest = fragments.empty() ? 0.0 : FarthestOf(picture.layer);
  for (const Sheet& sheet : SheetsOf(lenses, fragments)) {
    const SheetLens optics(lenses, sheet.item, medium);
    const std::vector<std::size_t> runs = RunsOf(sheet.fragments);
    std::vector<SeenLight> through(runs.size() - 1);
    const std::size_t tasks = (through.size() + kFragmentsPerTask - 1) / kFragmentsPerTask;
    ForEachBand(static_cast<int>(tasks), grid.threads, stop, [&](int task) {
      SheetPass pass(lenses, picture, drawn, optics);
      const std::size_t from = static_cast<std::size_t>(task) * kFragmentsPerTask;
      for (std::size_t k = from; k < std::min(from + kFragmentsPerTask, through.size()); ++k) {
        through[k] = pass.Through(std::span(sheet.fragments).subspan(runs[k], runs[k + 1] - runs[k]), farthest);
      }
    });
    const auto width = static_cast<std::uint32_t>(grid.width);
    for (std::size_t k = 0; k < through.size(); ++k) {
      const std::uint32_t sample = sheet.fragments[runs[k]].sample;
      drawn.seen[drawn.window.Index(static_cast<int>(sample % width), static_cast<int>(sample / width))] = through[k];
    }
  }
  return drawn;
}

}  // namespace annulus
