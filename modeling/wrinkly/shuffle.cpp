#include "modeling/wrinkly/shuffle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace annulus {
namespace {

/// Longer tables cost more in cache misses than the division of digits.
constexpr std::uint32_t kLongestTable = std::uint32_t{1} << 17U;

/// A code's digits, the most significant first; `crossings` in the order of the digits.
std::vector<int> Digits(std::uint32_t code, const std::vector<int>& crossings) {
  std::vector<int> digits(crossings.size());
  for (std::size_t k = crossings.size(); k-- > 0;) {
    const auto radix = static_cast<std::uint32_t>(2 * crossings[k] + 1);
    digits[k] = static_cast<int>(code % radix);
    code /= radix;
  }
  return digits;
}

/// What a smallest interval becomes in an interval that was folded: a reflection turns its digits round.
AxisPart Landed(const Shuffle& shuffle, std::uint32_t code, const FoldedInterval& folded) {
  return {folded.index, folded.mirrored ? shuffle.parts() - 1 - code : code, folded.mirrored};
}

}  // namespace

Result<Shuffle> Shuffle::Make(std::vector<int> crossings) {
  const char* const attempt = "set up the shuffle";
  if (crossings.size() > static_cast<std::size_t>(kMostIterations)) {
    return Fail(attempt, fmt::format("{} iterations", crossings.size()), fmt::format("use 0 to {}", kMostIterations));
  }
  std::uint64_t parts = 1;
  for (const int crossing : crossings) {
    if (crossing < 0 || crossing > kMostCrossing) {
      return Fail(attempt, fmt::format("M is {}", crossing), fmt::format("use 0 to {}", kMostCrossing));
    }
    parts *= static_cast<std::uint64_t>(2 * crossing + 1);
    if (parts > kMostParts) {
      return Fail(attempt, fmt::format("an interval would have more than {} parts", kMostParts),
                  "use fewer iterations or a smaller M");
    }
  }
  return Shuffle(std::move(crossings));
}

Result<Shuffle> Shuffle::Make(int crossing, int iterations) {
  if (iterations < 0 || iterations > kMostIterations) {
    return Fail("set up the shuffle", fmt::format("{} iterations", iterations),
                fmt::format("use 0 to {}", kMostIterations));
  }
  return Make(std::vector<int>(static_cast<std::size_t>(iterations), crossing));
}

Shuffle::Shuffle(std::vector<int> crossings)
    : crossings_(std::move(crossings)), reversed_(crossings_.rbegin(), crossings_.rend()) {
  for (const int crossing : crossings_) {
    parts_ *= static_cast<std::uint32_t>(2 * crossing + 1);
    reach_ += crossing;
  }
  if (parts_ > kLongestTable) return;
  std::vector<Move> table(parts_);
  for (std::uint32_t code = 0; code < parts_; ++code) table[code] = Reverse(code, reversed_);
  to_source_ = std::move(table);
}

Shuffle::Move Shuffle::Reverse(std::uint32_t code, const std::vector<int>& crossings) {
  Move move;
  for (auto crossing = crossings.rbegin(); crossing != crossings.rend(); ++crossing) {
    const auto radix = static_cast<std::uint32_t>(2 * *crossing + 1);
    const std::uint32_t digit = code % radix;
    code /= radix;
    move.code = move.code * radix + digit;
    move.shift += static_cast<std::int32_t>(digit) - *crossing;
  }
  return move;
}

Shuffle::Move Shuffle::Destination(std::uint32_t code) const {
  Move move = Reverse(code, crossings_);
  move.shift = -move.shift;
  return move;
}

std::vector<int> Shuffle::SourceDigits(std::uint32_t code) const { return Digits(code, crossings_); }

std::vector<int> Shuffle::DestinationDigits(std::uint32_t code) const { return Digits(code, reversed_); }

FoldedInterval Fold(std::int64_t index, std::int32_t count, AxisKind kind) {
  if (index >= 0 && index < count) return {static_cast<std::int32_t>(index), false};
  const std::int64_t period = kind == AxisKind::kCyclic ? count : 2 * std::int64_t{count};
  std::int64_t rest = index % period;
  if (rest < 0) rest += period;
  if (rest < count) return {static_cast<std::int32_t>(rest), false};
  return {static_cast<std::int32_t>(period - 1 - rest), true};
}

AxisPart SourcePart(const Shuffle& shuffle, std::pair<std::int32_t, std::uint32_t> destination, std::int32_t count,
                    AxisKind kind) {
  const Shuffle::Move move = shuffle.Source(destination.second);
  return Landed(shuffle, move.code, Fold(std::int64_t{destination.first} + move.shift, count, kind));
}

AxisPart DestinationPart(const Shuffle& shuffle, std::pair<std::int32_t, std::uint32_t> source, std::int32_t count,
                         AxisKind kind) {
  const Shuffle::Move move = shuffle.Destination(source.second);
  return Landed(shuffle, move.code, Fold(std::int64_t{source.first} + move.shift, count, kind));
}

}  // namespace annulus
