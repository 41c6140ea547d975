#include "modeling/wrinkly/control_mesh_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using LinkKind = ControlLink::Kind;

constexpr const char* kFormat = "annulus wrinkly mesh";
constexpr int kVersion = 1;
constexpr const char* kAdvice = "see docs/formats.md, 'Control mesh'";
constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::size_t kMostAttributes = 64;

/// A link as it is written: the point, and by which of its sides, if that is said.
struct WrittenLink {
  LinkKind kind = LinkKind::kBoundary;
  std::int64_t point = -1;
  std::optional<std::uint8_t> slot;
};
using WrittenLinks = std::vector<std::array<WrittenLink, 4>>;

std::optional<WrittenLink> LinkOf(const Json& json) {
  if (json.is_null()) return WrittenLink{};
  if (json == "closed") return WrittenLink{LinkKind::kClosed, -1, {}};
  if (json.is_number_integer()) return WrittenLink{LinkKind::kPoint, json.get<std::int64_t>(), {}};
  if (!json.is_array() || json.size() != 2 || !json[0].is_number_integer() || !json[1].is_number_integer()) return {};
  const auto slot = json[1].get<std::int64_t>();
  if (slot < 0 || slot > 3) return {};
  return WrittenLink{LinkKind::kPoint, json[0].get<std::int64_t>(), static_cast<std::uint8_t>(slot)};
}

/// By which side the neighbour of `slot` is linked back, where the file does not say: the opposite one if that names
/// this point, else the only one that does.
std::optional<std::uint8_t> SlotBack(const WrittenLinks& links, std::size_t point, std::size_t slot) {
  const WrittenLink& link = links[point][slot];
  const auto& back = links[static_cast<std::size_t>(link.point)];
  const auto names_us = [&](std::size_t k) {
    return back[k].kind == LinkKind::kPoint && back[k].point == static_cast<std::int64_t>(point) &&
           (!back[k].slot || *back[k].slot == slot);
  };
  const std::size_t opposite = (slot + 2) % 4;
  if (names_us(opposite)) return static_cast<std::uint8_t>(opposite);
  std::optional<std::uint8_t> found;
  for (std::size_t k = 0; k < 4; ++k) {
    if (!names_us(k)) continue;
    if (found) return std::nullopt;
    found = static_cast<std::uint8_t>(k);
  }
  return found;
}

/// Reads point by point.
class PointsReader {
 public:
  PointsReader(const JsonReader& reader, ControlMeshParts& parts) : reader_(reader), parts_(parts) {}

  Status Read(const Json& points) {
    parts_.points.resize(points.size());
    parts_.values.resize(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(parts_.attributes.size()));
    links_.resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) RETURN_IF_ERROR(ReadPoint(points[k], k));
    return JoinLinks();
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Refuse(std::size_t k, const std::string& seen) const {
    return reader_.Refuse(fmt::format("points[{}] {}", k, seen));
  }

  Status ReadPoint(const Json& json, std::size_t k) {
    const JsonReader at = reader_.Within(fmt::format("points[{}]", k));
    if (!json.is_object()) return Refuse(k, "is no object");
    RETURN_IF_ERROR(at.OnlyKeys(json, {"position_mm", "links", "values", "temporary"}));
    const auto position = at.Vector(json, "position_mm");
    if (!position) return Fail(position);
    parts_.points[k].position = *position;
    const auto links = at.Array(json, "links");
    if (!links) return Fail(links);
    if ((*links)->size() != 4) return Refuse(k, "has not four links");
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const auto link = LinkOf((**links)[slot]);
      if (!link) return Refuse(k, fmt::format("links[{}] is no point, null or \"closed\"", slot));
      links_[k][slot] = *link;
    }
    const auto values = at.Array(json, "values");
    if (!values) return Fail(values);
    if ((*values)->size() != parts_.attributes.size()) return Refuse(k, "has not one value for each attribute");
    for (std::size_t n = 0; n < parts_.attributes.size(); ++n) {
      if (!(**values)[n].is_number()) return Refuse(k, fmt::format("values[{}] is no number", n));
      parts_.values(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(n)) = (**values)[n].get<double>();
    }
    if (!json.contains("temporary")) return {};
    if (!json["temporary"].is_boolean()) return Refuse(k, "temporary is neither true nor false");
    parts_.points[k].temporary = json["temporary"].get<bool>();
    return {};
  }

  Status JoinLinks() {
    for (std::size_t k = 0; k < links_.size(); ++k) {
      for (std::size_t slot = 0; slot < 4; ++slot) {
        const WrittenLink& link = links_[k][slot];
        ControlLink& made = parts_.points[k].link[slot];
        made.kind = link.kind;
        if (link.kind != LinkKind::kPoint) continue;
        if (link.point < 0 || static_cast<std::size_t>(link.point) >= links_.size()) {
          return Refuse(k, fmt::format("is linked to point {}, which does not exist", link.point));
        }
        const auto back = link.slot ? link.slot : SlotBack(links_, k, slot);
        if (!back) {
          return Refuse(k, fmt::format("is linked to point {}, whose links do not say by which side it is linked back",
                                       link.point));
        }
        made.point = static_cast<PointIndex>(link.point);
        made.slot = *back;
      }
    }
    return {};
  }

  const JsonReader& reader_;
  ControlMeshParts& parts_;
  WrittenLinks links_;
};

Status ReadAttributes(const JsonReader& reader, const Json& root, ControlMeshParts& parts) {
  const auto names = reader.Array(root, "attributes");
  if (!names) return Fail(names);
  if ((*names)->size() > kMostAttributes) return reader.Refuse("it has more than 64 attributes");
  parts.attributes.clear();
  for (const Json& name : **names) {
    if (!name.is_string()) return reader.Refuse("an attribute's name is no text");
    if (std::find(parts.attributes.begin(), parts.attributes.end(), name) != parts.attributes.end()) {
      return reader.Refuse("two attributes have the same name");
    }
    parts.attributes.push_back(name.get<std::string>());
  }
  return {};
}

}  // namespace

Result<ControlMeshParts> ControlMeshFromJson(std::string_view text, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const auto root = reader.Root(text);
  if (!root) return Fail(root);
  const auto version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  RETURN_IF_ERROR(reader.OnlyKeys(*root, {"format", "version", "attributes", "points"}));
  ControlMeshParts parts;
  RETURN_IF_ERROR(ReadAttributes(reader, *root, parts));
  const auto points = reader.Array(*root, "points");
  if (!points) return Fail(points);
  if ((*points)->size() > kMostPoints) return reader.Refuse("it has more than 10 million points");
  RETURN_IF_ERROR(PointsReader(reader, parts).Read(**points));
  return parts;
}

std::string ControlMeshToJson(const ControlMeshParts& parts) {
  Json root{{"format", kFormat}, {"version", kVersion}, {"attributes", parts.attributes}, {"points", Json::array()}};
  for (std::size_t k = 0; k < parts.points.size(); ++k) {
    const ControlPoint& point = parts.points[k];
    Json links = Json::array();
    for (const ControlLink& link : point.link) {
      if (link.kind == LinkKind::kBoundary) links.push_back(nullptr);
      if (link.kind == LinkKind::kClosed) links.push_back("closed");
      if (link.kind == LinkKind::kPoint) links.push_back({link.point, link.slot});
    }
    Json values = Json::array();
    for (Eigen::Index n = 0; n < parts.values.cols(); ++n) {
      values.push_back(parts.values(static_cast<Eigen::Index>(k), n));
    }
    Json written{{"position_mm", JsonOf(point.position)}, {"links", links}, {"values", values}};
    if (point.temporary) written["temporary"] = true;
    root["points"].push_back(std::move(written));
  }
  return root.dump(1, ' ') + "\n";
}

}  // namespace annulus
