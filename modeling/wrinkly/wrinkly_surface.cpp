#include "modeling/wrinkly/wrinkly_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

constexpr std::size_t kNetSize = 9;

/// Products of the quadratic Bernstein polynomials, as a net is laid out.
std::array<float, kNetSize> NetWeights(double u, double v) {
  const std::array<double, 3> a{(1.0 - u) * (1.0 - u), 2.0 * u * (1.0 - u), u * u};
  const std::array<double, 3> b{(1.0 - v) * (1.0 - v), 2.0 * v * (1.0 - v), v * v};
  std::array<float, kNetSize> weights{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) weights[3 * i + j] = static_cast<float>(a[i] * b[j]);
  }
  return weights;
}

bool SamePlace(const MeshPlace& a, const MeshPlace& b) {
  return a.patch == b.patch && a.u_code == b.u_code && a.v_code == b.v_code && a.u_rest == b.u_rest &&
         a.v_rest == b.v_rest;
}

/// One coordinate of a place on a grid of `from` parts, on one of `to` parts; one is a multiple of the other.
void Regrid(std::uint32_t& code, double& rest, std::uint32_t from, std::uint32_t to) {
  if (to < from) {
    const std::uint32_t finer = from / to;
    rest = (code % finer + rest) / finer;
    code /= finer;
  } else if (to > from) {
    const std::uint32_t finer = to / from;
    const double at = rest * finer;
    const auto part = std::min(static_cast<std::uint32_t>(at), finer - 1);
    code = code * finer + part;
    rest = at - part;
  }
}

MeshPlace OnGrid(MeshPlace place, const MeshShuffle& from, const MeshShuffle& to) {
  Regrid(place.u_code, place.u_rest, from.u().parts(), to.u().parts());
  Regrid(place.v_code, place.v_rest, from.v().parts(), to.v().parts());
  return place;
}

/// The transformations of 0, 1, … iterations of these crossings, as far as they can be made and at most `most`.
Result<std::vector<MeshShuffle>> LevelsOf(const ControlMesh& mesh, const WrinklyOptions& options) {
  std::vector<MeshShuffle> levels;
  const std::size_t most =
      options.structure.empty() ? static_cast<std::size_t>(Shuffle::kMostIterations) : options.structure.size();
  for (std::size_t k = 0; k <= most; ++k) {
    std::vector<int> u(k, options.crossing_u);
    std::vector<int> v(k, options.crossing_v);
    if (!options.structure.empty()) {
      u.assign(options.structure.begin(), options.structure.begin() + static_cast<std::ptrdiff_t>(k));
      v = u;
    }
    auto along_u = Shuffle::Make(std::move(u));
    auto along_v = Shuffle::Make(std::move(v));
    if (!along_u || !along_v) {
      // Deeper ones than can be counted are not needed, unless they were asked for or not even one can be made.
      if (options.structure.empty() && k > 1) break;
      return along_u ? Fail(along_v) : Fail(along_u);
    }
    levels.emplace_back(mesh, std::move(*along_u), std::move(*along_v));
  }
  return levels;
}

}  // namespace

Result<WrinklySurface> WrinklySurface::Make(ControlMesh mesh, const WrinklyOptions& options) {
  if (!(options.u_then_v >= 0.0 && options.u_then_v <= 1.0)) {
    return Fail("make a wrinkly surface", fmt::format("the share of the order U, V is {}", options.u_then_v),
                "use 0 to 1");
  }
  auto kept = std::make_unique<const ControlMesh>(std::move(mesh));
  auto base = BaseSurface::Make(*kept, options.join);
  if (!base) return Fail(base);
  auto levels = LevelsOf(*kept, options);
  if (!levels) return Fail(levels);
  WrinklySurface surface(std::move(kept), std::move(*base));
  surface.levels_ = std::move(*levels);
  surface.u_then_v_ = options.u_then_v;
  surface.blend_ = options.blend;
  surface.FillNets();
  return surface;
}

void WrinklySurface::FillNets() {
  const ControlMeshParts& parts = mesh_->parts();
  const std::size_t count = parts.attributes.size();
  nets_.assign(parts.points.size() * count * kNetSize, 0.0F);
  for (std::size_t k = 0; k < parts.points.size(); ++k) {
    if (parts.points[k].temporary) continue;
    const PatchNet shares = ValueNetOf(*mesh_, static_cast<PointIndex>(k));
    for (std::size_t at = 0; at < kNetSize; ++at) {
      for (std::size_t attribute = 0; attribute < count; ++attribute) {
        double value = 0.0;
        for (const PointShare& share : shares[at / 3][at % 3]) {
          value += share.weight * parts.values(share.point, static_cast<Eigen::Index>(attribute));
        }
        nets_[(k * count + attribute) * kNetSize + at] = static_cast<float>(value);
        if (attribute > 0) continue;
        lowest_height_ = std::min(lowest_height_, value);
        highest_height_ = std::max(highest_height_, value);
      }
    }
  }
}

std::optional<std::size_t> WrinklySurface::AttributeNamed(std::string_view name) const {
  const auto& names = mesh_->parts().attributes;
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<std::size_t>(at - names.begin());
}

void WrinklySurface::Values(const MeshPlace& place, int depth, double iterations, std::span<float> values) const {
  std::fill(values.begin(), values.end(), 0.0F);
  const int whole = static_cast<int>(std::floor(iterations));
  const double part = iterations - whole;
  const auto add = [&](int k, double weight) {
    if (weight > 0.0) AddLevel(place, depth, std::clamp(k, 0, most_iterations()), weight, values);
  };
  if (blend_ == LevelBlend::kTwo) {
    add(whole, 1.0 - part);
    add(whole + 1, part);
    return;
  }
  add(whole - 1, 0.25 * (1.0 - part));
  add(whole, 0.25 * (2.0 - part));
  add(whole + 1, 0.25 * (1.0 + part));
  add(whole + 2, 0.25 * part);
}

double WrinklySurface::Height(const MeshPlace& place, int depth, double iterations) const {
  float height = 0.0F;
  Values(place, depth, iterations, std::span(&height, 1));
  return height;
}

void WrinklySurface::SmoothValues(PointIndex patch, double u, double v, std::span<float> values) const {
  std::fill(values.begin(), values.end(), 0.0F);
  AddSmooth({patch, 0, 0, u, v}, level(0), 1.0, values);
}

void WrinklySurface::AddLevel(const MeshPlace& place, int depth, int iterations, double weight,
                              std::span<float> values) const {
  const MeshShuffle& shuffle = level(iterations);
  const MeshPlace at = OnGrid(place, level(depth), shuffle);
  const MeshPlace first = shuffle.Source(at, ShuffleOrder::kUThenV);
  const MeshPlace second = shuffle.Source(at, ShuffleOrder::kVThenU);
  if (SamePlace(first, second)) return AddSmooth(first, shuffle, weight, values);
  AddSmooth(first, shuffle, weight * u_then_v_, values);
  AddSmooth(second, shuffle, weight * (1.0 - u_then_v_), values);
}

void WrinklySurface::AddSmooth(const MeshPlace& place, const MeshShuffle& shuffle, double weight,
                               std::span<float> values) const {
  const auto weights = NetWeights((place.u_code + place.u_rest) / shuffle.u().parts(),
                                  (place.v_code + place.v_rest) / shuffle.v().parts());
  const float* net = nets_.data() + ControlMesh::Index(place.patch) * attribute_count() * kNetSize;
  for (float& value : values) {
    float sum = 0.0F;
    for (std::size_t k = 0; k < kNetSize; ++k) sum += weights[k] * net[k];
    value += static_cast<float>(weight) * sum;
    net += kNetSize;
  }
}

}  // namespace annulus
