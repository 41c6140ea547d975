#include "modeling/flatten/sheet_cut.h"

#include <algorithm>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// Where in a face a vertex is; 3 if nowhere.
std::size_t PlaceIn(const std::array<std::uint32_t, 3>& face, std::uint32_t vertex) {
  return static_cast<std::size_t>(std::find(face.begin(), face.end(), vertex) - face.begin());
}

/// Faces around `vertex` at the left of the chain's way through it, clockwise from the vertex before or, at the chain's
/// start, counter-clockwise from the vertex after.
std::vector<std::size_t> FacesAtLeft(const CurvedSheet& sheet, const std::vector<std::size_t>& around,
                                     std::uint32_t vertex, std::uint32_t before, std::uint32_t after) {
  std::vector<std::size_t> found;
  const bool backwards = before != kNone;
  std::uint32_t from = backwards ? before : after;
  const std::uint32_t until = backwards ? after : kNone;
  while (from != until) {
    const auto next = std::find_if(around.begin(), around.end(), [&](std::size_t f) {
      const auto& face = sheet.faces[f];
      const std::size_t k = PlaceIn(face, vertex);
      return face[(k + (backwards ? 2U : 1U)) % 3] == from;
    });
    if (next == around.end()) break;  // the rim
    found.push_back(*next);
    const auto& face = sheet.faces[*next];
    from = face[(PlaceIn(face, vertex) + (backwards ? 1U : 2U)) % 3];
  }
  return found;
}

}  // namespace

CurvedSheet CutAlong(CurvedSheet sheet, const std::vector<std::uint32_t>& chain, SheetCutEnd end) {
  ENSURE(chain.size() >= 2, "a cut has two ends");
  const std::size_t doubled = end == SheetCutEnd::kTip ? chain.size() - 1 : chain.size();
  std::vector<std::vector<std::size_t>> around(chain.size());
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    for (std::size_t k = 0; k < chain.size(); ++k) {
      if (PlaceIn(sheet.faces[f], chain[k]) < 3) around[k].push_back(f);
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> moved;  // face, place in the chain
  for (std::size_t k = 0; k < doubled; ++k) {
    const std::uint32_t before = k == 0 ? kNone : chain[k - 1];
    const std::uint32_t after = k + 1 == chain.size() ? kNone : chain[k + 1];
    for (const std::size_t f : FacesAtLeft(sheet, around[k], chain[k], before, after)) moved.emplace_back(f, k);
  }
  const auto first = static_cast<std::uint32_t>(sheet.places.size());
  for (std::size_t k = 0; k < doubled; ++k) sheet.places.push_back(sheet.places[chain[k]]);
  for (const auto& [f, k] : moved) {
    sheet.faces[f][PlaceIn(sheet.faces[f], chain[k])] = first + static_cast<std::uint32_t>(k);
  }
  return sheet;
}

}  // namespace annulus
