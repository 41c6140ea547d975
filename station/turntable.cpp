#include "station/turntable.h"

#include <fmt/format.h>

#include "station/files.h"

namespace annulus {

Status WriteTurntable(Storage& storage, const std::string& out, const std::vector<RgbImage>& frames,
                      const AnimationOptions& options) {
  const auto film = EncodeAnimatedWebp(frames, options);
  if (!film) return Fail(film);
  if (out.ends_with(".webp")) return WriteFileAtomically(storage, out, std::span<const std::byte>(*film));
  RETURN_IF_ERROR(storage.CreateFolder(out));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    RETURN_IF_ERROR(WritePngFile(storage, fmt::format("{}/frame_{:03}.png", out, k), frames[k]));
  }
  return WriteFileAtomically(storage, out + "/turntable.webp", std::span<const std::byte>(*film));
}

}  // namespace annulus
