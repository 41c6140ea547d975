#include "station/picture_maker.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/units.h"
#include "station/files.h"
#include "station/inside_map.h"
#include "station/inside_view.h"
#include "station/lens_choice.h"
#include "station/measure_pictures.h"
#include "station/worn_lenses.h"

namespace annulus {
namespace {

/// The order that is kept with worn glasses, for their lenses.
Result<GlassesExportOptions> OrderOf(const GlassesSource& worn, const std::string& path) {
  GlassesExportOptions order;
  if (!worn.worn) return order;
  const auto kept = KeptOrderOf(*worn.worn, path);
  if (!kept) return Fail(kept);
  if (*kept) {
    order.prescription = (*kept)->order;
    order.lenses = (*kept)->choice;
  }
  return order;
}

/// What the wearer sees, or what the lenses give in every direction of gaze.
Result<MadePicture> FromInside(const RenderRequest& request, const Look& look, PictureSources& sources,
                               const TaskContext& task) {
  const auto studio = sources.StudioOf(request.model);
  if (!studio) return Fail(studio);
  const auto worn = sources.WornOf(request.worn);
  if (!worn) return Fail(worn);
  const auto order = OrderOf(**worn, request.worn);
  if (!order) return Fail(order);
  const auto glasses = InsideGlassesOf(**worn, *order);
  if (!glasses) return Fail(glasses);
  const auto lenses = WornLenses(**worn, look.lens, request.worn);
  if (!lenses) return Fail(lenses);
  auto options = InsideOptionsOf(request);
  if (!options) return Fail(options);
  options->finish = lenses->lenses.front().finish;
  options->frame = MaterialOf(look.upper);
  auto image = request.inside_map ? DrawInsideMap(*glasses, options->eyes, options->gazes)
                                  : DrawInsideView(*glasses, &(*studio)->model(), *options, task);
  if (!image) return Fail(image);
  MadePicture made;
  made.frames.push_back(std::move(*image));
  made.notes = glasses->notes;
  made.numbers = InsideReport(*glasses, options->eyes, options->gazes).dump();
  return made;
}

/// A model of the request with what is drawn of it.
Result<PictureSubject> SubjectOf(const std::string& model, const std::string& worn, const std::string& scan,
                                 PictureSources& sources) {
  const auto body = sources.BodyOf(model);
  if (!body) return Fail(body);
  const auto studio = sources.StudioOf(model);
  if (!studio) return Fail(studio);
  const auto glasses = sources.WornOf(worn);
  if (!glasses) return Fail(glasses);
  const auto samples = sources.SamplesOf(scan);
  if (!samples) return Fail(samples);
  PictureSubject subject;
  subject.model = &(*studio)->model();
  subject.body = *body;
  if (*glasses != nullptr) {
    if (!(*glasses)->worn) {
      return Fail("draw " + worn + " on a head", "nobody wears it: the file is a design",
                  "put it on the head first, with 'annulus glasses fit'");
    }
    subject.worn = &(*glasses)->worn->worn;
  }
  subject.samples = *samples;
  subject.caption = worn.empty() ? model : model + ", " + worn;
  return subject;
}

Result<MapInput> MapInputOf(const RenderRequest& request, PictureSources& sources) {
  MapInput input;
  if (!request.against.empty()) {
    auto against = SubjectOf(request.against, "", "", sources);
    if (!against) return Fail(against);
    input.against = std::move(*against);
  }
  if (!request.values.empty()) {
    auto text = ReadTextFile(sources.storage(), request.values);
    if (!text) return Fail(text);
    input.values_csv = std::move(*text);
    input.values_name = request.values;
  }
  return input;
}

/// Maps, tapes and landmarks, on the body or unrolled, one or two subjects.
Result<MadePicture> Measuring(const RenderRequest& request, const PictureOptions& picture, PictureSources& sources,
                              const TaskContext& task) {
  std::vector<PictureSubject> subjects;
  auto first = SubjectOf(request.model, request.worn, request.scan, sources);
  if (!first) return Fail(first);
  if (!request.caption.empty()) first->caption = request.caption;
  subjects.push_back(std::move(*first));
  if (!request.beside.empty() || !request.beside_worn.empty()) {
    const std::string& model = request.beside.empty() ? request.model : request.beside;
    auto second = SubjectOf(model, request.beside_worn, request.beside_scan, sources);
    if (!second) return Fail(second);
    subjects.push_back(std::move(*second));
  }
  const auto input = MapInputOf(request, sources);
  if (!input) return Fail(input);
  const auto options = MeasureOptionsOf(request);
  if (!options) return Fail(options);
  const auto prepared = MeasurePicture::Prepare(subjects, *input, *options, task);
  if (!prepared) return Fail(prepared);
  MadePicture made;
  if (const auto& range = prepared->range()) {
    made.numbers = nlohmann::ordered_json{
        {"least", range->least},
        {"greatest", range->greatest},
        {"mean", range->mean},
        {"rms", range->rms},
        {"scale_minimum", range->minimum},
        {"scale_maximum", range->maximum},
        {"share_below_scale", range->below},
        {"share_above_scale",
         range->above}}.dump();
  }
  if (request.turntable > 0) {
    auto frames = prepared->DrawAround(picture.view, request.turntable, task);
    if (!frames) return Fail(frames);
    made.frames = std::move(*frames);
  } else {
    auto image = prepared->Draw(picture.view, task);
    if (!image) return Fail(image);
    made.frames.push_back(std::move(*image));
  }
  return made;
}

/// From outside, once or all around.
Result<MadePicture> FromOutside(const RenderRequest& request, PictureOptions options, PictureSources& sources,
                                const TaskContext& task) {
  const auto studio = sources.StudioOf(request.model);
  if (!studio) return Fail(studio);
  const auto worn = sources.WornOf(request.worn);
  if (!worn) return Fail(worn);
  MadePicture made;
  const int count = std::max(1, request.turntable);
  if (request.turntable > 0) options.framing = PictureFraming::kTurning;
  const double start = options.view.azimuth;
  for (int k = 0; k < count; ++k) {
    options.view.azimuth = start + kTwoPi * k / count;
    auto picture = (*studio)->Take(*worn, request.worn, options, task);
    if (!picture) return Fail(picture);
    if (k == 0) {
      made.camera = picture->camera;
      made.notes = std::move(picture->notes);
    }
    made.frames.push_back(std::move(picture->image));
  }
  return made;
}

}  // namespace

Result<MadePicture> MakePicture(const RenderRequest& request, const PictureOptions& options, PictureSources& sources,
                                const TaskContext& task) {
  if (!request.inside.empty()) return FromInside(request, options.look, sources, task);
  if (IsMeasuring(request)) return Measuring(request, options, sources, task);
  return FromOutside(request, options, sources, task);
}

}  // namespace annulus
