#include "modeling/wrinkly/sample_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/bands.h"
#include "modeling/wrinkly/cell_choice.h"
#include "modeling/wrinkly/cell_trees.h"
#include "modeling/wrinkly/patch_grid.h"

namespace annulus {
namespace {

constexpr const char* kAttempt = "sample the wrinkly surface";
/// Vertices that one thread evaluates at a time.
constexpr std::size_t kChunk = 8192;

/// Where a vertex is, and how its values are made. Packed: there are half as many as triangles.
struct VertexSource {
  PointIndex patch = 0;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  float iterations = 0.0F;
  std::int8_t depth = 0;
  std::uint8_t halves_a = 1;  ///< Of the cell, 0 … 2: its − side, middle or + side.
  std::uint8_t halves_b = 1;

  [[nodiscard]] GridCell cell() const { return {patch, depth, a, b}; }
};

struct KeyHash {
  std::size_t operator()(const CornerKey& key) const {
    std::uint64_t x = key.what * 0x9e3779b97f4a7c15ULL ^ key.where;
    x = (x ^ (x >> 32U)) * 0xd6e8feb86659fd93ULL;
    return x ^ (x >> 32U);
  }
};

/// Turns the kept cells into triangles over shared vertices.
class FanMaker {
 public:
  FanMaker(const PatchGrid& grid, const CellTrees& trees, WrinklyMesh& mesh)
      : grid_(grid), trees_(trees), mesh_(mesh) {}

  void Add(const GridCell& cell, const CellChoice& choice) {
    ++mesh_.cells;
    iterations_ = choice.iterations;
    ring_.clear();
    const auto& parts = grid_.Parts(cell.depth);
    const auto& finest = grid_.Parts(grid_.finest());
    const std::uint32_t step_a = finest[0] / parts[0];
    const std::uint32_t step_b = finest[1] / parts[1];
    for (std::size_t side = 0; side < 4; ++side) {
      // A side begins where the one before it ends.
      AddCorner(cell.patch, (cell.a + (side == 0 || side == 1 ? 1U : 0U)) * step_a,
                (cell.b + (side == 1 || side == 2 ? 1U : 0U)) * step_b);
      AddFiner(grid_.Across(cell, side));
    }
    const auto middle = static_cast<std::uint32_t>(sources_.size());
    sources_.push_back({cell.patch, cell.a, cell.b, iterations_, static_cast<std::int8_t>(cell.depth), 1, 1});
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const std::uint32_t from = ring_[k];
      const std::uint32_t to = ring_[(k + 1) % ring_.size()];
      if (from != to) mesh_.faces.push_back({middle, from, to});
    }
  }

  [[nodiscard]] const std::vector<VertexSource>& sources() const { return sources_; }
  void Reserve(std::size_t cells) {
    numbers_.reserve(cells + cells / 8);
    sources_.reserve(2 * cells + cells / 4);
    mesh_.faces.reserve(4 * cells + cells / 4);
  }

 private:
  /// The corners of smaller cells across a side: over there they run the other way round.
  void AddFiner(const CellSide& across) {
    if (across.side > 3) return;
    finer_.clear();
    trees_.AddCornersAlong(across, grid_.finest(), finer_);
    for (auto corner = finer_.rbegin(); corner != finer_.rend(); ++corner) {
      AddCorner(across.cell.patch, (*corner)[0], (*corner)[1]);
    }
  }

  void AddCorner(PointIndex patch, std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] =
        numbers_.try_emplace(grid_.KeyOf(patch, a, b), static_cast<std::uint32_t>(sources_.size()));
    if (is_new) {
      const auto& finest = grid_.Parts(grid_.finest());
      VertexSource source{patch, a, b, iterations_, static_cast<std::int8_t>(grid_.finest()), 0, 0};
      if (a == finest[0]) {
        --source.a;
        source.halves_a = 2;
      }
      if (b == finest[1]) {
        --source.b;
        source.halves_b = 2;
      }
      sources_.push_back(source);
    }
    ring_.push_back(at->second);
  }

  const PatchGrid& grid_;
  const CellTrees& trees_;
  WrinklyMesh& mesh_;
  float iterations_ = 0.0F;
  std::unordered_map<CornerKey, std::uint32_t, KeyHash> numbers_;
  std::vector<VertexSource> sources_;
  std::vector<std::uint32_t> ring_;
  std::vector<std::array<std::uint32_t, 2>> finer_;
};

/// Positions and values of all vertices (eq. 15).
void Evaluate(const PatchGrid& grid, const std::vector<VertexSource>& sources, int threads, WrinklyMesh& mesh) {
  const WrinklySurface& surface = grid.surface();
  const std::size_t attributes = surface.attribute_count();
  mesh.positions.resize(sources.size());
  mesh.values.resize(sources.size() * attributes);
  const auto chunks = static_cast<int>((sources.size() + kChunk - 1) / kChunk);
  ForEachBand(chunks, threads, {}, [&](int chunk) {
    const std::size_t from = static_cast<std::size_t>(chunk) * kChunk;
    for (std::size_t k = from; k < std::min(from + kChunk, sources.size()); ++k) {
      const VertexSource& source = sources[k];
      const std::span<float> values(mesh.values.data() + k * attributes, attributes);
      const GridCell cell = source.cell();
      const double in_a = 0.5 * source.halves_a;
      const double in_b = 0.5 * source.halves_b;
      surface.Values(grid.PlaceOf(cell, in_a, in_b), cell.depth, source.iterations, values);
      const auto uv = grid.Parameters(cell, in_a, in_b);
      const PatchPoint at = surface.base().At(cell.patch, uv[0], uv[1]);
      mesh.positions[k] = (at.point + double{values[0]} * surface.base().NormalAt(cell.patch, at)).cast<float>();
    }
  });
}

void ComputeNormals(WrinklyMesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f& corner = mesh.positions[face[0]];
    const Eigen::Vector3f normal = (mesh.positions[face[1]] - corner).cross(mesh.positions[face[2]] - corner);
    for (const std::uint32_t vertex : face) mesh.normals[vertex] += normal;
  }
  for (Eigen::Vector3f& normal : mesh.normals) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
}

Status Check(const WrinklySurface& surface, const SamplingOptions& options) {
  const auto refuse = [](std::string seen, const char* advice) { return Fail(kAttempt, std::move(seen), advice); };
  const double iterations = options.iterations.value_or(0.0);
  if (!(iterations >= 0.0 && iterations <= surface.most_iterations())) {
    return Fail(kAttempt, fmt::format("{} iterations are asked for", iterations),
                fmt::format("use 0 to {}", surface.most_iterations()));
  }
  const int most = PatchGrid::MostDepth(surface);
  if (options.depth && (*options.depth < std::ceil(iterations) || *options.depth > most)) {
    return Fail(kAttempt, fmt::format("a depth of {} is asked for", *options.depth),
                fmt::format("use {} to {}", std::ceil(iterations), most));
  }
  if (std::ceil(iterations) > most) {
    return refuse(fmt::format("{} iterations are asked for", iterations), "use fewer");
  }
  if (!options.view) return {};
  const ScreenView& view = *options.view;
  const bool camera = view.width > 0 && view.height > 0 && view.half_height > 0.0 && view.near_mm > 0.0 &&
                      view.camera_from_station.allFinite() && view.eye_in_station.allFinite();
  if (!camera) return refuse("the camera is not one", "give a size, a field of view and a near limit over 0");
  if (!(options.triangle_px > 0.0)) return refuse("the size of triangles is not over 0", "give it in pixels");
  return {};
}

}  // namespace

Result<WrinklyMesh> SampleSurface(const WrinklySurface& surface, const SamplingOptions& options,
                                  const TaskContext& task) {
  RETURN_IF_ERROR(Check(surface, options));
  const int threads = ThreadCount(options.threads);
  const double iterations = options.iterations.value_or(0.0);
  const int even = options.depth.value_or(static_cast<int>(std::ceil(iterations)));
  const PatchGrid every(surface, options.view ? PatchGrid::MostDepth(surface) : even);
  task.Report("choose cells", 0, 3);
  const CellTrees trees(every, options.view ? CellsOnScreen(every, options) : EvenCells(iterations, even),
                        options.most_cells, threads, task.stop);
  const auto stopped = [] { return Fail(kAttempt, "it was stopped", "start it again"); };
  if (task.stop.stop_requested()) return stopped();
  if (trees.too_many()) {
    return Fail(
        kAttempt, fmt::format("it takes more than {} cells", options.most_cells),
        "use fewer iterations, larger triangles, a smaller picture or less zoom: high spikes beside it reach into it");
  }
  WrinklyMesh mesh;
  mesh.deepest = trees.deepest();
  mesh.shallowest = trees.shallowest();
  const PatchGrid grid(surface, mesh.deepest);
  FanMaker fans(grid, trees, mesh);
  fans.Reserve(trees.kept());
  task.Report("join cells", 1, 3);
  for (std::size_t k = 0; k < surface.mesh().size(); ++k) {
    if (task.stop.stop_requested()) return stopped();
    trees.ForEachKept(static_cast<PointIndex>(k),
                      [&](const GridCell& cell, const CellChoice& choice) { fans.Add(cell, choice); });
  }
  task.Report("evaluate the surface", 2, 3);
  Evaluate(grid, fans.sources(), threads, mesh);
  ComputeNormals(mesh);
  task.Report("evaluate the surface", 3, 3);
  return mesh;
}

}  // namespace annulus
