#pragma once

#include <vector>

#include "acquisition/scan_sink.h"
#include "base/result.h"

namespace annulus {

/// Collects what passes the buses, for the recording of the scan that runs. What passed while the devices were opened
/// (the prelude) is kept, and told to every recording first: with it a replay opens the same ring again. Thread-bound.
class BusTap {
 public:
  /// At most so much of the prelude is kept, bytes.
  static constexpr std::size_t kMaxPrelude = std::size_t{1} << 20;

  /// Something passed. Before EndPrelude it is kept, afterwards handed to the sink, if there is one.
  void Record(RawRecord record);
  /// The devices are open.
  void EndPrelude() { opening_ = false; }
  /// From now on to this sink, which is told the prelude first; it is borrowed until Detach.
  Status Attach(ScanSink& sink);
  void Detach() { sink_ = nullptr; }
  /// The first failure of the sink since Attach.
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  bool opening_ = true;
  std::vector<RawRecord> prelude_;
  std::size_t prelude_bytes_ = 0;
  ScanSink* sink_ = nullptr;  ///< Null: nothing is recorded.
  Status status_;
};

}  // namespace annulus
