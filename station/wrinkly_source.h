#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/mesh/triangle_mesh.h"
#include "modeling/wrinkly/bear.h"
#include "modeling/wrinkly/control_mesh.h"
#include "station/command_io.h"

namespace annulus {

/// What a wrinkly command is to work on, as it is typed.
struct WrinklySourceOptions {
  std::string in;                             ///< A file, a net (regular:8x8 …), bear, or figure12a … figure13.
  std::string dress;                          ///< hair, knit, tortoise, carved; "": what the file has.
  std::optional<std::vector<double>> random;  ///< Heights from, to (mm), for a mesh without.
  std::optional<double> z_min, z_max;         ///< Of a knitted band, mm.
  double length_mm = 8.0;                     ///< Of hair.
  std::uint64_t seed = 1;
  bool cut = false;
  bool split = false;  ///< Polygons of an .obj into quadrilaterals.
};

/// A control mesh and what else is seen of the thing.
struct WrinklySource {
  ControlMesh mesh;
  std::vector<BearBall> balls{};
  TriangleMesh beside{};  ///< What the mesh was laid over; station frame, mm.
};

/// Reads or makes it. A MODEL.json needs a dress of hair or knit, a FRAME.json one of tortoise or carved. Fails on
/// anything else, saying what can be used.
[[nodiscard]] Result<WrinklySource> ReadWrinklySource(const WrinklySourceOptions& options, CommandIo& io);

}  // namespace annulus
