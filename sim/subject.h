#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "base/frames.h"

namespace annulus::sim {

/// Where a beam first meets the subject.
struct SubjectHit {
  double distance_mm = 0.0;                           ///< Along the ray from its origin, mm.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< Outward unit normal, station frame.
  double reflectance = 1.0;                           ///< 0 … 1; dark patches, hair and lenses return less light.
};

/// Something that stands in the booth. Reentrant.
class Subject {
 public:
  virtual ~Subject() = default;

  /// First hit of `ray` (station frame, mm) at `time_s` seconds since the scan's start (sway and breathing move the
  /// subject), at most `max_distance_mm` away. The same arguments always give the same answer.
  [[nodiscard]] virtual std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const = 0;

  /// Height of the highest point at rest, mm.
  [[nodiscard]] virtual double top_mm() const = 0;
  /// Height of the lowest point at rest, mm.
  [[nodiscard]] virtual double bottom_mm() const = 0;
  /// For records: "body", "head", or the mesh's file stem.
  [[nodiscard]] virtual std::string name() const = 0;
};

}  // namespace annulus::sim
