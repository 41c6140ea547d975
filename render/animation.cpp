#include "render/animation.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include <cstdint>
#include <memory>
#include <string>

namespace annulus {
namespace {

constexpr const char* kAttempted = "encode an animated WebP";

struct DeleteEncoder {
  void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
};
using Encoder = std::unique_ptr<WebPAnimEncoder, DeleteEncoder>;

/// A picture in the library's memory.
class Picture {
 public:
  Picture() { ready_ = WebPPictureInit(&picture_) != 0; }
  ~Picture() { WebPPictureFree(&picture_); }
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;

  /// Takes the sRGB bytes of an image.
  [[nodiscard]] bool Fill(const RgbImage& image) {
    if (!ready_) return false;
    picture_.use_argb = 1;
    picture_.width = image.width;
    picture_.height = image.height;
    if (WebPPictureAlloc(&picture_) == 0) return false;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const LinearRgb& rgb = image.rgb[image.Index(x, y)];
        const std::uint32_t red = SrgbByteFromLinear(rgb[0]);
        const std::uint32_t green = SrgbByteFromLinear(rgb[1]);
        const std::uint32_t blue = SrgbByteFromLinear(rgb[2]);
        picture_.argb[static_cast<std::ptrdiff_t>(y) * picture_.argb_stride + x] =
            0xFF000000U | red << 16U | green << 8U | blue;
      }
    }
    return true;
  }
  [[nodiscard]] WebPPicture* get() { return &picture_; }

 private:
  WebPPicture picture_{};
  bool ready_ = false;
};

Status CheckFrames(std::span<const RgbImage> frames, const AnimationOptions& options) {
  if (frames.empty()) return Fail(kAttempted, "there is no frame", "give at least one");
  const RgbImage& first = frames.front();
  const auto in_range = [](int size) { return size >= 1 && size <= WEBP_MAX_DIMENSION; };
  for (const RgbImage& frame : frames) {
    if (frame.width != first.width || frame.height != first.height || !in_range(frame.width) ||
        !in_range(frame.height) || frame.rgb.size() != frame.Index(0, frame.height)) {
      return Fail(kAttempted, "a frame of " + std::to_string(frame.width) + " x " + std::to_string(frame.height),
                  "give frames of one size, each side 1 ... " + std::to_string(WEBP_MAX_DIMENSION) + " pixels");
    }
  }
  if (options.frame_ms < 10 || options.frame_ms > 10'000 || options.loops < 0 || options.loops > 65'535) {
    return Fail(kAttempted,
                std::to_string(options.frame_ms) + " ms per frame, " + std::to_string(options.loops) + " loops",
                "give 10 ... 10000 ms and 0 ... 65535 loops");
  }
  return {};
}

/// What the encoder says of itself.
Status EncoderFailed(WebPAnimEncoder* encoder) {
  const char* error = WebPAnimEncoderGetError(encoder);
  return Fail(kAttempted, error != nullptr ? error : "the encoder refused it", "try smaller or fewer frames");
}

}  // namespace

Result<std::vector<std::byte>> EncodeAnimatedWebp(std::span<const RgbImage> frames, const AnimationOptions& options) {
  RETURN_IF_ERROR(CheckFrames(frames, options));
  WebPAnimEncoderOptions animation;
  WebPConfig config;
  if (WebPAnimEncoderOptionsInit(&animation) == 0 || WebPConfigInit(&config) == 0) {
    return Fail(kAttempted, "the WebP library is of another version than its header", "install libwebp again");
  }
  animation.anim_params.loop_count = options.loops;
  // Every frame is whole: a reader can begin anywhere, and nothing is blended.
  animation.kmin = 0;
  animation.kmax = 1;
  config.lossless = 1;
  config.quality = 30.0F;  // effort: more costs much time for few bytes
  config.method = 2;
  const Encoder encoder(WebPAnimEncoderNew(frames.front().width, frames.front().height, &animation));
  if (!encoder) return Fail(kAttempted, "there is no memory for a frame", "try smaller frames");
  int time_ms = 0;
  for (const RgbImage& frame : frames) {
    Picture picture;
    if (!picture.Fill(frame)) return Fail(kAttempted, "there is no memory for a frame", "try smaller frames");
    if (WebPAnimEncoderAdd(encoder.get(), picture.get(), time_ms, &config) == 0) {
      return Fail(EncoderFailed(encoder.get()));
    }
    time_ms += options.frame_ms;
  }
  if (WebPAnimEncoderAdd(encoder.get(), nullptr, time_ms, nullptr) == 0) return Fail(EncoderFailed(encoder.get()));
  WebPData data;
  WebPDataInit(&data);
  const bool assembled = WebPAnimEncoderAssemble(encoder.get(), &data) != 0;
  const auto* first = reinterpret_cast<const std::byte*>(data.bytes);
  std::vector<std::byte> bytes(first, first + data.size);
  WebPDataClear(&data);
  if (!assembled) return Fail(EncoderFailed(encoder.get()));
  return bytes;
}

}  // namespace annulus
