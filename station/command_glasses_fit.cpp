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
  LensChoice lenses;
  bool size_free = false;
  bool keep_size = false;
  std::vector<std::string> set;
  std::string pd;
  std::string heights;
  std::optional<double> head_tilt;  ///< Degrees.
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
  if (options.head_tilt) fit.face.head_tilt = RadiansFromDegrees(*options.head_tilt);
  if (frame.material == DesignMaterial::kMetal) fit.frame_density = 4.5;
  return fit;
}

/// What the order says of the pupils counts more than the scan, and what was typed more than the order.
void TakePupils(const Prescription& order, GlassesFitOptions& fit) {
  if (!fit.face.pd_right) fit.face.pd_right = order.right.pd;
  if (!fit.face.pd_left) fit.face.pd_left = order.left.pd;
  if (!fit.pupil_height[0]) fit.pupil_height[0] = order.right.height;
  if (!fit.pupil_height[1]) fit.pupil_height[1] = order.left.height;
}

Result<std::optional<Prescription>> ReadOrder(const std::string& path, CommandIo& io) {
  if (path.empty()) return std::optional<Prescription>();
  const auto text = ReadTextFile(io.storage(), path);
  if (!text) return Fail(text);
  auto order = PrescriptionFromJson(*text, path);
  if (!order) return Fail(order);
  return std::optional<Prescription>(std::move(*order));
}

/// The worn file of a fit, with what was found in "fit".
WornFile WornFileOf(const GlassesFit& fit, const FrameFile& frame) {
  WornFile file{fit.worn, frame.material, {}};
  file.SetSection("fit", FitReport(fit).dump());
  return file;
}

/// The lenses of the prescription for this fit.
Result<LensPair> LensesFor(const GlassesFit& fit, const FrameFile& frame, const Prescription& order,
                           const LensChoice& choice) {
  const auto built = BuildWornFrame(fit.worn);
  if (!built) return Fail(built);
  const GlassesSource source{{fit.worn.design, frame.material, fit.worn.adjustment}, WornFileOf(fit, frame), *built};
  GlassesExportOptions options;
  options.prescription = order;
  options.lenses = choice;
  auto pair = LensesOf(source, options);
  if (!pair) return Fail(pair);
  return std::move(**pair);
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

/// A fit, and the lenses that were ordered for it.
struct FitWithLenses {
  GlassesFit fit;
  std::optional<Prescription> order;
  std::optional<LensPair> lenses;
};

/// The lenses follow the fit and the fit the lenses; the second round moves them by less than a tenth of a millimetre.
Status AddLenses(const LensChoice& choice, const WearerHead& head, const FrameFile& frame,
                 GlassesFitOptions fit_options, FitWithLenses& found) {
  const auto first = LensesFor(found.fit, frame, *found.order, choice);
  if (!first) return Fail(first);
  TakeLenses(*first, fit_options);
  auto again = FitGlasses(head, frame.design, fit_options);
  if (!again) return Fail(again);
  found.fit = std::move(*again);
  auto lenses = LensesFor(found.fit, frame, *found.order, choice);
  if (!lenses) return Fail(lenses);
  found.lenses = std::move(*lenses);
  return {};
}

Result<FitWithLenses> FitOnHead(const FitCommandOptions& options, const SurfaceModel& model, const FrameFile& frame,
                                CommandIo& io) {
  const auto surface = MeasuredSurface::FromModel(model);
  if (!surface) return Fail(surface);
  auto fit_options = FitOptionsOf(options, frame, surface->surface());
  if (!fit_options) return Fail(fit_options);
  auto order = ReadOrder(options.prescription, io);
  if (!order) return Fail(order);
  if (*order) TakePupils(**order, *fit_options);
  const auto head = WearerHead::Look(*surface, fit_options->face);
  if (!head) return Fail(head);
  auto fit = FitGlasses(*head, frame.design, *fit_options);
  if (!fit) return Fail(fit);
  FitWithLenses found{std::move(*fit), std::move(*order), {}};
  if (found.order) {
    const Status added = AddLenses(options.lenses, *head, frame, *fit_options, found);
    if (!added) return Fail(added);
  }
  return found;
}

/// The lenses in two lines each and what is to be said about them.
std::string LensText(const LensPair& pair) {
  std::string text;
  for (const LensDesign* lens : {&pair.right, &pair.left}) {
    const SpheroCylinder& power = lens->power.to_surface.power;
    text += fmt::format(
        "lens {}: make {:+.2f} {:+.2f} x {:.0f} on a base of {:.2f} D, {:.1f} to {:.1f} mm thick, {:.1f} g, blank "
        "{:.0f} mm; "
        "as worn {:.2f} D off the prescription ({:.2f} D if it were made as prescribed)\n",
        lens->eye == Eye::kRight ? "right" : "left ", power.sphere, power.cylinder, DegreesFromRadians(power.axis),
        lens->base, lens->thinnest, lens->thickest, lens->body.weight,
        lens->blank.stocked.value_or(lens->blank.minimum), lens->power.as_worn_error, lens->power.uncompensated_error);
    for (const LensMessage& message : lens->messages) text += "- " + message.text + "\n";
  }
  for (const LensMessage& message : pair.messages) text += "- " + message.text + "\n";
  return text + "PD and heights: " + pair.centration + "\n";
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
  const auto found = FitOnHead(options, *model, *frame, io);
  if (!found) return located(found.error());
  WornFile file = WornFileOf(found->fit, *frame);
  nlohmann::ordered_json report = FitReport(found->fit);
  std::string text = FitText(found->fit);
  if (found->lenses) {
    KeepOrder(*found->order, options.lenses, file);
    report["lenses"] = nlohmann::ordered_json::parse(LensPairToJson(*found->lenses));
    text += LensText(*found->lenses);
  }
  RETURN_IF_ERROR(io.WriteText(options.out, WornFileToJson(file)));
  if (!options.clearance.empty()) RETURN_IF_ERROR(io.WriteText(options.clearance, ClearanceCsv(found->fit)));
  return options.json.empty() ? io.Print(text) : io.WriteJson(options.json, report);
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
  AddLensOptions(*command, options->lenses);
  CLI::Option* free = command->add_flag("--size-free", options->size_free,
                                        "made to measure: width, bridge gap and face form are found");
  command->add_flag("--keep-size", options->keep_size, "the frame as it is (the default)")->excludes(free);
  command->add_option("--set", options->set, "a face point instead of the one found; may be repeated")
      ->type_name("NAME=X,Y,Z|THETA,Z");
  command->add_option("--pd", options->pd, "monocular pupillary distances, mm")->type_name("\"R;L\"");
  command
      ->add_option("--head-tilt", options->head_tilt,
                   "how far the head looked up, if it is known better than the scan tells")
      ->type_name("DEGREES")
      ->check(CLI::Range(-25.0, 25.0).description(""));
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
