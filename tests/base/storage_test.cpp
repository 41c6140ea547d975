#include "base/storage.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>

namespace annulus {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

/// A folder of its own that vanishes with the test.
class PosixStorageTest : public testing::Test {
 protected:
  PosixStorageTest() {
    std::string name = (fs::temp_directory_path() / "annulus_storage_XXXXXX").string();
    folder_ = ::mkdtemp(name.data()) != nullptr ? name : std::string();
  }
  ~PosixStorageTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  void SetUp() override { ASSERT_FALSE(folder_.empty()); }

  [[nodiscard]] std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  void Write(const std::string& name, std::string_view text) {
    auto file = storage_.Create(Path(name));
    ASSERT_TRUE(file.has_value()) << file.error().Text();
    ASSERT_TRUE((*file)->Append(Bytes(text)).has_value());
    ASSERT_TRUE((*file)->Close().has_value());
  }
  [[nodiscard]] std::string Read(const std::string& name) {
    const auto text = ReadTextFile(storage_, Path(name));
    return text ? *text : "error: " + text.error().Text();
  }

  PosixStorage storage_;
  std::string folder_;
};

TEST_F(PosixStorageTest, WritesToWhatALinkStandsForAndKeepsTheLink) {
  Write("real", "old");
  fs::create_symlink("real", Path("link"));
  ASSERT_TRUE(WriteFileAtomically(storage_, Path("link"), std::string("new")).has_value());
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(Read("real"), "new");
}

TEST_F(PosixStorageTest, WritesIntoAPipeAndNeverReplacesOne) {
  ASSERT_EQ(::mkfifo(Path("pipe").c_str(), 0600), 0);
  EXPECT_FALSE(WriteFileAtomically(storage_, Path("pipe"), std::string("lost")).has_value()) << "nobody reads";
  const int reader = ::open(Path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  ASSERT_TRUE(WriteFileAtomically(storage_, Path("pipe"), std::string("told")).has_value());
  std::array<char, 16> got{};
  EXPECT_EQ(::read(reader, got.data(), got.size()), 4);
  ::close(reader);
  Write("file", "x");
  const Status replaced = storage_.Rename(Path("file"), Path("pipe"));
  ASSERT_FALSE(replaced.has_value());
  EXPECT_THAT(replaced.error().Text(), testing::HasSubstr("a device or a pipe"));
  EXPECT_TRUE(fs::is_fifo(Path("pipe")));
}

TEST_F(PosixStorageTest, SaysThatADeviceIsFull) {
  const Status status = WriteFileAtomically(storage_, "/dev/full", std::string("x"));
  ASSERT_FALSE(status.has_value());
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(PosixStorageTest, ReadsBackWhatWasAppendedInPieces) {
  auto file = storage_.Create(Path("a"));
  ASSERT_TRUE(file.has_value());
  EXPECT_TRUE((*file)->Append(Bytes("one ")).has_value());
  EXPECT_TRUE((*file)->Append({}).has_value());
  EXPECT_TRUE((*file)->Append(Bytes("two")).has_value());
  EXPECT_TRUE((*file)->Sync().has_value());
  EXPECT_TRUE((*file)->Close().has_value());
  EXPECT_EQ(Read("a"), "one two");
}

TEST_F(PosixStorageTest, KeepsEveryByteValueAndMoreThanOneBlock) {
  std::string text;
  for (int k = 0; k < 700'000; ++k) text += static_cast<char>(k * 31 % 256);
  Write("a", text);
  EXPECT_TRUE(Read("a") == text);
}

TEST_F(PosixStorageTest, DoesNotCreateOverAnExistingFile) {
  Write("a", "first");
  const auto again = storage_.Create(Path("a"));
  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().Text(), "create " + Path("a") + ": File exists: choose another name or remove it first");
  EXPECT_EQ(Read("a"), "first");
}

TEST_F(PosixStorageTest, ReservesWithoutChangingTheSize) {
  auto file = storage_.Create(Path("a"));
  ASSERT_TRUE(file.has_value());
  EXPECT_TRUE((*file)->Append(Bytes("abc")).has_value());
  EXPECT_TRUE((*file)->Reserve(1'000'000).has_value());
  EXPECT_EQ(fs::file_size(Path("a")), 3U);
  EXPECT_TRUE((*file)->Append(Bytes("def")).has_value());
  EXPECT_TRUE((*file)->Close().has_value());
  EXPECT_EQ(Read("a"), "abcdef");
}

TEST_F(PosixStorageTest, SaysThatAFileOrItsFolderDoesNotExist) {
  const auto missing = storage_.ReadAll(Path("nowhere"), 10);
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().Text(), "read " + Path("nowhere") + ": No such file or directory: check the path");
  const auto created = storage_.Create(Path("no/such/folder"));
  ASSERT_FALSE(created.has_value());
  EXPECT_EQ(created.error().seen, "No such file or directory");
}

TEST_F(PosixStorageTest, SaysThatAFolderIsNoFile) {
  const auto read = storage_.ReadAll(folder_, 10);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().seen, "Is a directory");
  EXPECT_EQ(read.error().advice, "give the path of a file");
}

TEST_F(PosixStorageTest, SaysThatAFileIsNoFolder) {
  Write("a", "x");
  EXPECT_EQ(storage_.ReadAll(Path("a/b"), 10).error().seen, "Not a directory");
  EXPECT_FALSE(storage_.CreateFolder(Path("a/b")).has_value());
}

TEST_F(PosixStorageTest, ReadsUpToTheLimitAndNotOneByteMore) {
  Write("a", "12345");
  EXPECT_TRUE(storage_.ReadAll(Path("a"), 5).has_value());
  const auto larger = storage_.ReadAll(Path("a"), 4);
  ASSERT_FALSE(larger.has_value());
  EXPECT_THAT(larger.error().seen, testing::HasSubstr("larger than 4 bytes"));
}

TEST_F(PosixStorageTest, StopsAtTheLimitOnADeviceThatNeverEnds) {
  EXPECT_FALSE(storage_.ReadAll("/dev/zero", 1'000'000).has_value());
}

TEST_F(PosixStorageTest, ReadsAnEmptyFile) {
  Write("a", "");
  EXPECT_EQ(storage_.ReadAll(Path("a"), 10)->size(), 0U);
}

TEST_F(PosixStorageTest, RenamesOverAnExistingFile) {
  Write("new", "new");
  Write("old", "old");
  ASSERT_TRUE(storage_.Rename(Path("new"), Path("old")).has_value());
  EXPECT_EQ(Read("old"), "new");
  EXPECT_FALSE(storage_.Exists(Path("new")));
}

TEST_F(PosixStorageTest, CannotRenameWhatIsNotThere) {
  const auto status = storage_.Rename(Path("no"), Path("yes"));
  ASSERT_FALSE(status.has_value());
  EXPECT_THAT(status.error().attempted, testing::HasSubstr(Path("no")));
  EXPECT_FALSE(storage_.Exists(Path("yes")));
}

TEST_F(PosixStorageTest, RemovesAFileOnce) {
  Write("a", "x");
  EXPECT_TRUE(storage_.Exists(Path("a")));
  EXPECT_TRUE(storage_.Remove(Path("a")).has_value());
  EXPECT_FALSE(storage_.Exists(Path("a")));
  EXPECT_FALSE(storage_.Remove(Path("a")).has_value());
}

TEST_F(PosixStorageTest, CreatesAFolderWithItsParentsAndAcceptsOneThatExists) {
  EXPECT_TRUE(storage_.CreateFolder(Path("x/y/z")).has_value());
  EXPECT_TRUE(storage_.CreateFolder(Path("x/y/z")).has_value());
  EXPECT_TRUE(fs::is_directory(Path("x/y/z")));
}

TEST_F(PosixStorageTest, WritesAtomicallyAndLeavesNoTemporaryFile) {
  ASSERT_TRUE(WriteFileAtomically(storage_, Path("a"), std::string("first")).has_value());
  ASSERT_TRUE(WriteFileAtomically(storage_, Path("a"), std::string("second")).has_value());
  EXPECT_EQ(Read("a"), "second");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(PosixStorageTest, WritesAtomicallyInTheWorkingFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  const Status status = WriteFileAtomically(storage_, "plain", std::string("x"));
  fs::current_path(before);
  ASSERT_TRUE(status.has_value()) << status.error().Text();
  EXPECT_EQ(Read("plain"), "x");
}

TEST_F(PosixStorageTest, DoesNotReplaceAFolderByAFile) {
  ASSERT_TRUE(storage_.CreateFolder(Path("d")).has_value());
  const Status status = WriteFileAtomically(storage_, Path("d"), std::string("x"));
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().attempted, "write " + Path("d"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace annulus
