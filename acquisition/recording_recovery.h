#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "acquisition/recording.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// What a recovery found and saved.
struct RecoverySummary {
  bool lossless = false;  ///< Nothing that is known to have been recorded is missing.
  bool was_finished = false;
  bool sealed = false;
  std::uint64_t levels = 0;                            ///< In the new file.
  std::map<std::string, std::uint64_t> messages;       ///< In the new file, by topic.
  std::map<std::string, std::uint64_t> messages_lost;  ///< Known from gaps and from the end record, by topic.
  std::uint64_t chunks_lost = 0;                       ///< Seen, but damaged.
  std::uint64_t frames_lost = 0;                       ///< Of a sealed file.
  std::uint64_t skipped_bytes = 0;                     ///< Belong to no record: torn writes.
  std::uint64_t unprotected = 0;                       ///< Messages that no CRC vouches for; left out.
  std::vector<std::string> notes;                      ///< One line per damage, with its place.

  /// One line for people.
  [[nodiscard]] std::string BriefReport() const;
};

/// How a sealed recording is saved.
enum class RecoveredAs {
  kItWas,  ///< Sealed again with its key.
  kPlain,
};

/// Saves what is sound of a recording as the new, finished recording `out` (replaced if it exists), with all its
/// channels. `path` is only read. Sequence numbers stay as they were, so that gaps remain to
/// be seen. What was written is read again and compared before it gets its name. A plain recording that is whole gives
/// the same bytes, and a recovered one too. Fails if it is no recording, has no readable header or level, or cannot be
/// opened or written; then `out` is as it was.
Result<RecoverySummary> RecoverRecording(Storage& storage, const std::string& path, const std::string& out,
                                         const KeySource* keys = nullptr, RecoveredAs as = RecoveredAs::kItWas);

/// What became of a recording that was found unfinished.
struct OpenRecording {
  std::string part;       ///< The path under which it was found.
  std::string recording;  ///< What it was recovered to; "" if it was not.
  std::string kept;       ///< Where the original is now; "" if it is gone, because nothing of it is missing.
  Result<RecoverySummary> outcome;
};

/// At start-up: recovers every recording in `folder` that a program which is gone has left unfinished, under its name,
/// or beside it if that is taken. The original is removed once all of it is safe in the new file; after a loss, or if
/// nothing could be saved, it is kept as NAME.damaged-PID. One whose key is missing is left for another time.
Result<std::vector<OpenRecording>> RecoverOpenRecordings(Storage& storage, const std::string& folder,
                                                         const KeySource* keys = nullptr);

}  // namespace annulus
