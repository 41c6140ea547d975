/// Our path tracer beside povray on the paper's job, for docs/benchmarks.md: each program draws the same scenes with
/// several settings; each picture is compared with the same program's own converged one, so that differences of the
/// models do not count.
///
/// usage: povray_peer --out FILE.json --folder DIR [--quick]

#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "render/trace.h"
#include "tests/support/face_scene.h"
#include "tests/support/povray_process.h"
#include "tests/support/povray_scene.h"

namespace annulus::bench {
namespace {

constexpr int kThreads = 2;

/// How one picture was made, what it cost and how far it is from the converged one.
struct Point {
  std::string program;
  std::string setting;
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  double error_255 = 0.0;  ///< Root mean square over pixels and channels of sRGB values, in 1/255.
};

struct PovraySetting {
  std::string name;
  test::PovraySceneOptions scene;
  double threshold = 0.0;
  int depth = 3;
};

/// A scene, and what both programs try.
struct Contest {
  std::string name;
  int size = 360;
  Lighting lighting{Environment::Uniform(LinearRgb::Zero()), {}};
  int max_bounces = 0;
  std::vector<int> samples;
  int reference_samples = 1024;
  std::vector<PovraySetting> povray;
  PovraySetting povray_reference;
};

template <class T>
T OrThrow(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().Text());
  return *std::move(result);
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double ErrorOf(const RgbImage& image, const RgbImage& reference) {
  double sum = 0.0;
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double difference = SrgbFromLinear(static_cast<double>(image.rgb[i][c])) -
                                SrgbFromLinear(static_cast<double>(reference.rgb[i][c]));
      sum += difference * difference;
    }
  }
  return 255.0 * std::sqrt(sum / (3.0 * static_cast<double>(image.rgb.size())));
}

/// The head of more than 100,000 triangles with its two lenses, from the front.
struct Job {
  Scene scene;
  Camera camera;
};
Job PapersJob() {
  test::FaceLenses lenses;
  lenses.orders = {{-4.0, 0.0, kPi}, {-3.0, -1.0, 0.6}};
  Job job{OrThrow(test::FaceScene(400, 130, lenses)), {}};
  job.camera = OrThrow(FrameCamera(BoundsOf(job.scene), OrThrow(ParseView("front")), {}));
  return job;
}

RgbImage Trace(const Tracer& tracer, const Job& job, const Contest& contest, const TraceOptions& changed,
               Point& point) {
  TraceOptions options = changed;
  options.width = contest.size;
  options.height = contest.size;
  options.threads = kThreads;
  options.max_bounces = contest.max_bounces;
  options.tone_curve = ToneCurve::kLinear;
  options.backdrop = {LinearRgb::Zero(), LinearRgb::Zero()};
  const double cpu = CpuSeconds();
  const auto begin = std::chrono::steady_clock::now();
  RgbImage image = OrThrow(tracer.Trace(job.camera, contest.lighting, options, {}));
  point.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  point.cpu_seconds = CpuSeconds() - cpu;
  return image;
}

std::vector<Point> OurPoints(const Tracer& tracer, const Job& job, const Contest& contest) {
  TraceOptions options;
  options.denoising = Denoising::kOff;
  options.samples = contest.reference_samples;
  options.seed = 99;
  Point unused;
  const RgbImage reference = Trace(tracer, job, contest, options, unused);
  options.seed = 1;
  std::vector<Point> points;
  for (const Denoising denoising : {Denoising::kOff, Denoising::kOn}) {
    for (const int samples : contest.samples) {
      options.denoising = denoising;
      options.samples = samples;
      Point point{denoising == Denoising::kOn ? "annulus, denoised" : "annulus", std::to_string(samples) + " samples"};
      point.error_255 = ErrorOf(Trace(tracer, job, contest, options, point), reference);
      points.push_back(point);
    }
  }
  return points;
}

test::PovrayPicture Povray(const Job& job, const Contest& contest, const PovraySetting& setting,
                           const std::string& folder) {
  const std::string text = OrThrow(test::PovrayScene(job.scene, job.camera, contest.lighting, setting.scene));
  test::PovraySampling sampling;
  sampling.width = contest.size;
  sampling.height = contest.size;
  sampling.threads = kThreads;
  sampling.threshold = setting.threshold;
  sampling.depth = setting.depth;
  return OrThrow(test::RunPovray(text, sampling, folder, "job"));
}

std::vector<Point> PovrayPoints(const Job& job, const Contest& contest, const std::string& folder) {
  const RgbImage reference = Povray(job, contest, contest.povray_reference, folder).image;
  std::vector<Point> points;
  for (const PovraySetting& setting : contest.povray) {
    const test::PovrayPicture picture = Povray(job, contest, setting, folder);
    points.push_back(
        {"povray", setting.name, picture.trace.seconds, picture.trace.cpu_seconds, ErrorOf(picture.image, reference)});
  }
  return points;
}

/// Seconds of processor in which `program` reaches an error, between its points by straight lines in logarithms; beyond
/// its best point by the inverse square of the error; its quickest point if that is better already.
double CpuSecondsFor(const std::vector<Point>& points, const std::string& program, double error) {
  const Point* last = nullptr;
  for (const Point& point : points) {
    if (point.program != program) continue;
    if (point.error_255 <= error) {
      if (last == nullptr) return point.cpu_seconds;
      const double share = std::log(last->error_255 / error) / std::log(last->error_255 / point.error_255);
      return last->cpu_seconds * std::pow(point.cpu_seconds / last->cpu_seconds, share);
    }
    last = &point;
  }
  return last == nullptr ? 0.0 : last->cpu_seconds * std::pow(last->error_255 / error, 2);
}

nlohmann::json InJson(const Contest& contest, const std::vector<Point>& points) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Point& point : points) {
    nlohmann::json row = {{"program", point.program},
                          {"setting", point.setting},
                          {"time_ms", 1e3 * point.seconds},
                          {"cpu_ms", 1e3 * point.cpu_seconds},
                          {"error_255", point.error_255}};
    if (point.program == "povray") {
      // How many times faster we are at povray's error.
      for (const char* ours : {"annulus", "annulus, denoised"}) {
        row[std::string(ours) == "annulus" ? "ratio" : "ratio_denoised"] =
            point.cpu_seconds / CpuSecondsFor(points, ours, point.error_255);
      }
    }
    rows.push_back(row);
  }
  return {{"scene", contest.name}, {"size", contest.size}, {"threads", kThreads}, {"points", rows}};
}

// --- the scenes
// -------------------------------------------------------------------------------------------------------

/// Three far lights: all that is to be found are edges.
Contest FarLights() {
  Contest contest;
  contest.name = "three far lights";
  contest.lighting.lights = {{Eigen::Vector3d(-0.45, 0.8, 0.45).normalized(), LinearRgb(0.7F, 0.68F, 0.62F)},
                             {Eigen::Vector3d(0.5, 0.85, 0.1).normalized(), LinearRgb(0.22F, 0.24F, 0.27F)},
                             {Eigen::Vector3d(-0.7, -0.5, 0.5).normalized(), LinearRgb(0.4F, 0.4F, 0.45F)}};
  contest.samples = {1, 2, 4, 8, 16, 32, 64};
  contest.povray = {{"no antialiasing", {}, 0.0, 1},
                    {"+A0.3 +R2", {}, 0.3, 2},
                    {"+A0.1 +R3", {}, 0.1, 3},
                    {"+A0.03 +R3", {}, 0.03, 3}};
  contest.povray_reference = {"", {}, 1e-6, 4};
  return contest;
}

PovraySetting Dome(int lights, double threshold, int depth) {
  PovraySetting setting{"dome of " + std::to_string(lights) + " lights", {}, threshold, depth};
  setting.scene.sky_lights = lights;
  setting.scene.background = test::PovraySceneOptions::Background::kBlack;
  return setting;
}

/// The studio's soft lamps and walls, direct light; povray's are a dome of far lights drawn from the same environment.
Contest Studio() {
  Contest contest;
  contest.name = "studio";
  contest.size = 180;
  contest.lighting.environment = Environment::Preset(LightPreset::kStudio);
  contest.samples = {1, 2, 4, 8, 16, 32, 64, 128};
  contest.povray = {Dome(16, 0.1, 2), Dome(64, 0.1, 2), Dome(256, 0.1, 2)};
  contest.povray_reference = Dome(1024, 0.02, 2);
  return contest;
}

PovraySetting Radiosity(int count, double error_bound) {
  PovraySetting setting{"radiosity, count " + std::to_string(count), {}, 0.1, 2};
  char text[200];
  std::snprintf(text, sizeof text,
                "radiosity { pretrace_start 0.08 pretrace_end %.4f count %d error_bound %g nearest_count 10 "
                "recursion_limit 2 low_error_factor 0.5 gray_threshold 0 brightness 1 }",
                count >= 200 ? 0.005 : 0.01, count, error_bound);
  setting.scene.settings = text;
  return setting;
}

/// An even sky and a sun, with light from surface to surface once.
Contest SkyAndSun() {
  Contest contest;
  contest.name = "even sky and sun, one reflection between surfaces";
  contest.size = 180;
  contest.lighting.environment = Environment::Uniform(LinearRgb(0.35F, 0.38F, 0.42F));
  contest.lighting.lights = {{Eigen::Vector3d(-0.45, 0.8, 0.45).normalized(), LinearRgb(0.5F, 0.48F, 0.42F)}};
  contest.max_bounces = 1;
  contest.samples = {1, 2, 4, 8, 16, 32, 64, 128};
  contest.povray = {Radiosity(35, 0.8), Radiosity(150, 0.4), Radiosity(400, 0.2)};
  contest.povray_reference = Radiosity(1000, 0.15);
  contest.povray_reference.threshold = 0.02;
  return contest;
}

/// Little work, to see that all of it runs.
Contest Quick(Contest contest) {
  contest.size = 60;
  contest.reference_samples = 64;
  contest.samples.resize(3);
  contest.povray.resize(2);
  contest.povray_reference = contest.povray.back();
  contest.povray_reference.threshold = 0.05;
  return contest;
}

}  // namespace
}  // namespace annulus::bench

int main(int count, char** arguments) {
  using namespace annulus::bench;  // NOLINT(google-build-using-namespace)
  std::string out;
  std::string folder = ".";
  bool quick = false;
  for (int i = 1; i < count; ++i) {
    const std::string_view word = arguments[i];
    if (word == "--quick") quick = true;
    if (i + 1 < count && word == "--out") out = arguments[i + 1];
    if (i + 1 < count && word == "--folder") folder = arguments[i + 1];
  }
  if (!annulus::test::HasPovray()) {
    std::fputs("povray_peer: no povray here\n", stderr);
    return 1;
  }
  try {
    const Job job = PapersJob();
    const annulus::Tracer tracer = OrThrow(annulus::Tracer::Make(job.scene));
    nlohmann::json all = nlohmann::json::array();
    for (const Contest& whole : {FarLights(), Studio(), SkyAndSun()}) {
      const Contest contest = quick ? Quick(whole) : whole;
      std::vector<Point> points = OurPoints(tracer, job, contest);
      const std::vector<Point> theirs = PovrayPoints(job, contest, folder);
      points.insert(points.end(), theirs.begin(), theirs.end());
      all.push_back(InJson(contest, points));
      std::fprintf(stderr, "povray_peer: %s done\n", contest.name.c_str());
      // After every scene, so that what was measured is kept whatever follows.
      if (!out.empty()) std::ofstream(out) << nlohmann::json{{"trace_beside_povray", all}}.dump(1) << "\n";
    }
    if (out.empty()) std::puts(nlohmann::json{{"trace_beside_povray", all}}.dump(1).c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "povray_peer: %s\n", error.what());
    return 1;
  }
  return 0;
}
