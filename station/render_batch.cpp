#include "station/render_batch.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "render/image_file.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPictures = 10000;

/// Reads one batch file; borrows its name.
class BatchReader {
 public:
  explicit BatchReader(std::string_view name) : attempted_("read the batch of pictures " + std::string(name)) {}

  [[nodiscard]] Result<RenderBatch> Read(std::string_view text) const {
    const Json root = Json::parse(text, nullptr, false);
    if (root.is_discarded()) return Fail(attempted_, "it is not JSON", "repair it");
    RETURN_IF_ERROR(CheckKeys(root, "the file", {"defaults", "pictures", "sheet"}));
    const Json defaults = root.value("defaults", Json::object());
    if (!defaults.is_object()) return Wrong("\"defaults\"", "an object");
    if (!root.contains("pictures") || !root["pictures"].is_array() || root["pictures"].empty() ||
        root["pictures"].size() > kMostPictures) {
      return Wrong("\"pictures\"", "a list of 1 ... " + std::to_string(kMostPictures) + " objects");
    }
    RenderBatch batch;
    for (const Json& entry : root["pictures"]) {
      const std::string where = "pictures[" + std::to_string(batch.pictures.size()) + "]";
      if (!entry.is_object()) return Wrong(where, "an object");
      Json merged = defaults;
      merged.update(entry);
      auto request = ReadPicture(merged, where);
      if (!request) return Fail(request);
      batch.pictures.push_back(std::move(*request));
    }
    if (root.contains("sheet")) RETURN_IF_ERROR(ReadSheet(root["sheet"], batch.sheet));
    return CheckOutputs(std::move(batch));
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Wrong(const std::string& what, const std::string& wanted) const {
    return Fail(attempted_, what + " is missing or something else", "give " + wanted);
  }

  [[nodiscard]] Status CheckKeys(const Json& object, const std::string& what,
                                 const std::set<std::string>& known) const {
    if (!object.is_object()) return Wrong(what, "an object");
    for (const auto& [key, value] : object.items()) {
      if (known.count(key) == 0) return Fail(attempted_, what + " has an unknown key '" + key + "'", "remove it");
    }
    return {};
  }

  /// The words that would be typed for the picture, last first, as CLI11 wants them.
  [[nodiscard]] Result<std::vector<std::string>> WordsOf(const Json& picture, const std::string& where) const {
    std::vector<std::string> words;
    std::string model;
    for (const auto& [key, value] : picture.items()) {
      std::string option = key;
      std::replace(option.begin(), option.end(), '_', '-');
      if (value.is_null() || (value.is_boolean() && !value.get<bool>())) continue;
      const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
      if (key == "model" && value.is_string()) {
        model = text;
      } else if (value.is_boolean()) {
        words.push_back("--" + option);
      } else if (value.is_string() || value.is_number()) {
        words.push_back("--" + option + "=" + text);
      } else {
        return Wrong(where + "." + key, "a text, a number, true, false or null");
      }
    }
    if (!model.empty()) words.insert(words.end(), {"--", model});
    std::reverse(words.begin(), words.end());
    return words;
  }

  [[nodiscard]] Result<RenderRequest> ReadPicture(const Json& picture, const std::string& where) const {
    auto words = WordsOf(picture, where);
    if (!words) return Fail(words);
    RenderRequest request;
    CLI::App app;
    app.set_help_flag();
    AddRenderOptions(app, request);
    try {
      app.parse(std::move(*words));
    } catch (const CLI::ParseError& error) {
      return Fail(attempted_, where + ": " + error.what(), "give the options of annulus render as keys");
    }
    const Status checked = CheckRequest(request);
    if (!checked) return Fail(attempted_, where + ": " + checked.error().Text(), "add or repair it");
    return request;
  }

  [[nodiscard]] Status ReadSheet(const Json& json, BatchSheet& sheet) const {
    RETURN_IF_ERROR(CheckKeys(json, "\"sheet\"", {"out", "columns", "title"}));
    if (!json.contains("out") || !json["out"].is_string()) return Wrong("sheet.out", "the name of a .png or .exr file");
    sheet.out = json["out"].get<std::string>();
    RETURN_IF_ERROR(CheckImagePath(sheet.out));
    if (json.contains("columns")) {
      const Json& columns = json["columns"];
      if (!columns.is_number_integer() || columns.get<std::int64_t>() < 1 || columns.get<std::int64_t>() > 20) {
        return Wrong("sheet.columns", "a whole number of 1 ... 20");
      }
      sheet.columns = columns.get<int>();
    }
    if (json.contains("title")) {
      if (!json["title"].is_string()) return Wrong("sheet.title", "a text");
      sheet.title = json["title"].get<std::string>();
    }
    return {};
  }

  /// Every picture goes somewhere, and no two to the same file.
  [[nodiscard]] Result<RenderBatch> CheckOutputs(RenderBatch batch) const {
    std::set<std::string> taken{batch.sheet.out};
    for (std::size_t k = 0; k < batch.pictures.size(); ++k) {
      const RenderRequest& request = batch.pictures[k];
      const std::string where = "pictures[" + std::to_string(k) + "]";
      if (request.out.empty() && batch.sheet.out.empty()) {
        return Fail(attempted_, where + " has no \"out\"", "add it, or a \"sheet\"");
      }
      for (const std::string& path : {request.out, request.alpha, request.depth, request.progressive}) {
        if (!path.empty() && !taken.insert(path).second) {
          return Fail(attempted_, where + " writes '" + path + "' a second time", "give each its own name");
        }
      }
    }
    return batch;
  }

  std::string attempted_;
};

}  // namespace

Result<RenderBatch> RenderBatchFromJson(std::string_view json, std::string_view name) {
  return BatchReader(name).Read(json);
}

}  // namespace annulus
