#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Reading the tables of a configuration file. Included by the .cpp files that read a section of it, nowhere else.
namespace annulus::toml_table {

/// What is wrong with a node of the file. Thrown by everything here, caught by ParseConfig.
struct BadConfig {
  std::string seen;
  std::string advice;
};

/// "line 7", where the node stands.
[[nodiscard]] std::string LineOf(const toml::node& node);
/// Throws that the node, called `key`, is not what was expected.
[[noreturn]] void Refuse(const toml::node& node, const std::string& key, const std::string& expected);

[[nodiscard]] std::string Text(const toml::node& node, const std::string& key);
[[nodiscard]] double NumberIn(const toml::node& node, const std::string& key, double low, double high);
[[nodiscard]] std::int64_t WholeIn(const toml::node& node, const std::string& key, std::int64_t low, std::int64_t high);
[[nodiscard]] bool Flag(const toml::node& node, const std::string& key);
[[nodiscard]] std::vector<std::string> Texts(const toml::node& node, const std::string& key);

using Setter = std::function<void(const toml::node&, const std::string&)>;
using Setters = std::vector<std::pair<std::string, Setter>>;

/// Applies one setter per key of a table; a key without a setter is an error that names its line and the known keys.
void ReadTable(const toml::node& node, const std::string& section, const Setters& setters);

/// Setters that put a value into `target`, which must outlive them.
[[nodiscard]] Setter ToNumber(double& target, double low, double high);
[[nodiscard]] Setter ToNumber(std::optional<double>& target, double low, double high);
[[nodiscard]] Setter ToWhole(int& target, int low, int high);
[[nodiscard]] Setter ToText(std::string& target);
[[nodiscard]] Setter ToFlag(bool& target);
/// For sections and keys that a later version reads: known, so not an error, and without effect yet.
[[nodiscard]] Setter Ignore();

}  // namespace annulus::toml_table
