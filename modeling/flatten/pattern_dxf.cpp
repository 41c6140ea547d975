#include "modeling/flatten/pattern_dxf.h"

#include <fmt/format.h>

#include <array>

namespace annulus {
namespace {

using Eigen::Vector2d;

struct Layer {
  const char* name;
  int colour;  ///< AutoCAD's index.
};
constexpr std::array<Layer, 5> kLayers{{{"CUT", 7}, {"SEW", 5}, {"GRAIN", 3}, {"NOTCH", 1}, {"LABEL", 8}}};
constexpr double kTextHeight = 6.0;  ///< mm

class Writer {
 public:
  void Put(int code, const std::string& value) { text_ += fmt::format("{:3d}\n{}\n", code, value); }
  void Put(int code, double value) { Put(code, fmt::format("{:.4f}", value)); }
  void Place(int code, const Vector2d& p) {
    Put(code, p.x());
    Put(code + 10, p.y());
    Put(code + 20, 0.0);
  }
  void Begin(const char* entity, const char* layer) {
    Put(0, entity);
    Put(8, layer);
  }

  void Chain(const DrawnChain& chain, const char* layer) {
    Begin("POLYLINE", layer);
    Put(66, "1");
    Place(10, Vector2d::Zero());
    Put(70, chain.end == DrawnChain::End::kClosed ? "1" : "0");
    for (const Vector2d& p : chain.points) {
      Begin("VERTEX", layer);
      Place(10, p);
    }
    Begin("SEQEND", layer);
  }
  void Stroke(const DrawnStroke& stroke, const char* layer) {
    Begin("LINE", layer);
    Place(10, stroke[0]);
    Place(11, stroke[1]);
  }
  void Text(const Vector2d& at, const std::string& text) {
    std::string plain;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if ((byte & 0xC0U) == 0x80U) continue;  // the rest of a letter of several bytes
      plain += byte >= 32 && byte < 127 ? c : '?';
    }
    Begin("TEXT", "LABEL");
    Place(10, at);
    Put(40, kTextHeight);
    Put(1, plain);
  }
  [[nodiscard]] std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

void PutHead(Writer& dxf, const std::vector<DrawnPiece>& pieces) {
  Eigen::Array2d high = Eigen::Array2d::Zero();
  for (const DrawnPiece& piece : pieces) high = high.max(piece.high.array());
  dxf.Put(0, "SECTION");
  dxf.Put(2, "HEADER");
  dxf.Put(9, "$ACADVER");
  dxf.Put(1, "AC1009");
  dxf.Put(9, "$EXTMIN");
  dxf.Place(10, Vector2d::Zero());
  dxf.Put(9, "$EXTMAX");
  dxf.Place(10, high.matrix());
  dxf.Put(0, "ENDSEC");
  dxf.Put(0, "SECTION");
  dxf.Put(2, "TABLES");
  dxf.Put(0, "TABLE");
  dxf.Put(2, "LTYPE");
  dxf.Put(70, "1");
  dxf.Put(0, "LTYPE");
  dxf.Put(2, "CONTINUOUS");
  dxf.Put(70, "0");
  dxf.Put(3, "Solid line");
  dxf.Put(72, "65");
  dxf.Put(73, "0");
  dxf.Put(40, 0.0);
  dxf.Put(0, "ENDTAB");
  dxf.Put(0, "TABLE");
  dxf.Put(2, "LAYER");
  dxf.Put(70, std::to_string(kLayers.size()));
  for (const Layer& layer : kLayers) {
    dxf.Put(0, "LAYER");
    dxf.Put(2, layer.name);
    dxf.Put(70, "0");
    dxf.Put(62, std::to_string(layer.colour));
    dxf.Put(6, "CONTINUOUS");
  }
  dxf.Put(0, "ENDTAB");
  dxf.Put(0, "ENDSEC");
}

}  // namespace

std::string PatternDxf(const std::vector<DrawnPiece>& pieces) {
  Writer dxf;
  PutHead(dxf, pieces);
  dxf.Put(0, "SECTION");
  dxf.Put(2, "ENTITIES");
  for (const DrawnPiece& piece : pieces) {
    dxf.Chain(piece.cut, "CUT");
    for (const DrawnChain& chain : piece.sew) dxf.Chain(chain, "SEW");
    for (const DrawnStroke& stroke : piece.grain) dxf.Stroke(stroke, "GRAIN");
    for (const DrawnStroke& stroke : piece.notches) dxf.Stroke(stroke, "NOTCH");
    for (std::size_t k = 0; k < piece.label.size(); ++k) {
      dxf.Text(piece.label_at - 1.6 * kTextHeight * static_cast<double>(k) * Vector2d::UnitY(), piece.label[k]);
    }
  }
  dxf.Put(0, "ENDSEC");
  dxf.Put(0, "EOF");
  return dxf.Take();
}

}  // namespace annulus
