#include "station/scanner_port.h"

#include <filesystem>
#include <utility>

#include "station/calibration_gate.h"
#include "station/command_line.h"
#include "station/profile_plan.h"

namespace annulus {

Result<std::string> RecordingPath(const std::string& folder, const std::string& name) {
  const std::string attempted = "record to '" + name + "'";
  const std::filesystem::path path(name);
  if (path.is_absolute() || path.extension() != ".mcap") {
    return Fail(attempted, "it is not the name of a recording below the booth's folder",
                "give one such as scan-17.mcap");
  }
  for (const auto& part : path) {
    if (part.empty() || part.string().front() == '.') {
      return Fail(attempted, "it has a part that is empty or begins with a dot", "give one such as day/scan-17.mcap");
    }
  }
  return (std::filesystem::path(folder) / path).string();
}

ScannerPort::ScannerPort(Scanner& scanner, BoothDescription description, ScannerPortOptions options)
    : scanner_(scanner), description_(std::move(description)), options_(std::move(options)) {}

Status ScannerPort::Arm(const ArmOrder& order) {
  const Config& config = options_.config;
  ArmRequest request;
  request.search = order.search;
  request.header.station_id = config.station_id;
  request.header.source = description_.simulated ? config.sim.subject : "";
  request.header.subject_id = order.subject_id;
  request.header.consent_reference = order.consent;
  request.header.program_version = ProgramVersion();
  request.header.ring_radius_mm = config.ring.radius_mm;
  auto calibration = CalibrationInForce(config, order.profile, options_.storage);
  if (!calibration) return Fail(calibration);
  request.header.calibration = std::move(*calibration);
  request.header.reference = RecordedReferenceOf(config.ring);
  request.header.profile = order.profile;
  request.header.seed = description_.simulated ? config.sim.seed : 0;
  if (!order.search) {
    const bool person = !description_.simulated && !IsTargetProfile(order.profile);
    if (person && (order.subject_id.empty() || order.consent.empty())) {
      return Fail("arm a scan", "no subject or no consent is named", "give subject_id and consent");
    }
    const auto path = RecordingPath(options_.recordings, order.out);
    if (!path) return Fail(path);
    if (options_.storage.Exists(*path)) {
      return Fail("arm a scan", "there is a recording '" + order.out + "' already", "choose another name");
    }
    RETURN_IF_ERROR(options_.storage.CreateFolder(std::filesystem::path(*path).parent_path().string()));
    auto plan = PlanOfProfile(config, order.profile, order.height);
    if (!plan) return Fail(plan);
    request.plan = *plan;
    request.out = *path;
  }
  return scanner_.OrderArm(std::move(request));
}

Status ScannerPort::Start(std::uint64_t version) {
  const ScannerStatus status = scanner_.status();
  if (status.state == ScanState::kArmed && !status.start_agreed) {
    return Fail("start the scan",
                "nobody has pressed the start key at the booth since it was armed, or not within the last 10 s",
                "press it, then start");
  }
  return scanner_.OrderStart(version);
}

ScannerStatus ScannerPort::status() const {
  ScannerStatus status = scanner_.status();
  status.warnings.insert(status.warnings.begin(), options_.notes.begin(), options_.notes.end());
  return status;
}

}  // namespace annulus
