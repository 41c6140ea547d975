#include "acquisition/recording.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "acquisition/mcap_writer.h"
#include "acquisition/recording_channels.h"
#include "acquisition/scan_json.h"
#include "scan_fixture.h"
#include "tests/support/folders.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::MakeScan;
using test::SameLevel;
using test::SameScan;
using test::StorageFault;
using test::TestStorage;

constexpr char kPath[] = "scan.mcap";

std::vector<std::byte> BytesOf(const Scan& scan) {
  TestStorage storage;
  EXPECT_TRUE(WriteRecording(storage, kPath, scan));
  return storage.files[kPath];
}

/// True if the levels of `part` are some of those of `whole`, in their order.
bool IsSubsequence(const std::vector<ScanLevel>& part, const std::vector<ScanLevel>& whole) {
  std::size_t next = 0;
  for (const ScanLevel& level : part) {
    while (next < whole.size() && !SameLevel(whole[next], level)) ++next;
    if (next == whole.size()) return false;
    ++next;
  }
  return true;
}

TEST(Recording, GivesBackEveryBitOfAScan) {
  Scan scan = MakeScan(6, 9);
  auto& readings = scan.levels[1].readings;
  readings[0].range_mm = 5e-324;
  readings[1].range_mm = 1.7976931348623157e308;
  readings[2].range_mm = -0.0;
  readings[3].range_mm = 12345678901234567168.0;
  readings[4].range_mm = 0.1 + 0.2;
  readings[5].z_mm = -0.0;
  readings[6].z_mm = -1e-7;
  scan.levels[3].time = std::chrono::nanoseconds(std::numeric_limits<std::int64_t>::max());
  scan.levels[4].time = std::chrono::nanoseconds(-5);
  scan.levels[5].index = std::numeric_limits<std::uint32_t>::max();
  scan.levels[5].sweep = 65'535;
  TestStorage storage;
  ASSERT_TRUE(WriteRecording(storage, kPath, scan));
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(read->report.clean());
  EXPECT_TRUE(SameScan(read->scan, scan));
  EXPECT_EQ(ScanHash(read->scan), ScanHash(scan));
}

TEST(Recording, OfTheSameScanHasTheSameBytes) { EXPECT_EQ(BytesOf(MakeScan(5, 8)), BytesOf(MakeScan(5, 8))); }

TEST(Recording, KeepsAxisTrackAndEventsInTheirOrder) {
  TestStorage storage;
  const Scan scan = MakeScan(2, 3);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header);
  ASSERT_TRUE(writer);
  using std::chrono::nanoseconds;
  ASSERT_TRUE(writer->AppendEvent(nanoseconds(1), "sweep 0 begins: \"down\"\n"));
  ASSERT_TRUE(writer->AppendAxis(nanoseconds(2), 1800.25));
  ASSERT_TRUE(writer->AppendLevel(scan.levels[0]));
  ASSERT_TRUE(writer->AppendAxis(nanoseconds(3), 0.1));
  ASSERT_TRUE(writer->AppendLevel(scan.levels[1]));
  ASSERT_TRUE(writer->AppendEvent(nanoseconds(4), "done"));
  ASSERT_TRUE(writer->Finish());
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->report.clean());
  EXPECT_EQ(read->axis, (std::vector<AxisPoint>{{nanoseconds(2), 1800.25}, {nanoseconds(3), 0.1}}));
  EXPECT_EQ(read->events,
            (std::vector<RecordedEvent>{{nanoseconds(1), "sweep 0 begins: \"down\"\n"}, {nanoseconds(4), "done"}}));
}

RawRecord Raw(RawChannel channel, std::int64_t time_ns, const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {channel, std::chrono::nanoseconds(time_ns), {bytes.begin(), bytes.end()}};
}

bool SameRaw(const std::vector<RawRecord>& a, const std::vector<RawRecord>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const RawRecord& x, const RawRecord& y) {
    return x.channel == y.channel && x.time == y.time && x.bytes == y.bytes;
  });
}

TEST(Recording, KeepsRawBytesInTheOrderInWhichTheyPassedTheBuses) {
  TestStorage storage;
  const Scan scan = MakeScan(2, 3);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header);
  ASSERT_TRUE(writer);
  const std::int64_t start = scan.levels[0].time.count();
  std::vector<RawRecord> raw{Raw(RawChannel::kUsb, start + 5, {"\0\x01\xff", 3}), Raw(RawChannel::kCall, start + 5, ""),
                             Raw(RawChannel::kModbus, start + 3, "told late"), Raw(RawChannel::kCan, start + 9, "c")};
  for (int i = 0; i < 500; ++i)
    raw.push_back(Raw(static_cast<RawChannel>(i % 4), start + 10 + i, std::string(1000, 'r')));
  for (std::size_t i = 0; i < raw.size(); ++i) {
    ASSERT_TRUE(writer->AppendRaw(raw[i]));
    if (i == 300) {
      ASSERT_TRUE(writer->AppendLevel(scan.levels[0]));
    }
  }
  ASSERT_TRUE(writer->Finish());
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->report.clean());
  EXPECT_TRUE(SameRaw(read->raw, raw));
  EXPECT_EQ(read->report.messages.at("/bus/usb"), 126U);
  EXPECT_EQ(read->report.messages.at("/points"), 1U);
}

TEST(Recording, KeepsTheLinesOfTheSafetyChain) {
  TestStorage storage;
  const Scan scan = MakeScan(1, 3);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header);
  ASSERT_TRUE(writer);
  std::vector<SafetyLines> lines;
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    SafetyLines changed;
    changed.time = std::chrono::nanoseconds(i);
    changed.input[i] = true;
    changed.output[i % kInterlockOutputs] = true;
    lines.push_back(changed);
    ASSERT_TRUE(writer->AppendSafety(changed));
  }
  ASSERT_TRUE(writer->AppendLevel(scan.levels[0]));
  ASSERT_TRUE(writer->Finish());
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->safety, lines);
}

TEST(Recording, WritesWhatCameBetweenTwoLevelsTogetherWithTheNextOne) {
  TestStorage storage;
  const Scan scan = MakeScan(3, 4);
  RecordingOptions options;
  options.sync_every_levels = 0;
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) {
    const std::uint64_t before = storage.calls();
    const std::int64_t time = level.time.count();
    ASSERT_TRUE(writer->AppendRaw(Raw(RawChannel::kUsb, time + 1, "bytes")));
    ASSERT_TRUE(writer->AppendAxis(level.time, 5.0));
    ASSERT_TRUE(writer->AppendEvent(level.time, "something"));
    EXPECT_EQ(storage.calls(), before);
    ASSERT_TRUE(writer->AppendLevel(level));
    EXPECT_EQ(storage.calls(), before + 1);
  }
}

TEST(Recording, WithoutLevelsIsWrittenOnceItSpansAHundredMillisecondsOr64KiB) {
  TestStorage storage;
  RecordingOptions options;
  options.sync_every_levels = 0;
  auto writer = RecordingWriter::Create(storage, kPath, MakeScan(1, 4).header, options);
  ASSERT_TRUE(writer);
  const std::uint64_t before = storage.calls();
  using std::chrono::milliseconds;
  ASSERT_TRUE(writer->AppendAxis(milliseconds(1'000), 1.0));
  ASSERT_TRUE(writer->AppendAxis(milliseconds(1'100), 2.0));
  EXPECT_EQ(storage.calls(), before);
  ASSERT_TRUE(writer->AppendAxis(milliseconds(1'101), 3.0));
  EXPECT_EQ(storage.calls(), before + 1);
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(writer->AppendRaw(Raw(RawChannel::kCan, 1'101'000'000, std::string(30'000, 'x'))));
  EXPECT_EQ(storage.calls(), before + 1);
  ASSERT_TRUE(writer->AppendRaw(Raw(RawChannel::kCan, 1'101'000'000, "y")));
  EXPECT_EQ(storage.calls(), before + 2);
  const auto settled = writer->Settle();
  ASSERT_TRUE(settled);
  EXPECT_TRUE(*settled);
  EXPECT_EQ(storage.calls(), before + 4);  // the rest, and a sync
}

TEST(Recording, InAThreadHoldsTheSameBytes) {
  const Scan scan = MakeScan(40, 8);
  const auto bytes_of = [&](DiskWriterMode mode) {
    TestStorage storage;
    RecordingOptions options;
    options.disk = mode;
    auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
    EXPECT_TRUE(writer);
    for (const ScanLevel& level : scan.levels) {
      EXPECT_TRUE(writer->AppendRaw(Raw(RawChannel::kUsb, level.time.count() - 1, "raw")));
      EXPECT_TRUE(writer->AppendLevel(level));
    }
    EXPECT_TRUE(writer->Finish());
    EXPECT_EQ(writer->durable_levels(), 40U);
    return storage.files[kPath];
  };
  EXPECT_EQ(bytes_of(DiskWriterMode::kInline), bytes_of(DiskWriterMode::kThread));
}

TEST(Recording, HasItsNameOnlyWhenItIsFinished) {
  TestStorage storage;
  const Scan scan = MakeScan(3, 4);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
  const std::string temporary = writer->temporary_path();
  EXPECT_FALSE(storage.Exists(kPath));
  const auto unfinished = ReadWholeRecording(storage, temporary);
  ASSERT_TRUE(unfinished) << unfinished.error().Text();
  EXPECT_TRUE(SameScan(unfinished->scan, scan));
  EXPECT_FALSE(unfinished->report.finished);
  EXPECT_FALSE(unfinished->report.clean());
  ASSERT_TRUE(writer->Finish());
  EXPECT_TRUE(storage.Exists(kPath));
  EXPECT_FALSE(storage.Exists(temporary));
}

TEST(Recording, IsLeftReadableWhenItsWriterGoesAway) {
  TestStorage storage;
  const Scan scan = MakeScan(2, 4);
  std::string temporary;
  {
    auto writer = RecordingWriter::Create(storage, kPath, scan.header);
    ASSERT_TRUE(writer);
    temporary = writer->temporary_path();
    ASSERT_TRUE(writer->AppendLevel(scan.levels[0]));
  }
  const auto read = ReadRecording(storage, temporary);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->levels.size(), 1U);
}

TEST(Recording, TakesOneWritePerLevel) {
  TestStorage storage;
  const Scan scan = MakeScan(3, 4);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, {.reserve_bytes = 0, .sync_every_levels = 0});
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) {
    const std::uint64_t before = storage.calls();
    ASSERT_TRUE(writer->AppendLevel(level));
    EXPECT_EQ(storage.calls(), before + 1);
  }
}

TEST(Recording, CutAtAnyByteGivesThePrefixThatIsWhole) {
  const Scan scan = MakeScan(8, 5);
  TestStorage storage;
  auto writer = RecordingWriter::Create(storage, kPath, scan.header);
  ASSERT_TRUE(writer);
  std::vector<std::size_t> ends;  // of the file after each level, as the storage saw it
  for (const ScanLevel& level : scan.levels) {
    ASSERT_TRUE(writer->AppendLevel(level));
    ends.push_back(storage.files[writer->temporary_path()].size());
  }
  ASSERT_TRUE(writer->Finish());
  const std::vector<std::byte> whole = storage.files[kPath];
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    const auto read = ParseRecording(std::span(whole).first(cut), "cut");
    const auto whole_writes =
        static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](std::size_t end) { return end <= cut; }));
    const std::size_t levels = read ? read->scan.levels.size() : 0;
    // The Message Index after a chunk is no part of the level: the level may be there one cut earlier.
    ASSERT_GE(levels, whole_writes) << "cut at " << cut;
    ASSERT_LE(levels, whole_writes + 1) << "cut at " << cut;
    if (!read) continue;
    for (std::size_t i = 0; i < levels; ++i) ASSERT_TRUE(SameLevel(read->scan.levels[i], scan.levels[i]));
    ASSERT_FALSE(read->report.clean()) << "cut at " << cut;
  }
}

TEST(Recording, WithAnyOneBitFlippedLosesAtMostOneLevelAndSaysSo) {
  const Scan scan = MakeScan(5, 4);
  std::vector<std::byte> bytes = BytesOf(scan);
  std::size_t refused = 0;
  std::size_t with_loss = 0;
  // 11 has no factor in common with 8: all eight places of a byte are met.
  const std::size_t step = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 11;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += step) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    bytes[bit / 8] ^= mask;
    const auto read = ParseRecording(bytes, "flipped");
    bytes[bit / 8] ^= mask;
    if (!read) {
      ++refused;
      ASSERT_EQ(bit / 8, 5U) << read.error().Text();  // the byte that says the version of MCAP
      continue;
    }
    ASSERT_FALSE(read->report.clean()) << "bit " << bit;
    ASSERT_TRUE(IsSubsequence(read->scan.levels, scan.levels)) << "bit " << bit;
    ASSERT_GE(read->scan.levels.size() + 1, scan.levels.size()) << "bit " << bit;
    ASSERT_EQ(read->scan.levels.size() + read->report.levels_lost, scan.levels.size()) << "bit " << bit;
    ASSERT_TRUE(test::SameHeader(read->scan.header, scan.header)) << "bit " << bit;
    if (read->report.levels_lost > 0) ++with_loss;
  }
  EXPECT_EQ(refused, step == 1 ? 8U : 1U);  // of bits 40 … 47
  EXPECT_GT(with_loss, 0U);
}

TEST(Recording, SurvivesAHoleOfZerosInTheMiddle) {
  const Scan scan = MakeScan(20, 5);
  std::vector<std::byte> bytes = BytesOf(scan);
  const std::size_t middle = bytes.size() / 2;
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(middle), 512, std::byte{0});
  const auto read = ParseRecording(bytes, "hole");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(IsSubsequence(read->scan.levels, scan.levels));
  EXPECT_GE(read->scan.levels.size(), 15U);
  EXPECT_EQ(read->scan.levels.size() + read->report.levels_lost, 20U);
}

TEST(WriteRecording, LeavesNothingBehindWhicheverCallFails) {
  const Scan scan = MakeScan(4, 3);
  for (const StorageFault fault : {StorageFault::kIoError, StorageFault::kShortWrite}) {
    for (std::uint64_t n = 1;; ++n) {
      TestStorage storage;
      storage.files[kPath] = {std::byte{'o'}, std::byte{'l'}, std::byte{'d'}};
      storage.FailCall(n, fault);
      const Status status = WriteRecording(storage, kPath, scan);
      if (!storage.fault_hit()) {
        EXPECT_TRUE(status);
        EXPECT_GT(n, 8U);  // create, header, sync, 4 levels, end, …
        break;
      }
      ASSERT_FALSE(status) << "call " << n;
      ASSERT_EQ(storage.files.size(), 1U) << "call " << n;
      ASSERT_EQ(storage.files[kPath].size(), 3U) << "call " << n;
    }
  }
}

TEST(WriteRecording, OnAFullDiskLeavesNothingAndNamesTheFile) {
  TestStorage storage;
  storage.quota_bytes = 4000;
  const Status status = WriteRecording(storage, kPath, MakeScan(50, 20));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().Text(),
            "write scan.mcap: No space left on device: free space on this disk or choose another");
  EXPECT_TRUE(storage.files.empty());
}

TEST(RecordingWriter, KeepsEveryAcknowledgedLevelWhicheverCallFails) {
  const Scan scan = MakeScan(10, 3);
  for (const StorageFault fault : {StorageFault::kIoError, StorageFault::kShortWrite}) {
    for (std::uint64_t n = 1;; ++n) {
      TestStorage storage;
      storage.FailCall(n, fault);
      auto writer =
          RecordingWriter::Create(storage, kPath, scan.header, {.reserve_bytes = 100, .sync_every_levels = 2});
      if (!writer) {
        ASSERT_TRUE(storage.files.empty()) << "call " << n;
        continue;
      }
      std::size_t acknowledged = 0;
      Status status;
      while (status && acknowledged < scan.levels.size()) {
        status = writer->AppendLevel(scan.levels[acknowledged]);
        if (status) ++acknowledged;
      }
      if (status) status = writer->Finish();
      if (!storage.fault_hit()) {
        EXPECT_TRUE(status);
        break;
      }
      ASSERT_FALSE(status) << "call " << n;
      ASSERT_FALSE(storage.Exists(kPath));
      const auto read = ReadWholeRecording(storage, writer->temporary_path());
      if (acknowledged == 0 && !read) continue;
      ASSERT_TRUE(read) << "call " << n << ": " << read.error().Text();
      ASSERT_GE(read->scan.levels.size(), acknowledged) << "call " << n;
      ASSERT_TRUE(IsSubsequence(read->scan.levels, scan.levels));
    }
  }
}

TEST(RecordingWriter, RepeatsItsFirstFailure) {
  TestStorage storage;
  const Scan scan = MakeScan(3, 3);
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, {.reserve_bytes = 0, .sync_every_levels = 1});
  ASSERT_TRUE(writer);
  storage.FailCall(2, StorageFault::kIoError);  // the sync after the first level
  EXPECT_FALSE(writer->AppendLevel(scan.levels[0]));
  const Status second = writer->AppendLevel(scan.levels[1]);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().seen, "Input/output error");
  EXPECT_FALSE(writer->Finish());
}

TEST(RecordingWriter, RefusesAHeaderThatCannotBe) {
  TestStorage storage;
  ScanHeader header = MakeScan(1, 3).header;
  header.calibration.sensors[2].aim_lateral = std::numeric_limits<double>::quiet_NaN();
  const auto writer = RecordingWriter::Create(storage, kPath, header);
  ASSERT_FALSE(writer);
  EXPECT_NE(writer.error().Text().find("aim_lateral_rad"), std::string::npos);
  EXPECT_TRUE(storage.files.empty());
}

TEST(ReadRecording, KnowsTheRingsTemperatureIfItWasKnown) {
  for (const std::optional<double> temperature_c : {std::optional<double>(23.456), std::optional<double>()}) {
    TestStorage storage;
    Scan scan = MakeScan(1, 3);
    scan.header.machine.ring_temperature_c = temperature_c;
    ASSERT_TRUE(WriteRecording(storage, kPath, scan));
    const auto read = ReadRecording(storage, kPath);
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(read->header.machine.ring_temperature_c, temperature_c);
  }
}

TEST(ReadRecording, SaysWhatAForeignFileBeginsWith) {
  TestStorage storage;
  const std::string zip = "PK\x03\x04 and so on";
  const auto bytes = std::as_bytes(std::span(zip));
  storage.files["x.zip"] = {bytes.begin(), bytes.end()};
  const auto read = ReadRecording(storage, "x.zip");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().Text(),
            "read x.zip: its first bytes are 50 4b 03 04 20 61 6e 64, not those of an MCAP file: "
            "give a recording that this program wrote");
}

// tests/golden/recording_0001.mcap: `annulus import` of three levels and two sensors by the program before channels of
// raw bytes; range_mm 400 + 10 level + sensor, z_mm 1500 - 5 level.
TEST(ReadRecording, ReadsRecordingsOfTheFirstVersion) {
  PosixStorage storage;
  const auto read = ReadWholeRecording(storage, test::SourceFolder() + "/tests/golden/recording_0001.mcap");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(read->report.clean());
  ASSERT_EQ(read->scan.levels.size(), 3U);
  for (std::size_t level = 0; level < 3; ++level) {
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
      const RangeReading& reading = read->scan.levels[level].readings.at(sensor);
      EXPECT_EQ(reading.range_mm, 400.0 + 10.0 * static_cast<double>(level) + static_cast<double>(sensor));
      EXPECT_EQ(reading.z_mm, 1500.0 - 5.0 * static_cast<double>(level));
    }
  }
  EXPECT_EQ(read->scan.header.machine, RecordedMachine{});
}

TEST(ReadRecording, R2_RefusesAFileOfANewerVersionAndSkipsKeysItDoesNotKnow) {
  TestStorage storage;
  const Scan scan = MakeScan(1, 3);
  const auto with_header = [&](const std::string& json) {
    auto file = storage.Create("f");
    McapWriter writer(std::move(*file), McapCompression::kZstd);
    EXPECT_TRUE(writer.WritePreamble(RecordingPreamble(json, "9.0")));
    const std::string level = JsonFromLevel(scan.levels[0]);
    const McapMessage message{1, 0, 0, 0, level};
    EXPECT_TRUE(writer.WriteChunk(std::span(&message, 1)));
    EXPECT_TRUE(writer.Finish());
    const std::vector<std::byte> bytes = storage.files["f"];
    storage.files.clear();
    return bytes;
  };
  std::string json = JsonFromHeader(scan.header);
  const auto known = ParseRecording(with_header("{\"later\":[1,2]," + json.substr(1)), "newer");
  ASSERT_TRUE(known) << known.error().Text();
  EXPECT_TRUE(test::SameHeader(known->scan.header, scan.header));
  json.replace(json.find("\"format_version\":1"), 18, "\"format_version\":2");
  const auto refused = ParseRecording(with_header(json), "newer");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().Text(),
            "read newer: the header of the recording is unusable: its format version is 2, this program knows 1: "
            "take another copy of the file, or a newer version of the program");
}

TEST(ReadRecording, RefusesAnEmptyFile) {
  const auto read = ParseRecording({}, "empty");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().seen, "it is empty");
}

TEST(ReadRecording, RefusesAScanWithoutALevel) {
  Scan scan = MakeScan(1, 3);
  scan.levels.clear();
  const auto read = ParseRecording(BytesOf(scan), "no level");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().seen, "it holds no readable level");
}

TEST(ScanHash, TellsScansApartAndForgetsWhoWasScanned) {
  Scan scan = MakeScan(3, 4);
  const std::string hash = ScanHash(scan);
  EXPECT_EQ(hash.size(), std::string("sha256:").size() + 64);
  scan.header.subject_id = "another";
  scan.header.wall_start_ns = 0;
  EXPECT_EQ(ScanHash(scan), hash);
  scan.levels[2].readings[3].range_mm = std::nextafter(scan.levels[2].readings[3].range_mm, 0.0);
  EXPECT_NE(ScanHash(scan), hash);
}

TEST(Recording, GivesBackEveryBitOfAWholeCalibration) {
  Scan scan = MakeScan(2, 9);
  test::MakeWhole(scan.header.calibration);
  TestStorage storage;
  ASSERT_TRUE(WriteRecording(storage, kPath, scan));
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(test::SameCalibration(read->scan.header.calibration, scan.header.calibration));
  EXPECT_TRUE(SameScan(read->scan, scan));
  EXPECT_EQ(ScanHash(read->scan), ScanHash(scan));
}

TEST(Recording, OfAPlainCalibrationSaysNothingOfTheParts) {
  const std::string json = JsonFromHeader(MakeScan(1, 3).header);
  for (const char* key : {"range_quadratic_per_mm", "pose", "carriage", "temperature", "certificate", "uncertainty"}) {
    EXPECT_EQ(json.find('"' + std::string(key) + '"'), std::string::npos) << key;
  }
}

TEST(ReadRecording, RefusesACalibrationThatCannotBe) {
  const auto refused = [](const std::string& key, const auto& damage) {
    Scan scan = MakeScan(1, 3);
    test::MakeWhole(scan.header.calibration);
    damage(scan.header.calibration);
    const auto checked = CheckHeader(scan.header);
    ASSERT_FALSE(checked) << key;
    EXPECT_NE(checked.error().find(key), std::string::npos) << checked.error();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused("range_scale", [](RingCalibration& c) { c.sensors[1].range_scale = 0.0; });
  refused("range_quadratic_per_mm", [&](RingCalibration& c) { c.sensors[1].range_quadratic = nan; });
  refused("tilt_x_rad", [](RingCalibration& c) { c.pose.tilt_x = 4.0; });
  refused("x_mm", [&](RingCalibration& c) { c.pose.x_mm = nan; });
  refused("position_scale", [](RingCalibration& c) { c.carriage.position_scale = 0.0; });
  refused("knots_z_mm", [](RingCalibration& c) { c.carriage.knots_z_mm[1] = c.carriage.knots_z_mm[0]; });
  refused("knots_z_mm", [](RingCalibration& c) { c.carriage.x_mm.pop_back(); });
  refused("range_mm_per_c", [&](RingCalibration& c) { c.range_mm_per_c = nan; });
  refused("own_mm", [](RingCalibration& c) { c.uncertainty->own_mm[2] = -0.1; });
  refused("together_mm", [&](RingCalibration& c) { c.uncertainty->together_mm(2, 1) = nan; });
  refused("height_scale_sigma", [](RingCalibration& c) { c.uncertainty->height_scale_sigma = -1.0; });
}

/// A ring of two sensors, one level.
Scan TwoReadings() {
  Scan scan;
  scan.header.ring_radius_mm = 600.0;
  scan.header.calibration = RingCalibration::Ideal(600.0, 2);
  for (SensorCalibration& sensor : scan.header.calibration.sensors) sensor.range_offset_mm = 0.25;
  scan.levels = {{0, 0, std::chrono::nanoseconds(1000), {{450.0, 1000.0, 255}, {451.0, 1000.0, 255}}}};
  return scan;
}

TEST(ScanHash, OfAPlainCalibrationIsWhatItAlwaysWas) {
  // python3: b = pack('<Id', 2, 600); per sensor pack('<7d', pi*i, 600, 0.25, 1, 0, 0, 0); pack('<HIq', 0, 0, 1000);
  //          per reading pack('<ddB', 1000, 450 + i, 255); sha256(b).hexdigest()
  Scan scan = TwoReadings();
  const std::string hash = "sha256:05e81df77f3ce953e2e0503ed37524cceb85404024641532e2509f0df4a808d2";
  EXPECT_EQ(ScanHash(scan), hash);
  scan.header.calibration.ring_serial = "ring-1";
  scan.header.calibration.certificate = "sha256:1";
  scan.header.calibration.uncertainty.emplace();
  EXPECT_EQ(ScanHash(scan), hash) << "what is said of it changes no point";
}

TEST(ScanHash, ChangesWithPoseCarriageAndQuadraticTerm) {
  const std::string hash = ScanHash(TwoReadings());
  const auto changed = [&](const auto& change) {
    Scan scan = TwoReadings();
    change(scan.header.calibration);
    return ScanHash(scan);
  };
  EXPECT_NE(changed([](RingCalibration& c) { c.pose.tilt_y = 1e-9; }), hash);
  EXPECT_NE(changed([](RingCalibration& c) { c.carriage.slope_x = 1e-9; }), hash);
  EXPECT_NE(changed([](RingCalibration& c) { c.carriage.knots_z_mm = c.carriage.x_mm = c.carriage.y_mm = {1.0}; }),
            hash);
  EXPECT_NE(changed([](RingCalibration& c) { c.sensors[1].range_quadratic = 1e-9; }), hash);
  EXPECT_NE(changed([](RingCalibration& c) { c.pose.x_mm = 1.0; }),
            changed([](RingCalibration& c) { c.pose.y_mm = 1.0; }));
}

}  // namespace
}  // namespace annulus
