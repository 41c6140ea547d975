#include <utility>

#include "forwarding_storage.h"
#include "planted_defects.h"

namespace annulus::test {
namespace {

/// What a defective file knows of where it lies.
struct Place {
  CrashDisk& disk;
  std::size_t file = 0;
};

using FileDefect = std::function<std::unique_ptr<AppendFile>(std::unique_ptr<AppendFile> below, Place place)>;

/// A storage whose new files are defective.
class DefectiveFiles final : public ForwardingStorage {
 public:
  DefectiveFiles(Storage& below, CrashDisk& disk, FileDefect defect)
      : ForwardingStorage(below), disk_(disk), defect_(std::move(defect)) {}
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    auto file = below_.Create(path);
    if (!file) return Fail(file);
    return defect_(std::move(*file), Place{disk_, *disk_.FileOf(path)});
  }

 private:
  CrashDisk& disk_;
  FileDefect defect_;
};

/// A Defect that puts a File, made from what is below and its Place, around every new file.
template <class File>
Defect Files() {
  return [](Storage& below, CrashDisk& disk) -> std::unique_ptr<Storage> {
    return std::make_unique<DefectiveFiles>(below, disk, [](std::unique_ptr<AppendFile> file, Place place) {
      return std::make_unique<File>(std::move(file), place);
    });
  };
}

/// A Defect that is a whole Storage.
template <class Kind>
Defect Whole() {
  return
      [](Storage& below, CrashDisk& disk) -> std::unique_ptr<Storage> { return std::make_unique<Kind>(below, disk); };
}

/// A file that knows its place; the base of the defects.
class PlacedFile : public ForwardingFile {
 public:
  PlacedFile(std::unique_ptr<AppendFile> below, Place place) : ForwardingFile(std::move(below)), place_(place) {}

 protected:
  Place place_;
};

/// Says "written" while the bytes are in a buffer of the program, as stdio does.
class BufferedFile final : public ForwardingFile {
 public:
  using ForwardingFile::ForwardingFile;
  Status Append(std::span<const std::byte> bytes) override {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    constexpr std::size_t kBufferBytes = std::size_t{64} << 10U;
    return buffer_.size() >= kBufferBytes ? Flush() : Status();
  }
  Status Close() override {
    RETURN_IF_ERROR(Flush());
    return below_->Close();
  }

 private:
  Status Flush() {
    const Status status = below_->Append(buffer_);
    buffer_.clear();
    return status;
  }
  std::vector<std::byte> buffer_;
};

class BufferedFiles final : public ForwardingStorage {
 public:
  using ForwardingStorage::ForwardingStorage;
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    auto file = below_.Create(path);
    if (!file) return Fail(file);
    return std::make_unique<BufferedFile>(std::move(*file));
  }
};

class UnsyncedFile final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Sync() override { return {}; }
};

class SyncErrorSwallowed final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Sync() override {
    (void)below_->Sync();
    return {};
  }
};

class SyncTriedAgain final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Sync() override {
    const Status first = below_->Sync();
    return first ? first : below_->Sync();
  }
};

class ShortWriteCalledSuccess final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Append(std::span<const std::byte> bytes) override {
    (void)below_->Append(bytes);
    return {};
  }
};

/// Hands every second write on after the one that follows it.
class WritesReordered final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Append(std::span<const std::byte> bytes) override {
    if (++writes_ > 1 && writes_ % 2 == 0) {
      held_.assign(bytes.begin(), bytes.end());
      return {};
    }
    RETURN_IF_ERROR(below_->Append(bytes));
    return LetGo();
  }
  Status Sync() override {
    RETURN_IF_ERROR(LetGo());
    return below_->Sync();
  }

 private:
  Status LetGo() {
    const std::vector<std::byte> bytes = std::exchange(held_, {});
    return bytes.empty() ? Status() : below_->Append(bytes);
  }
  std::vector<std::byte> held_;
  std::uint64_t writes_ = 0;
};

class WriteDoneTwice final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Append(std::span<const std::byte> bytes) override {
    RETURN_IF_ERROR(below_->Append(bytes));
    return ++writes_ % 7 == 0 ? below_->Append(bytes) : Status();
  }

 private:
  std::uint64_t writes_ = 0;
};

/// Every ninth write begins 16 bytes too early.
class WriteAtAWrongPlace final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Append(std::span<const std::byte> bytes) override {
    const std::uint64_t wrong = ++writes_ % 9 == 0 ? 16 : 0;
    const Status status = place_.disk.WriteAt(place_.file, end_ - wrong, bytes);
    if (status) end_ += bytes.size() - wrong;
    return status;
  }

 private:
  std::uint64_t writes_ = 0;
  std::uint64_t end_ = 0;
};

/// Every tenth write has one wrong byte in it.
class ByteSpoiled final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Append(std::span<const std::byte> bytes) override {
    std::vector<std::byte> copy(bytes.begin(), bytes.end());
    if (++writes_ % 10 == 0) copy[copy.size() / 3] ^= std::byte{0x10};
    return below_->Append(copy);
  }

 private:
  std::uint64_t writes_ = 0;
};

class HeaderUnsynced final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Sync() override { return std::exchange(first_, false) ? Status() : below_->Sync(); }

 private:
  bool first_ = true;
};

class SyncedTooRarely final : public PlacedFile {
 public:
  using PlacedFile::PlacedFile;
  Status Sync() override {
    constexpr std::uint64_t kKept = 4;
    return syncs_++ % kKept == 0 ? below_->Sync() : Status();
  }

 private:
  std::uint64_t syncs_ = 0;
};

/// Gives the file its name, and only then syncs what the last Sync should have brought to the disk.
class RenamedBeforeSync final : public ForwardingStorage {
 public:
  RenamedBeforeSync(Storage& below, CrashDisk&) : ForwardingStorage(below) {}
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    auto file = below_.Create(path);
    if (!file) return Fail(file);
    return std::make_unique<File>(*this, std::move(*file));
  }
  Status Rename(const std::string& from, const std::string& to) override {
    RETURN_IF_ERROR(below_.Rename(from, to));
    if (closed_ == nullptr) return {};
    RETURN_IF_ERROR(closed_->Sync());
    return std::exchange(closed_, nullptr)->Close();
  }

 private:
  class File final : public ForwardingFile {
   public:
    File(RenamedBeforeSync& storage, std::unique_ptr<AppendFile> below)
        : ForwardingFile(std::move(below)), storage_(storage) {}
    Status Append(std::span<const std::byte> bytes) override {
      RETURN_IF_ERROR(SyncNow());
      return below_->Append(bytes);
    }
    Status Sync() override {
      wanted_ = true;
      return {};
    }
    Status Close() override {
      storage_.closed_ = std::move(below_);
      return {};
    }

   private:
    Status SyncNow() { return std::exchange(wanted_, false) ? below_->Sync() : Status(); }
    RenamedBeforeSync& storage_;
    bool wanted_ = false;
  };
  std::unique_ptr<AppendFile> closed_;
};

class RenameUnsynced final : public ForwardingStorage {
 public:
  RenameUnsynced(Storage& below, CrashDisk& disk) : ForwardingStorage(below), disk_(disk) {}
  Status Rename(const std::string& from, const std::string& to) override { return disk_.RenameOnly(from, to); }

 private:
  CrashDisk& disk_;
};

class NewNameUnsynced final : public ForwardingStorage {
 public:
  NewNameUnsynced(Storage& below, CrashDisk&) : ForwardingStorage(below) {}
  Status SyncFolder(const std::string&) override { return {}; }
};

/// Opens an existing file as if it were new.
class TruncatesOnCreate final : public ForwardingStorage {
 public:
  TruncatesOnCreate(Storage& below, CrashDisk& disk) : ForwardingStorage(below), disk_(disk) {}
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    if (disk_.Exists(path)) disk_.Unlink(path);
    return below_.Create(path);
  }

 private:
  CrashDisk& disk_;
};

}  // namespace

std::unique_ptr<Storage> BufferingStorage(Storage& below) { return std::make_unique<BufferedFiles>(below); }

std::vector<PlantedDefect> DefectiveDisks() {
  const Defect buffered = [](Storage& below, CrashDisk&) { return BufferingStorage(below); };
  return {
      {"a buffer of 64 KiB with early acknowledgement", {.below = buffered}},
      {"a sync that does nothing", {.below = Files<UnsyncedFile>()}},
      {"a sync's error is swallowed", {.below = Files<SyncErrorSwallowed>()}},
      {"a failed sync is tried again and believed", {.below = Files<SyncTriedAgain>()}},
      {"a short write is called a success", {.below = Files<ShortWriteCalledSuccess>()}},
      {"writes are reordered", {.below = Files<WritesReordered>()}},
      {"a write is done twice", {.below = Files<WriteDoneTwice>()}},
      {"a write begins 16 bytes too early", {.below = Files<WriteAtAWrongPlace>()}},
      {"a byte is spoiled on its way", {.below = Files<ByteSpoiled>()}},
      {"the file has its name before it is synced", {.below = Whole<RenamedBeforeSync>()}},
      {"the folder is not synced after the rename", {.below = Whole<RenameUnsynced>()}},
      {"the folder is not synced after the file was created", {.below = Whole<NewNameUnsynced>()}},
      {"an existing file is emptied when it is created again", {.below = Whole<TruncatesOnCreate>()}},
      {"the header is not synced before the first level", {.above = Files<HeaderUnsynced>()}},
      {"three of four syncs are left out", {.above = Files<SyncedTooRarely>()}},
  };
}

}  // namespace annulus::test
