#include "modeling/wrinkly/mesh_shuffle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "modeling/wrinkly/wrinkly_surface.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

MeshShuffle ShuffleOf(const ControlMesh& mesh, int m, int k) {
  return {mesh, Shuffle::Make(m, k).value(), Shuffle::Make(m, k).value()};
}

using Cell = std::tuple<PointIndex, std::uint32_t, std::uint32_t>;

TEST(MeshShuffle, IsOneToOneOnEveryMeshWhereItCanBeCounted) {
  for (const std::string& kind : MeshKinds()) {
    const ControlMesh mesh = NetMesh(kind);
    for (const auto& [m, k] : {std::pair(1, 0), {0, 3}, {1, 1}, {1, 2}, {2, 1}, {3, 1}, {2, 2}}) {
      const MeshShuffle shuffle = ShuffleOf(mesh, m, k);
      for (const ShuffleOrder order : {ShuffleOrder::kUThenV, ShuffleOrder::kVThenU}) {
        std::set<Cell> sources;
        for (std::size_t point = 0; point < mesh.size(); ++point) {
          if (!mesh.HasPatch(static_cast<PointIndex>(point))) continue;
          for (std::uint32_t u = 0; u < shuffle.u().parts(); ++u) {
            for (std::uint32_t v = 0; v < shuffle.v().parts(); ++v) {
              const MeshPlace source = shuffle.Source({static_cast<PointIndex>(point), u, v}, order);
              sources.insert({source.patch, source.u_code, source.v_code});
            }
          }
        }
        ASSERT_EQ(sources.size(), mesh.patch_count() * shuffle.u().parts() * shuffle.v().parts()) << kind;
      }
    }
  }
}

TEST(MeshShuffle, ForwardUndoesInverseUpToThreeCrossingsAndSixIterations) {
  for (const std::string& kind : MeshKinds()) {
    const ControlMesh mesh = NetMesh(kind);
    for (int m = 1; m <= 3; ++m) {
      for (int k = 1; k <= 6; ++k) {
        const MeshShuffle shuffle = ShuffleOf(mesh, m, k);
        for (std::uint64_t n = 0; n < 200; ++n) {
          MeshPlace place;
          do {
            place.patch = static_cast<PointIndex>(ScatteredNumber(n, 0) * static_cast<double>(mesh.size()));
            ++n;
          } while (!mesh.HasPatch(place.patch));
          place.u_code = static_cast<std::uint32_t>(ScatteredNumber(n, 1) * shuffle.u().parts());
          place.v_code = static_cast<std::uint32_t>(ScatteredNumber(n, 2) * shuffle.v().parts());
          place.u_rest = 0.25;
          place.v_rest = 0.125;
          for (const ShuffleOrder order : {ShuffleOrder::kUThenV, ShuffleOrder::kVThenU}) {
            for (const MeshPlace& back : {shuffle.Destination(shuffle.Source(place, order), order),
                                          shuffle.Source(shuffle.Destination(place, order), order)}) {
              ASSERT_EQ(back.patch, place.patch) << kind;
              ASSERT_EQ(back.u_code, place.u_code) << kind;
              ASSERT_EQ(back.v_code, place.v_code) << kind;
              ASSERT_EQ(back.u_rest, 0.25) << kind;
              ASSERT_EQ(back.v_rest, 0.125) << kind;
            }
          }
        }
      }
    }
  }
}

/// How many smallest cells come from different places by the two orders.
std::size_t Differences(const ControlMesh& mesh, int k) {
  const MeshShuffle shuffle = ShuffleOf(mesh, 1, k);
  std::size_t different = 0;
  for (std::size_t point = 0; point < mesh.size(); ++point) {
    if (!mesh.HasPatch(static_cast<PointIndex>(point))) continue;
    for (std::uint32_t u = 0; u < shuffle.u().parts(); ++u) {
      for (std::uint32_t v = 0; v < shuffle.v().parts(); ++v) {
        const MeshPlace place{static_cast<PointIndex>(point), u, v, 0.3, 0.7};
        const MeshPlace a = shuffle.Source(place, ShuffleOrder::kUThenV);
        const MeshPlace b = shuffle.Source(place, ShuffleOrder::kVThenU);
        const bool same = a.patch == b.patch && a.u_code == b.u_code && a.v_code == b.v_code && a.u_rest == b.u_rest &&
                          a.v_rest == b.v_rest;
        if (!same) ++different;
      }
    }
  }
  return different;
}

TEST(MeshShuffle, OnRegularMeshesBothOrdersAgreeToTheBit) {
  for (const char* kind : {"regular:4x3", "tube:5x3", "torus:3x4", "bordered:3x2", "directions:2x2"}) {
    EXPECT_EQ(Differences(NetMesh(kind), 3), 0U) << kind;
  }
  for (const char* kind : {"directions:3x2", "directions:4x2"}) EXPECT_GT(Differences(NetMesh(kind), 2), 0U) << kind;
}

TEST(MeshShuffle, ActsOnRegularMeshesAlongEachAxisAlone) {
  // Eq. 9: U by itself and V by itself.
  const ControlMesh mesh = NetMesh("regular:4x3");
  const MeshShuffle shuffle = ShuffleOf(mesh, 1, 2);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      for (std::uint32_t u = 0; u < 9; ++u) {
        for (std::uint32_t v = 0; v < 9; ++v) {
          const MeshPlace source = shuffle.Source({row * 4 + column, u, v}, ShuffleOrder::kUThenV);
          const AxisPart along = SourcePart(shuffle.u(), {column, u}, 4, AxisKind::kOpen);
          const AxisPart across = SourcePart(shuffle.v(), {row, v}, 3, AxisKind::kOpen);
          ASSERT_EQ(source.patch, across.interval * 4 + along.interval);
          ASSERT_EQ(source.u_code, along.code);
          ASSERT_EQ(source.v_code, across.code);
        }
      }
    }
  }
}

TEST(WrinklySurface, BlendsBothOrdersAsEquationTwelve) {
  ControlMeshParts parts = RoughNet("directions:3x3");
  for (const double alpha : {0.0, 0.3, 1.0}) {
    const WrinklySurface surface = WrinklySurface::Make(ControlMesh::Make(parts).value(), {.u_then_v = alpha}).value();
    const MeshShuffle& shuffle = surface.level(3);
    for (std::uint64_t n = 0; n < 500; ++n) {
      const MeshPlace place{static_cast<PointIndex>(ScatteredNumber(n, 0) * 54),
                            static_cast<std::uint32_t>(ScatteredNumber(n, 1) * 27),
                            static_cast<std::uint32_t>(ScatteredNumber(n, 2) * 27), 0.4, 0.9};
      const auto smooth = [&](ShuffleOrder order) {
        const MeshPlace at = shuffle.Source(place, order);
        float height = 0.0F;
        surface.SmoothValues(at.patch, (at.u_code + at.u_rest) / 27, (at.v_code + at.v_rest) / 27,
                             std::span(&height, 1));
        return static_cast<double>(height);
      };
      EXPECT_NEAR(surface.Height(place, 3, 3.0),
                  alpha * smooth(ShuffleOrder::kUThenV) + (1.0 - alpha) * smooth(ShuffleOrder::kVThenU), 1e-6);
    }
  }
}

TEST(WrinklySurface, MovesContinuouslyBetweenIterations) {
  const WrinklySurface surface = WrinklySurface::Make(ControlMesh::Make(RoughNet("torus:8x8")).value(), {}).value();
  for (std::uint64_t n = 0; n < 200; ++n) {
    const MeshPlace place{static_cast<PointIndex>(ScatteredNumber(n, 0) * 64),
                          static_cast<std::uint32_t>(ScatteredNumber(n, 1) * 243),
                          static_cast<std::uint32_t>(ScatteredNumber(n, 2) * 243)};
    const double two = surface.Height(place, 5, 2.0);
    const double three = surface.Height(place, 5, 3.0);
    EXPECT_NEAR(surface.Height(place, 5, 2.25), 0.75 * two + 0.25 * three, 1e-6);
  }
}

TEST(WrinklySurface, KeepsTheDistributionOfHeights) {
  // One-to-one: as many places of every height at every K. Means over all cells are the same to rounding.
  const WrinklySurface surface = WrinklySurface::Make(ControlMesh::Make(RoughNet("torus:6x5")).value(), {}).value();
  const auto moments = [&](int iterations) {
    const int depth = 3;
    double mean = 0.0;
    double square = 0.0;
    const std::uint32_t parts = surface.level(depth).u().parts();
    for (PointIndex patch = 0; patch < 30; ++patch) {
      for (std::uint32_t u = 0; u < parts; ++u) {
        for (std::uint32_t v = 0; v < parts; ++v) {
          const double h = surface.Height({patch, u, v}, depth, iterations);
          mean += h;
          square += h * h;
        }
      }
    }
    return std::pair(mean / (30.0 * parts * parts), square / (30.0 * parts * parts));
  };
  const auto smooth = moments(0);
  for (const int k : {1, 2, 3}) {
    EXPECT_NEAR(moments(k).first, smooth.first, 1e-7);
    EXPECT_NEAR(moments(k).second, smooth.second, 1e-7);
  }
}

TEST(WrinklySurface, RefusesWhatItCannotMake) {
  const auto make = [](const WrinklyOptions& options) { return WrinklySurface::Make(NetMesh("regular:3x3"), options); };
  EXPECT_FALSE(make({.u_then_v = 1.5}));
  EXPECT_FALSE(make({.crossing_u = -1}));
  EXPECT_FALSE(make({.structure = {1, 2, 5000}}));
  EXPECT_EQ(make({.structure = {1, 2, 1}})->most_iterations(), 3);
  EXPECT_EQ(make({})->most_iterations(), 19);
}

}  // namespace
}  // namespace annulus
