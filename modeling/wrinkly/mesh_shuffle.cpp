#include "modeling/wrinkly/mesh_shuffle.h"

namespace annulus {
namespace {

/// A patch's interval of its axis.
struct OnAxis {
  const GlobalAxis& axis;
  std::int32_t index;

  OnAxis(const ControlMesh& mesh, PointIndex patch, AxisFamily family)
      : axis(mesh.axes()[static_cast<std::size_t>(mesh.IntervalOf(patch, family).axis)]),
        index(mesh.IntervalOf(patch, family).index) {}
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(axis.points.size()); }
};

AxisPart SourceOn(const OnAxis& on, const Shuffle& shuffle, std::uint32_t code) {
  return SourcePart(shuffle, {on.index, code}, on.count(), on.axis.kind);
}

AxisPart DestinationOn(const OnAxis& on, const Shuffle& shuffle, std::uint32_t code) {
  return DestinationPart(shuffle, {on.index, code}, on.count(), on.axis.kind);
}

void TurnRound(std::uint32_t& code, double& rest, std::uint32_t parts) {
  code = parts - 1 - code;
  rest = 1.0 - rest;
}

}  // namespace

void MeshShuffle::AlongU(MeshPlace& place, const AxisPart& part) const {
  const auto axis = static_cast<std::size_t>(mesh_->IntervalOf(place.patch, AxisFamily::kU).axis);
  const PointIndex patch = mesh_->axes()[axis].points[static_cast<std::size_t>(part.interval)];
  place.u_code = part.code;
  if (part.mirrored) place.u_rest = 1.0 - place.u_rest;
  if (mesh_->IsRightHanded(patch) != mesh_->IsRightHanded(place.patch)) {
    TurnRound(place.v_code, place.v_rest, v_.parts());
  }
  place.patch = patch;
}

void MeshShuffle::AlongV(MeshPlace& place, const AxisPart& part) const {
  const auto axis = static_cast<std::size_t>(mesh_->IntervalOf(place.patch, AxisFamily::kV).axis);
  const PointIndex patch = mesh_->axes()[axis].points[static_cast<std::size_t>(part.interval)];
  place.v_code = part.code;
  if (part.mirrored) place.v_rest = 1.0 - place.v_rest;
  if (mesh_->IsRightHanded(patch) != mesh_->IsRightHanded(place.patch)) {
    TurnRound(place.u_code, place.u_rest, u_.parts());
  }
  place.patch = patch;
}

MeshPlace MeshShuffle::Source(const MeshPlace& destination, ShuffleOrder order) const {
  MeshPlace place = destination;
  const auto undo_u = [&] { AlongU(place, SourceOn({*mesh_, place.patch, AxisFamily::kU}, u_, place.u_code)); };
  const auto undo_v = [&] { AlongV(place, SourceOn({*mesh_, place.patch, AxisFamily::kV}, v_, place.v_code)); };
  if (order == ShuffleOrder::kUThenV) {
    undo_v();
    undo_u();
  } else {
    undo_u();
    undo_v();
  }
  return place;
}

MeshPlace MeshShuffle::Destination(const MeshPlace& source, ShuffleOrder order) const {
  MeshPlace place = source;
  const auto do_u = [&] { AlongU(place, DestinationOn({*mesh_, place.patch, AxisFamily::kU}, u_, place.u_code)); };
  const auto do_v = [&] { AlongV(place, DestinationOn({*mesh_, place.patch, AxisFamily::kV}, v_, place.v_code)); };
  if (order == ShuffleOrder::kUThenV) {
    do_u();
    do_v();
  } else {
    do_v();
    do_u();
  }
  return place;
}

}  // namespace annulus
