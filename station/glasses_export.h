#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/lens_design.h"
#include "modeling/glasses/prescription.h"
#include "station/glasses_source.h"
#include "station/lens_choice.h"

namespace annulus {

/// What a user may say about an export.
struct GlassesExportOptions {
  enum class Skin {
    kShells,  ///< Closed shells that overlap: what slicers unite.
    kFused,   ///< One skin round each body.
  } skin = Skin::kShells;
  enum class ThinWalls { kRefuse, kWarn } thin_walls = ThinWalls::kRefuse;
  std::optional<double> least_wall;  ///< mm; absent: the usual one of the frame's material.
  std::string reference;             ///< Of the customer or the order; shown as it is.
  std::string confirmed_by;          ///< Who confirmed PDs and heights; "": nobody did.
  std::optional<Prescription> prescription;
  LensChoice lenses;
};

/// A solid of a STEP file.
struct ExportedSolid {
  std::string body;
  double volume = 0.0;     ///< mm³
  bool fused = false;      ///< Not so: the shells' solids, overlapping.
  std::size_t pieces = 0;  ///< Solids in the file.
};

/// A file as it will be written, and what its maker should know.
struct ExportedFile {
  std::string bytes;
  std::vector<std::string> notes{};     ///< One line each.
  std::vector<ExportedSolid> solids{};  ///< Of a STEP file.
};

/// Binary STL of the frame for printing, frame frame, mm: closed, without triangles that have lost a side in float32.
/// Fails on walls that are too thin (CheckWalls) unless that is to be a note. A body that cannot be fused comes as its
/// shells, with a note.
[[nodiscard]] Result<ExportedFile> GlassesStl(const GlassesSource& source, const GlassesExportOptions& options);

/// STEP of the frame: one product per body (StepText). The same walls count.
[[nodiscard]] Result<ExportedFile> GlassesStep(const GlassesSource& source, const GlassesExportOptions& options);

/// The trace of both lenses for a lab. Fails without a name in options.confirmed_by: no lab file leaves without one.
/// PDs and heights are the prescription's; those that it lacks are the worn frame's.
[[nodiscard]] Result<ExportedFile> GlassesDcs(const GlassesSource& source, const GlassesExportOptions& options);

/// FRAME.json that builds this frame to the byte.
[[nodiscard]] ExportedFile GlassesJson(const GlassesSource& source);

/// The prescription with PDs and heights that it lacks from the worn frame, confirmed if options say so; nothing
/// without a prescription.
[[nodiscard]] std::optional<Prescription> CentredPrescription(const GlassesSource& source,
                                                              const GlassesExportOptions& options);
/// The lenses of that order in this frame; nothing without a prescription. Fails if they cannot be made.
[[nodiscard]] Result<std::optional<LensPair>> LensesOf(const GlassesSource& source,
                                                       const GlassesExportOptions& options);

}  // namespace annulus
