#pragma once

#include <string>
#include <vector>

#include "modeling/landmarks/landmark.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/table/table.h"

namespace annulus {

/// What a measurement is called and how it is taken.
struct MeasurementSpec {
  std::string id;
  std::string term;
  std::string definition;
  std::string method;
  std::string unit = "mm";
  double iso20685_limit_mm = 0.0;
};

/// A measurement before its uncertainty is taken.
struct RawMeasurement {
  MeasurementSpec spec{};              ///< Given by MeasurementList::Add.
  Estimate estimate;                   ///< Moves with the surface and with the landmarks on it.
  double placing_variance = 0.0;       ///< From the placing of landmarks, unit².
  double height_share = 0.0;           ///< d(value)/d(scale of heights): the value of a height, 0 of a level girth.
  double height_offset = 0.0;          ///< d(value)/d(offset of heights): 1 of a height over the floor, else 0.
  double measured_share = 0.0;         ///< 0 … 1
  std::vector<std::string> landmarks;  ///< Ids.
  std::vector<std::vector<Eigen::Vector3d>> paths{};
};

/// Makes a measurement follow a coordinate of a landmark (its z, or its theta): `derivative` is d(value)/d(coordinate),
/// `placing` the sd of placing in the coordinate's unit.
void Follow(RawMeasurement& raw, const Estimate& coordinate, double derivative, double placing);

/// d(length)/d(scale of heights) of a line in space: Σ dz²/|edge|, mm.
[[nodiscard]] double HeightShare(const std::vector<Eigen::Vector3d>& line);

/// Collects measurements on one body; the uncertainties are taken all together at the end.
class MeasurementList {
 public:
  /// Borrows the body.
  MeasurementList(const MeasuredSurface& body, Landmarks landmarks);

  [[nodiscard]] const MeasuredSurface& body() const { return *body_; }
  /// Null if the landmark was not found.
  [[nodiscard]] const Landmark* Find(const std::string& id) const { return landmarks_.Find(id); }
  /// Landmarks::front, rad.
  [[nodiscard]] double front() const { return landmarks_.front; }
  /// Adds what was measured under the name of `spec`, or a sentence on why it is left out.
  void Add(MeasurementSpec spec, Result<RawMeasurement> raw);
  /// "TERM: WHY."
  void Omit(const std::string& term, const std::string& why);
  /// Everything with its uncertainties. Empties the list.
  [[nodiscard]] MeasurementTable Finish();

 private:
  const MeasuredSurface* body_;
  Landmarks landmarks_;
  std::vector<RawMeasurement> raw_;
  std::vector<std::string> omitted_;
};

}  // namespace annulus
