#include "acquisition/scan_cause.h"

namespace annulus {
namespace {

using Role = CauseRole;
using Path = StopPath;

/// In the order of CauseCode.
constexpr std::array<CauseTraits, kCauseCodes> kTraits{{
    {"chain_open", Role::kOperator, Path::kQuickStop, true},
    {"interlock", Role::kOperator, Path::kQuickStop, true},
    {"channels_differ", Role::kService, Path::kQuickStop, true},
    {"welded_contact", Role::kService, Path::kQuickStop, true},
    {"brake_slip", Role::kService, Path::kQuickStop, true},
    {"axis_link", Role::kOperator, Path::kQuickStop, true},
    {"axis_fault", Role::kOperator, Path::kQuickStop, true},
    {"axis_parameters", Role::kOperator, Path::kQuickStop, true},
    {"following_error", Role::kOperator, Path::kQuickStop, true},
    {"encoder_jump", Role::kOperator, Path::kQuickStop, true},
    {"homing", Role::kOperator, Path::kRamp, true},
    {"limit", Role::kOperator, Path::kQuickStop, true},
    {"unordered_move", Role::kOperator, Path::kQuickStop, true},
    {"wrong_direction", Role::kOperator, Path::kQuickStop, true},
    {"overspeed", Role::kOperator, Path::kQuickStop, true},
    {"stop_overdue", Role::kOperator, Path::kQuickStop, true},
    {"sensor_lost", Role::kOperator, Path::kRamp, false},
    {"sensor_bus", Role::kOperator, Path::kRamp, false},
    {"sensor_data", Role::kOperator, Path::kRamp, false},
    {"sensors_dead", Role::kOperator, Path::kRamp, false},
    {"emitter", Role::kOperator, Path::kRamp, false},
    {"ring_identity", Role::kOperator, Path::kRamp, false},
    {"host_late", Role::kOperator, Path::kRamp, false},
    {"host_hang", Role::kOperator, Path::kQuickStop, true},
    {"thread_dead", Role::kOperator, Path::kQuickStop, true},
    {"memory", Role::kOperator, Path::kQuickStop, true},
    {"host_health", Role::kOperator, Path::kRamp, false},
    {"storage", Role::kOperator, Path::kRamp, false},
    {"disk_full", Role::kOperator, Path::kRamp, false},
    {"gate", Role::kOperator, Path::kRamp, false},
    {"plan", Role::kOperator, Path::kRamp, false},
    {"internal", Role::kOperator, Path::kQuickStop, true},
}};

}  // namespace

const CauseTraits& TraitsOf(CauseCode code) { return kTraits.at(static_cast<std::size_t>(code)); }

}  // namespace annulus
