#include "station/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "modeling/exchange/pattern_file.h"
#include "station/measurement_output.h"
#include "station/units_text.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// Variance of one scan's number as far as it is its own and not shared with the other scan.
double OwnVariance(const Measurement& m, RingErrors ring) {
  const double all = m.value.sigma * m.value.sigma;
  if (ring == RingErrors::kIndependent || std::isnan(all)) return all;  // std::max would take a NaN for 0
  return std::max(0.0, all - m.budget.calibration * m.budget.calibration);
}

Difference DifferenceOf(const Measurement& a, const Measurement& b, RingErrors ring) {
  Difference d{a.id, a.term, a.unit, a.value.value, b.value.value, b.value.value - a.value.value};
  d.sigma = std::sqrt(OwnVariance(a, ring) + OwnVariance(b, ring));
  // Two numbers without any error (sigma 0) differ surely or not at all.
  d.z = d.sigma == 0.0 && d.difference == 0.0 ? 0.0 : d.difference / d.sigma;
  d.p = std::erfc(std::abs(d.z) / std::sqrt(2.0));
  return d;
}

/// Why two measurements of one id are not the same thing; "" if they are.
std::string WhyDifferent(const Measurement& a, const Measurement& b) {
  if (a.unit != b.unit) return "in " + a.unit + " and in " + b.unit;
  if (a.method != b.method) return "by the methods '" + a.method + "' and '" + b.method + "'";
  if (a.definition != b.definition) return "defined as '" + a.definition + "' and as '" + b.definition + "'";
  return "";
}

std::string_view RingText(RingErrors ring) {
  return ring == RingErrors::kCommon ? "common to both scans (same calibration): they cancel"
                                     : "independent (calibrations differ or are not known): they add";
}

}  // namespace

RingErrors RingErrorsOf(const Provenance& a, const Provenance& b) {
  const bool same = !a.calibration_hash.empty() && a.calibration_hash == b.calibration_hash;
  return same ? RingErrors::kCommon : RingErrors::kIndependent;
}

std::vector<double> HolmCorrected(const std::vector<double>& p_values) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < p_values.size(); ++k) {
    if (!std::isnan(p_values[k])) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return p_values[i] < p_values[j]; });
  std::vector<double> corrected = p_values;
  double largest = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    largest = std::max(largest, p_values[order[rank]] * static_cast<double>(order.size() - rank));
    corrected[order[rank]] = std::min(1.0, largest);
  }
  return corrected;
}

Comparison Compare(const ComparedScan& a, const ComparedScan& b) {
  Comparison comparison;
  comparison.ring = RingErrorsOf(a.model.provenance, b.model.provenance);
  for (const Measurement& first : a.table.measurements) {
    const Measurement* second = FindMeasurement(b.table, first.id);
    if (FindMeasurement(a.table, first.id) == nullptr) continue;
    const std::string why = second == nullptr ? "measured in A only" : WhyDifferent(first, *second);
    if (why.empty()) {
      comparison.differences.push_back(DifferenceOf(first, *second, comparison.ring));
    } else {
      comparison.not_comparable.push_back(first.id + ": " + why + ".");
    }
  }
  for (const Measurement& second : b.table.measurements) {
    if (FindMeasurement(a.table, second.id) == nullptr) {
      comparison.not_comparable.push_back(second.id + ": measured in B only.");
    }
  }
  std::vector<double> p_values;
  for (const Difference& d : comparison.differences) p_values.push_back(d.p);
  const std::vector<double> corrected = HolmCorrected(p_values);
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    comparison.differences[k].p_holm = corrected[k];
    comparison.differences[k].significant = corrected[k] < kComparisonLevel;
  }
  return comparison;
}

Json ComparisonToJson(const Comparison& comparison) {
  Json differences = Json::array();
  std::size_t tested = 0;
  for (const Difference& d : comparison.differences) {
    const double half = HalfWidth95({d.difference, d.sigma});
    const bool is_tested = std::isfinite(d.sigma);
    if (is_tested) ++tested;
    differences.push_back({{"id", d.id},
                           {"term", d.term},
                           {"a_" + d.unit, d.a},
                           {"b_" + d.unit, d.b},
                           {"difference_" + d.unit, d.difference},
                           {"sigma_" + d.unit, JsonNumber(d.sigma)},
                           {"low95_" + d.unit, JsonNumber(d.difference - half)},
                           {"high95_" + d.unit, JsonNumber(d.difference + half)},
                           {"z", JsonNumber(d.z)},
                           {"p", JsonNumber(d.p)},
                           {"p_holm", JsonNumber(d.p_holm)},
                           {"significant", is_tested ? Json(d.significant) : Json(nullptr)}});
  }
  return {{"ring_errors", comparison.ring == RingErrors::kCommon ? "common" : "independent"},
          {"level", kComparisonLevel},
          {"tested", tested},
          {"differences", differences},
          {"not_comparable", comparison.not_comparable}};
}

std::string ComparisonToText(const Comparison& comparison) {
  std::string text = fmt::format("{:<45}{:>9}{:>9}{:>10}     {:>8}{:>8}{:>10}  {}\n", "measurement", "A", "B", "B - A",
                                 "± 95 %", "z", "p (Holm)", "significant");
  for (const Difference& d : comparison.differences) {
    const auto shown = [&](double value) {
      Measurement m;
      m.unit = d.unit;
      m.value = {value, d.sigma};
      return DescribeValue(m, LengthUnit::kMillimetre);
    };
    const ValueText difference = shown(d.difference);
    text += fmt::format("{:<45}{:>9}{:>9}{:>10} {:<4}{:>8}", d.term, shown(d.a).value, shown(d.b).value,
                        (d.difference < 0.0 ? "" : "+") + difference.value, difference.unit, difference.half95);
    text += std::isfinite(d.sigma) ? fmt::format("{:>8.1f}{:>10.3g}  {}\n", d.z, d.p_holm, d.significant ? "yes" : "no")
                                   : fmt::format("{:>8}{:>10}  {}\n", "–", "–", "not known");
  }
  for (const NamesOfReason& entry : GatherByReason(comparison.not_comparable)) {
    text += "not comparable, " + entry.reason + ": " + entry.names + "\n";
  }
  return text + fmt::format("significant at {:g} over all differences (Holm); errors of the ring: {}\n",
                            kComparisonLevel, RingText(comparison.ring));
}

}  // namespace annulus
