#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "base/storage.h"
#include "station/inside_view.h"
#include "station/measure_pictures.h"
#include "station/pictures.h"

namespace annulus {

/// What is typed about one picture: on the command line, or as an object of a batch file with the same names.
struct RenderRequest {
  std::string model;
  std::string worn;
  std::string view;
  int size = 720;
  std::string out;
  std::string alpha;
  std::string depth;
  std::string caption;  ///< Under the picture on a sheet of a batch.
  RenderMethod method = RenderMethod::kZBuffer;
  PictureBackground background = PictureBackground::kBackdrop;
  int supersampling = 2;
  LensMedium lens_medium = LensMedium::kThin;
  LightPreset light = LightPreset::kStudio;
  int samples = 64;
  std::uint64_t seed = 0;
  bool no_denoise = false;
  bool dispersion = false;
  std::string progressive;  ///< A file that is replaced whenever the picture has become better.
  int turntable = 0;        ///< Frames all around; 0: one picture.
  std::string frames;       ///< Folder for the frames of a turntable, as PNG.
  // Pictures that measure.
  std::optional<MapKind> map;
  std::string range;    ///< "A,B": ends of the scale.
  std::string scan;     ///< For residuals.
  std::string against;  ///< The second model of a difference or a strain.
  std::string values;   ///< CSV of a map of one's own.
  std::optional<TapeChoice> tapes;
  bool landmarks = false;
  bool unrolled = false;
  std::string beside;       ///< A second model in the same picture.
  std::string beside_worn;  ///< What it wears; alone: other glasses on the same model.
  std::string beside_scan;
  // View from inside.
  std::string inside;  ///< "right", "left", "both"; empty: from outside.
  std::string gaze = "0,0";
  bool inside_map = false;
  GazeSceneKind inside_scene = GazeSceneKind::kShop;
  double pupil_mm = 4.0;
  // The look; what is absent is LOOK.json's, or the usual.
  std::string look;
  std::string frame_colour;
  std::string upper_colour;
  std::string lower_colour;
  std::optional<Finish> frame_material;
  std::optional<Finish> upper_material;
  std::optional<Finish> lower_material;
  std::optional<TexturePattern> upper_texture;
  std::optional<TexturePattern> lower_texture;
  std::string lens_colour;
  std::optional<double> lens_transmittance;
  std::optional<double> lens_lower_transmittance;
  std::optional<LensCoating> lens_coating;
  std::optional<double> lens_power;
  std::string lips;
  std::string cheeks;
  std::string brows;
};

/// Adds the options of one picture. `request` must outlive the parsing. Nothing is required here: CheckRequest knows
/// what must be there.
void AddRenderOptions(CLI::App& command, RenderRequest& request);

/// What can be said before any file is read: model, view and output are there and make sense. Its errors are wrong
/// usage.
[[nodiscard]] Status CheckRequest(const RenderRequest& request);

/// The look: LOOK.json, and over it what was typed. Fails on a file that cannot be read and a colour that is none.
[[nodiscard]] Result<Look> LookOf(const RenderRequest& request, Storage& storage);

/// Whether the picture is one that measures: a map, tapes, landmarks, or two side by side.
[[nodiscard]] bool IsMeasuring(const RenderRequest& request);
/// What a checked request for such a picture wants.
[[nodiscard]] Result<MeasurePictureOptions> MeasureOptionsOf(const RenderRequest& request);

/// What a checked request for a view from inside wants.
[[nodiscard]] Result<InsideViewOptions> InsideOptionsOf(const RenderRequest& request);

/// The rest of a checked request.
[[nodiscard]] Result<PictureOptions> PictureOptionsOf(const RenderRequest& request, Storage& storage);

}  // namespace annulus
