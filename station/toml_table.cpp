#include "station/toml_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace annulus::toml_table {

std::string LineOf(const toml::node& node) { return "line " + std::to_string(node.source().begin.line); }

void Refuse(const toml::node& node, const std::string& key, const std::string& expected) {
  throw BadConfig{LineOf(node) + ": " + key + " is not " + expected, "correct this line"};
}

std::string Text(const toml::node& node, const std::string& key) {
  if (const auto value = node.value<std::string>()) return *value;
  Refuse(node, key, "a text in quotes");
}

double NumberIn(const toml::node& node, const std::string& key, double low, double high) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (value && *value >= low && *value <= high) return *value;
  Refuse(node, key, "a number from " + std::to_string(low) + " to " + std::to_string(high));
}

std::int64_t WholeIn(const toml::node& node, const std::string& key, std::int64_t low, std::int64_t high) {
  const auto value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
  if (value && *value >= low && *value <= high) return *value;
  Refuse(node, key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
}

bool Flag(const toml::node& node, const std::string& key) {
  if (const auto value = node.value<bool>()) return *value;
  Refuse(node, key, "true or false");
}

std::vector<std::string> Texts(const toml::node& node, const std::string& key) {
  const toml::array* list = node.as_array();
  if (list == nullptr) Refuse(node, key, "a list of texts in quotes");
  std::vector<std::string> texts;
  for (const toml::node& one : *list) texts.push_back(Text(one, key));
  return texts;
}

void ReadTable(const toml::node& node, const std::string& section, const Setters& setters) {
  const toml::table* table = node.as_table();
  if (table == nullptr) Refuse(node, "[" + section + "]", "a table");
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    const auto found = std::find_if(setters.begin(), setters.end(), [&](const auto& s) { return s.first == name; });
    if (found == setters.end()) {
      std::string known;
      for (const auto& [other, setter] : setters) known.append(known.empty() ? "" : ", ").append(other);
      throw BadConfig{fmt::format("line {}: unknown key '{}' in [{}]", key.source().begin.line, name, section),
                      "use one of: " + known};
    }
    found->second(value, fmt::format("{}.{}", section, name));
  }
}

Setter ToNumber(double& target, double low, double high) {
  return [&target, low, high](const toml::node& n, const std::string& key) { target = NumberIn(n, key, low, high); };
}
Setter ToNumber(std::optional<double>& target, double low, double high) {
  return [&target, low, high](const toml::node& n, const std::string& key) { target = NumberIn(n, key, low, high); };
}
Setter ToWhole(int& target, int low, int high) {
  return [&target, low, high](const toml::node& n, const std::string& key) {
    target = static_cast<int>(WholeIn(n, key, low, high));
  };
}
Setter ToText(std::string& target) {
  return [&target](const toml::node& n, const std::string& key) { target = Text(n, key); };
}
Setter ToFlag(bool& target) {
  return [&target](const toml::node& n, const std::string& key) { target = Flag(n, key); };
}
Setter Ignore() {
  return [](const toml::node&, const std::string&) {};
}

}  // namespace annulus::toml_table
