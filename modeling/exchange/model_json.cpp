#include "modeling/exchange/model_json.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "modeling/exchange/base64.h"
#include "modeling/exchange/json_fields.h"
#include "modeling/exchange/paper_json.h"
#include "modeling/exchange/systematic_json.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr std::size_t kMaxCoefficients = std::size_t{1} << 24;
constexpr std::size_t kMaxRefinements = 8;
constexpr double kShortestInterval = 1e-3;  // mm; far above rounding, however often it is halved
constexpr std::string_view kFormat = "annulus-model";

template <class T>
std::string ToBase64(std::span<const T> values) {
  return EncodeBase64(std::as_bytes(values));
}

Json MatrixToJson(const Eigen::SparseMatrix<double>& upper) {
  // Stored by columns of the upper triangle, which are the rows of the lower one.
  const auto columns = static_cast<std::size_t>(upper.cols());
  const auto entries = static_cast<std::size_t>(upper.nonZeros());
  Json json;
  json["size"] = columns;
  json["entries"] = entries;
  json["encoding"] =
      "base64 little-endian; sparse rows of the lower triangle: int32 row_start, int32 column, float64 value";
  json["row_start"] = ToBase64(std::span(upper.outerIndexPtr(), columns + 1));
  json["column"] = ToBase64(std::span(upper.innerIndexPtr(), entries));
  json["value"] = ToBase64(std::span(upper.valuePtr(), entries));
  return json;
}

/// One text of 0 and 1 per row of cells.
Json FlagsToJson(const HierarchicalSpline& hierarchy) {
  Json levels = Json::array();
  for (std::size_t l = 0; l < hierarchy.flags().size(); ++l) {
    const std::size_t width = hierarchy.levels()[l].theta_cells();
    Json rows = Json::array();
    for (std::size_t row = 0; row < hierarchy.levels()[l].z_cells(); ++row) {
      std::string text;
      for (std::size_t k = 0; k < width; ++k) text += hierarchy.flags()[l][row * width + k] != 0 ? '1' : '0';
      rows.push_back(text);
    }
    levels.push_back(rows);
  }
  return levels;
}

Json AxisToJson(const SegmentAxis& axis) {
  return {{"z_middle_mm", axis.z_middle},  {"x_mm", axis.at.x()},       {"y_mm", axis.at.y()},
          {"x_slope", axis.slope.x()},     {"y_slope", axis.slope.y()}, {"x_bend_per_mm", axis.bend.x()},
          {"y_bend_per_mm", axis.bend.y()}};
}

Json PaperSurfaceToJson(const SurfaceSegment& segment) {
  Json json;
  json["name"] = segment.name;
  json["kind"] = "P(u, v): bicubic uniform B-spline, closed in u, open in v (paper 001, eq. 2.10)";
  json["z_min_mm"] = segment.paper->surface.z_min();
  json["z_max_mm"] = segment.paper->surface.z_max();
  json["paper"] = PaperModelToJson(*segment.paper);
  if (!segment.axis.IsRingAxis()) json["axis"] = AxisToJson(segment.axis);
  return json;
}

Json SurfaceToJson(const SurfaceSegment& segment) {
  if (segment.paper != nullptr) return PaperSurfaceToJson(segment);
  const SplineSurface& s = segment.surface;
  const bool plain = segment.hierarchy == nullptr;
  const SplineLevel coarsest = plain ? SplineLevel{s.theta_basis(), s.z_basis()} : segment.hierarchy->levels().front();
  const Eigen::VectorXd& c = plain ? s.coefficients() : segment.active;
  Json json;
  json["name"] = segment.name;
  json["kind"] =
      "r(theta, z): truncated hierarchical cubic B-splines, periodic uniform in theta, clamped in z, dyadic refinement";
  json["z_min_mm"] = s.z_min();
  json["z_max_mm"] = s.z_max();
  json["theta_count"] = coarsest.theta.count();
  json["z_breakpoints_mm"] = coarsest.z.breakpoints();
  json["refined"] = plain ? Json::array() : FlagsToJson(*segment.hierarchy);
  json["coefficients_mm"] = std::vector<double>(c.data(), c.data() + c.size());
  if (segment.detail_sigma > 0.0) json["detail_sigma_mm"] = segment.detail_sigma;
  if (!segment.axis.IsRingAxis()) json["axis"] = AxisToJson(segment.axis);
  return json;
}

Json KnowledgeToJson(const KnowledgeMap& map) {
  Json rows = Json::array();
  for (std::size_t row = 0; row < map.rows(); ++row) {
    std::string text;
    for (std::size_t column = 0; column < map.columns(); ++column)
      text += "uim"[static_cast<int>(map.Cell(column, row))];
    rows.push_back(text);
  }
  Json json;
  json["legend"] = "m measured, i inferred, u unknown; column k is centred on theta = 360 k / columns degrees";
  json["columns"] = map.columns();
  json["z_min_mm"] = map.z_min();
  json["z_max_mm"] = map.z_max();
  json["rows"] = rows;
  return json;
}

RefinementFlags FlagsFromJson(const Json& json, std::size_t theta_cells, std::size_t z_cells) {
  const Json& levels = Member(json, "refined");
  if (!levels.is_array() || levels.size() > kMaxRefinements) throw BadModel{"'refined' is not a short list of levels"};
  RefinementFlags flags;
  for (const Json& rows : levels) {
    if (!rows.is_array() || rows.size() != z_cells) throw BadModel{"a level of 'refined' has not one row per interval"};
    std::vector<char> level;
    for (const Json& row : rows) {
      if (!row.is_string() || row.get_ref<const std::string&>().size() != theta_cells) {
        throw BadModel{"a row of 'refined' has not one character per cell"};
      }
      for (const char c : row.get_ref<const std::string&>()) {
        if (c != '0' && c != '1') throw BadModel{"'refined' holds something else than 0 and 1"};
        level.push_back(c == '1' ? 1 : 0);
      }
    }
    flags.push_back(std::move(level));
    theta_cells *= 2;
    z_cells *= 2;
  }
  return flags;
}

/// An axis that stays within `kLargestLength` over the heights of its surface.
SegmentAxis AxisFromJson(const Json& json, const SplineSurface& surface) {
  SegmentAxis axis;
  axis.z_middle = Number(json, "z_middle_mm");
  axis.at = {Number(json, "x_mm"), Number(json, "y_mm")};
  axis.slope = {Number(json, "x_slope"), Number(json, "y_slope")};
  axis.bend = {Number(json, "x_bend_per_mm"), Number(json, "y_bend_per_mm")};
  for (const double z : {surface.z_min(), surface.z_max()}) {
    if (!(axis.At(z).cwiseAbs().maxCoeff() <= kLargestLength)) throw BadModel{"'axis' leaves the range"};
  }
  return axis;
}

double DetailFromJson(const Json& json) {
  const double sigma = Number(json, "detail_sigma_mm");
  if (sigma < 0.0) throw BadModel{"'detail_sigma_mm' is negative"};
  return sigma;
}

SurfaceSegment PaperSurfaceFromJson(const Json& json) {
  auto paper = std::make_shared<const PaperModel>(PaperModelFromJson(Member(json, "paper")));
  SplineSurface surface = ApproximateByTensor(paper->surface).surface;
  return {String(json, "name"), std::move(surface), {}, {}, {}, {}, std::move(paper)};
}

SurfaceSegment SurfaceFromJson(const Json& json) {
  if (json.is_object() && json.contains("paper")) return PaperSurfaceFromJson(json);
  const std::size_t theta_count = Count(json, "theta_count", 4, 100'000);
  std::vector<double> breakpoints = Numbers(json, "z_breakpoints_mm");
  if (breakpoints.size() < 2) throw BadModel{"'z_breakpoints_mm' has fewer than two entries"};
  if (std::abs(breakpoints.front()) > kLargestLength || std::abs(breakpoints.back()) > kLargestLength) {
    throw BadModel{"'z_breakpoints_mm' is out of range"};
  }
  for (std::size_t k = 1; k < breakpoints.size(); ++k) {
    if (!(breakpoints[k] - breakpoints[k - 1] >= kShortestInterval)) {
      throw BadModel{"'z_breakpoints_mm' does not increase"};
    }
  }
  const std::vector<double> numbers = Numbers(json, "coefficients_mm");
  const Eigen::VectorXd coefficients =
      Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
  RefinementFlags flags = FlagsFromJson(json, theta_count, breakpoints.size() - 1);
  if (theta_count * (breakpoints.size() + 2) > kMaxCoefficients >> (2 * flags.size())) {
    throw BadModel{"the surface has too many knots"};
  }
  const auto check_count = [&](std::size_t expected) {
    if (numbers.size() == expected) return;
    throw BadModel{"'coefficients_mm' has " + std::to_string(numbers.size()) + " entries, not " +
                   std::to_string(expected)};
  };
  const std::string name = String(json, "name");
  if (flags.empty()) {
    check_count(theta_count * (breakpoints.size() + 2));
    return {name, {PeriodicCubicBasis(theta_count), ClampedCubicBasis(std::move(breakpoints)), coefficients},
            {},   {},
            {},   {}};
  }
  auto hierarchy = std::make_shared<const HierarchicalSpline>(theta_count, breakpoints, std::move(flags));
  check_count(hierarchy->size());
  SplineSurface surface = hierarchy->Surface(coefficients);
  return {name, std::move(surface), {}, {}, std::move(hierarchy), coefficients};
}

template <class T>
std::vector<T> FromBase64(const Json& json, const char* key, std::size_t count) {
  const auto bytes = DecodeBase64(String(json, key));
  if (!bytes || bytes->size() != count * sizeof(T)) {
    throw BadModel{std::string("'") + key + "' of normal_matrix does not hold " + std::to_string(count) + " entries"};
  }
  std::vector<T> values(count);
  if (count > 0) std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

Eigen::SparseMatrix<double> MatrixFromJson(const Json& json, std::size_t size) {
  if (Count(json, "size", 1, kMaxCoefficients) != size)
    throw BadModel{"'normal_matrix' has another size than the surface"};
  const std::size_t entries = Count(json, "entries", 0, size * 512);
  const auto start = FromBase64<int>(json, "row_start", size + 1);
  const auto column = FromBase64<int>(json, "column", entries);
  const auto value = FromBase64<double>(json, "value", entries);
  if (start.front() != 0 || start.back() != static_cast<int>(entries)) throw BadModel{"'row_start' is inconsistent"};
  for (std::size_t row = 0; row < size; ++row) {
    if (start[row] > start[row + 1] || start[row] < 0 || start[row + 1] > static_cast<int>(entries)) {
      throw BadModel{"'row_start' is inconsistent"};
    }
    for (int k = start[row]; k < start[row + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const bool ascends = k == start[row] || column[at - 1] < column[at];
      if (column[at] < 0 || column[at] > static_cast<int>(row) || !ascends || !std::isfinite(value[at])) {
        throw BadModel{"row " + std::to_string(row) + " of 'normal_matrix' is not a sparse row of a lower triangle"};
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(size);
  return Eigen::Map<const Eigen::SparseMatrix<double>>(n, n, static_cast<Eigen::Index>(entries), start.data(),
                                                       column.data(), value.data());
}

KnowledgeMap KnowledgeFromJson(const Json& json) {
  const std::size_t columns = Count(json, "columns", 1, 100'000);
  const Json& rows = Member(json, "rows");
  if (!rows.is_array() || rows.empty()) throw BadModel{"'rows' of measured is not a list of rows"};
  const double z_min = Number(json, "z_min_mm");
  const double z_max = Number(json, "z_max_mm");
  if (!(z_min < z_max)) throw BadModel{"'z_min_mm' of measured is not below 'z_max_mm'"};
  for (const Json& row : rows) {  // before room is made for what they should hold
    if (!row.is_string()) throw BadModel{"a row of measured is not a text"};
    if (row.get_ref<const std::string&>().size() != columns) throw BadModel{"a row of measured has another length"};
  }
  KnowledgeMap map(columns, rows.size(), z_min, z_max);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const auto& text = rows[row].get_ref<const std::string&>();
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t state = std::string_view("uim").find(text[column]);
      if (state == std::string_view::npos) throw BadModel{"measured holds something else than m, i, u"};
      map.SetCell(column, row, static_cast<Knowledge>(state));
    }
  }
  return map;
}

SurfaceModel ModelFromObject(const Json& json) {
  if (!json.is_object() || json.value("format", Json()) != Json(kFormat)) {
    throw BadModel{"'format' is not \"annulus-model\""};
  }
  const std::size_t version = Count(json, "version", 1, 1'000'000);
  if (version > kVersion) throw BadModel{"version " + std::to_string(version) + " is newer than this program"};
  const Json& surfaces = Member(json, "surfaces");
  const Json& measured = Member(json, "measured");
  const Json& matrices = Member(json, "normal_matrix");
  if (!surfaces.is_array() || surfaces.empty()) throw BadModel{"'surfaces' is not a list of surfaces"};
  if (!measured.is_array() || measured.size() != surfaces.size())
    throw BadModel{"'measured' does not match 'surfaces'"};
  if (!matrices.is_array() || (!matrices.empty() && matrices.size() != surfaces.size())) {
    throw BadModel{"'normal_matrix' does not match 'surfaces'"};
  }
  SurfaceModel model;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    SurfaceSegment segment = SurfaceFromJson(surfaces[k]);
    if (const auto axis = surfaces[k].find("axis"); axis != surfaces[k].end())
      segment.axis = AxisFromJson(*axis, segment.surface);
    if (k == 0 && !segment.axis.IsRingAxis()) throw BadModel{"the first surface is not about the ring's axis"};
    if (surfaces[k].contains("detail_sigma_mm")) segment.detail_sigma = DetailFromJson(surfaces[k]);
    segment.knowledge = KnowledgeFromJson(measured[k]);
    if (!matrices.empty()) {
      segment.normal_matrix = MatrixFromJson(
          matrices[k],
          static_cast<std::size_t>((segment.hierarchy ? segment.active : segment.surface.coefficients()).size()));
    }
    model.segments.push_back(std::move(segment));
  }
  model.noise_sigma_mm = Number(json, "noise_sigma_mm");
  const Json& provenance = Member(json, "provenance");
  model.provenance.recording_hash = String(provenance, "recording_hash");
  model.provenance.calibration_hash = String(provenance, "calibration_hash");
  model.provenance.program_version = String(provenance, "program_version");
  model.provenance.method = String(provenance, "method");
  const Json& seed = Member(provenance, "seed");
  if (!seed.is_number_unsigned()) throw BadModel{"'seed' is not a whole number"};
  model.provenance.seed = seed.get<std::uint64_t>();
  model.systematic = SystematicFromJson(json);
  return model;
}

}  // namespace

std::string ModelToJson(const SurfaceModel& model) {
  Json json;
  json["format"] = kFormat;
  json["version"] = kVersion;
  json["provenance"] = {{"recording_hash", model.provenance.recording_hash},
                        {"calibration_hash", model.provenance.calibration_hash},
                        {"program_version", model.provenance.program_version},
                        {"method", model.provenance.method},
                        {"seed", model.provenance.seed}};
  json["noise_sigma_mm"] = model.noise_sigma_mm;
  json["landmarks"] = Json::array();
  json["calibration_covariance"] = CalibrationToJson(model.systematic);
  json["sway"] = SwayToJson(model.systematic);
  json["surfaces"] = Json::array();
  json["measured"] = Json::array();
  json["normal_matrix"] = Json::array();
  for (const SurfaceSegment& segment : model.segments) {
    json["surfaces"].push_back(SurfaceToJson(segment));
    json["measured"].push_back(KnowledgeToJson(segment.knowledge));
    if (segment.normal_matrix.nonZeros() > 0) json["normal_matrix"].push_back(MatrixToJson(segment.normal_matrix));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // foreign bytes in a text never throw
}

Result<SurfaceModel> ModelFromJson(std::string_view json, std::string_view name) {
  const std::string attempted = "read model " + std::string(name);
  const char* advice = "give a MODEL.json written by 'annulus fit'";
  try {
    return ModelFromObject(Json::parse(json));
  } catch (const Json::out_of_range&) {
    return Fail(attempted, "it holds a number that is too large", advice);
  } catch (const Json::parse_error& error) {
    return Fail(attempted,
                "it is not JSON (byte " + std::to_string(error.byte) + " of " + std::to_string(json.size()) + ")",
                advice);
  } catch (const BadModel& bad) {
    return Fail(attempted, bad.seen, advice);
  }
}

}  // namespace annulus
