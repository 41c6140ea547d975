#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/storage.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::StorageFault;
using test::TestStorage;

std::vector<std::byte> Bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

/// Storage calls that one undisturbed write takes.
std::uint64_t CallsOfOneWrite() {
  TestStorage storage;
  EXPECT_TRUE(WriteFileAtomically(storage, "out", std::string("text")).has_value());
  return storage.calls();
}

class WriteFileAtomicallyFaults : public testing::TestWithParam<StorageFault> {};

TEST_P(WriteFileAtomicallyFaults, LeaveNothingWhicheverCallFails) {
  const std::uint64_t calls = CallsOfOneWrite();
  ASSERT_GE(calls, 4U);  // create, write, sync, rename at least
  for (std::uint64_t n = 1; n <= calls; ++n) {
    TestStorage storage;
    storage.FailCall(n, GetParam());
    const Status status = WriteFileAtomically(storage, "out", std::string("text"));
    ASSERT_TRUE(storage.fault_hit());
    ASSERT_FALSE(status.has_value()) << "call " << n;
    EXPECT_EQ(status.error().attempted, "write out");
    EXPECT_TRUE(storage.files.empty()) << "call " << n << " left " << storage.files.begin()->first;
  }
}

TEST_P(WriteFileAtomicallyFaults, KeepAnExistingFileAsItWas) {
  const std::uint64_t calls = CallsOfOneWrite();
  for (std::uint64_t n = 1; n <= calls; ++n) {
    TestStorage storage;
    storage.files["out"] = Bytes("old");
    storage.FailCall(n, GetParam());
    ASSERT_FALSE(WriteFileAtomically(storage, "out", std::string("text")).has_value());
    EXPECT_EQ(storage.files.size(), 1U) << "call " << n;
    EXPECT_EQ(storage.files["out"], Bytes("old")) << "call " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFault, WriteFileAtomicallyFaults,
                         testing::Values(StorageFault::kIoError, StorageFault::kShortWrite));

TEST(WriteFileAtomically, ReplacesAnExistingFile) {
  TestStorage storage;
  storage.files["out"] = Bytes("old and longer");
  ASSERT_TRUE(WriteFileAtomically(storage, "out", std::string("new")).has_value());
  EXPECT_EQ(storage.files.size(), 1U);
  EXPECT_EQ(storage.files["out"], Bytes("new"));
}

TEST(WriteFileAtomically, SaysThatTheDiskIsFullAndLeavesNothing) {
  TestStorage storage;
  storage.quota_bytes = 3;
  const Status status = WriteFileAtomically(storage, "out", std::string("text"));
  ASSERT_FALSE(status.has_value());
  EXPECT_THAT(status.error().Text(), testing::HasSubstr("No space left"));
  EXPECT_TRUE(storage.files.empty());
}

TEST(TemporaryName, LiesInTheSameFolder) { EXPECT_THAT(TemporaryName("a/b.json"), testing::StartsWith("a/b.json.")); }

}  // namespace
}  // namespace annulus
