#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "modeling/glasses/placement.h"
#include "modeling/measure/measured_surface.h"
#include "render/camera.h"
#include "render/image.h"
#include "station/body_maps.h"
#include "station/map_figure.h"

namespace annulus {

/// Whom a picture shows. Borrows all; must outlive what is made of it.
struct PictureSubject {
  const SurfaceModel* model = nullptr;
  const MeasuredSurface* body = nullptr;                ///< Of the model.
  const WornFrame* worn = nullptr;                      ///< Null: no glasses.
  const std::vector<SurfaceSample>* samples = nullptr;  ///< Of its scans, for residuals (FittedSamples); may be null.
  std::string caption;                                  ///< Under its panel: a file's name, a date.
};

/// What a map needs beside its subjects.
struct MapInput {
  std::optional<PictureSubject> against{};  ///< The second model of a difference or a strain.
  std::string values_csv{};                 ///< Text of the table of kValues.
  std::string values_name{};                ///< Its file's name.
};

enum class TapeChoice {
  kNone,
  kGirths,  ///< The horizontal girths.
  kAll,     ///< Every measurement of the table that has a line on the body, heights left out.
};
enum class LandmarkChoice { kNone, kAll };
enum class PictureForm {
  kBody,      ///< On the body, seen from a view.
  kUnrolled,  ///< theta to the right, z upwards. Main segment.
};

/// What is drawn of a subject.
struct MeasurePictureOptions {
  std::optional<MapKind> map{};
  std::optional<std::array<double, 2>> range{};  ///< Ends of the scale instead of the map's rule.
  TapeChoice tapes = TapeChoice::kNone;
  LandmarkChoice landmarks = LandmarkChoice::kNone;
  PictureForm form = PictureForm::kBody;
  int size = 720;  ///< Pixels of the longer side of a panel, 100 … 4096; margins, legend and notes come on top.
};

/// Pictures that measure: prepared once, drawn from any view. One panel per subject (two of a clearance map: the head
/// without the frame, and the frame), all from one direction at one scale (orthographic) with one legend.
class MeasurePicture {
 public:
  /// Borrows what the subjects borrow. Fails if a map's input is missing or useless, the range or size is out of range,
  /// or nothing can be drawn or measured.
  static Result<MeasurePicture> Prepare(const std::vector<PictureSubject>& subjects, const MapInput& input,
                                        const MeasurePictureOptions& options, const TaskContext& task);

  /// The figure from a view; the view does not matter for an unrolled one.
  [[nodiscard]] Result<RgbImage> Draw(const View& view, const TaskContext& task) const;
  /// `count` figures around the subject, the first from `start`, each 360/count degrees of azimuth further; the
  /// camera's distance, scale and lamp are those of all.
  [[nodiscard]] Result<std::vector<RgbImage>> DrawAround(const View& start, int count, const TaskContext& task) const;
  /// What the scale was made from: least, greatest, mean, … of the map; nothing without a map of numbers.
  [[nodiscard]] const std::optional<ValueRange>& range() const { return range_; }

 private:
  /// A line on the body with its name.
  struct Tape {
    std::vector<std::vector<Eigen::Vector3d>> paths;
    SheetColour colour;
    std::string label;
  };
  struct Mark {
    Eigen::Vector3d position;
    SheetColour colour;
    std::string label;
  };
  struct Panel {
    std::vector<MapMesh> meshes;
    std::optional<UnrolledMap> unrolled;
    double girth = 0.0;  ///< Mean length around, mm, of an unrolled map.
    std::vector<Tape> tapes;
    std::vector<Mark> marks;
    std::string caption;
  };
  /// One camera for all panels.
  struct Framed {
    Camera camera;
    int width = 0;
    int height = 0;
    double pixels_per_mm = 0.0;
  };

  MeasurePicture() = default;
  Status AddMap(const std::vector<PictureSubject>& subjects, const MapInput& input);
  Status AddClearance(const std::vector<PictureSubject>& subjects);
  void AddField(const PictureSubject& subject, const BodyField& field);
  Status AddMarks(const std::vector<PictureSubject>& subjects, const TaskContext& task);
  void Describe(const BodyField& field);
  void DescribeRange(const BodyField& field, const std::vector<WeightedValue>& values);
  void DescribeClasses(const std::vector<WeightedValue>& values);
  [[nodiscard]] Result<Framed> FrameAll(const View& view) const;
  [[nodiscard]] Result<Framed> FrameTurning(const View& view) const;
  [[nodiscard]] Result<MapPanel> DrawPanel(const Panel& panel, const Framed& framed, const TaskContext& task) const;
  [[nodiscard]] MapPanel DrawUnrolled(const Panel& panel) const;
  void MarkOn(const Panel& panel, const Framed& framed, MapPanel& drawn) const;
  [[nodiscard]] Result<RgbImage> DrawFramed(const Framed& framed, const std::string& from,
                                            const TaskContext& task) const;

  MeasurePictureOptions options_;
  std::vector<Panel> panels_;
  std::optional<MapLegend> legend_;
  std::optional<ValueRange> range_;
  MapFigureText text_;
  double label_room_mm_ = 0.0;  ///< Of a film's frames.
};

}  // namespace annulus
