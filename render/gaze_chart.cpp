#include "render/gaze_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/ensure.h"
#include "base/units.h"
#include "render/canvas.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const LinearRgb kInk = LinearFromHex(0x161616);
const LinearRgb kPaper = LinearFromHex(0xfbfbf8);

// The shop, mm from the eye: a room of 6.4 m × 2.8 m × 6 m.
constexpr double kHalfWidth = 3200.0;
constexpr double kFloor = -1600.0;
constexpr double kCeiling = 1200.0;
constexpr double kBehind = -500.0;  // side walls reach behind the eye, so that nothing ends in the picture

/// A repeatable number in [0, 1) for a cell.
double Chance(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9E3779B1U ^ (b + 0x7F4A7C15U) * 0x85EBCA77U;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 13;
  return static_cast<double>(h >> 8) / 16777216.0;
}

/// A wall being painted: millimetres from its upper left corner, on a canvas of `texel` mm a pixel.
class Painter {
 public:
  Painter(double width_mm, double height_mm, double texel, const LinearRgb& ground)
      : texel_(texel),
        canvas_(static_cast<int>(std::lround(width_mm / texel)), static_cast<int>(std::lround(height_mm / texel))) {
    Box(-10.0, -10.0, width_mm + 20.0, height_mm + 20.0, ground);
  }
  // The canvas counts from its pixels' middles and draws both ends.
  void Box(double left, double top, double width, double height, const LinearRgb& colour) {
    const Vector2d from = Vector2d(left, top) / texel_;
    const Vector2d to = Vector2d(left + width, top + height) / texel_ - Vector2d(1.0, 1.0);
    canvas_.FillRectangle(from, to.cwiseMax(from), colour);
  }
  void Disc(double x, double y, double radius, const LinearRgb& colour) {
    canvas_.FillDisc(Vector2d(x, y) / texel_ - Vector2d(0.5, 0.5), radius / texel_, colour);
  }

  [[nodiscard]] WallPicture Finished() const {
    RgbImage image = canvas_.ToImage();
    return {image.width, image.height, std::move(image.rgb)};
  }

 private:
  double texel_;
  Canvas canvas_;
};

/// A Landolt ring about (x, y); gap right, up, left or down.
void Landolt(Painter& wall, double x, double y, double diameter, int towards) {
  wall.Disc(x, y, 0.5 * diameter, kInk);
  wall.Disc(x, y, 0.3 * diameter, kPaper);
  const double gap = 0.2 * diameter;
  const double reach = 0.55 * diameter;
  switch (towards % 4) {
    case 0:
      return wall.Box(x, y - 0.5 * gap, reach, gap, kPaper);
    case 1:
      return wall.Box(x - 0.5 * gap, y - reach, gap, reach, kPaper);
    case 2:
      return wall.Box(x - reach, y - 0.5 * gap, reach, gap, kPaper);
    default:
      return wall.Box(x - 0.5 * gap, y, gap, reach, kPaper);
  }
}

/// A letter E of five bars' height about (x, y), its arms right, up, left or down.
void TurnedE(Painter& wall, double x, double y, double size, int towards) {
  const double bar = 0.2 * size;
  const double low = -0.5 * size;
  wall.Box(x + low, y + low, size, size, kInk);
  for (int arm = 0; arm < 2; ++arm) {
    const double along = low + (1.0 + 2.0 * arm) * bar;
    if (towards % 2 == 0) {
      wall.Box(x + (towards % 4 == 0 ? low + bar : low - bar), y + along, size, bar, kPaper);
    } else {
      wall.Box(x + along, y + (towards % 4 == 1 ? low - bar : low + bar), bar, size, kPaper);
    }
  }
}

/// Rows of Landolt rings from acuity 0.05 to 1.25 on a lit board of 800 × 1000 mm.
constexpr double kBoardWidth = 800.0;
constexpr double kBoardHeight = 1000.0;
WallPicture TestChart() {
  Painter board(kBoardWidth, kBoardHeight, 0.8, kPaper);
  for (const double edge : {0.0, kBoardWidth - 12.0}) board.Box(edge, 0.0, 12.0, kBoardHeight, LinearFromHex(0x303438));
  for (const double edge : {0.0, kBoardHeight - 12.0}) board.Box(0.0, edge, kBoardWidth, 12.0, LinearFromHex(0x303438));
  struct Row {
    double acuity;
    double y;
    int rings;
  };
  constexpr std::array kRows{Row{0.05, 130.0, 3}, Row{0.08, 310.0, 4}, Row{0.1, 450.0, 5},  Row{0.16, 560.0, 5},
                             Row{0.25, 640.0, 5}, Row{0.4, 705.0, 5},  Row{0.63, 758.0, 5}, Row{0.8, 800.0, 5},
                             Row{1.0, 838.0, 5},  Row{1.25, 872.0, 5}};
  std::uint32_t row_number = 0;
  for (const Row& row : kRows) {
    const double diameter = LandoltDiameter(row.acuity);
    const double pitch = std::min(1.9 * diameter, 0.86 * kBoardWidth / row.rings);
    for (int i = 0; i < row.rings; ++i) {
      const double x = 0.5 * kBoardWidth + (i - 0.5 * (row.rings - 1)) * std::max(pitch, 22.0);
      const auto towards = static_cast<int>(4.0 * Chance(row_number, static_cast<std::uint32_t>(i)));
      Landolt(board, x, row.y, diameter, towards);
    }
    ++row_number;
  }
  board.Disc(0.5 * kBoardWidth, 920.0, 9.0, LinearFromHex(0xb01c24));
  return board.Finished();
}

/// Shelves with spectacles on them: boards every 350 mm, uprights every 1000 mm.
void Shelves(Painter& wall, double left, double top, double width, double height, std::uint32_t seed) {
  const LinearRgb board = LinearFromHex(0xf1ede4);
  const LinearRgb shade = LinearFromHex(0xb7afa2);
  const std::array<LinearRgb, 6> frames{LinearFromHex(0x24272b), LinearFromHex(0x7b4a21), LinearFromHex(0x8c1f2d),
                                        LinearFromHex(0x1f4e8c), LinearFromHex(0xa9a9a9), LinearFromHex(0xc49a3a)};
  wall.Box(left, top, width, height, LinearFromHex(0xd9d2c5));
  constexpr double kPitch = 350.0;
  for (double y = top + kPitch; y <= top + height + 1.0; y += kPitch) {
    std::uint32_t number = 0;
    for (double x = left + 110.0; x < left + width - 110.0; x += 185.0, ++number) {
      const auto row = static_cast<std::uint32_t>(y);
      const LinearRgb& colour = frames[static_cast<std::size_t>(6.0 * Chance(seed + row, number))];
      const double high = y - 130.0;
      for (const double side : {-38.0, 38.0}) {
        wall.Box(x + side - 30.0, high - 22.0, 60.0, 44.0, colour);
        wall.Box(x + side - 23.0, high - 16.0, 46.0, 32.0, LinearFromHex(0xc9d3d6));
      }
      wall.Box(x - 10.0, high - 12.0, 20.0, 8.0, colour);
    }
    wall.Box(left, y - 24.0, width, 24.0, board);
    wall.Box(left, y, width, 10.0, shade);
  }
  for (double x = left; x <= left + width + 1.0; x += 1000.0) wall.Box(x - 14.0, top, 28.0, height, board);
}

WallPicture FarWall() {
  const double height = kCeiling - kFloor;
  Painter wall(2.0 * kHalfWidth, height, 4.0, LinearFromHex(0xe4dfd3));
  Shelves(wall, 350.0, 500.0, 1650.0, 1750.0, 11);
  // A door at the right.
  wall.Box(4500.0, 640.0, 1100.0, height - 640.0, LinearFromHex(0x6a4a33));
  wall.Box(4560.0, 700.0, 980.0, height - 700.0, LinearFromHex(0x8a6547));
  for (const double y : {800.0, 1500.0, 2150.0}) wall.Box(4680.0, y, 740.0, 540.0, LinearFromHex(0x7a573c));
  wall.Disc(4640.0, 1750.0, 34.0, LinearFromHex(0xd8c27a));
  // A dark surround of the chart, a mirror, the skirting.
  wall.Box(2700.0, 640.0, 1000.0, 1200.0, LinearFromHex(0x55606a));
  wall.Box(3900.0, 700.0, 420.0, 1100.0, LinearFromHex(0x40464c));
  wall.Box(3925.0, 725.0, 370.0, 1050.0, LinearFromHex(0xb9cbd3));
  wall.Box(0.0, height - 110.0, 2.0 * kHalfWidth, 110.0, LinearFromHex(0x8b8478));
  return wall.Finished();
}

/// The side walls, `length` mm long; the one at the wearer's right is a shop window.
WallPicture ShelfWall(double length) {
  const double height = kCeiling - kFloor;
  Painter wall(length, height, 6.0, LinearFromHex(0xe4dfd3));
  for (double x = 250.0; x + 2000.0 < length; x += 2250.0) Shelves(wall, x, 400.0, 2000.0, 2100.0, 5);
  wall.Box(0.0, height - 110.0, length, 110.0, LinearFromHex(0x8b8478));
  return wall.Finished();
}
WallPicture WindowWall(double length) {
  const double height = kCeiling - kFloor;
  Painter wall(length, height, 6.0, LinearFromHex(0xddd6c8));
  const double pane = 1450.0;
  for (double x = 260.0; x + pane < length; x += pane + 180.0) {
    wall.Box(x - 60.0, 340.0, pane + 120.0, 2120.0, LinearFromHex(0x4b5157));
    wall.Box(x, 400.0, pane, 1000.0, LinearFromHex(0xcfe4f5));
    wall.Box(x, 1150.0, pane, 260.0, LinearFromHex(0xa89f93));  // houses over the road
    for (double house = x; house < x + pane; house += 145.0) {
      const double top = 1020.0 + 160.0 * Chance(static_cast<std::uint32_t>(house), 3);
      wall.Box(house, top, std::min(140.0, x + pane - house), 1330.0 - top, LinearFromHex(0xb98e74));
    }
    wall.Box(x, 1330.0, pane, 600.0, LinearFromHex(0x9aa39a));
    wall.Box(x, 1930.0, pane, 470.0, LinearFromHex(0x868c90));
    wall.Box(x, 1380.0, pane, 40.0, LinearFromHex(0x4b5157));
    wall.Box(x + 0.5 * pane - 20.0, 400.0, 40.0, 2000.0, LinearFromHex(0x4b5157));
  }
  wall.Box(0.0, height - 110.0, length, 110.0, LinearFromHex(0x8b8478));
  return wall.Finished();
}

WallPicture TiledFloor(double length) {
  Painter floor(2.0 * kHalfWidth, length, 8.0, LinearFromHex(0x6f6a63));
  constexpr double kTile = 640.0;
  for (double y = 0.0, row = 0; y < length; y += kTile, ++row) {
    for (double x = 0.0, column = 0; x < 2.0 * kHalfWidth; x += kTile, ++column) {
      const bool dark = std::fmod(row + column, 2.0) > 0.5;
      floor.Box(x + 8.0, y + 8.0, kTile - 16.0, kTile - 16.0, dark ? LinearFromHex(0x9b948a) : LinearFromHex(0xc4bdb1));
    }
  }
  return floor.Finished();
}

WallPicture LampCeiling(double length) {
  Painter ceiling(2.0 * kHalfWidth, length, 8.0, LinearFromHex(0xb9b9b5));
  constexpr double kPanel = 640.0;
  for (double y = 0.0, row = 0; y < length; y += kPanel, ++row) {
    for (double x = 0.0, column = 0; x < 2.0 * kHalfWidth; x += kPanel, ++column) {
      const bool lamp = std::fmod(row, 3.0) == 1.0 && std::fmod(column, 3.0) == 1.0;
      ceiling.Box(x + 8.0, y + 8.0, kPanel - 16.0, kPanel - 16.0,
                  lamp ? LinearFromHex(0xffffff) : LinearFromHex(0xd9d8d3));
    }
  }
  return ceiling.Finished();
}

constexpr double kGridSquare = 500.0;
constexpr double kGridHalfWidth = 14000.0;
constexpr double kGridHalfHeight = 10500.0;
WallPicture GridWall() {
  constexpr double kTexel = 12.5;
  Painter wall(2.0 * kGridHalfWidth, 2.0 * kGridHalfHeight, kTexel, LinearFromHex(0xf6f6f2));
  const auto lines = [&](double half, const auto& line) {
    const auto count = static_cast<int>(half / kGridSquare);
    for (int k = -count; k <= count; ++k) {
      if (k % 2 != 0) line(half + k * kGridSquare, 18.0, LinearFromHex(0x8793a0));
    }
    for (int k = -count; k <= count; ++k) {
      if (k % 2 == 0) line(half + k * kGridSquare, k == 0 ? 55.0 : 40.0, LinearFromHex(k == 0 ? 0x1f4e8c : 0x38424d));
    }
  };
  lines(kGridHalfWidth, [&](double x, double wide, const LinearRgb& colour) {
    wall.Box(x - 0.5 * wide, 0.0, wide, 2.0 * kGridHalfHeight, colour);
  });
  lines(kGridHalfHeight, [&](double y, double wide, const LinearRgb& colour) {
    wall.Box(0.0, y - 0.5 * wide, 2.0 * kGridHalfWidth, wide, colour);
  });
  // Letters of acuity 0.03 (290 mm) all over, so that blur shows.
  std::uint32_t number = 0;
  for (double y = 250.0 + kGridSquare; y < 2.0 * kGridHalfHeight; y += 3.0 * kGridSquare) {
    for (double x = 250.0 + kGridSquare; x < 2.0 * kGridHalfWidth; x += 3.0 * kGridSquare, ++number) {
      TurnedE(wall, x, y, 290.0, static_cast<int>(4.0 * Chance(number, 7)));
    }
  }
  return wall.Finished();
}

/// The chart's board stands a little before its wall, its middle straight ahead.
Vector3d BoardCorner() { return {0.5 * kBoardWidth, 0.5 * kBoardHeight, kChartDistance - 5.0}; }

}  // namespace

double LandoltDiameter(double acuity) {
  return 5.0 * kChartDistance * std::tan(RadiansFromDegrees(1.0 / 60.0) / acuity);
}

WallPicture::WallPicture(int width, int height, std::vector<LinearRgb> rgb) {
  ENSURE(width >= 1 && height >= 1 && rgb.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
         "a wall picture of another size");
  levels_.push_back({width, height, std::move(rgb)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{std::max(1, (fine.width + 1) / 2), std::max(1, (fine.height + 1) / 2), {}};
    coarse.rgb.reserve(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
    const auto at = [&fine](int x, int y) -> const LinearRgb& {
      const int column = std::min(x, fine.width - 1);
      return fine.rgb[static_cast<std::size_t>(std::min(y, fine.height - 1)) * static_cast<std::size_t>(fine.width) +
                      static_cast<std::size_t>(column)];
    };
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        coarse.rgb.emplace_back(
            0.25F * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1)));
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

LinearRgb WallPicture::Level::Between(double x, double y) const {
  const double u = std::clamp(x - 0.5, 0.0, width - 1.0);
  const double v = std::clamp(y - 0.5, 0.0, height - 1.0);
  const int column = std::min(static_cast<int>(u), std::max(0, width - 2));
  const int row = std::min(static_cast<int>(v), std::max(0, height - 2));
  const auto fu = static_cast<float>(u - column);
  const auto fv = static_cast<float>(v - row);
  const LinearRgb* upper =
      &rgb[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  const LinearRgb* lower = upper + (height > 1 ? width : 0);
  const int next = width > 1 ? 1 : 0;
  return (1.0F - fv) * ((1.0F - fu) * upper[0] + fu * upper[next]) + fv * ((1.0F - fu) * lower[0] + fu * lower[next]);
}

LinearRgb WallPicture::At(double x, double y, double spot) const {
  const double depth = std::clamp(std::log2(std::max(spot, 1.0)), 0.0, static_cast<double>(levels_.size()) - 1.0);
  const auto level = std::min(static_cast<std::size_t>(depth), levels_.size() - 1);
  const auto share = static_cast<float>(depth - static_cast<double>(level));
  const auto scale = [](std::size_t k) { return 1.0 / static_cast<double>(std::size_t{1} << k); };
  const LinearRgb fine = levels_[level].Between(x * scale(level), y * scale(level));
  if (share == 0.0F || level + 1 == levels_.size()) return fine;
  return (1.0F - share) * fine + share * levels_[level + 1].Between(x * scale(level + 1), y * scale(level + 1));
}

const std::array<std::string_view, 2>& GazeSceneNames() {
  static constexpr std::array<std::string_view, 2> kNames{"shop", "grid"};
  return kNames;
}

GazeScene::Wall::Wall(const Vector3d& corner, const Vector3d& right, const Vector3d& down, WallPicture its_picture)
    : normal(right.cross(down).normalized()),
      distance(normal.dot(corner)),
      across(its_picture.width() / right.squaredNorm() * right),
      along(its_picture.height() / down.squaredNorm() * down),
      left(across.dot(corner)),
      top(along.dot(corner)),
      texels_per_mm(its_picture.width() / right.norm()),
      picture(std::move(its_picture)) {}

GazeScene GazeScene::Make(GazeSceneKind kind) {
  GazeScene scene;
  const Vector3d right = -Vector3d::UnitX();  // of the wearer
  const Vector3d down = -Vector3d::UnitY();
  const Vector3d forward = Vector3d::UnitZ();
  scene.walls_.emplace_back(BoardCorner(), kBoardWidth * right, kBoardHeight * down, TestChart());
  if (kind == GazeSceneKind::kGrid) {
    scene.beyond_ = LinearFromHex(0xb9bcbf);
    scene.walls_.emplace_back(Vector3d(kGridHalfWidth, kGridHalfHeight, kChartDistance), 2.0 * kGridHalfWidth * right,
                              2.0 * kGridHalfHeight * down, GridWall());
    return scene;
  }
  const double length = kChartDistance - kBehind;
  const double height = kCeiling - kFloor;
  scene.beyond_ = LinearFromHex(0x8b8478);
  scene.walls_.push_back({{kHalfWidth, kCeiling, kChartDistance}, 2.0 * kHalfWidth * right, height * down, FarWall()});
  scene.walls_.push_back({{kHalfWidth, kCeiling, kBehind}, length * forward, height * down, ShelfWall(length)});
  const auto add = [&](double x, double y, double z, const Vector3d& across, const Vector3d& along,
                       WallPicture&& seen) {
    scene.walls_.emplace_back(Vector3d(x, y, z), across, along, std::move(seen));
  };
  const Vector3d wide = 2.0 * kHalfWidth * right;
  add(kHalfWidth, kCeiling, kChartDistance, wide, height * down, FarWall());
  add(kHalfWidth, kCeiling, kBehind, length * forward, height * down, ShelfWall(length));
  add(-kHalfWidth, kCeiling, kChartDistance, -length * forward, height * down, WindowWall(length));
  add(kHalfWidth, kFloor, kChartDistance, wide, -length * forward, TiledFloor(length));
  add(kHalfWidth, kCeiling, kBehind, wide, length * forward, LampCeiling(length));
  return scene;
}

LinearRgb GazeScene::Light(const Vector3d& direction, double spot) const {
  for (const Wall& wall : walls_) {
    const double slope = wall.normal.dot(direction);
    const double far = wall.distance / slope;
    if (!(far > 0.0 && std::isfinite(far))) continue;
    const Vector3d point = far * direction;
    const double x = wall.across.dot(point) - wall.left;
    const double y = wall.along.dot(point) - wall.top;
    if (!(x >= 0.0 && x <= wall.picture.width() && y >= 0.0 && y <= wall.picture.height())) continue;
    // The spot's mean width on the wall: across it is its distance times the spot, along the slant more by 1/cos.
    const double length = direction.norm();
    const double cosine = std::max(std::abs(slope) / length, 0.02);
    return wall.picture.At(x, y, far * length * spot / std::sqrt(cosine) * wall.texels_per_mm);
  }
  return beyond_;
}

}  // namespace annulus
