#include "modeling/measure/section_svg.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"
#include "base/markup_text.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/section.h"
#include "modeling/measure/section_arcs.h"
#include "modeling/measure/section_sampler.h"
#include "modeling/measure/surface_path.h"

namespace annulus {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;  // standard normal quantile at 0.975

constexpr double kTolerance = 0.01;   // mm between drawing and section
constexpr double kMargin = 15.0;      // mm around the section and its labels
constexpr double kLineHeight = 5.5;   // mm
constexpr double kNarrowest = 120.0;  // mm of paper: room for the text
constexpr double kHollow = 0.02;      // mm of air under the tape that are worth a straight line
constexpr std::size_t kTapePoints = 1440;

/// Directions in a row that are known alike.
struct KnownRun {
  Knowledge knowledge = Knowledge::kUnknown;
  double from = 0.0;  ///< rad
  double to = 0.0;    ///< rad, > from
};

/// The runs of the whole turn; one of a whole turn if all is known alike.
std::vector<KnownRun> RunsOfSection(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(1, body.segment().knowledge.columns());
  const double width = kTwoPi / static_cast<double>(columns);
  const auto at = [&](std::size_t k) { return body.KnowledgeAt(static_cast<double>(k % columns) * width, z); };
  std::size_t first = 0;  // a column that differs from the one before
  while (first < columns && at(first) == at(first + columns - 1)) ++first;
  if (first == columns) return {{at(0), 0.0, kTwoPi}};
  std::vector<KnownRun> runs;
  for (std::size_t k = first; k < first + columns; ++k) {
    const double low = (static_cast<double>(k) - 0.5) * width;
    if (runs.empty() || runs.back().knowledge != at(k)) runs.push_back({at(k), low, low});
    runs.back().to = low + width;
  }
  return runs;
}

double ShareOf(const std::vector<KnownRun>& runs, Knowledge knowledge) {
  double sum = 0.0;
  for (const KnownRun& run : runs) sum += run.knowledge == knowledge ? run.to - run.from : 0.0;
  return sum / kTwoPi;
}

/// Draws in mm of the station frame seen from above; y of the paper points down.
class Paper {
 public:
  static std::string At(const Eigen::Vector2d& p) { return fmt::format("{:.4f},{:.4f}", p.x(), -p.y()); }

  static std::string Curves(const std::vector<SectionArc>& arcs) {
    std::string text;
    for (const SectionArc& arc : arcs) text += " C" + At(arc[1]) + " " + At(arc[2]) + " " + At(arc[3]);
    return text;
  }

  static std::string Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const char* kind) {
    return fmt::format("<line class=\"{}\" x1=\"{:.3f}\" y1=\"{:.3f}\" x2=\"{:.3f}\" y2=\"{:.3f}\"/>\n", kind, a.x(),
                       -a.y(), b.x(), -b.y());
  }

  static std::string Text(const Eigen::Vector2d& p, const char* anchor, const std::string& text) {
    return fmt::format("<text x=\"{:.3f}\" y=\"{:.3f}\" text-anchor=\"{}\">{}</text>\n", p.x(), -p.y(), anchor, text);
  }
};

std::string SkinPath(const SplineSurface& surface, double z, const KnownRun& run) {
  const std::vector<SectionArc> arcs = FitSectionArcs(surface, z, run.from, run.to, kTolerance);
  const bool whole = run.to - run.from >= kTwoPi;
  return fmt::format("<path class=\"{}\" d=\"M{}{}{}\"/>\n",
                     run.knowledge == Knowledge::kMeasured ? "measured" : "inferred", Paper::At(arcs.front()[0]),
                     Paper::Curves(arcs), whole ? " Z" : "");
}

/// Whether there is air between the skin and the tape's straight line from one corner to another.
bool IsHollow(const std::vector<Eigen::Vector2d>& skin, std::size_t from, std::size_t to) {
  const Eigen::Vector2d chord = (skin[to % skin.size()] - skin[from]).normalized();
  for (std::size_t k = from + 1; k < to; ++k) {
    const Eigen::Vector2d p = skin[k % skin.size()] - skin[from];
    if (chord.x() * p.y() - chord.y() * p.x() > kHollow) return true;
  }
  return false;
}

/// The hull: straight over hollows, elsewhere along the skin.
std::string TapePath(const SplineSurface& surface, double z) {
  const std::vector<double> directions = EvenDirections(kTapePoints);
  const std::vector<Eigen::Vector2d> skin = SectionSampler(surface, directions).Points(z);
  const std::vector<std::size_t> corners = HullOfSection(skin);
  const double step = kTwoPi / static_cast<double>(kTapePoints);
  // The hull's corners may begin anywhere on the turn; from here on they ascend.
  std::string path = "M" + Paper::At(skin[corners.front()]);
  std::size_t lying_from = corners.front();  // where the tape has lain on the skin since
  const auto lie = [&](std::size_t until) {
    if (until == lying_from) return;
    path += Paper::Curves(FitSectionArcs(surface, z, static_cast<double>(lying_from) * step,
                                         static_cast<double>(until) * step, kTolerance));
  };
  std::size_t last = corners.front();
  for (std::size_t k = 1; k <= corners.size(); ++k) {
    std::size_t next = corners[k % corners.size()];
    while (next <= last) next += kTapePoints;
    if (IsHollow(skin, last % kTapePoints, last % kTapePoints + (next - last))) {
      lie(last);
      path += " L" + Paper::At(skin[next % kTapePoints]);
      lying_from = next;
    }
    last = next;
  }
  lie(last);
  return "<path class=\"tape\" d=\"" + path + " Z\"/>\n";
}

/// "12.30 ± 0.08 mm", half the 95 % interval; without it where the model has none.
std::string NumberWithSigma(const Uncertain& number, int digits, const char* unit) {
  const std::string value = fmt::format("{:.{}f}", number.value, digits);
  if (std::isnan(number.sigma)) return value + " " + unit;
  return fmt::format("{} ± {:.{}f} {}", value, kTwoSided95 * number.sigma, digits, unit);
}

std::vector<std::string> Captions(const MeasuredSurface& body, double z, const std::vector<KnownRun>& runs,
                                  const SectionSvgOptions& options) {
  std::vector<std::string> lines{options.title.empty() ? fmt::format("Section at z = {:.1f} mm", z)
                                                       : MarkupText(options.title)};
  const auto section = MeasureSection(body, z);
  if (section) {
    lines.push_back("perimeter " + NumberWithSigma(section->perimeter, 2, "mm"));
    lines.push_back("tape (dashed) " + NumberWithSigma(section->tape, 2, "mm"));
    lines.push_back("area " + NumberWithSigma(section->area, 0, "mm²"));
    lines.push_back(fmt::format("{}{:.1f} % measured", std::isnan(section->tape.sigma) ? "" : "± is 95 %; ",
                                100.0 * section->measured_share));
  } else {
    lines.push_back(
        fmt::format("not one visible loop: {:.1f} % was not seen", 100.0 * ShareOf(runs, Knowledge::kUnknown)));
  }
  if (ShareOf(runs, Knowledge::kInferred) > 0.0) {
    lines.push_back(
        fmt::format("orange: inferred between returns, {:.1f} %", 100.0 * ShareOf(runs, Knowledge::kInferred)));
  }
  return lines;
}

/// A round length, about a quarter of `width`.
double BarLength(double width) {
  double length = 1.0;
  for (double decade = 1.0; decade <= width; decade *= 10.0) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (digit * decade <= 0.3 * width) length = digit * decade;
    }
  }
  return length;
}

/// What surrounds the section and the ring's axis.
Eigen::AlignedBox2d BoxOfSection(const SplineSurface& surface, double z) {
  Eigen::AlignedBox2d box(Eigen::Vector2d::Zero());
  for (const Eigen::Vector2d& p : SectionSampler(surface, EvenDirections(kTapePoints)).Points(z)) box.extend(p);
  return box;
}

std::string CrossAndLabels(const Eigen::AlignedBox2d& box) {
  const double x = box.min().x() - 3.0;
  const double right = box.max().x() + 3.0;
  const double y = box.min().y() - 3.0;
  const double front = box.max().y() + 3.0;
  return Paper::Line({x, 0.0}, {right, 0.0}, "axis") + Paper::Line({0.0, y}, {0.0, front}, "axis") +
         Paper::Text({0.0, front + 1.5}, "middle", "front") + Paper::Text({0.0, y - 4.5}, "middle", "back") +
         Paper::Text({x - 1.0, -1.3}, "end", "left") + Paper::Text({right + 1.0, -1.3}, "start", "right");
}

std::string ScaleBar(const Eigen::Vector2d& left, double length) {
  const Eigen::Vector2d right = left + Eigen::Vector2d(length, 0.0);
  const Eigen::Vector2d tick(0.0, 1.5);
  return Paper::Line(left, right, "bar") + Paper::Line(left - tick, left + tick, "bar") +
         Paper::Line(right - tick, right + tick, "bar") +
         Paper::Text(right + Eigen::Vector2d(2.0, -1.3), "start", NumberText(length) + " mm");
}

constexpr const char* kStyle =
    "<style type=\"text/css\">\n"
    ".measured{fill:none;stroke:#1b4f8f;stroke-width:0.5}\n"
    ".inferred{fill:none;stroke:#e07000;stroke-width:0.5}\n"
    ".tape{fill:none;stroke:#b00040;stroke-width:0.3;stroke-dasharray:3,2}\n"
    ".axis{stroke:#999999;stroke-width:0.15}\n"
    ".bar{stroke:#000000;stroke-width:0.4}\n"
    "text{font-family:sans-serif;font-size:4px;fill:#000000}\n"
    "</style>\n";

}  // namespace

Result<std::string> SectionSvg(const MeasuredSurface& body, double z, const SectionSvgOptions& options) {
  const std::string attempted = "draw the section at z = " + NumberText(z) + " mm";
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  const std::vector<KnownRun> runs = RunsOfSection(body, z);
  const double unknown = ShareOf(runs, Knowledge::kUnknown);
  if (runs.size() == 1 && unknown > 0.0) {
    return Fail(attempted, "nothing of it was seen", "choose another height, or scan again");
  }
  const Eigen::AlignedBox2d box = BoxOfSection(body.surface(), z);
  const std::vector<std::string> captions = Captions(body, z, runs, options);
  const double bar = BarLength(box.sizes().x());
  const double width = std::max(kNarrowest, box.sizes().x() + 2.0 * kMargin);
  const double below = kMargin + 6.0 + kLineHeight * static_cast<double>(captions.size() + 1);
  const double height = box.sizes().y() + kMargin + below;
  const double left = box.center().x() - 0.5 * width;
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" "
      "viewBox=\"{2:.3f} {3:.3f} {0:.3f} {1:.3f}\">\n",
      width, height, left, -(box.max().y() + kMargin));
  svg += "<title>" + captions.front() + "</title>\n" + kStyle;
  svg += fmt::format("<rect x=\"{:.3f}\" y=\"{:.3f}\" width=\"{:.3f}\" height=\"{:.3f}\" fill=\"#ffffff\"/>\n", left,
                     -(box.max().y() + kMargin), width, height);
  svg += CrossAndLabels(box);
  for (const KnownRun& run : runs) {
    if (run.knowledge != Knowledge::kUnknown) svg += SkinPath(body.surface(), z, run);
  }
  if (unknown == 0.0) svg += TapePath(body.surface(), z);
  Eigen::Vector2d line(left + 4.0, box.min().y() - kMargin - 4.0);
  svg += ScaleBar(line, bar);
  line.y() -= 2.0;
  for (const std::string& caption : captions) {
    line.y() -= kLineHeight;
    svg += Paper::Text(line, "start", caption);
  }
  return svg + "</svg>\n";
}

}  // namespace annulus
