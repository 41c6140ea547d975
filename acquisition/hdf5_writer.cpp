#include "acquisition/hdf5_writer.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/calibrated_return.h"
#include "acquisition/scan_json.h"
#include "base/ensure.h"

namespace annulus {
namespace {

/// An HDF5 handle, closed when it goes. Everything here is written to memory: a failing call is a bug or no memory.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) { ENSURE(id >= 0, "HDF5 does what it is asked"); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { (void)close_(id_); }
  [[nodiscard]] hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void Check(herr_t status) { ENSURE(status >= 0, "HDF5 does what it is asked"); }

/// A text of fixed length, UTF-8.
Handle TextType(std::size_t length) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  ENSURE(type >= 0, "HDF5 has a type for text");
  Check(H5Tset_size(type, std::max<std::size_t>(length, 1)));
  Check(H5Tset_cset(type, H5T_CSET_UTF8));
  Check(H5Tset_strpad(type, H5T_STR_NULLPAD));
  return Handle(type, H5Tclose);
}

void PutAttribute(hid_t object, const char* name, const std::string& text) {
  const Handle type = TextType(text.size());
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!text.empty()) Check(H5Awrite(attribute.get(), type.get(), text.data()));
}

/// Rows and columns of a dataset; no columns: one dimension.
struct Shape {
  hsize_t rows = 0;
  hsize_t columns = 0;
};

/// One file in memory.
class Hdf5Image {
 public:
  Hdf5Image() : access_(H5Pcreate(H5P_FILE_ACCESS), H5Pclose), file_(Create(access_.get()), H5Fclose) {}

  [[nodiscard]] hid_t root() const { return file_.get(); }
  void Group(const char* name) const {
    const Handle group(H5Gcreate2(root(), name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  }
  /// `stored`: the type in the file, `in_memory`: that of `data`.
  void Put(const char* name, Shape shape, std::pair<hid_t, hid_t> stored_and_memory, const void* data,
           const char* units) const {
    const std::array<hsize_t, 2> size{shape.rows, shape.columns};
    const Handle space(H5Screate_simple(shape.columns == 0 ? 1 : 2, size.data(), nullptr), H5Sclose);
    const Handle options(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    Check(H5Pset_obj_track_times(options.get(), 0));  // the same bytes whenever it is written
    const Handle set(
        H5Dcreate2(root(), name, stored_and_memory.first, space.get(), H5P_DEFAULT, options.get(), H5P_DEFAULT),
        H5Dclose);
    if (shape.rows > 0) Check(H5Dwrite(set.get(), stored_and_memory.second, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    if (units != nullptr) PutAttribute(set.get(), "units", units);
  }
  void Put(const char* name, const std::vector<double>& numbers, const char* units, hsize_t columns = 0) const {
    Put(name, ShapeOf(numbers.size(), columns), {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE}, numbers.data(), units);
  }
  void Put(const char* name, const std::vector<std::int64_t>& numbers, const char* units) const {
    Put(name, ShapeOf(numbers.size(), 0), {H5T_STD_I64LE, H5T_NATIVE_INT64}, numbers.data(), units);
  }
  void Put(const char* name, const std::vector<std::uint8_t>& numbers, const char* units, hsize_t columns = 0) const {
    Put(name, ShapeOf(numbers.size(), columns), {H5T_STD_U8LE, H5T_NATIVE_UINT8}, numbers.data(), units);
  }
  /// Texts, padded with zeros to the longest.
  void Put(const char* name, const std::vector<std::string>& texts) const {
    std::size_t longest = 1;
    for (const std::string& text : texts) longest = std::max(longest, text.size());
    std::string padded;
    for (std::string text : texts) {
      text.resize(longest, '\0');
      padded += text;
    }
    const Handle type = TextType(longest);
    Put(name, {texts.size(), 0}, {type.get(), type.get()}, padded.data(), nullptr);
  }

  [[nodiscard]] std::vector<std::byte> Bytes() const {
    Check(H5Fflush(root(), H5F_SCOPE_GLOBAL));
    const ssize_t size = H5Fget_file_image(root(), nullptr, 0);
    ENSURE(size > 0, "HDF5 has an image of its file");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    ENSURE(H5Fget_file_image(root(), bytes.data(), bytes.size()) == size, "HDF5 gives the image of its file");
    return bytes;
  }

 private:
  static hid_t Create(hid_t access) {
    constexpr std::size_t kGrowth = std::size_t{1} << 20;
    Check(H5Pset_fapl_core(access, kGrowth, 0));  // 0: nothing goes to the disk
    return H5Fcreate("recording", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  }
  static Shape ShapeOf(std::size_t count, hsize_t columns) {
    return columns == 0 ? Shape{count, 0} : Shape{count / columns, columns};
  }

  Handle access_;
  Handle file_;
};

void PutLevels(const Hdf5Image& file, const Scan& scan) {
  std::vector<double> ranges;
  std::vector<double> heights;
  std::vector<double> points;
  std::vector<std::uint8_t> qualities;
  std::vector<std::int64_t> times;
  std::vector<std::int64_t> indices;
  std::vector<std::int64_t> sweeps;
  for (const ScanLevel& level : scan.levels) {
    times.push_back(level.time.count());
    indices.push_back(level.index);
    sweeps.push_back(level.sweep);
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      const RangeReading& reading = level.readings[sensor];
      ranges.push_back(reading.range_mm);
      heights.push_back(reading.z_mm);
      qualities.push_back(reading.quality);
      const auto seen = Calibrate(scan.header.calibration, sensor, reading);
      const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      const Eigen::Vector3d point = seen ? seen->point : none;
      points.insert(points.end(), {point.x(), point.y(), point.z()});
    }
  }
  const hsize_t sensors = scan.header.calibration.sensors.size();
  file.Group("ring");
  file.Put("ring/range_mm", ranges, "mm", sensors);
  file.Put("ring/z_mm", heights, "mm", sensors);
  file.Put("ring/quality", qualities, "1", sensors);
  file.Put("ring/point_mm", points, "mm", 3 * sensors);
  file.Put("ring/time_ns", times, "ns");
  file.Put("ring/level", indices, "1");
  file.Put("ring/sweep", sweeps, "1");
}

void PutTracks(const Hdf5Image& file, const Recording& recording) {
  std::vector<std::int64_t> times;
  std::vector<double> heights;
  for (const AxisPoint& point : recording.axis) {
    times.push_back(point.time.count());
    heights.push_back(point.z_mm);
  }
  file.Group("axis");
  file.Put("axis/time_ns", times, "ns");
  file.Put("axis/z_mm", heights, "mm");
  times.clear();
  std::vector<std::string> texts;
  for (const RecordedEvent& event : recording.events) {
    times.push_back(event.time.count());
    texts.push_back(event.text);
  }
  file.Group("events");
  file.Put("events/time_ns", times, "ns");
  file.Put("events/text", texts);
  times.clear();
  std::vector<std::uint8_t> inputs;
  std::vector<std::uint8_t> outputs;
  for (const SafetyLines& lines : recording.safety) {
    times.push_back(lines.time.count());
    inputs.insert(inputs.end(), lines.input.begin(), lines.input.end());
    outputs.insert(outputs.end(), lines.output.begin(), lines.output.end());
  }
  file.Group("safety");
  file.Put("safety/time_ns", times, "ns");
  file.Put("safety/input", inputs, "1", kInterlockInputs);
  file.Put("safety/output", outputs, "1", kInterlockOutputs);
}

/// Raw bytes end to end: record k is bytes[first_byte[k]] … up to the next one's.
void PutRaw(const Hdf5Image& file, const Recording& recording) {
  std::vector<std::int64_t> times;
  std::vector<std::int64_t> first_bytes;
  std::vector<std::uint8_t> channels;
  std::vector<std::uint8_t> bytes;
  for (const RawRecord& record : recording.raw) {
    times.push_back(record.time.count());
    first_bytes.push_back(static_cast<std::int64_t>(bytes.size()));
    channels.push_back(static_cast<std::uint8_t>(record.channel));
    for (const std::byte byte : record.bytes) bytes.push_back(std::to_integer<std::uint8_t>(byte));
  }
  file.Group("bus");
  file.Put("bus/time_ns", times, "ns");
  file.Put("bus/channel", channels, "0: usb, 1: can, 2: modbus, 3: calls");
  file.Put("bus/first_byte", first_bytes, "1");
  file.Put("bus/bytes", bytes, "1");
}

}  // namespace

Status WriteHdf5Recording(Storage& storage, const std::string& path, const Recording& recording) {
  const Hdf5Image file;
  PutAttribute(file.root(), "format", "annulus recording");
  PutAttribute(file.root(), "scan_hash", ScanHash(recording.scan));
  // Attributes hold at most 64 KiB; the header's calibration may be longer.
  file.Put("header_json", std::vector<std::string>{JsonFromHeader(recording.scan.header)});
  PutLevels(file, recording.scan);
  PutTracks(file, recording);
  PutRaw(file, recording);
  const std::vector<std::byte> bytes = file.Bytes();
  return WriteFileAtomically(storage, path, std::span<const std::byte>(bytes));
}

}  // namespace annulus
