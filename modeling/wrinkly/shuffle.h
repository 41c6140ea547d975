#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"

namespace annulus {

/// How an axis of base intervals ends.
enum class AxisKind {
  kOpen,    ///< At both ends: what would leave it is folded back by reflection (並進軸).
  kCyclic,  ///< Not at all: interval n is interval 0 (巡回軸).
};

/// Iterated shuffle transformation of one axis of unit base intervals (IST; paper 003, §2.1, fig. 1).
///
/// K iterations, of which iteration k crosses M_k intervals on either side. A smallest interval of base interval i has
/// digits j_1 … j_K, most significant first, j_k in 0 … 2·M_k; written as one number, its code, in 0 … parts() − 1. The
/// source (i; j_1 … j_K) goes to the destination (s; p_1 … p_K) with
///
///     p_k = j_{K+1−k},    s = i − Σ_k (j_k − M_k),
///
/// so a destination's digits have the iterations' radices in reverse order. What remains inside a smallest interval is
/// kept. Without iterations, or with M = 0, nothing moves. A value; thread-safe.
class Shuffle {
 public:
  /// One direction of the transformation for a smallest interval: its code over there, and how many base intervals
  /// over.
  struct Move {
    std::uint32_t code = 0;
    std::int32_t shift = 0;
  };

  /// `crossings`: M of each iteration, each 0 … kMostCrossing. Fails beyond kMostParts parts or kMostIterations.
  static Result<Shuffle> Make(std::vector<int> crossings);
  /// The same M in each of K iterations, as in the paper.
  static Result<Shuffle> Make(int crossing, int iterations);

  static constexpr int kMostCrossing = 1000;
  static constexpr int kMostIterations = 64;
  static constexpr std::uint64_t kMostParts = std::uint64_t{1} << 31U;

  [[nodiscard]] const std::vector<int>& crossings() const { return crossings_; }
  [[nodiscard]] int iterations() const { return static_cast<int>(crossings_.size()); }
  /// Smallest intervals of one base interval: Π_k (2·M_k + 1).
  [[nodiscard]] std::uint32_t parts() const { return parts_; }
  /// Base intervals that a point can come from on either side: Σ_k M_k.
  [[nodiscard]] int reach() const { return reach_; }

  /// From a destination's code to its source (inverse). Requires code < parts().
  [[nodiscard]] Move Source(std::uint32_t code) const {
    return to_source_.empty() ? Reverse(code, reversed_) : to_source_[code];
  }
  /// From a source's code to its destination (forward). Requires code < parts().
  [[nodiscard]] Move Destination(std::uint32_t code) const;

  /// The digits of a source's code, j_1 … j_K, and of a destination's, p_1 … p_K.
  [[nodiscard]] std::vector<int> SourceDigits(std::uint32_t code) const;
  [[nodiscard]] std::vector<int> DestinationDigits(std::uint32_t code) const;

 private:
  explicit Shuffle(std::vector<int> crossings);
  /// Reads digits of these iterations from the least significant one, and writes them in that order.
  [[nodiscard]] static Move Reverse(std::uint32_t code, const std::vector<int>& crossings);

  std::vector<int> crossings_;
  std::vector<int> reversed_;  ///< crossings_ from the last to the first: the order of a destination's digits.
  std::uint32_t parts_ = 1;
  int reach_ = 0;
  std::vector<Move> to_source_;  ///< By code; empty if that were too long.
};

/// A base interval of an axis, and whether it was reached by a reflection, which turns round what is inside.
struct FoldedInterval {
  std::int32_t index = 0;
  bool mirrored = false;
};

/// Where interval number `index` of the endless axis lies on one of `count` >= 1 intervals.
[[nodiscard]] FoldedInterval Fold(std::int64_t index, std::int32_t count, AxisKind kind);

/// A smallest interval of an axis with `count` base intervals. The offset within it is kept, or turned round: r → 1 −
/// r.
struct AxisPart {
  std::int32_t interval = 0;
  std::uint32_t code = 0;
  bool mirrored = false;
};

/// Where the smallest interval `code` of base interval `interval` comes from (inverse), and goes to (forward).
[[nodiscard]] AxisPart SourcePart(const Shuffle& shuffle, std::pair<std::int32_t, std::uint32_t> destination,
                                  std::int32_t count, AxisKind kind);
[[nodiscard]] AxisPart DestinationPart(const Shuffle& shuffle, std::pair<std::int32_t, std::uint32_t> source,
                                       std::int32_t count, AxisKind kind);

}  // namespace annulus
