#include "modeling/glasses/frame_adjust.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "modeling/glasses/frame_limits.h"

namespace annulus {
namespace {

/// tan(22.5°): an octagon's edge loses this much of an inward offset at each end.
const double kMitre = std::numbers::sqrt2 - 1.0;
/// Sums of lengths stay this share inside their limits, so that rounding does not carry them out.
constexpr double kInside = 1e-12;

/// The corners in a fixed order.
constexpr std::array<double FrameParameters::*, 4> kCorners{
    &FrameParameters::upper_outer, &FrameParameters::upper_inner, &FrameParameters::lower_inner,
    &FrameParameters::lower_outer};

std::string_view NameOf(double FrameParameters::*member) {
  for (const FrameParameterField& field : FrameParameterFields()) {
    if (field.member == member) return field.option;
  }
  return {};
}

class Adjuster {
 public:
  explicit Adjuster(const FrameDesign& design) : given_(design), used_(design) {}

  AdjustedDesign Run() {
    AdjustSizes();
    AdjustCorners();
    AdjustBridge();
    AdjustForms();
    AdjustDetails();
    return {used_, std::move(messages_)};
  }

 private:
  FrameParameters& p() { return used_.parameters; }

  void Clamp(double FrameParameters::*member, double low, double high, std::string_view why) {
    const double before = p().*member;
    p().*member = std::clamp(before, low, high);
    if (p().*member != before) Say(member, why);
  }

  void Say(double FrameParameters::*member, std::string_view why) {
    messages_.push_back(fmt::format("{}: {:.3f} mm given, {:.3f} mm used: {}", NameOf(member),
                                    given_.parameters.*member, p().*member, why));
  }

  void AdjustSizes() {
    Clamp(&FrameParameters::width, 10.0, 200.0, "no face needs it");
    Clamp(&FrameParameters::height, 0.3 * p().width, 1.5 * p().width, "a rim's height is 30 to 150 % of its width");
    constexpr std::string_view kWhy = "a rim's thickness is 1 to 25 % of its width";
    Clamp(&FrameParameters::lower_thickness, 0.01 * p().width, 0.25 * p().width, kWhy);
    // Even with the squarest corners the sides must hold the bridge, which is as high as the upper rim is thick.
    const double share = 0.5 * kMitre / std::numbers::sqrt2;
    const double room = (1.0 - 1e-9) * (p().height - share * p().lower_thickness) / (1.0 + share);
    const double most = 0.25 * p().width;
    Clamp(&FrameParameters::upper_thickness, 0.01 * p().width, std::min(room, most),
          room < most ? std::string_view("the rim's sides must hold the bridge") : kWhy);
  }

  /// Smallest cut of a corner.
  double Lowest(std::size_t corner) { return 0.5 * kMitre * (corner < 2 ? p().upper_thickness : p().lower_thickness); }

  /// A limit on the sum of two corners' cuts.
  struct Sum {
    std::size_t first;
    std::size_t second;
    double limit;
  };

  std::vector<Sum> Sums() {
    const double root = std::numbers::sqrt2;
    const double mean = 0.5 * (p().upper_thickness + p().lower_thickness);
    const double upper = (p().width - kMitre * p().upper_thickness) / root;
    const double lower = (p().width - kMitre * p().lower_thickness) / root;
    const double side = (p().height - kMitre * mean) / root;
    // Between the lower and the upper corners the bridge must find its height: max of the two on either side.
    const double bridge = root * (p().height - p().upper_thickness);
    const double beside = std::min(side, bridge);
    return {{0, 1, upper}, {2, 3, lower}, {1, 2, beside}, {0, 3, beside}, {0, 2, bridge}, {1, 3, bridge}};
  }

  /// Dykstra's projection on the intersection of the limits: the nearest set of corners.
  void AdjustCorners() {
    Eigen::Vector4d t;
    Eigen::Vector4d lowest;
    for (std::size_t k = 0; k < 4; ++k) {
      lowest[static_cast<Eigen::Index>(k)] = Lowest(k);
      // What is far beyond every limit only costs precision.
      t[static_cast<Eigen::Index>(k)] = std::clamp(p().*kCorners[k], -p().width, 2.0 * p().width);
    }
    const std::vector<Sum> sums = Sums();
    const auto allowed = [&](double inside) {
      return (t.array() >= lowest.array()).all() && std::all_of(sums.begin(), sums.end(), [&](const Sum& sum) {
               return t[static_cast<Eigen::Index>(sum.first)] + t[static_cast<Eigen::Index>(sum.second)] <=
                      (1.0 - inside) * sum.limit;
             });
    };
    if (allowed(0.0)) return;
    const Eigen::Vector4d before_projection = t;
    Project(sums, lowest, t);
    // Corners that only rounding moved stay as they were given; the others give way to rounding.
    const Eigen::Array<bool, 4, 1> moved = (t - before_projection).array().abs() > 1e-9 * p().width;
    t = moved.select(t, before_projection);
    for (double shrink = kInside; !allowed(kInside) && shrink < 1.0; shrink *= 4.0) {
      const Eigen::Vector4d shrunk = lowest + (1.0 - shrink) * (t - lowest);
      t = shrink < 1e-6 ? Eigen::Vector4d(moved.select(shrunk, t)) : shrunk;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double before = p().*kCorners[k];
      const double now = t[static_cast<Eigen::Index>(k)];
      if (now == before) continue;
      p().*kCorners[k] = now;
      Say(kCorners[k], before < lowest[static_cast<Eigen::Index>(k)]
                           ? "the rim is too thick for so square a corner"
                           : "the corners together must leave room on their sides and for the bridge");
    }
  }

  static void Project(const std::vector<Sum>& sums, const Eigen::Vector4d& lowest, Eigen::Vector4d& t) {
    constexpr int kRounds = 400;
    Eigen::Vector4d low_memory = Eigen::Vector4d::Zero();
    std::vector<double> memory(sums.size(), 0.0);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t k = 0; k < sums.size(); ++k) {
        double& first = t[static_cast<Eigen::Index>(sums[k].first)];
        double& second = t[static_cast<Eigen::Index>(sums[k].second)];
        first += memory[k];
        second += memory[k];
        memory[k] = std::max(0.0, 0.5 * (first + second - sums[k].limit));
        first -= memory[k];
        second -= memory[k];
      }
      const Eigen::Vector4d free = t - low_memory;
      t = free.cwiseMax(lowest);
      low_memory = t - free;
    }
    t = t.cwiseMax(lowest);
  }

  void AdjustBridge() {
    const double root = std::numbers::sqrt2;
    const double low = std::max(p().lower_inner, p().lower_outer) / root + 0.5 * p().upper_thickness;
    const double high = p().height - std::max(p().upper_inner, p().upper_outer) / root - 0.5 * p().upper_thickness;
    // Where rounding leaves less than nothing between the two, both are the same.
    Clamp(&FrameParameters::bridge_height, std::min(low, high), std::max(low, high),
          "bridge and temples start beside the rim's straight sides");
  }

  void AdjustForms() {
    FrameDetails& details = used_.details;
    if (details.rim != RimForm::kRimless) return;
    if (details.bridge == BridgeForm::kKeyhole) {
      details.bridge = BridgeForm::kSaddle;
      messages_.emplace_back("bridge: keyhole given, saddle used: a keyhole grows from rims and there are none");
    }
    if (details.pads == PadForm::kFixed) {
      details.pads = PadForm::kAdjustable;
      messages_.emplace_back("pads: fixed given, adjustable used: fixed pads grow from rims and there are none");
    }
  }

  void AdjustDetails() {
    for (const DetailRule& rule : DetailRules()) {
      const std::optional<double> before = rule.Value(used_);
      if (!before) continue;
      const DetailLimits limits = rule.limits(used_);
      const double now = std::clamp(*before, std::min(limits.low, limits.high), limits.high);
      if (now == *before) continue;
      if (rule.member != nullptr) {
        used_.details.*rule.member = now;
      } else {
        used_.details.*rule.optional_member = now;
      }
      messages_.push_back(
          fmt::format("{}: {} given, {} used: {}", rule.name, rule.Text(*before), rule.Text(now), limits.why));
    }
  }

  const FrameDesign& given_;
  FrameDesign used_;
  std::vector<std::string> messages_;
};

Status CheckFinite(const FrameDesign& design) {
  const auto refuse = [](std::string_view name, double value) {
    return Fail("adjust the frame's design", fmt::format("{} is {}", name, value), "every size of a frame is a number");
  };
  for (const FrameParameterField& field : FrameParameterFields()) {
    if (!std::isfinite(design.parameters.*field.member)) return refuse(field.option, design.parameters.*field.member);
  }
  for (const DetailRule& rule : DetailRules()) {
    const std::optional<double> value = rule.Value(design);
    if (value && !std::isfinite(*value)) return refuse(rule.name, *value);
  }
  return {};
}

}  // namespace

Result<AdjustedDesign> AdjustDesign(const FrameDesign& design) {
  RETURN_IF_ERROR(CheckFinite(design));
  if (Validate(design)) return AdjustedDesign{design, {}};
  return Adjuster(design).Run();
}

}  // namespace annulus
