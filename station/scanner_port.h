#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/scanner.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/booth_server.h"
#include "station/config.h"

namespace annulus {

/// What a client calls a recording, as a path: below `folder`, with the ending ".mcap". Fails for a name that would
/// lead elsewhere, or that begins with a dot.
Result<std::string> RecordingPath(const std::string& folder, const std::string& name);

/// What the port needs to know beside the scanner. Borrowed, but for the folder and the notes.
struct ScannerPortOptions {
  const Config& config;
  Storage& storage;
  std::string recordings;          ///< Folder of the recordings.
  std::vector<ScanWarning> notes;  ///< Shown as warnings of the status all the time.
};

/// The booth's scanner behind the port: profiles become plans, names of recordings paths. Borrows the scanner.
class ScannerPort final : public BoothPort {
 public:
  ScannerPort(Scanner& scanner, BoothDescription description, ScannerPortOptions options);

  [[nodiscard]] const BoothDescription& description() const override { return description_; }
  Status Home() override { return scanner_.OrderHome(); }
  /// Fails before the scanner is asked if the plan cannot be made, the name leads elsewhere or is taken, or, on a booth
  /// with real devices, subject or consent are missing.
  Status Arm(const ArmOrder& order) override;
  /// Fails unless somebody has just pressed the start key at the booth, since it was armed: nobody starts it from afar.
  Status Start(std::uint64_t version) override;
  Status Cancel() override { return scanner_.Cancel(); }
  Status Acknowledge(CauseRole role) override { return scanner_.Acknowledge(role); }
  Status Jog(Scanner::JogDirection direction) override { return scanner_.Jog(direction); }
  [[nodiscard]] ScannerStatus status() const override;

 private:
  Scanner& scanner_;
  BoothDescription description_;
  ScannerPortOptions options_;
};

}  // namespace annulus
