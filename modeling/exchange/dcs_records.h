#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "modeling/exchange/dcs.h"

namespace annulus {

/// A chiral record that every trace has, mm.
struct DcsLength {
  std::string_view label;
  double DcsEye::*member;
  double low;  ///< What a reader takes.
  double high;
};
inline constexpr std::array<DcsLength, 4> kDcsLengths{{{"HBOX", &DcsEye::hbox, 1.0, 200.0},
                                                       {"VBOX", &DcsEye::vbox, 1.0, 200.0},
                                                       {"FED", &DcsEye::fed, 1.0, 300.0},
                                                       {"CIRC", &DcsEye::circ, 1.0, 1000.0}}};

/// A chiral record that may be missing, for one eye or both.
struct DcsOptional {
  std::string_view label;
  std::optional<double> DcsEye::*member;
  double low;
  double high;
};
inline constexpr std::array<DcsOptional, 9> kDcsOptionals{{{"IPD", &DcsEye::ipd, 10.0, 60.0},
                                                           {"OCHT", &DcsEye::ocht, 0.0, 100.0},
                                                           {"FCRV", &DcsEye::frame_curve, -20.0, 20.0},
                                                           {"SPH", &DcsEye::sphere, -60.0, 60.0},
                                                           {"CYL", &DcsEye::cylinder, -30.0, 30.0},
                                                           {"AX", &DcsEye::axis_deg, 0.0, 180.0},
                                                           {"ADD", &DcsEye::add, 0.0, 10.0},
                                                           {"PRVM", &DcsEye::prism, 0.0, 60.0},
                                                           {"PRVA", &DcsEye::base_deg, 0.0, 360.0}}};

/// `text` with what a record cannot hold replaced by '?', at most 80 bytes.
[[nodiscard]] std::string DcsPrintable(std::string_view text);

}  // namespace annulus
