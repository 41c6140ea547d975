// glasses fit: put a frame on a head.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <map>
#include <memory>
#include <utility>

#include "base/frames.h"
#include "base/units.h"
#include "modeling/glasses/glasses_fit.h"
#include "station/command_glasses.h"
#include "station/files.h"
#include "station/glasses_export.h"
#include "station/glasses_fit_report.h"
#include "station/worn_glasses.h"

namespace annulus {
namespace {

enum class PlacementMethod { kFit, kPaper };

struct FitCommandOptions {
  std::string model;
  std::string frame;
  std::string prescription;
  std::string lens_material = "cr39";
  bool size_free = false;
  bool keep_size = false;
  std::vector<std::string> set;
  std::string pd;
  std::string heights;
  PlacementMethod placement = PlacementMethod::kFit;
  std::string out;
  std::string json;
  std::string clearance;
};

/// Numbers between any of the separators; empty if one is not a number.
std::vector<double> NumbersOf(const std::string& text, std::string_view separators) {
  std::vector<double> numbers;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, start), text.size());
    double value = 0.0;
    const auto read = std::from_chars(text.data() + start, text.data() + end, value);
    if (read.ec != std::errc() || read.ptr != text.data() + end) return {};
    numbers.push_back(value);
    start = end + 1;
  }
  return numbers;
}

/// "eye_right=x,y,z" in mm, or "eye_right=theta,z" in degrees and mm: on the surface.
Result<GivenFacePoint> ParseFacePoint(const std::string& text, const SplineSurface& head) {
  const std::size_t equals = text.find('=');
  const std::vector<double> numbers =
      equals == std::string::npos ? std::vector<double>() : NumbersOf(text.substr(equals + 1), ",");
  if (numbers.size() < 2 || numbers.size() > 3) {
    return Fail("set a face point by '" + text + "'", "it is not a name with two or three numbers",
                "give NAME=X,Y,Z in mm or NAME=THETA,Z in degrees and mm");
  }
  GivenFacePoint given;
  given.name = text.substr(0, equals);
  if (numbers.size() == 3) {
    given.position = {numbers[0], numbers[1], numbers[2]};
    return given;
  }
  if (!(numbers[1] >= head.z_min() && numbers[1] <= head.z_max())) {
    return Fail("set a face point by '" + text + "'",
                fmt::format("the model reaches from z = {:.0f} to {:.0f} mm", head.z_min(), head.z_max()),
                "give a height in between");
  }
  given.position = head.Point(RadiansFromDegrees(numbers[0]), numbers[1]);
  return given;
}

/// "R;L" (or with a comma or slash) into two values.
Status ParsePair(const std::string& text, const char* what, std::optional<double>& right, std::optional<double>& left) {
  if (text.empty()) return {};
  const std::vector<double> numbers = NumbersOf(text, ";,/");
  if (numbers.size() != 2) {
    return Fail(fmt::format("read the {} '{}'", what, text), "it is not two numbers", "give \"R;L\" in mm");
  }
  right = numbers[0];
  left = numbers[1];
  return {};
}

Result<GlassesFitOptions> FitOptionsOf(const FitCommandOptions& options, const FrameFile& frame,
                                       const SplineSurface& head) {
  GlassesFitOptions fit;
  fit.size = options.size_free ? FitSize::kMadeToMeasure : FitSize::kKept;
  for (const std::string& text : options.set) {
    const auto given = ParseFacePoint(text, head);
    if (!given) return Fail(given);
    fit.face.points.push_back(*given);
  }
  RETURN_IF_ERROR(ParsePair(options.pd, "pupillary distances", fit.face.pd_right, fit.face.pd_left));
  RETURN_IF_ERROR(ParsePair(options.heights, "pupil heights", fit.pupil_height[0], fit.pupil_height[1]));
  if (frame.material == DesignMaterial::kMetal) fit.frame_density = 4.5;
  return fit;
}

/// The worn file of a fit, with what was found in "fit".
WornFile WornFileOf(const GlassesFit& fit, const FrameFile& frame) {
  WornFile file{fit.worn, frame.material, {}};
  file.SetSection("fit", FitReport(fit).dump());
  return file;
}

/// The lenses of the prescription for this fit.
Result<std::optional<LensPair>> LensesFor(const GlassesFit& fit, const FrameFile& frame, const Prescription& order,
                                          const std::string& material) {
  const auto built = BuildWornFrame(fit.worn);
  if (!built) return Fail(built);
  const GlassesSource source{{fit.worn.design, frame.material, fit.worn.adjustment}, WornFileOf(fit, frame), *built};
  GlassesExportOptions options;
  options.prescription = order;
  options.lens_material = material;
  return LensesOf(source, options);
}

/// How the lenses change the fit: their weight, and where their backs are behind the rim's plane.
void TakeLenses(const LensPair& pair, GlassesFitOptions& options) {
  const std::array<const LensDesign*, 2> lenses{&pair.right, &pair.left};
  for (std::size_t side = 0; side < 2; ++side) {
    options.lens_mass_g[side] = lenses[side]->body.weight;
    options.lens_back[side] = lenses[side]->bevel.mean_z - lenses[side]->form.back_point.z();
  }
}

Status RunPaperPlacement(const FitCommandOptions& options, const SurfaceModel& model, const FrameFile& frame,
                         CommandIo& io) {
  const auto worn = FitFrame(model.main().surface, frame.design);
  if (!worn) return Fail(worn);
  RETURN_IF_ERROR(io.WriteText(options.out, WornFrameToJson(*worn)));
  return options.json.empty() ? io.Print(PlacementText(*worn)) : io.WriteJson(options.json, PlacementReport(*worn));
}

Result<GlassesFit> FitOnHead(const FitCommandOptions& options, const SurfaceModel& model, const FrameFile& frame,
                             CommandIo& io) {
  const auto surface = MeasuredSurface::FromModel(model);
  if (!surface) return Fail(surface);
  auto fit_options = FitOptionsOf(options, frame, surface->surface());
  if (!fit_options) return Fail(fit_options);
  const auto head = WearerHead::Look(*surface, fit_options->face);
  if (!head) return Fail(head);
  auto fit = FitGlasses(*head, frame.design, *fit_options);
  if (!fit || options.prescription.empty()) return fit;
  const auto text = ReadTextFile(io.storage(), options.prescription);
  if (!text) return Fail(text);
  const auto order = PrescriptionFromJson(*text, options.prescription);
  if (!order) return Fail(order);
  // The lenses follow the fit and the fit the lenses; the second round moves them by less than a tenth of a millimetre.
  const auto pair = LensesFor(*fit, frame, *order, options.lens_material);
  if (!pair) return Fail(pair);
  if (*pair) TakeLenses(**pair, *fit_options);
  return FitGlasses(*head, frame.design, *fit_options);
}

Status RunFitGlasses(const FitCommandOptions& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  const auto frame = ReadFrameFile(io.storage(), options.frame);
  if (!frame) return Fail(frame);
  const auto located = [&](Error error) {
    error.attempted = "fit " + options.frame + " on " + options.model + ": " + error.attempted;
    return tl::unexpected<Error>(error);
  };
  if (options.placement == PlacementMethod::kPaper) {
    const Status placed = RunPaperPlacement(options, *model, *frame, io);
    return placed ? placed : located(placed.error());
  }
  const auto fit = FitOnHead(options, *model, *frame, io);
  if (!fit) return located(fit.error());
  RETURN_IF_ERROR(io.WriteText(options.out, WornFileToJson(WornFileOf(*fit, *frame))));
  if (!options.clearance.empty()) RETURN_IF_ERROR(io.WriteText(options.clearance, ClearanceCsv(*fit)));
  return options.json.empty() ? io.Print(FitText(*fit)) : io.WriteJson(options.json, FitReport(*fit));
}

}  // namespace

void AddGlassesFit(CLI::App& parent, CommandWork& chosen) {
  static const std::map<std::string, PlacementMethod> kPlacements{{"fit", PlacementMethod::kFit},
                                                                  {"paper", PlacementMethod::kPaper}};
  auto options = std::make_shared<FitCommandOptions>();
  CLI::App* command = parent.add_subcommand("fit", "put a frame on the head of a model");
  command->add_option("model", options->model, "model with a head")->required();
  command->add_option("--frame", options->frame, "frame to put on")->required()->type_name("FRAME.json");
  command->add_option("--rx", options->prescription, "prescription: weight and back of its lenses count")
      ->type_name("RX.json");
  command->add_option("--lens-material", options->lens_material, "what the lenses are made of")
      ->type_name("NAME")
      ->capture_default_str();
  CLI::Option* free = command->add_flag("--size-free", options->size_free,
                                        "made to measure: width, bridge gap and face form are found");
  command->add_flag("--keep-size", options->keep_size, "the frame as it is (the default)")->excludes(free);
  command->add_option("--set", options->set, "a face point instead of the one found; may be repeated")
      ->type_name("NAME=X,Y,Z|THETA,Z");
  command->add_option("--pd", options->pd, "monocular pupillary distances, mm")->type_name("\"R;L\"");
  command->add_option("--heights", options->heights, "pupils over the boxes' lower edges that are wanted, mm")
      ->type_name("\"R;L\"");
  command
      ->add_option("--placement", options->placement,
                   "fit: by contact, targets and clearance; paper: by the four steps of paper 000")
      ->transform(CLI::CheckedTransformer(kPlacements))
      ->type_name("fit|paper");
  command->add_option("--out", options->out, "worn frame to write")->required()->type_name("WORN.json");
  AddJsonOption(*command, options->json);
  command->add_option("--clearance", options->clearance, "distances of all parts from the head to write")
      ->type_name("F.csv");
  command->footer("Example: annulus glasses fit model.json --frame frame.json --out worn.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunFitGlasses(*options, io); }; });
}

}  // namespace annulus
