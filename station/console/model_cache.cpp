#include "station/console/model_cache.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "base/log.h"
#include "modeling/exchange/landmarks_json.h"
#include "modeling/exchange/model_json.h"
#include "modeling/landmarks/landmarks.h"
#include "station/console/scan_json.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kMost = 4;
constexpr std::chrono::seconds kUnused{300};
constexpr std::chrono::seconds kLook{30};

class Cache final : public ModelCache {
 public:
  explicit Cache(Opener opener) : opener_(std::move(opener)) {
    forgetting_ = std::jthread([this](const std::stop_token& stop) { Forget(stop); });
  }

  Result<std::shared_ptr<const OpenModel>> Open(const std::string& scan_id) override {
    if (auto found = Find(scan_id)) return found;
    // One at a time: two requests for the same model would open it twice.
    const std::lock_guard one(opening_);
    if (auto found = Find(scan_id)) return found;
    std::uint64_t drops = 0;
    {
      const std::lock_guard lock(mutex_);
      drops = drops_;
    }
    auto opened = opener_(scan_id);
    if (!opened) return Fail(opened);
    const std::lock_guard lock(mutex_);
    if (drops == drops_) {  // else it may be an old one
      entries_.push_front({*opened, SteadyClock::now()});
      if (entries_.size() > kMost) entries_.pop_back();
    }
    return *opened;
  }

  void Change(const OpenModel& from, std::shared_ptr<const OpenModel> to) override {
    const std::lock_guard lock(mutex_);
    ++drops_;  // one that is being opened has the landmarks of before
    for (Entry& entry : entries_) {
      if (entry.model.get() == &from) entry = {to, SteadyClock::now()};
    }
    entries_.remove_if([&](const Entry& entry) { return entry.model->scan_id == to->scan_id && entry.model != to; });
  }
  void Drop(const std::string& scan_id) override {
    const std::lock_guard lock(mutex_);
    ++drops_;
    entries_.remove_if([&](const Entry& entry) { return entry.model->scan_id == scan_id; });
  }
  void DropAll() override {
    const std::lock_guard lock(mutex_);
    ++drops_;
    entries_.clear();
  }

 private:
  struct Entry {
    std::shared_ptr<const OpenModel> model;
    SteadyClock::time_point used;
  };

  std::shared_ptr<const OpenModel> Find(const std::string& scan_id) {
    const std::lock_guard lock(mutex_);
    const auto entry =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.model->scan_id == scan_id; });
    if (entry == entries_.end()) return nullptr;
    entry->used = SteadyClock::now();
    entries_.splice(entries_.begin(), entries_, entry);
    return entry->model;
  }

  void Forget(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      const auto now = SteadyClock::now();
      entries_.remove_if([&](const Entry& entry) { return now - entry.used >= kUnused; });
      stopped_.wait_for(lock, stop, kLook, [] { return false; });
    }
  }

  const Opener opener_;
  std::mutex opening_;
  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any stopped_;
  std::list<Entry> entries_;  ///< The last used first.
  std::uint64_t drops_ = 0;
  std::jthread forgetting_;  ///< Last: it ends first.
};

std::string_view AsText(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Landmarks WithThoseByHand(Store& store, const std::string& scan_id, const MeasuredSurface& body, Landmarks landmarks) {
  const auto file = NewestArtefact(store, scan_id, "landmarks");
  if (!file) return landmarks;  // nobody has set one
  const auto text = store.ReadArtefact(file->id);
  const auto given = text ? GivenLandmarksFromJson(AsText(*text), "landmarks of " + scan_id)
                          : Result<std::vector<GivenLandmark>>(Fail(text));
  if (!given) Log(LogLevel::kWarning, given.error().Text());
  if (!given) return landmarks;
  for (const GivenLandmark& one : *given) {
    auto edited = SetByHand(body, landmarks, one);
    if (!edited) Log(LogLevel::kWarning, scan_id + ": " + edited.error().Text());
    if (edited) landmarks = std::move(*edited);
  }
  return landmarks;
}

}  // namespace

std::unique_ptr<ModelCache> ModelCache::Make(Opener opener) { return std::make_unique<Cache>(std::move(opener)); }

Result<std::shared_ptr<const OpenModel>> OpenStoredModel(Store& store, const std::string& scan_id) {
  const auto artefact = NewestArtefact(store, scan_id, "model");
  if (!artefact) return Fail(artefact);
  const auto bytes = store.ReadArtefact(artefact->id);
  if (!bytes) return Fail(bytes);
  auto model = ModelFromJson(AsText(*bytes), "the model of " + scan_id);
  if (!model) return Fail(model);
  auto owned = std::make_unique<const SurfaceModel>(std::move(*model));
  auto body = MeasuredSurface::FromModel(*owned);
  if (!body) return Fail(body);
  Landmarks landmarks = WithThoseByHand(store, scan_id, *body, FindLandmarks(*body, {}));
  auto open = std::make_shared<OpenModel>(
      OpenModel{scan_id, artefact->id, LoadedModel{std::move(owned), *body}, std::move(landmarks)});
  return std::shared_ptr<const OpenModel>(std::move(open));
}

}  // namespace annulus
