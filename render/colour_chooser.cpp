#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/units.h"
#include "render/canvas.h"
#include "render/colour_choice.h"
#include "render/hvc.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr int kWidth = 760;
constexpr int kHeight = 560;
constexpr double kLeft = 40.0;
constexpr double kRight = 720.0;
const LinearRgb kInk = LinearFromHex(0x333333);
const LinearRgb kHalo = LinearFromHex(0xffffff);

/// A rectangle on the sheet, pixels.
struct Box {
  double left;
  double top;
  double right;
  double bottom;
};

void Outline(Canvas& canvas, const Box& box) {
  canvas.Polyline(
      {{box.left, box.top}, {box.right, box.top}, {box.right, box.bottom}, {box.left, box.bottom}, {box.left, box.top}},
      kInk, 1);
}

void DrawSamples(Canvas& canvas, double top) {
  const auto& samples = SampleColours();
  const double step = (kRight - kLeft + 10.0) / static_cast<double>(samples.size());
  canvas.Text("sample:NAME", {kLeft, top}, kSmallText, Anchor::kLeft);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double left = kLeft + step * static_cast<double>(k);
    const Box box{left, top + 10.0, left + step - 10.0, top + 56.0};
    canvas.FillRectangle({box.left, box.top}, {box.right, box.bottom}, LinearFromHex(samples[k].rrggbb));
    Outline(canvas, box);
    const std::string name = std::to_string(k + 1) + " " + std::string(samples[k].name);
    canvas.Text(name, {0.5 * (box.left + box.right), box.bottom + 16.0}, kSmallText, Anchor::kCentre);
  }
}

void DrawBar(Canvas& canvas, double top) {
  const Box box{kLeft, top + 10.0, kRight, top + 44.0};
  canvas.Text("bar:POSITION", {kLeft, top}, kSmallText, Anchor::kLeft);
  for (int x = static_cast<int>(box.left); x < static_cast<int>(box.right); ++x) {
    const LinearRgb colour = ColourBar((x - box.left) / (box.right - box.left));
    for (int y = static_cast<int>(box.top); y < static_cast<int>(box.bottom); ++y) canvas.SetPixel(x, y, colour);
  }
  Outline(canvas, box);
  for (int k = 0; k <= 10; ++k) {
    const double x = box.left + 0.1 * k * (box.right - box.left);
    canvas.Polyline({{x, box.bottom}, {x, box.bottom + 5.0}}, kInk, 1);
    canvas.Text(NumberText(0.1 * k, 0.1), {x, box.bottom + 20.0}, kSmallText, Anchor::kCentre);
  }
}

constexpr Box kPlane{70.0, 240.0, 470.0, 510.0};
constexpr double kMostChroma = 30.0;

Vector2d InPlane(const Hvc& hvc) {
  return {kPlane.left + hvc.chroma / kMostChroma * (kPlane.right - kPlane.left),
          kPlane.bottom - hvc.value / 10.0 * (kPlane.bottom - kPlane.top)};
}

void DrawPlaneAxes(Canvas& canvas) {
  for (int k = 0; k <= 5; ++k) {
    const double y = kPlane.bottom - 0.2 * k * (kPlane.bottom - kPlane.top);
    canvas.Polyline({{kPlane.left - 5.0, y}, {kPlane.left, y}}, kInk, 1);
    canvas.Text(std::to_string(2 * k), {kPlane.left - 9.0, y + 4.0}, kSmallText, Anchor::kRight);
  }
  for (int k = 0; k <= 6; ++k) {
    const double x = kPlane.left + k / 6.0 * (kPlane.right - kPlane.left);
    canvas.Polyline({{x, kPlane.bottom}, {x, kPlane.bottom + 5.0}}, kInk, 1);
    canvas.Text(std::to_string(5 * k), {x, kPlane.bottom + 20.0}, kSmallText, Anchor::kCentre);
  }
  canvas.Text("chroma (dull - vivid)", {0.5 * (kPlane.left + kPlane.right), kPlane.bottom + 38.0}, kSmallText,
              Anchor::kCentre);
  canvas.VerticalText("value (dark - bright)", 0.5 * (kPlane.top + kPlane.bottom));
}

void DrawPlane(Canvas& canvas, const Hvc& chosen) {
  for (int y = static_cast<int>(kPlane.top); y < static_cast<int>(kPlane.bottom); ++y) {
    const double value = 10.0 * (kPlane.bottom - y - 0.5) / (kPlane.bottom - kPlane.top);
    const double most = GreatestChroma(chosen.hue, value);
    for (int x = static_cast<int>(kPlane.left); x < static_cast<int>(kPlane.right); ++x) {
      const double chroma = kMostChroma * (x + 0.5 - kPlane.left) / (kPlane.right - kPlane.left);
      if (chroma > most) break;
      canvas.SetPixel(x, y, RgbFromHvc({chosen.hue, value, chroma}));
    }
  }
  Outline(canvas, kPlane);
  DrawPlaneAxes(canvas);
  const Vector2d mark = InPlane(chosen);
  for (const auto& [radius, colour] : {std::pair(8.0, kInk), std::pair(6.0, kHalo)}) {
    std::vector<Vector2d> ring;
    for (int k = 0; k <= 32; ++k) {
      const double angle = k * kTwoPi / 32.0;
      ring.emplace_back(mark.x() + radius * std::cos(angle), mark.y() + radius * std::sin(angle));
    }
    canvas.Polyline(ring, colour, 2);
  }
}

std::string TextOf(const char* format, double first, double second, double third) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), format, first, second, third);
  return text.data();
}

void DrawChosen(Canvas& canvas, const LinearRgb& colour, const Hvc& hvc) {
  const Box box{510.0, 240.0, kRight, 330.0};
  canvas.FillRectangle({box.left, box.top}, {box.right, box.bottom}, colour);
  Outline(canvas, box);
  const auto byte = [&colour](int k) { return static_cast<double>(SrgbByteFromLinear(colour[k])); };
  std::array<char, 16> hex{};
  std::snprintf(hex.data(), hex.size(), "#%02x%02x%02x", static_cast<unsigned>(byte(0)), static_cast<unsigned>(byte(1)),
                static_cast<unsigned>(byte(2)));
  const std::array<std::string, 6> lines = {hex.data(),
                                            TextOf("rgb:%.0f,%.0f,%.0f", byte(0), byte(1), byte(2)),
                                            TextOf("hvc:%.1f,%.1f,%.1f", hvc.hue * 50.0 / kPi, hvc.value, hvc.chroma),
                                            "Munsell about " + MunsellText(hvc),
                                            "then ,brighter:-1 ... 1",
                                            "and ,vivid:-1 ... 1"};
  double y = box.bottom + 28.0;
  for (const std::string& line : lines) {
    canvas.Text(line, {box.left, y}, kSmallText, Anchor::kLeft);
    y += 26.0;
  }
}

}  // namespace

RgbImage ColourChooser(const LinearRgb& colour) {
  Canvas canvas(kWidth, kHeight);
  const Hvc hvc = HvcFromRgb(colour);
  DrawSamples(canvas, 28.0);
  DrawBar(canvas, 128.0);
  canvas.Text("hvc:HUE,VALUE,CHROMA at this hue", {kPlane.left, kPlane.top - 12.0}, kSmallText, Anchor::kLeft);
  DrawPlane(canvas, hvc);
  DrawChosen(canvas, colour, hvc);
  return canvas.ToImage();
}

}  // namespace annulus
