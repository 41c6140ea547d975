#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "render/overlay.h"
#include "render/scalar_map.h"
#include "station/figure.h"

namespace annulus {

/// A line over a panel.
struct PanelLine {
  OverlayRun run;
  SheetColour colour;
};

/// A marked place of a panel.
struct PanelPoint {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< Pixels, y down.
  SheetColour colour;
  bool visible = true;
};

/// Words in the margin with a thin line to what they name.
struct PanelLabel {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< Pixels, y down.
  std::string text;
  SheetColour colour;
};

/// One picture of a figure with what is drawn over and around it.
struct MapPanel {
  RgbImage image;
  std::string caption;         ///< Under it.
  double pixels_per_mm = 0.0;  ///< Of the body, for a scale bar; 0: none.
  /// Lowest and highest z (mm) of an unrolled map: axes are drawn around it instead of a scale bar.
  std::optional<std::array<double, 2>> unrolled{};
  std::vector<PanelLine> lines{};
  std::vector<PanelPoint> points{};
  std::vector<PanelLabel> labels{};
  double label_room_mm = 0.0;  ///< At least so much on both sides, so that frames of a film are of one size.
};

/// What the colours mean.
struct MapLegend {
  MapColours colours;
  std::string unit;
  ValueRange range;         ///< Says which end is clamped.
  std::string under_label;  ///< Of ValueScale::under.
  std::string over_label;   ///< Of ValueScale::over.
  std::string hatch_label;  ///< "" leaves it out.
  bool grey = false;        ///< Whether grey (no value) is explained.
};

struct MapFigureText {
  std::string title;
  std::vector<std::string> notes;  ///< Paragraphs under the panels.
};

/// Room that labels of these texts need on a side, mm.
[[nodiscard]] double LabelRoom(const std::vector<std::string>& texts);

/// Panels side by side, their labels in columns beside them, the legend at the right, notes below. The pixels of a
/// panel stay as they are when the figure becomes an image of `pixels_per_mm`. Requires a panel.
[[nodiscard]] Figure MapFigure(const std::vector<MapPanel>& panels, const std::optional<MapLegend>& legend,
                               const MapFigureText& text, double pixels_per_mm);

}  // namespace annulus
