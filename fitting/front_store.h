#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fitting/front_kernels.h"

namespace annulus {

/// How many unknowns leave the equations with a front, and how many it is coupled to.
struct FrontSize {
  std::size_t own = 0;
  std::size_t boundary = 0;

  /// Distance of columns of the front's own part and of its Schur complement, as EliminateFront asks for them.
  [[nodiscard]] std::size_t panel_stride() const { return RoundUp(own + boundary) + kFrontLanes; }
  [[nodiscard]] std::size_t rest_stride() const { return RoundUp(boundary) + kFrontLanes; }

 private:
  static std::size_t RoundUp(std::size_t n) { return (n + kFrontLanes - 1) / kFrontLanes * kFrontLanes; }
};

/// A front of a multifrontal factorisation: its first columns go to the factor, the rest to the parent. Local index:
/// own unknowns first, then those of the boundary. Lower part only. Borrows its numbers.
struct Front {
  FrontSize size;
  double* panel = nullptr;
  double* rest = nullptr;

  /// The column whose element `row` is at [row], for rows >= column.
  [[nodiscard]] double* Column(std::size_t column) const {
    return column < size.own ? panel + column * size.panel_stride()
                             : rest + (column - size.own) * size.rest_stride() - size.own;
  }
  /// As fitting/front_kernels.h. False if a pivot is not positive.
  [[nodiscard]] bool Eliminate() const {
    return EliminateFront(panel, size.panel_stride(), size.own + size.boundary, size.own, rest, size.rest_stride());
  }
};

/// An unknown of a dense matrix that is added to a front, and its place there.
struct FrontPlace {
  std::uint32_t in_front = 0;
  std::uint32_t in_matrix = 0;
};

/// Adds a symmetric matrix (both triangles, column-major) to a front. `places` rise by `in_front`.
inline void AddToFront(const double* matrix, std::size_t stride, std::span<const FrontPlace> places,
                       const Front& front) {
  for (std::size_t b = 0; b < places.size(); ++b) {
    double* column = front.Column(places[b].in_front);
    const double* from = matrix + places[b].in_matrix * stride;
    for (std::size_t a = b; a < places.size(); ++a) column[places[a].in_front] += from[places[a].in_matrix];
  }
}

/// Adds a child's Schur complement to its parent's front. `place`: of each of the child's boundary unknowns there,
/// rising.
inline void AddChildToFront(const double* rest, const FrontSize& child, std::span<const std::uint32_t> place,
                            const Front& front) {
  for (std::size_t c = 0; c < place.size(); ++c) {
    const double* from = rest + c * child.rest_stride();
    double* column = front.Column(place[c]);  // places rise: rows below are in the same column
    for (std::size_t r = c; r < place.size(); ++r) column[place[r]] += from[r];
  }
}

/// The own columns of all fronts, one after the other.
class FrontPanels {
 public:
  FrontPanels() = default;
  /// Of fronts of these sizes, all zero.
  explicit FrontPanels(const std::vector<FrontSize>& sizes) {
    std::size_t total = 0;
    for (const FrontSize& size : sizes) {
      first_.push_back(total);
      total += size.panel_stride() * size.own;
    }
    numbers_.assign(total + kFrontLanes, 0.0);
  }

  [[nodiscard]] double* operator[](std::size_t front) { return numbers_.data() + first_[front]; }
  [[nodiscard]] const double* operator[](std::size_t front) const { return numbers_.data() + first_[front]; }
  void SetZero() { std::fill(numbers_.begin(), numbers_.end(), 0.0); }
  /// Numbers stored.
  [[nodiscard]] std::size_t stored() const { return numbers_.size(); }

 private:
  std::vector<double> numbers_;
  std::vector<std::size_t> first_;
};

/// Schur complements that wait for their parents: the last ones are the children of the node at hand (postorder).
class FrontStack {
 public:
  /// A new one of this size, zero. Addresses from before are no longer valid.
  double* Push(const FrontSize& size) {
    const std::size_t n = size.rest_stride() * size.boundary + kFrontLanes;
    starts_.push_back(used_);
    used_ += n;
    if (used_ > numbers_.size()) numbers_.resize(std::max(used_, 2 * numbers_.size()));
    std::fill_n(numbers_.begin() + static_cast<std::ptrdiff_t>(starts_.back()), n, 0.0);
    return numbers_.data() + starts_.back();
  }
  /// The n-th last; 1 is the last.
  [[nodiscard]] const double* FromTop(std::size_t n) const { return numbers_.data() + starts_[starts_.size() - n]; }
  /// Drops the `count` complements below the last one and moves that down.
  void DropBelowTop(std::size_t count) {
    if (count == 0) return;
    const std::size_t top = starts_.back();
    starts_.resize(starts_.size() - count);
    std::copy(numbers_.begin() + static_cast<std::ptrdiff_t>(top),
              numbers_.begin() + static_cast<std::ptrdiff_t>(used_),
              numbers_.begin() + static_cast<std::ptrdiff_t>(starts_.back()));
    used_ -= top - starts_.back();
  }
  void Clear() {
    starts_.clear();
    used_ = 0;
  }

 private:
  std::vector<double> numbers_;
  std::vector<std::size_t> starts_;
  std::size_t used_ = 0;
};

}  // namespace annulus
