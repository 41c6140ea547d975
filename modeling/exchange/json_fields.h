#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace annulus {

/// What is wrong with a JSON model. Thrown by the readers of its fields, caught in ModelFromJson; never leaves
/// modeling/exchange.
struct BadModel {
  std::string seen;
};

/// Largest length that a model may hold, mm.
inline constexpr double kLargestLength = 1e9;

/// Fields of a JSON object. Each throws BadModel, naming the key, if the field is missing or not what is asked for.
const nlohmann::ordered_json& Member(const nlohmann::ordered_json& json, const char* key);
double Number(const nlohmann::ordered_json& json, const char* key);  ///< Finite, at most kLargestLength.
double Finite(const nlohmann::ordered_json& json, const char* key);
std::size_t Count(const nlohmann::ordered_json& json, const char* key, std::size_t low, std::size_t high);
std::string String(const nlohmann::ordered_json& json, const char* key);
std::vector<double> Numbers(const nlohmann::ordered_json& json, const char* key);  ///< All finite.

}  // namespace annulus
