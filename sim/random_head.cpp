#include "sim/random_head.h"

#include <algorithm>
#include <random>

namespace annulus::sim {
namespace {

/// Normal numbers that stop at bounds: people without the rarest.
class People {
 public:
  explicit People(std::uint64_t seed) : random_(seed) {}

  double Normal(double mean, double sd, double low, double high) {
    return std::clamp(mean + sd * gaussian_(random_), low, high);
  }
  double Uniform(double low, double high) { return low + (high - low) * uniform_(random_); }
  /// Both sides about a common value; each at most `most` from it.
  Sides Pair(double common, double sd, double most) {
    const double half = Normal(0.0, sd, -most, most);
    return {common + half, common - half};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> gaussian_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

void DrawEyes(People& people, HeadVariation& head) {
  head.eye_lateral = people.Pair(0.5 * people.Normal(63.0, 3.5, 54.0, 74.0), 0.6, 1.5);
  head.eye_above = people.Pair(0.0, 0.4, 1.0);
  // The face curves back: eyes far apart lie deeper.
  const double deeper = 0.3 * (head.eye_lateral[0] + head.eye_lateral[1] - 63.0) / 2.0;
  head.eye_forward = people.Pair(people.Normal(-10.5 - deeper, 1.3, -14.0, -7.5), 0.3, 0.8);
  head.eyeball_radius = people.Normal(12.3, 0.35, 11.3, 13.3);
  head.lid_fold = people.Normal(0.6, 0.3, 0.0, 1.4);
  head.socket_depth = people.Normal(3.5, 0.7, 2.0, 5.0);
}

void DrawNose(People& people, HeadVariation& head) {
  head.sellion_above = people.Normal(7.5, 2.5, 2.0, 13.0);
  head.sellion_forward = people.Normal(4.0, 1.5, 1.0, 7.5);
  head.nose_length = head.size * people.Normal(39.0, 2.5, 34.5, 43.5);
  head.nose_protrusion = head.size * people.Normal(20.5, 2.2, 16.0, 25.0);
  head.nose_hump = people.Normal(0.2, 0.6, -1.3, 1.8);
  head.root_width = people.Normal(7.1, 0.5, 6.1, 8.4);
  head.tip_width = people.Normal(8.6, 0.5, 7.6, 9.8);
  head.ridge_flatness = people.Uniform(0.25, 0.65);
  head.root_right = people.Normal(0.0, 0.4, -1.0, 1.0);
  head.tip_right = head.root_right + people.Normal(0.0, 0.5, -1.0, 1.0);
  head.flank_bulge = people.Pair(people.Normal(0.0, 0.2, -0.4, 0.4), 0.2, 0.4);
  head.glabella_forward = people.Normal(4.2, 1.0, 2.2, 7.5);
}

void DrawEars(People& people, HeadVariation& head) {
  head.ear_above = people.Pair(people.Normal(-26.0, 3.0, -33.0, -19.0), 1.2, 2.5);
  head.ear_behind = people.Pair(people.Normal(10.0, 2.5, 5.0, 15.0), 1.2, 2.0);
  head.ear_protrusion = people.Pair(people.Normal(16.5, 1.8, 13.0, 20.0), 0.7, 1.0);
  head.ear_half_height = people.Pair(people.Normal(31.0, 1.5, 28.0, 34.0), 0.4, 1.0);
}

}  // namespace

HeadVariation DrawHeadVariation(std::uint64_t seed) {
  People people(seed);
  HeadVariation head;
  head.eye_z = people.Normal(1584.0, 60.0, 1440.0, 1740.0);
  head.size = people.Normal(1.0, 0.03, 0.93, 1.07);
  head.depth = people.Normal(1.0, 0.025, 0.94, 1.06);
  DrawEyes(people, head);
  // A wide face carries its eyes apart.
  const double apart = head.eye_lateral[0] + head.eye_lateral[1] - 63.0;
  head.breadth = std::clamp(people.Normal(1.0 + 0.004 * apart, 0.02, 0.94, 1.06), 0.94, 1.06);
  DrawNose(people, head);
  head.brow = people.Pair(people.Normal(3.5, 0.8, 1.8, 5.5), 0.2, 0.5);
  head.cheek = people.Pair(people.Normal(5.0, 1.0, 3.0, 7.3), 0.2, 0.6);
  DrawEars(people, head);
  head.placement.x_mm = people.Uniform(-6.0, 6.0);
  head.placement.y_mm = people.Uniform(-6.0, 6.0);
  head.placement.yaw_rad = people.Uniform(-0.06, 0.06);
  return head;
}

ParametricBody MakeRandomHead(std::uint64_t seed) { return MakeVariedHead(DrawHeadVariation(seed)); }

}  // namespace annulus::sim
