#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/lens_design.h"

namespace annulus {

/// What a user says about the lenses of a pair of glasses.
struct LensChoice {
  std::string material;                ///< Of the catalogue, or "INDEX,ABBE,DENSITY"; empty: cr39.
  std::optional<double> base_curve;    ///< D, in the lens' own index; absent: Vogel's rule.
  std::optional<double> least_centre;  ///< mm; absent: LensOptions' own.
  std::optional<double> least_edge;    ///< mm
  bool as_prescribed = false;          ///< Made to the prescription itself, not to give it as worn.
};

/// --lens-material, --base-curve, --min-centre, --min-edge, --as-prescribed. `choice` must outlive the parsing.
void AddLensOptions(CLI::App& command, LensChoice& choice);

/// The material that is meant. Fails on a name that is not known and on impossible numbers.
[[nodiscard]] Result<LensMaterial> MaterialOf(const LensChoice& choice);
/// The rest for DesignLensPair.
[[nodiscard]] LensOptions LensOptionsOf(const LensChoice& choice);

/// `given`, and where it says nothing `kept`.
[[nodiscard]] LensChoice Completed(const LensChoice& given, const LensChoice& kept);

/// Keeps order and choice in WORN.json, as "prescription" and "lens_choice".
void KeepOrder(const Prescription& order, const LensChoice& choice, WornFile& file);
/// What is kept there; `path` is for messages. Empty if nothing is. Refuses a choice with an unknown key, a wrong type
/// or a number out of the command line's range: a lens would be made of it.
struct KeptOrder {
  Prescription order;
  LensChoice choice;
};
[[nodiscard]] Result<std::optional<KeptOrder>> KeptOrderOf(const WornFile& file, const std::string& path);

}  // namespace annulus
