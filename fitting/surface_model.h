#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fitting/hierarchical_spline.h"
#include "fitting/spline_surface.h"
#include "fitting/systematic_errors.h"

namespace annulus {

/// How a place on the surface is known.
enum class Knowledge : std::uint8_t {
  kUnknown = 0,   ///< Too far from any accepted return: no number may be given.
  kInferred = 1,  ///< Between accepted returns: the smooth surface bridges it.
  kMeasured = 2,  ///< Accepted returns lie in or next to it.
};

/// The measured/inferred/unknown state of a regular grid of cells over (theta, z).
class KnowledgeMap {
 public:
  KnowledgeMap() = default;
  /// All unknown. Row 0 begins at z_min; column 0 is centred on theta 0. Requires columns, rows >= 1 and z_min < z_max.
  KnowledgeMap(std::size_t columns, std::size_t rows, double z_min, double z_max);

  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] double z_min() const { return z_min_; }
  [[nodiscard]] double z_max() const { return z_max_; }
  [[nodiscard]] Knowledge Cell(std::size_t column, std::size_t row) const { return cells_[row * columns_ + column]; }
  void SetCell(std::size_t column, std::size_t row, Knowledge k) { cells_[row * columns_ + column] = k; }
  /// The cell that holds (theta, z); z outside the map is unknown.
  [[nodiscard]] Knowledge At(double theta, double z) const;

 private:
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  double z_min_ = 0.0;
  double z_max_ = 0.0;
  std::vector<Knowledge> cells_;
};

/// The line about which a segment is star-shaped, station frame: a parabola over the height, since elbows and legs are
/// bent. At height z it passes through (x, y) = at + slope·d + bend·d² with d = z - z_middle. The ring's axis: all 0.
struct SegmentAxis {
  double z_middle = 0.0;                            ///< mm
  Eigen::Vector2d at = Eigen::Vector2d::Zero();     ///< mm
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< mm/mm
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();   ///< 1/mm

  [[nodiscard]] Eigen::Vector2d At(double z) const {
    const double d = z - z_middle;
    return at + d * slope + d * d * bend;
  }
  /// Whether it is the ring's own axis.
  [[nodiscard]] bool IsRingAxis() const { return at.isZero(0.0) && slope.isZero(0.0) && bend.isZero(0.0); }
};

struct PaperModel;  // fitting/paper_model.h

/// One connected piece of a body's surface.
struct SurfaceSegment {
  std::string name;       ///< "body" unless there are several.
  SplineSurface surface;  ///< Tensor form; with a hierarchy, on its finest level.
  KnowledgeMap knowledge;
  /// Upper triangle of the precision of the active coefficients (without a hierarchy: all coefficients of `surface`),
  /// 1/mm²; its inverse is their covariance (fit_uncertainty.h). May be empty.
  Eigen::SparseMatrix<double> normal_matrix;
  /// Where the surface is refined; null for a plain tensor surface. Shared by copies because it is large and immutable.
  std::shared_ptr<const HierarchicalSpline> hierarchy{};
  Eigen::VectorXd active{};  ///< The hierarchy's coefficients, mm; empty without one.
  /// The surface of `fit --method paper`, null for other fits; `surface` is then ApproximateByTensor of it, within 0.01
  /// mm but where a section runs nearly towards the axis. Shared by copies because it is large and immutable.
  std::shared_ptr<const PaperModel> paper{};
  /// The surface's theta and r are about this line; the main segment's is the ring's axis.
  SegmentAxis axis{};
  /// Sd of detail that the surface does not follow, mm: part of the uncertainty of a radius beside the covariance.
  double detail_sigma = 0.0;

  /// The point in the station frame, mm.
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;
};

/// Where a model came from. No path, host name or wall time.
struct Provenance {
  std::string recording_hash;  ///< "sha256:…" of the recording's samples; "" where unknown.
  std::string calibration_hash;
  std::string program_version;
  std::string method;      ///< "uniform", …
  std::uint64_t seed = 0;  ///< Of a simulated scan; 0 otherwise.
};

/// All that a fit knows of a body: self-sufficient input of every later step. Saved as MODEL.json.
struct SurfaceModel {
  std::vector<SurfaceSegment> segments;  ///< At least one; the first is the main one.
  double noise_sigma_mm = 0.0;           ///< Estimated sd of one return about the surface.
  Provenance provenance;
  /// Errors that the residuals of the fit cannot show; absent until a calibration or an estimate of sway says more.
  std::optional<SystematicErrors> systematic{};

  [[nodiscard]] const SurfaceSegment& main() const { return segments.front(); }
};

}  // namespace annulus
