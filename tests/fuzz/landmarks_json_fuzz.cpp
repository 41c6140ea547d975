/// The reader of landmarks files. Beyond "no crash": what is accepted can be set on a surface or is refused in one
/// line, and what was set is written and read back as it was.
#include <cstdint>
#include <string_view>

#include "base/ensure.h"
#include "base/units.h"
#include "modeling/exchange/landmarks_json.h"

namespace {

using namespace annulus;

/// A cylinder of radius 100 mm from 0 to 2000 mm, all measured.
SurfaceModel Cylinder() {
  const PeriodicCubicBasis theta(8);
  const ClampedCubicBasis z(UniformBreakpoints(0.0, 2000.0, 4));
  const auto count = static_cast<Eigen::Index>(theta.count() * z.count());
  KnowledgeMap knowledge(8, 8, 0.0, 2000.0);
  for (std::size_t row = 0; row < 8; ++row) {
    for (std::size_t column = 0; column < 8; ++column) knowledge.SetCell(column, row, Knowledge::kMeasured);
  }
  SurfaceModel model;
  model.segments.push_back({"body", {theta, z, Eigen::VectorXd::Constant(count, 100.0)}, knowledge, {}, {}, {}});
  return model;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SurfaceModel model = Cylinder();
  static const MeasuredSurface body = *MeasuredSurface::FromModel(model);
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto applied = ApplyLandmarksFile(body, {}, text, "fuzz");
  if (!applied) {
    ENSURE(applied.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  const std::string written = LandmarksToJson(body, *applied);
  const auto again = ApplyLandmarksFile(body, {}, written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(LandmarksToJson(body, *again) == written, "landmarks read back as the same bytes");
  return 0;
}
