/// The fitter on adversarial scans: bytes become up to 40 levels × 16 sensors of a trunk with holes, steps, repeated
/// and impossible samples. Each fit is a finite surface, closed in theta, or an error; libFuzzer's time-out ends one
/// that hangs (sanitizers cost a hundred times: 0.02 s of a release build are 2 s here).
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/ensure.h"
#include "fitting/fit_surface.h"

namespace {

using namespace annulus;

/// Takes the input apart; zeros once it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  std::uint8_t Next() { return at_ < size_ ? data_[at_++] : std::uint8_t{0}; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

double Special(std::uint8_t which) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kSpecials[] = {std::numeric_limits<double>::quiet_NaN(),
                                  kInfinity,
                                  -kInfinity,
                                  1e308,
                                  -1e308,
                                  0.0,
                                  -0.0,
                                  5e-324,
                                  -1.0,
                                  1e-9,
                                  1e4,
                                  1e12};
  return kSpecials[which % std::size(kSpecials)];
}

/// One byte spoils a sample in one of many ways; most byte values leave it alone.
void Spoil(std::uint8_t how, Bytes& bytes, SurfaceSample& sample) {
  switch (how) {
    case 1:
      sample.radius = Special(bytes.Next());
      break;
    case 2:
      sample.z = Special(bytes.Next());
      break;
    case 3:
      sample.theta = Special(bytes.Next());
      break;
    case 4:
      sample.weight = static_cast<float>(Special(bytes.Next()));
      break;
    case 5:
      sample.radius += 4.0 * bytes.Next();
      break;
    case 6:
      sample.radius -= 0.5 * bytes.Next();
      break;
    case 7:
      sample.level = bytes.Next();
      break;
    case 8:
      sample.sensor = bytes.Next();
      break;
    case 9:
      sample.sweep = bytes.Next();
      break;
    case 10:
      sample.z += 0.1 * bytes.Next();
      break;
    default:
      break;
  }
}

std::vector<SurfaceSample> ScanFrom(Bytes& bytes, FitMethod method) {
  const std::uint32_t levels = 1U + bytes.Next() % 40U;
  // The paper's method wants 22 sensors or more: its windows are 11 wide.
  const int spread = method == FitMethod::kPaper ? 3 : 1;
  const std::uint16_t sensors = static_cast<std::uint16_t>(spread * (1 + bytes.Next() % 16));
  const double pitch = bytes.Next() * 0.1;
  const double wave = bytes.Next();
  const bool repeated = bytes.Next() % 4 == 1;
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < levels; ++level) {
    for (std::uint16_t sensor = 0; sensor < sensors; ++sensor) {
      const std::uint8_t how = bytes.Next();
      if (how == 255) continue;  // a hole
      SurfaceSample sample;
      sample.theta = kTwoPi * sensor / sensors;
      sample.z = pitch * level;
      sample.radius = 100.0 + 0.2 * wave * std::sin(2.0 * sample.theta + 0.03 * sample.z) + 0.01 * how;
      sample.level = level;
      sample.sensor = sensor;
      Spoil(how, bytes, sample);
      samples.push_back(sample);
      if (repeated) samples.push_back(sample);
    }
  }
  return samples;
}

void CheckFit(const FitResult& fit) {
  const SplineSurface& surface = fit.model.main().surface;
  ENSURE(surface.coefficients().allFinite(), "coefficients are finite");
  ENSURE(std::isfinite(fit.summary.rms_mm) && std::isfinite(fit.summary.noise_sigma_mm), "the summary is finite");
  const bool trunk_only = fit.model.main().paper != nullptr;
  ENSURE(trunk_only || fit.summary.used + fit.summary.rejected.size() == fit.summary.samples,
         "every sample is accounted for");
  for (int k = 0; k <= 8; ++k) {
    const double z = surface.z_min() + (surface.z_max() - surface.z_min()) * k / 8.0;
    ENSURE(surface.Radius(0.0, z) == surface.Radius(kTwoPi, z), "the surface is closed");
    for (int i = 0; i < 32; ++i) ENSURE(std::isfinite(surface.Radius(i * kTwoPi / 32.0, z)), "radii are finite");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  FitOptions options;
  const int choice = bytes.Next() % 8;
  if (choice == 2) options.method = FitMethod::kPaper;
  if (choice == 1) {
    options.method = FitMethod::kUniform;
    options.theta_knots = 12;  // the usual 48 × 117 are too slow with sanitizers
    options.z_knots = 8;
  }
  const std::vector<SurfaceSample> samples = ScanFrom(bytes, options.method);
  const auto fit = FitSurface(samples, options, {});
  if (fit) {
    CheckFit(*fit);
  } else {
    ENSURE(fit.error().Text().find('\n') == std::string::npos, "a message is one line");
  }
  return 0;
}
