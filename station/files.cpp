#include "station/files.h"

#include <filesystem>
#include <system_error>

#include "modeling/exchange/model_json.h"
#include "render/png.h"

namespace annulus {

Result<SurfaceModel> ReadModelFile(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return ModelFromJson(*text, path);
}

Status WriteModelFile(Storage& storage, const std::string& path, const SurfaceModel& model) {
  return WriteFileAtomically(storage, path, ModelToJson(model));
}

Result<FrameFile> ReadFrameFile(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return FrameFromJson(*text, path);
}

Result<FrameLibrary> ReadFrameLibraryFile(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return FrameLibraryFromJson(*text, path);
}

Result<WornFrame> ReadWornFile(Storage& storage, const std::string& path) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return WornFrameFromJson(*text, path);
}

Status WritePngFile(Storage& storage, const std::string& path, const RgbImage& image) {
  const auto bytes = EncodePng(image);
  if (!bytes) return Fail(bytes);
  return WriteFileAtomically(storage, path, std::span<const std::byte>(*bytes));
}

Status CheckReplacing(const Storage& storage, const std::string& path, Replacing replacing) {
  if (replacing == Replacing::kForce || !storage.Exists(path)) return {};
  return Fail("write " + path, "it exists already", "choose another name, or give --force to replace it");
}

Status CheckNotItself(const std::string& input, const std::string& output) {
  std::error_code none;
  if (input.empty() || output.empty() || !std::filesystem::equivalent(input, output, none)) return {};
  return Fail("write " + output, "it is the input itself", "choose another name: input files are never changed");
}

}  // namespace annulus
