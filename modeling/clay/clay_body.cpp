#include "modeling/clay/clay_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/ensure.h"
#include "modeling/clay/patch_volume.h"

namespace annulus {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

namespace {

/// Of the volume: what a deformation may leave, and what Newton is asked for.
constexpr double kVolumeTolerance = 1e-14;
constexpr int kCorrections = 3;

constexpr const char* kAttempted = "deform the clay";

Eigen::AlignedBox3d BoxOf(const ControlNet& net) {
  Eigen::AlignedBox3d box;
  for (const auto& row : net) {
    for (const Vector3d& point : row) box.extend(point);
  }
  return box;
}

double MedianSize(const ClayMesh& mesh) {
  std::vector<double> sizes;
  for (const ClayPatch& patch : mesh.patches()) {
    if (patch.node != kNoIndex) sizes.push_back(BoxOf(patch.net).sizes().maxCoeff());
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

bool Finite(const std::vector<GroupMotion>& motions) {
  return std::all_of(motions.begin(), motions.end(),
                     [](const GroupMotion& motion) { return motion.move.allFinite() && motion.gradient.allFinite(); });
}

}  // namespace

Result<ClayBody> ClayBody::Make(const PatchShell& shell) {
  auto mesh = ClayMesh::Make(shell);
  if (!mesh) return Fail(mesh);
  return Make(std::move(*mesh));
}

Result<ClayBody> ClayBody::Make(ClayMesh mesh) {
  ClayBody body;
  body.mesh_ = std::move(mesh);
  Eigen::AlignedBox3d box;
  for (const ClayPatch& patch : body.mesh_.patches()) {
    if (patch.node != kNoIndex) box.extend(patch.net[0][0]).extend(patch.net[3][3]);
  }
  body.apex_ = box.center();
  const double size = MedianSize(body.mesh_);
  if (!(size > 0.0)) return Fail("make a body of clay", "its patches have no size", "give a body with a skin");
  body.embedding_ = Embedding(size);
  for (PatchIndex index = 0; index < body.mesh_.patches().size(); ++index) {
    if (body.mesh_.alive(index)) body.Renew(index);
  }
  body.changed_.clear();
  body.kept_ = body.volume();
  if (!(body.kept_ > 0.0)) {
    return Fail("make a body of clay", fmt::format("its volume is {:.6g} mm3", body.kept_),
                "give patches of which S_u x S_v points out of the body");
  }
  return body;
}

double ClayBody::Area() const {
  double area = 0.0;
  for (const ClayPatch& patch : mesh_.patches()) area += patch.node == kNoIndex ? 0.0 : PatchArea(patch.net);
  return area;
}

Vector3d ClayBody::Point(const ClayAddress& address) const {
  const ClayMesh::Leaf leaf = mesh_.Locate(address);
  ENSURE(leaf.patch != kNoIndex, "an address is on the skin");
  return BezierPatch(mesh_.patch(leaf.patch).net).Point(leaf.u, leaf.v);
}

Vector3d ClayBody::Normal(const ClayAddress& address) const {
  const ClayMesh::Leaf leaf = mesh_.Locate(address);
  ENSURE(leaf.patch != kNoIndex, "an address is on the skin");
  return BezierPatch(mesh_.patch(leaf.patch).net).Normal(leaf.u, leaf.v);
}

void ClayBody::Renew(PatchIndex index) {
  const ControlNet& net = mesh_.patch(index).net;
  cones_.Set(index, ConeVolume(net, apex_));
  embedding_.Place(mesh_, index);
  changed_.push_back(index);
  Note(index);
}

void ClayBody::Note(PatchIndex index) {
  // Who has not asked for so long may as well look at all of it.
  static constexpr std::size_t kMost = 100'000;
  if (log_.size() >= kMost) Forget();
  log_.push_back(index);
}

void ClayBody::Forget() {
  first_change_ += log_.size() + 1;
  log_.clear();
}

std::optional<std::vector<PatchIndex>> ClayBody::LeavesSince(std::size_t count) const {
  if (count < first_change_) return std::nullopt;
  return std::vector<PatchIndex>(log_.begin() + static_cast<std::ptrdiff_t>(count - first_change_), log_.end());
}

Cubic ClayBody::VolumeWith(const ClayTrial& trial) const {
  Cubic all = trial.VolumeAlong(apex_);
  double rest = volume();
  for (const PatchIndex index : trial.touched()) rest -= cones_.Get(index);
  all.c[0] += rest;
  return all;
}

Result<ClayBody::Solution> ClayBody::Solve(const ClayTrial& trial) {
  Cubic excess = VolumeWith(trial);
  excess.c[0] -= kept_;
  const std::vector<double> roots = RealRoots(excess);
  if (roots.empty()) {
    return Fail(
        kAttempted,
        fmt::format("nothing takes up {:.6g} mm3: no amount of the indirect motion keeps the volume", -excess.c[0]),
        "make the operation smaller, or its indirect region larger");
  }
  std::string trouble;
  for (const double root : roots) {
    std::string seen = embedding_.Trouble(mesh_, marks_, trial, root);
    if (seen.empty()) return Solution{root, excess.Slope(root)};
    if (trouble.empty()) trouble = std::move(seen);
  }
  return Fail(kAttempted, trouble, "make the operation smaller, or act in several steps");
}

void ClayBody::Commit(const ClayTrial& trial, double k) {
  std::vector<PatchIndex> touched = trial.touched();
  for (std::size_t n = 0; n < touched.size(); ++n) mesh_.SetNet(touched[n], trial.NetAt(n, k));
  // Slaved once more, from what was rounded; coarser leaves first.
  std::stable_sort(touched.begin(), touched.end(),
                   [this](PatchIndex a, PatchIndex b) { return mesh_.patch(a).rank < mesh_.patch(b).rank; });
  const auto net_of = [this](PatchIndex index) -> const ControlNet& { return mesh_.patch(index).net; };
  for (const PatchIndex index : touched) {
    ControlNet net = mesh_.patch(index).net;
    mesh_.PullSlaves(index, net_of, net);
    mesh_.SetNet(index, net);
    Renew(index);
  }
}

Result<ClayChange> ClayBody::Deform(const ClayDeformation& deformation, VolumeRule rule) {
  if (!Finite(deformation.direct) || !Finite(deformation.indirect)) {
    return Fail(kAttempted, "a motion is not a finite number", "correct the operation's parameters");
  }
  ClayChange change;
  change.volume_before_mm3 = volume();
  const ClayDeformation direct{deformation.direct, {}};
  const ClayTrial trial(mesh_, marks_, rule == VolumeRule::kKept ? deformation : direct);
  double slope = 0.0;
  if (rule == VolumeRule::kKept) {
    const auto solution = Solve(trial);
    if (!solution) return Fail(solution);
    change.k = solution->k;
    slope = solution->slope;
  } else if (std::string trouble = embedding_.Trouble(mesh_, marks_, trial, 0.0); !trouble.empty()) {
    return Fail(kAttempted, std::move(trouble), "make the operation smaller, or act in several steps");
  } else if (!(VolumeWith(trial).At(0.0) > 0.0)) {
    return Fail(kAttempted, "nothing would be left of the body", "make the operation smaller");
  }
  Commit(trial, change.k);
  if (rule == VolumeRule::kKept) {
    for (int i = 0; i < kCorrections && std::abs(volume() - kept_) > kVolumeTolerance * kept_; ++i) {
      change.k -= (volume() - kept_) / slope;
      Commit(trial, change.k);
    }
  } else if (rule == VolumeRule::kFreed) {
    kept_ = volume();
  }
  change.volume_after_mm3 = volume();
  change.patches_touched = trial.touched().size();
  return change;
}

void ClayBody::Keep(double volume) {
  ENSURE(volume > 0.0, "a body has a volume");
  kept_ = volume;
}

double ClayBody::ScaleToKept(const Vector3d& centre) {
  ENSURE(volume() > 0.0, "a body has a volume");
  const double scale = std::cbrt(kept_ / volume());
  // About the apex, whose cones scale as a whole; then all of it moves, cones and apex, to where `centre` stays.
  const Vector3d shift = (1.0 - scale) * (centre - apex_);
  for (PatchIndex index = 0; index < mesh_.patches().size(); ++index) {
    if (!mesh_.alive(index)) continue;
    ControlNet net = mesh_.patch(index).net;
    for (auto& row : net) {
      for (Vector3d& point : row) point = apex_ + scale * (point - apex_) + shift;
    }
    mesh_.SetNet(index, net);
  }
  embedding_.Move(scale, apex_ - scale * apex_ + shift);
  apex_ += shift;
  cones_.Scale(scale * scale * scale);
  Forget();
  return scale - 1.0;
}

void ClayBody::Follow(const LeafChange& change) {
  for (const PatchIndex index : change.gone) {
    cones_.Set(index, 0.0);
    Note(index);
  }
  for (const PatchIndex index : change.made) {
    if (mesh_.alive(index)) Renew(index);
  }
}

std::vector<PatchIndex> ClayBody::Split(PatchIndex index) {
  LeafChange change = mesh_.Split(index);
  Follow(change);
  return std::move(change.made);
}

Status ClayBody::OpenHole(const ClayMesh::Hole& hole) {
  const auto change = mesh_.OpenHole(hole);
  if (!change) return Fail(change);
  Follow(*change);
  std::string trouble = embedding_.TroubleOf(mesh_, change->made);
  if (trouble.empty()) return {};
  return Fail("make a hole through the clay", std::move(trouble), "hold the tool in another direction");
}

void ClayBody::MergeAroundHole(std::size_t hole) {
  const std::uint32_t first = mesh_.FirstWall(hole);
  const std::uint32_t end = first + 4 * mesh_.holes()[hole].segments;
  Eigen::AlignedBox3d above;
  Eigen::AlignedBox3d below;
  for (std::uint32_t e = 0; e < 4; ++e) {
    above.extend(Point({first + e, 0.0, 0.0}));
    below.extend(Point({end - 4 + e, 0.0, 1.0}));
  }
  const std::uint32_t rank = mesh_.patch(mesh_.Locate({first, 0.0, 0.0}).patch).rank -
                             mesh_.patch(mesh_.Locate({first, 0.0, 0.0}).patch).level;
  const auto in_the_way = [&](const ClayPatch& leaf) {
    if (leaf.base >= first && leaf.base < end) return leaf.level > 0;
    const Eigen::AlignedBox3d box = BoxOf(leaf.net);
    return leaf.rank > rank + 1 && (box.squaredExteriorDistance(above.center()) < above.diagonal().squaredNorm() ||
                                    box.squaredExteriorDistance(below.center()) < below.diagonal().squaredNorm());
  };
  for (bool merged = true; merged;) {
    merged = false;
    for (PatchIndex index = 0; index < mesh_.patches().size(); ++index) {
      if (!mesh_.alive(index) || !in_the_way(mesh_.patch(index))) continue;
      const LeafChange change = mesh_.Merge(index, std::numeric_limits<double>::infinity());
      merged = merged || !change.made.empty();
      Follow(change);
    }
  }
}

Status ClayBody::FillHole(std::size_t hole) {
  MergeAroundHole(hole);
  const auto change = mesh_.FillHole(hole);
  if (!change) return Fail(change);
  Follow(*change);
  std::string trouble = embedding_.TroubleOf(mesh_, change->made);
  if (trouble.empty()) return {};
  return Fail("fill a hole through the clay", std::move(trouble), "go back in the history to before it was made");
}

std::vector<PatchIndex> ClayBody::FirstQuartersOf(const std::vector<PatchIndex>& leaves) const {
  std::vector<PatchIndex> first;
  for (const PatchIndex index : leaves) {
    const PatchIndex quarter = mesh_.alive(index) ? mesh_.FirstQuarter(index) : kNoIndex;
    if (quarter != kNoIndex) first.push_back(quarter);
  }
  std::sort(first.begin(), first.end());
  first.erase(std::unique(first.begin(), first.end()), first.end());
  return first;
}

std::vector<ClayBody::FormerLeaf> ClayBody::Coarsen(const std::vector<PatchIndex>& leaves, double size,
                                                    double tolerance) {
  std::vector<FormerLeaf> former;
  const auto remember = [&](PatchIndex index) {
    const ClayPatch& leaf = mesh_.patch(index);
    former.push_back({{leaf.base, leaf.level, leaf.column, leaf.row}, leaf.net});
  };
  std::vector<PatchIndex> open = FirstQuartersOf(leaves);
  for (std::size_t n = 0; n < open.size(); ++n) {
    const PatchIndex first = mesh_.alive(open[n]) ? mesh_.FirstQuarter(open[n]) : kNoIndex;
    if (first == kNoIndex || !mesh_.Merges(first, tolerance)) continue;
    const std::array<PatchIndex, 4> quarters = mesh_.QuartersWith(first);
    Eigen::AlignedBox3d box;
    for (const PatchIndex quarter : quarters) box.extend(BoxOf(mesh_.patch(quarter).net));
    if (box.sizes().maxCoeff() > size) continue;
    for (const PatchIndex quarter : quarters) {
      remember(quarter);
      // Leaves next to the whole will be finer than it, and slaved to it.
      for (const ClayJoin& join : mesh_.patch(quarter).join) {
        if (join.kind == ClayJoin::Kind::kEqual) remember(join.patch[0]);
      }
    }
    const LeafChange change = mesh_.Merge(first, tolerance);
    Follow(change);
    open.push_back(change.made.front());
  }
  return former;
}

void ClayBody::Restore(const std::vector<FormerLeaf>& former) {
  const auto leaf_at = [this](const ClayMesh::Part& part) {
    const double share = 1.0 / static_cast<double>(1U << part.level);
    return mesh_.Locate({part.base, (part.column + 0.5) * share, (part.row + 0.5) * share}).patch;
  };
  for (const FormerLeaf& leaf : former) {
    while (mesh_.patch(leaf_at(leaf.part)).level < leaf.part.level) Split(leaf_at(leaf.part));
  }
  // What was remembered first is what was there.
  for (auto leaf = former.rbegin(); leaf != former.rend(); ++leaf) {
    const PatchIndex index = leaf_at(leaf->part);
    mesh_.SetNet(index, leaf->net);
    Renew(index);
  }
}

std::size_t ClayBody::MergeTouched(double tolerance) {
  const std::size_t before = mesh_.leaf_count();
  // Four quarters have one whole: it is tried once, by the first of them.
  std::vector<PatchIndex> candidates = FirstQuartersOf(changed_);
  changed_.clear();
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    if (!mesh_.alive(candidates[n])) continue;
    const LeafChange change = mesh_.Merge(candidates[n], tolerance);
    Follow(change);
    // A whole may be a quarter, and what was too fine for a neighbour may not be any more.
    for (const PatchIndex made : change.made) {
      candidates.push_back(made);
      for (const ClayJoin& join : mesh_.patch(made).join) {
        if (join.kind != ClayJoin::Kind::kPole) candidates.push_back(join.patch[0]);
      }
    }
  }
  changed_.clear();
  return before - mesh_.leaf_count();
}

}  // namespace annulus
