/// write_recording FOLDER: writes a finished and an unfinished recording into FOLDER and prints as JSON where they are
/// and what they hold. Numbers are printed by printf, so that a reader can check the recording's own text.
#include <cstdio>
#include <string>

#include "acquisition/recording.h"
#include "tests/acquisition/scan_fixture.h"

namespace {

using namespace annulus;

void PrintNumbers(const char* key, const ScanLevel& level, double RangeReading::*member) {
  std::printf("\"%s\": [", key);
  for (std::size_t i = 0; i < level.readings.size(); ++i) {
    const double number = level.readings[i].*member;
    std::printf(i == 0 ? "" : ", ");
    std::isnan(number) ? std::printf("null") : std::printf("%.17g", number);
  }
  std::printf("], ");
}

void PrintLevel(const ScanLevel& level) {
  std::printf("{\"level\": %u, \"sweep\": %u, \"time_ns\": %lld, ", level.index, static_cast<unsigned>(level.sweep),
              static_cast<long long>(level.time.count()));
  PrintNumbers("range_mm", level, &RangeReading::range_mm);
  PrintNumbers("z_mm", level, &RangeReading::z_mm);
  std::printf("\"quality\": [");
  for (std::size_t i = 0; i < level.readings.size(); ++i) {
    std::printf(i == 0 ? "%u" : ", %u", static_cast<unsigned>(level.readings[i].quality));
  }
  std::printf("]}");
}

Status Write(const std::string& folder, const Scan& scan) {
  using std::chrono::nanoseconds;
  PosixStorage storage;
  const std::string path = folder + "/peer.mcap";
  auto writer = RecordingWriter::Create(storage, path, scan.header);
  if (!writer) return Fail(writer);
  RETURN_IF_ERROR(writer->AppendEvent(nanoseconds(5), "begin \"quoted\" \xE2\x80\xA6"));
  RETURN_IF_ERROR(writer->AppendAxis(nanoseconds(6), 0.1));
  SafetyLines lines;
  lines.time = nanoseconds(7);
  lines.input[1] = true;
  lines.output[2] = true;
  RETURN_IF_ERROR(writer->AppendSafety(lines));
  for (std::uint8_t channel = 0; channel < kRawChannels; ++channel) {
    const auto byte = static_cast<std::byte>(0xF0 + channel);
    RETURN_IF_ERROR(writer->AppendRaw({static_cast<RawChannel>(channel), nanoseconds(8 + channel), {byte, byte}}));
  }
  for (const ScanLevel& level : scan.levels) RETURN_IF_ERROR(writer->AppendLevel(level));
  RETURN_IF_ERROR(writer->Finish());
  auto unfinished = RecordingWriter::Create(storage, folder + "/torn.mcap", scan.header);
  if (!unfinished) return Fail(unfinished);
  for (const ScanLevel& level : scan.levels) RETURN_IF_ERROR(unfinished->AppendLevel(level));
  std::printf("{\"finished\": \"%s\", \"unfinished\": \"%s\", ", path.c_str(), unfinished->temporary_path().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_recording FOLDER\n");
    return 2;
  }
  const Scan scan = test::MakeScan(40, 16);
  if (const Status written = Write(argv[1], scan); !written) {
    std::fprintf(stderr, "%s\n", written.error().Text().c_str());
    return 1;
  }
  std::printf("\"scan_hash\": \"%s\", \"axis\": [{\"time_ns\": 6, \"z_mm\": 0.1}], ", ScanHash(scan).c_str());
  std::printf("\"events\": [{\"time_ns\": 5, \"text\": \"begin \\\"quoted\\\" \xE2\x80\xA6\"}], \"levels\": [");
  for (std::size_t i = 0; i < scan.levels.size(); ++i) {
    std::printf(i == 0 ? "" : ", ");
    PrintLevel(scan.levels[i]);
  }
  std::printf("]}\n");
  return 0;
}
