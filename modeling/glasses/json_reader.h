#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// Reads typed members of one JSON file and words every failure alike: `read NAME: 'details.depth_mm' is …: advice`.
/// Borrows nothing but the advice, which must be a literal.
class JsonReader {
 public:
  using Json = nlohmann::ordered_json;

  /// `name` of the file is for messages.
  JsonReader(std::string_view name, const char* advice);

  /// A reader of the same file that puts `place` before every key it names: "details", "styles[3]".
  [[nodiscard]] JsonReader Within(std::string_view place) const;

  [[nodiscard]] tl::unexpected<Error> Refuse(std::string seen) const;
  /// The key with its place, in quotes.
  [[nodiscard]] std::string Named(std::string_view key) const;

  /// The whole text as one object. Fails, naming the line, on what is no JSON, on a key that an object has twice and on
  /// more than 32 levels.
  [[nodiscard]] Result<Json> Root(std::string_view text) const;
  /// The version of a root object of this format. Fails unless it is 1 … `newest`.
  [[nodiscard]] Result<int> Version(const Json& root, const char* format, int newest) const;
  /// Fails on a key that is not in `known`, naming it.
  [[nodiscard]] Status OnlyKeys(const Json& object, std::initializer_list<std::string_view> known) const;

  /// Members of `parent`. Each fails, naming the key, if it is missing or not what is asked for.
  [[nodiscard]] Result<const Json*> Object(const Json& parent, std::string_view key) const;
  [[nodiscard]] Result<const Json*> Array(const Json& parent, std::string_view key) const;
  [[nodiscard]] Result<double> Number(const Json& parent, std::string_view key) const;  ///< Finite.
  [[nodiscard]] Result<std::string> Text(const Json& parent, std::string_view key) const;
  [[nodiscard]] Result<Eigen::Vector3d> Vector(const Json& parent, std::string_view key) const;  ///< Finite.
  /// An angle written by PutAngle, rad: one of STEM_deg and STEM_rad.
  [[nodiscard]] Result<double> Angle(const Json& parent, std::string_view stem) const;

 private:
  std::string attempt_;
  std::string place_;
  const char* advice_;
};

/// Three finite numbers; empty otherwise.
[[nodiscard]] std::optional<Eigen::Vector3d> VectorOf(const nlohmann::ordered_json& array);
[[nodiscard]] nlohmann::ordered_json JsonOf(const Eigen::Vector3d& vector);

/// Writes an angle as STEM_deg, for people, if that reads back to the same bits, else as STEM_rad.
/// Why both: about one radian value in eleven is no degree value times π/180 in double precision.
void PutAngle(nlohmann::ordered_json& object, std::string_view stem, double radians);

}  // namespace annulus
