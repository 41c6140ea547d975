#include "modeling/clay/clay_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "modeling/clay/clay_script.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAttempted = "undo operations on clay";
constexpr const char* kName = "the history";
constexpr double kSame = 1e-6;  ///< mm

/// The largest distance between control points of two meshes, mm; infinite if their leaves are not the same.
double Apart(const ClayMesh& a, const ClayMesh& b) {
  constexpr double kOther = std::numeric_limits<double>::infinity();
  const std::vector<PatchIndex> of_a = a.LeavesInOrder();
  const std::vector<PatchIndex> of_b = b.LeavesInOrder();
  if (of_a.size() != of_b.size()) return kOther;
  double largest = 0.0;
  for (std::size_t n = 0; n < of_a.size(); ++n) {
    const ClayPatch& one = a.patch(of_a[n]);
    const ClayPatch& other = b.patch(of_b[n]);
    if (one.base != other.base || one.level != other.level || one.column != other.column || one.row != other.row) {
      return kOther;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) largest = std::max(largest, (one.net[i][j] - other.net[i][j]).norm());
    }
  }
  return largest;
}

}  // namespace

Result<std::vector<std::string>> WithoutLast(const std::vector<std::string>& scripts, std::size_t count) {
  std::vector<std::string> left = scripts;
  std::size_t still = count;
  while (still > 0 && !left.empty()) {
    RETURN_IF_ERROR(ClayScriptFromJson(left.back(), kName));
    Json script = Json::parse(left.back());
    Json& operations = script["operations"];
    const std::size_t here = std::min(still, operations.size());
    operations.erase(operations.end() - static_cast<std::ptrdiff_t>(here), operations.end());
    still -= here;
    left.pop_back();
    if (!operations.empty()) left.push_back(script.dump());
  }
  if (still == 0) return left;
  return Fail(kAttempted, fmt::format("its history has {} operations, not {}", count - still, count),
              "undo fewer of them");
}

Result<ClayFile> Replay(const ClayBody& beginning, const std::vector<std::string>& scripts) {
  ClayFile file{beginning, {}};
  for (const std::string& text : scripts) {
    if (!file.scripts.empty()) {
      auto again = ClayFromJson(ClayToJson(file), kName);
      if (!again) return Fail(again);
      file = std::move(*again);
    }
    const auto script = ClayScriptFromJson(text, kName);
    if (!script) return Fail(script);
    for (const ClayStep& step : script->steps) {
      const auto report = Perform(file.body, step, script->practice);
      if (!report) return Fail(report);
    }
    file.scripts.push_back(text);
  }
  return file;
}

Result<ClayFile> Undone(const ClayFile& file, const ClayBody& beginning, std::size_t count) {
  const auto left = WithoutLast(file.scripts, count);
  if (!left) return Fail(left);
  const auto whole = Replay(beginning, file.scripts);
  if (!whole) {
    return Fail(kAttempted, "its history cannot be carried out on that body (" + whole.error().seen + ")",
                "name the body that it was made of");
  }
  const double apart = Apart(whole->body.mesh(), file.body.mesh());
  if (apart <= kSame) return Replay(beginning, *left);
  return Fail(kAttempted,
              std::isinf(apart) ? std::string("its history on that body leads to other patches")
                                : fmt::format("its history on that body leads {:g} mm away from it", apart),
              "name the body that it was made of");
}

}  // namespace annulus
