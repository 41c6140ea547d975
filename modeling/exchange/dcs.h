#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/lens_outline.h"

namespace annulus {

/// What a frame is made of, as FTYP names it.
enum class DcsFrame { kPlastic = 1, kMetal = 2, kRimless = 3 };
/// How a lens is held, as ETYP names it.
enum class DcsEdge { kBevel = 1, kRimless = 2, kGroove = 3 };

/// One lens of a trace. Lengths are mm to 0.01.
struct DcsEye {
  /// n radii about the box centre at angles i · 2π / n: front view, counter-clockwise from 3 o'clock. Between them the
  /// outline is straight.
  std::vector<double> radii;
  double hbox = 0.0;  ///< HBOX: the box's width A.
  double vbox = 0.0;  ///< VBOX: its height B.
  double fed = 0.0;   ///< FED: effective diameter.
  double circ = 0.0;  ///< CIRC: length of the outline.

  std::optional<double> ipd;       ///< IPD: monocular pupillary distance, mm.
  std::optional<double> ocht;      ///< OCHT: optical centre above the box's lower side, mm.
  std::optional<double> sphere;    ///< SPH, D.
  std::optional<double> cylinder;  ///< CYL, D.
  std::optional<double> axis_deg;  ///< AX, 0 … 180.
  std::optional<double> add;       ///< ADD, D.
  std::optional<double> prism;     ///< PRVM, cm/m.
  std::optional<double>
      base_deg;  ///< PRVA: where its base lies, 0 … 360, front view, counter-clockwise from 3 o'clock.
  std::optional<double> frame_curve;  ///< FCRV, D at n = 1.53.

  [[nodiscard]] bool operator==(const DcsEye&) const = default;
};

/// A trace of both eyes for a lab: what a .dcs file holds.
struct DcsJob {
  std::string job;                      ///< JOB: reference of the order.
  double dbl = 0.0;                     ///< DBL: distance between lenses, mm.
  DcsFrame frame = DcsFrame::kPlastic;  ///< FTYP.
  DcsEdge edge = DcsEdge::kBevel;       ///< ETYP.
  std::string lens_name;                ///< LNAM; "" leaves it out.
  std::string confirmed_by;             ///< _CONFIRMED: who answers for PDs and heights; "" leaves it out.
  DcsEye right;
  DcsEye left;

  [[nodiscard]] bool operator==(const DcsJob&) const = default;
};

/// How near the radii of a trace come to its outline and its box, mm.
inline constexpr double kDcsOutlineTolerance = 0.01;
inline constexpr double kDcsBoxTolerance = 0.02;

/// Boxes, effective diameters, circumferences and radii of both outlines: the smallest n of 400, 800, 1000, 2000, 4000,
/// 8000 and 16000 whose polygon of rounded radii is within kDcsOutlineTolerance of both. If the outlines are mirror
/// images, so are the radii: L[n/2 - i] = R[i]. Fails on an outline that is invalid or has a corner too sharp for that.
struct DcsTrace {
  DcsEye right;
  DcsEye left;
};
[[nodiscard]] Result<DcsTrace> TraceOutlines(const LensOutline& right, const LensOutline& left);

/// Largest distance of the outline of `eye` from `outline` (which is about any origin), mm.
[[nodiscard]] double OutlineDeviation(const DcsEye& eye, const LensOutline& outline);

/// The file: records LABEL=value, chiral ones right;left, ten radii of 0.01 mm a line, CRLF, ASCII. In texts what is
/// not printable ASCII, and ';' and '=', become '?'. The records are those of published samples of the Vision Council's
/// Data Communication Standard; no conformance is claimed. Requires radii of both eyes.
[[nodiscard]] std::string DcsText(const DcsJob& job);

/// Reads such a file: TRCFMT=1 with equal angles for both eyes, 90 … 36000 radii each, HBOX, VBOX, DBL. Lines may end
/// in LF. Other labels are skipped. Refuses, with the line: bytes that are not printable ASCII, a line that is no
/// record, a known record twice, numbers that are none or out of range, radii whose box is not HBOX, VBOX within
/// kDcsBoxTolerance. `name` of the file is for messages.
[[nodiscard]] Result<DcsJob> DcsFromText(std::string_view text, std::string_view name);

}  // namespace annulus
