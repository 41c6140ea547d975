#pragma once

#include <memory>
#include <string>

#include "acquisition/scanner.h"
#include "acquisition/sealed_file.h"
#include "station/console/console_context.h"

namespace annulus {

/// Where boothd leaves its recordings.
struct ScanIntakeOptions {
  std::string recordings;           ///< The folder that boothd was given.
  const KeySource* keys = nullptr;  ///< Of boothd's key file; null: its recordings are plain. Borrowed.
};

/// Takes recordings from boothd's folder into the store: judged, sealed with the customer's key, told to the browsers
/// (`scan_result`), fitted, and looked at for drift of the ring. Looks at its start, when a scan has ended, and when
/// boothd is there again; so nothing is lost if the console was away, or died in between (a recording that is in the
/// store already, by its ticket, is only removed). A recording whose customer was erased, or whose consent was
/// withdrawn meanwhile, is deleted, which the audit says. One that the store does not take stays, and is tried again.
///
/// A thread of its own; thread-safe.
class ScanIntake {
 public:
  static std::unique_ptr<ScanIntake> Make(ConsoleContext& context, ScanIntakeOptions options);
  virtual ~ScanIntake() = default;

  /// boothd says how a scan has ended; null: it is there again (BoothLive::OnScanEnded). Returns at once.
  virtual void ScanEnded(const ScanResult* result) = 0;
};

}  // namespace annulus
