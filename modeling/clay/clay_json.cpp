#include "modeling/clay/clay_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

constexpr const char* kFormat = "annulus clay";
constexpr int kVersion = 1;
constexpr const char* kAdvice = "the file is damaged: make it again from its operations";
constexpr std::size_t kMostLeaves = 2'000'000;
constexpr std::uint32_t kDeepest = 16;
constexpr std::uint32_t kMostSegments = 16;
constexpr double kLargestGap = 1e-6;  ///< mm

Json NetJson(const ControlNet& net) {
  Json numbers = Json::array();
  for (const auto& row : net) {
    for (const Vector3d& point : row) {
      for (const double x : point) numbers.push_back(x);
    }
  }
  return numbers;
}

/// Thrown by what follows, caught in ClayFromJson.
struct BadClay {
  Error error;
};

class Reader {
 public:
  explicit Reader(const JsonReader& reader) : reader_(reader) {}

  ClayFile File(const Json& root) {
    const Json& bases = *Taken(reader_.Array(root, "patches"));
    const Json& leaves = *Taken(reader_.Array(root, "leaves"));
    if (bases.empty() || bases.size() > kMostLeaves || leaves.size() > kMostLeaves)
      Refuse("it has no patches, or too many");
    std::vector<ClayMesh::Base> read;
    for (std::size_t n = 0; n < bases.size(); ++n) read.push_back(BaseOf(bases, n));
    auto made = ClayMesh::Joined(read);
    if (!made) throw BadClay{made.error()};
    ClayMesh mesh = std::move(*made);
    if (root.contains("holes")) OpenHoles(*Taken(reader_.Array(root, "holes")), mesh);
    std::vector<std::pair<ClayMesh::Part, ControlNet>> parts;
    for (std::size_t n = 0; n < leaves.size(); ++n)
      parts.emplace_back(PartOf(leaves[n], fmt::format("leaves[{}]", n), mesh.base_count()), NetOf(leaves, n));
    for (const auto& [part, net] : parts) {
      mesh.SplitTo(part);
      if (mesh.leaf_count() > parts.size()) break;
    }
    if (mesh.leaf_count() != parts.size()) Refuse("its leaves do not cover its patches");
    std::vector<bool> set(mesh.patches().size(), false);
    for (const auto& [part, net] : parts) {
      const PatchIndex index = mesh.LeafOf(part);
      if (index == kNoIndex || set[index]) Refuse("two of its leaves cover the same place");
      set[index] = true;
      mesh.SetNet(index, net);
    }
    if (!(mesh.LargestGap() <= kLargestGap)) Refuse("its leaves do not fit together");
    auto body = ClayBody::Make(std::move(mesh));
    if (!body) throw BadClay{body.error()};
    const double kept = Taken(reader_.Number(root, "kept_volume_mm3"));
    if (!(kept > 0.0)) Refuse("'kept_volume_mm3' is not positive");
    body->Keep(kept);
    ClayFile file{std::move(*body), {}};
    for (const Json& script : *Taken(reader_.Array(root, "history"))) file.scripts.push_back(script.dump());
    return file;
  }

 private:
  [[noreturn]] void Refuse(std::string seen) const { throw BadClay{reader_.Refuse(std::move(seen)).value()}; }
  template <class T>
  static T Taken(Result<T> result) {
    if (!result) throw BadClay{result.error()};
    return std::move(*result);
  }

  std::uint32_t Whole(const Json& json, const char* where, std::uint32_t most) const {
    if (!json.is_number_unsigned() || json.get<std::uint64_t>() > most) {
      Refuse(fmt::format("{} is not a whole number from 0 to {}", where, most));
    }
    return json.get<std::uint32_t>();
  }

  ClayMesh::Base BaseOf(const Json& list, std::size_t n) const {
    const auto most = static_cast<std::uint32_t>(list.size() - 1);
    const JsonReader here = reader_.Within(fmt::format("patches[{}]", n));
    if (!list[n].is_object()) Refuse(fmt::format("patches[{}] is not an object", n));
    const Json& vertex = *Taken(here.Array(list[n], "vertex"));
    const Json& join = *Taken(here.Array(list[n], "join"));
    if (vertex.size() != 4 || join.size() != 4) Refuse(fmt::format("patches[{}] has not four corners and joins", n));
    ClayMesh::Base base;
    for (std::size_t e = 0; e < 4; ++e) {
      base.vertex[e] = Whole(vertex[e], "a vertex", 4 * most + 3);
      if (join[e].is_null()) continue;
      if (!join[e].is_object()) Refuse(fmt::format("patches[{}].join is not of objects", n));
      const JsonReader inner = here.Within(fmt::format("join[{}]", e));
      ClayJoin& to = base.join[e];
      to.kind = ClayJoin::Kind::kEqual;
      to.patch[0] = Whole(join[e].value("patch", Json()), "a join's patch", most);
      to.edge[0] = static_cast<std::uint8_t>(Whole(join[e].value("edge", Json()), "a join's edge", 3));
      to.smooth = join[e].value("smooth", Json()) == Json(true);
      to.ratio = Taken(inner.Number(join[e], "ratio"));
      if (!(to.ratio > 0.0)) Refuse("a join's ratio is not positive");
    }
    return base;
  }

  void OpenHoles(const Json& holes, ClayMesh& mesh) const {
    for (std::size_t n = 0; n < holes.size(); ++n) {
      if (mesh.leaf_count() > kMostLeaves) Refuse("it has too many holes");
      const std::string where = fmt::format("holes[{}]", n);
      if (!holes[n].is_object()) Refuse(where + " is not an object");
      ClayMesh::Hole hole;
      hole.entry = PartOf(holes[n].value("entry", Json()), where + ".entry", mesh.base_count());
      hole.exit = PartOf(holes[n].value("exit", Json()), where + ".exit", mesh.base_count());
      hole.turn = Whole(holes[n].value("turn", Json()), "a hole's turn", 3);
      hole.segments = Whole(holes[n].value("segments", Json()), "a hole's segments", kMostSegments);
      mesh.SplitTo(hole.entry);
      mesh.SplitTo(hole.exit);
      if (const auto opened = mesh.OpenHole(hole); !opened) Refuse(where + ": " + opened.error().seen);
      if (!holes[n].contains("filled")) continue;
      if (holes[n].at("filled") != Json(true)) Refuse(where + ".filled is not true");
      if (const auto filled = mesh.FillHole(n); !filled) Refuse(where + ": " + filled.error().seen);
    }
  }

  ClayMesh::Part PartOf(const Json& leaf, const std::string& where, std::size_t bases) const {
    if (!leaf.is_object()) Refuse(where + " is not an object");
    ClayMesh::Part part;
    part.base = Whole(leaf.value("patch", Json()), "a leaf's patch", static_cast<std::uint32_t>(bases - 1));
    part.level = Whole(leaf.value("level", Json()), "a leaf's level", kDeepest);
    const std::uint32_t most = (1U << part.level) - 1;
    part.column = Whole(leaf.value("column", Json()), "a leaf's column", most);
    part.row = Whole(leaf.value("row", Json()), "a leaf's row", most);
    return part;
  }

  ControlNet NetOf(const Json& list, std::size_t n) const {
    const Json& numbers = *Taken(reader_.Within(fmt::format("leaves[{}]", n)).Array(list[n], "net"));
    ControlNet net;
    if (numbers.size() != 48) Refuse(fmt::format("leaves[{}].net has {} numbers, not 48", n, numbers.size()));
    for (std::size_t k = 0; k < 48; ++k) {
      const double x = numbers[k].is_number() ? numbers[k].get<double>() : std::nan("");
      if (!(std::abs(x) <= 1e9)) Refuse(fmt::format("leaves[{}].net[{}] is not a length", n, k));
      net[k / 12][k / 3 % 4][static_cast<Eigen::Index>(k % 3)] = x;
    }
    return net;
  }

  const JsonReader& reader_;
};

}  // namespace

std::string ClayToJson(const ClayFile& file) {
  const ClayMesh& mesh = file.body.mesh();
  Json patches = Json::array();
  for (const ClayMesh::Base& base : mesh.Bases()) {
    Json joins = Json::array();
    for (const ClayJoin& join : base.join) {
      joins.push_back(join.kind == ClayJoin::Kind::kPole ? Json()
                                                         : Json{{"patch", join.patch[0]},
                                                                {"edge", static_cast<int>(join.edge[0])},
                                                                {"smooth", join.smooth},
                                                                {"ratio", join.ratio}});
    }
    patches.push_back({{"vertex", base.vertex}, {"join", std::move(joins)}});
  }
  Json leaves = Json::array();
  for (const PatchIndex index : mesh.LeavesInOrder()) {
    const ClayPatch& leaf = mesh.patch(index);
    leaves.push_back({{"patch", leaf.base},
                      {"level", leaf.level},
                      {"column", leaf.column},
                      {"row", leaf.row},
                      {"net", NetJson(leaf.net)}});
  }
  Json holes = Json::array();
  const auto part = [](const ClayMesh::Part& one) {
    return Json{{"patch", one.base}, {"level", one.level}, {"column", one.column}, {"row", one.row}};
  };
  for (const ClayMesh::Hole& hole : mesh.holes()) {
    holes.push_back(
        {{"entry", part(hole.entry)}, {"exit", part(hole.exit)}, {"turn", hole.turn}, {"segments", hole.segments}});
    if (hole.filled) holes.back()["filled"] = true;
  }
  Json history = Json::array();
  for (const std::string& script : file.scripts) history.push_back(Json::parse(script));
  Json root{{"format", kFormat},
            {"version", kVersion},
            {"kept_volume_mm3", file.body.kept_volume()},
            {"patches", std::move(patches)}};
  if (!holes.empty()) root["holes"] = std::move(holes);
  root["leaves"] = std::move(leaves);
  root["history"] = std::move(history);
  return root.dump() + "\n";
}

Result<ClayFile> ClayFromJson(std::string_view text, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const auto root = reader.Root(text);
  if (!root) return Fail(root);
  const auto version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  try {
    return Reader(reader).File(*root);
  } catch (const BadClay& bad) {
    return tl::unexpected<Error>(bad.error);
  }
}

bool IsClayJson(std::string_view text) {
  const std::string_view head = text.substr(0, 200);
  return head.find(kFormat) != std::string_view::npos;
}

}  // namespace annulus
