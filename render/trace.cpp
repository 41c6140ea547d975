#include "render/trace.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/bands.h"
#include "render/check_scene.h"
#include "render/opaque_picture.h"
#include "render/tone.h"
#include "render/trace_camera.h"
#include "render/trace_film.h"
#include "render/trace_path.h"
#include "render/trace_scene.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
constexpr const char* kStage = "trace";
/// Pixels of a tile along each side: its rays run alike, its paths fit the cache.
constexpr int kTile = 8;
/// Samples of each pixel that are traced side by side.
constexpr int kSamplesAtOnce = 8;
/// Paths between two reports of progress, about.
constexpr std::int64_t kPathsPerRound = std::int64_t{1} << 19;

Status CheckOptions(const Camera& camera, const Lighting& lighting, const TraceOptions& options) {
  RenderOptions request;
  request.width = options.width;
  request.height = options.height;
  request.supersampling = 1;
  RETURN_IF_ERROR(CheckRequest(camera, request));
  if (options.samples < 1 || options.samples > 65536) {
    return Fail(kAttempted, std::to_string(options.samples) + " samples per pixel", "give 1 ... 65536");
  }
  if (options.max_bounces < 0 || options.max_bounces > 64) {
    return Fail(kAttempted, "paths of " + std::to_string(options.max_bounces) + " bounces", "give 0 ... 64");
  }
  const auto is_light = [](const LinearRgb& rgb) { return rgb.allFinite() && rgb.minCoeff() >= 0.0F; };
  const bool lights_ok = std::all_of(lighting.lights.begin(), lighting.lights.end(), [&](const FarLight& light) {
    return is_light(light.radiance) && light.towards.allFinite() && light.towards.norm() > 1e-9;
  });
  if (!lights_ok || !is_light(options.backdrop.centre) || !is_light(options.backdrop.edge)) {
    return Fail(kAttempted, "a light or the backdrop is not finite or is negative", "correct the light");
  }
  return {};
}

/// Which samples are taken together: `first` … `last` - 1 of every pixel.
struct SampleRange {
  int first = 0;
  int last = 0;
};

/// One call of Trace.
class TraceRun {
 public:
  TraceRun(const TraceScene& scene, const Camera& camera, const Lighting& lighting, const TraceOptions& options)
      : options_(options),
        camera_(camera, scene, options.width, options.height),
        tracer_(scene, camera_, lighting, options),
        film_(options.width, options.height),
        covered_(camera_.Coverage(scene)),
        threads_(ThreadCount(options.threads)) {
    backdrop_.width = options.width;
    backdrop_.height = options.height;
    backdrop_.backdrop = options.backdrop;
    // The environment behind the scene is seen in every pixel.
    if (options.background == TraceOptions::Background::kEnvironment) {
      std::fill(covered_.begin(), covered_.end(), std::uint8_t{1});
    }
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        if (covered_[IndexOf(x, y)] == 0) film_.SetBehind(IndexOf(x, y), BehindAt(x, y));
      }
    }
    tiles_across_ = (options.width + kTile - 1) / kTile;
    tiles_ = tiles_across_ * ((options.height + kTile - 1) / kTile);
  }

  [[nodiscard]] Result<RgbImage> Run(const TaskContext& task, const TracePassSink& on_pass) {
    for (int done = 0, pass_end = 1; done < options_.samples; pass_end = std::min(2 * pass_end, options_.samples)) {
      while (done < pass_end) {
        const SampleRange range{done, std::min(done + kSamplesAtOnce, pass_end)};
        RETURN_IF_ERROR(TakeSamples(range, task));
        done = range.last;
      }
      if (done < options_.samples && on_pass) {
        const RgbImage image = film_.Develop(done, options_, threads_, task.stop);
        RETURN_IF_ERROR(CheckStop(task));
        on_pass({image, done});
      }
    }
    RgbImage image = film_.Develop(options_.samples, options_, threads_, task.stop);
    RETURN_IF_ERROR(CheckStop(task));
    if (on_pass) on_pass({image, options_.samples});
    return image;
  }

 private:
  static Status CheckStop(const TaskContext& task) {
    if (!task.stop.stop_requested()) return {};
    return Fail(kAttempted, "it was stopped", "start it again when you want it");
  }

  [[nodiscard]] std::size_t IndexOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.width) + static_cast<std::size_t>(x);
  }

  /// The light that becomes the backdrop's under the tone curve.
  [[nodiscard]] LinearRgb BehindAt(int x, int y) const {
    const LinearRgb backdrop = BackdropAt(backdrop_, x, y);
    return options_.tone_curve == ToneCurve::kSoft ? BeforeSoftLimit(backdrop) : backdrop;
  }

  /// Some samples of every pixel, with progress in between if that takes long.
  [[nodiscard]] Status TakeSamples(const SampleRange& range, const TaskContext& task) {
    const int samples = range.last - range.first;
    const std::int64_t per_round = std::max<std::int64_t>(1, kPathsPerRound / (std::int64_t{kTile} * kTile * samples));
    for (std::int64_t first = 0; first < tiles_; first += per_round) {
      const auto count = static_cast<int>(std::min<std::int64_t>(per_round, tiles_ - first));
      ForEachBand(count, threads_, task.stop, [&](int k) { TraceTile(static_cast<int>(first) + k, range); });
      RETURN_IF_ERROR(CheckStop(task));
      task.Report(kStage, range.first + samples * static_cast<double>(first + count) / tiles_, options_.samples);
    }
    return {};
  }

  void TraceTile(int tile, const SampleRange& range) {
    const int left = tile % tiles_across_ * kTile;
    const int top = tile / tiles_across_ * kTile;
    std::vector<PathRequest> requests;
    std::vector<std::size_t> pixels;
    requests.reserve(static_cast<std::size_t>(kTile * kTile * (range.last - range.first)));
    pixels.reserve(std::size_t{kTile} * kTile);
    // In squares of 2 x 2 and 4 x 4: neighbours in the list are neighbours in the picture.
    for (int k = 0; k < kTile * kTile; ++k) {
      const int x = left + (k & 1) + ((k >> 1) & 2) + ((k >> 2) & 4);
      const int y = top + ((k >> 1) & 1) + ((k >> 2) & 2) + ((k >> 3) & 4);
      if (x >= options_.width || y >= options_.height || covered_[IndexOf(x, y)] == 0) continue;
      pixels.push_back(IndexOf(x, y));
      const LinearRgb behind = BehindAt(x, y);
      for (int sample = range.first; sample < range.last; ++sample) {
        requests.push_back({x, y, static_cast<std::uint32_t>(sample), behind});
      }
    }
    if (requests.empty()) return;
    const std::vector<PathResult> results = tracer_.Trace(requests);
    const auto per_pixel = static_cast<std::size_t>(range.last - range.first);
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      film_.Add(pixels[k], std::span(results).subspan(k * per_pixel, per_pixel));
    }
  }

  const TraceOptions& options_;  // of the caller, for the duration of the call
  RenderOptions backdrop_;       // what BackdropAt asks for
  TraceCamera camera_;
  PathTracer tracer_;
  TraceFilm film_;
  std::vector<std::uint8_t> covered_;
  int threads_;
  int tiles_across_ = 0;
  int tiles_ = 0;
};

}  // namespace

struct Tracer::Prepared {
  std::unique_ptr<const TraceScene> scene;
};

Tracer::Tracer(std::unique_ptr<const Prepared> prepared) : prepared_(std::move(prepared)) {}
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;
Tracer::~Tracer() = default;

Result<Tracer> Tracer::Make(const Scene& scene) {
  for (const SceneItem& item : scene.items) RETURN_IF_ERROR(CheckItem(item));
  Result<std::unique_ptr<const TraceScene>> made = TraceScene::Make(scene);
  if (!made) return Fail(made);
  auto prepared = std::make_unique<Prepared>();
  prepared->scene = std::move(*made);
  return Tracer(std::move(prepared));
}

Result<RgbImage> Tracer::Trace(const Camera& camera, const Lighting& lighting, const TraceOptions& options,
                               const TaskContext& task, const TracePassSink& on_pass) const {
  RETURN_IF_ERROR(CheckOptions(camera, lighting, options));
  return TraceRun(*prepared_->scene, camera, lighting, options).Run(task, on_pass);
}

}  // namespace annulus
