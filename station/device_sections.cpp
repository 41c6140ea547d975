#include "station/device_sections.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using toml_table::ReadTable;
using toml_table::Refuse;
using toml_table::Setters;
using toml_table::Text;
using toml_table::Texts;
using toml_table::ToFlag;
using toml_table::ToNumber;
using toml_table::ToText;
using toml_table::ToWhole;
using toml_table::WholeIn;

std::vector<std::string> Interfaces(const toml::node& node, const std::string& key) {
  constexpr std::size_t kLongest = 15;  // IFNAMSIZ less the final zero
  std::vector<std::string> names = Texts(node, key);
  if (names.empty()) Refuse(node, key, "a list of at least one interface");
  for (const std::string& name : names) {
    if (name.empty() || name.size() > kLongest) Refuse(node, key, "a list of names of 1 to 15 characters");
    if (std::count(names.begin(), names.end(), name) > 1) Refuse(node, key, "a list without repetition");
  }
  return names;
}

void ReadBoards(const toml::node& node, const std::string& key, RingConfig& ring) {
  const toml::table* boards = node.as_table();
  if (boards == nullptr) Refuse(node, key, "a table of board serial = first sensor");
  for (const auto& [serial_key, value] : *boards) {
    const std::string serial(serial_key.str());
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(serial.data(), serial.data() + serial.size(), number);
    if (error != std::errc() || end != serial.data() + serial.size())
      Refuse(value, fmt::format("{}.{}", key, serial), "named by a board's serial number");
    ring.boards[number] = static_cast<std::uint16_t>(WholeIn(value, fmt::format("{}.{}", key, serial), 0, 65'535));
  }
}

ReferenceSensor ReadReferenceSensor(const toml::node& node, const std::string& key) {
  ReferenceSensor sensor;
  double theta_deg = 0.0;
  double aim_deg = 0.0;
  ReadTable(node, key,
            {{"channel",
              [&](const toml::node& n, const std::string& name) {
                sensor.channel = static_cast<std::uint8_t>(WholeIn(n, name, 0, kSensorsPerBoard - 1));
              }},
             {"theta_deg", ToNumber(theta_deg, -360.0, 360.0)},
             {"distance_mm", ToNumber(sensor.distance_mm, 100.0, 5000.0)},
             {"height_mm", ToNumber(sensor.height_mm, 0.0, 3000.0)},
             {"aim_deg", ToNumber(aim_deg, -45.0, 45.0)}});
  if (sensor.distance_mm == 0.0 || sensor.height_mm == 0.0) {
    Refuse(node, key, "{ channel, theta_deg, distance_mm, height_mm, aim_deg } with at least distance and height");
  }
  sensor.theta = RadiansFromDegrees(theta_deg);
  sensor.aim = RadiansFromDegrees(aim_deg);
  return sensor;
}

void ReadReference(const toml::node& node, const std::string& key, RingConfig& ring) {
  ReferenceConfig reference;
  ReadTable(node, key,
            {{"board",
              [&](const toml::node& n, const std::string& name) {
                reference.board = static_cast<std::uint32_t>(WholeIn(n, name, 1, 0xFFFF'FFFF));
              }},
             {"sensors", [&](const toml::node& n, const std::string& name) {
                const toml::array* list = n.as_array();
                if (list == nullptr || list->empty()) Refuse(n, name, "a list of at least one sensor");
                for (const toml::node& one : *list) {
                  const ReferenceSensor sensor = ReadReferenceSensor(one, name);
                  for (const ReferenceSensor& other : reference.sensors) {
                    if (other.channel == sensor.channel) Refuse(one, name, "a list of different channels");
                  }
                  reference.sensors.push_back(sensor);
                }
              }}});
  if (reference.board == 0 || reference.sensors.empty()) Refuse(node, key, "{ board = …, sensors = [ … ] }");
  ring.reference = std::move(reference);
}

/// A reference board is not one of the ring's, and its sensors stand outside the ring.
void CheckReference(const toml::node& node, const RingConfig& ring) {
  if (!ring.reference) return;
  if (ring.boards.count(ring.reference->board) != 0) Refuse(node, "ring.reference.board", "not one of [ring] boards");
  for (const ReferenceSensor& sensor : ring.reference->sensors) {
    if (sensor.distance_mm > ring.radius_mm) continue;
    Refuse(node, "ring.reference.sensors", fmt::format("distance_mm beyond the ring's {} mm", ring.radius_mm));
  }
}

}  // namespace

void ReadRingSection(const toml::node& node, RingConfig& ring) {
  ReadTable(node, "ring",
            {{"bus",
              [&](const toml::node& n, const std::string& key) {
                const std::string bus = Text(n, key);
                if (bus == "sim")
                  ring.bus = RingBus::kSimulated;
                else if (bus == "usb")
                  ring.bus = RingBus::kUsb;
                else if (bus == "can")
                  ring.bus = RingBus::kCan;
                else
                  Refuse(n, key, "\"sim\", \"usb\" or \"can\"");
              }},
             {"can", [&](const toml::node& n, const std::string& key) { ring.can_interfaces = Interfaces(n, key); }},
             {"radius_mm", ToNumber(ring.radius_mm, 50.0, 5000.0)},
             {"boards", [&](const toml::node& n, const std::string& key) { ReadBoards(n, key, ring); }},
             {"reference", [&](const toml::node& n, const std::string& key) { ReadReference(n, key, ring); }}});
  CheckReference(node, ring);
}

namespace {

/// The keys of [axis] before the link's kind is known.
struct AxisKeys {
  std::string link = "sim";
  int unit = 1;
  ModbusRtuOptions serial;
  char parity = 'E';
  const toml::node* link_at = nullptr;
};

char ParityOf(const toml::node& node, const std::string& key) {
  const std::string parity = Text(node, key);
  if (parity == "none") return 'N';
  if (parity == "odd") return 'O';
  if (parity == "even") return 'E';
  Refuse(node, key, "\"none\", \"odd\" or \"even\"");
}

int BaudOf(const toml::node& node, const std::string& key) {
  constexpr std::array<int, 11> kRates{1200,   2400,    4800,    9600,    19'200, 38'400,
                                       57'600, 115'200, 230'400, 460'800, 921'600};
  const auto rate = static_cast<int>(WholeIn(node, key, kRates.front(), kRates.back()));
  if (std::find(kRates.begin(), kRates.end(), rate) == kRates.end()) {
    Refuse(node, key,
           "a rate of serial lines (1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600)");
  }
  return rate;
}

/// "tcp:ADDRESS:PORT"; an IPv6 address has colons of its own, so the port is what follows the last one.
ModbusTcpOptions TcpLink(const toml::node& node, const std::string& link) {
  const std::string expected = "\"sim\", a serial port's path, or \"tcp:ADDRESS:PORT\"";
  const std::size_t colon = link.rfind(':');
  ModbusTcpOptions tcp;
  if (colon <= 4) Refuse(node, "axis.link", expected);
  tcp.host = link.substr(4, colon - 4);
  const auto [end, error] = std::from_chars(link.data() + colon + 1, link.data() + link.size(), tcp.port);
  if (error != std::errc() || end != link.data() + link.size() || tcp.port < 1 || tcp.port > 65'535) {
    Refuse(node, "axis.link", expected);
  }
  // How long a name server takes cannot be bounded.
  std::array<unsigned char, sizeof(in6_addr)> digits{};
  if (inet_pton(AF_INET, tcp.host.c_str(), digits.data()) != 1 &&
      inet_pton(AF_INET6, tcp.host.c_str(), digits.data()) != 1) {
    Refuse(node, "axis.link", "\"tcp:ADDRESS:PORT\" with an address in digits, as tcp:192.168.7.20:502 or tcp:::1:502");
  }
  return tcp;
}

WordOrder WordOrderOf(const toml::node& node, const std::string& key) {
  const std::string text = Text(node, key);
  if (text == "high_first") return WordOrder::kHighFirst;
  if (text == "low_first") return WordOrder::kLowFirst;
  Refuse(node, key, "\"high_first\" or \"low_first\"");
}

/// An address, or "none" for a value that the drive does not have.
std::uint16_t AddressOf(const toml::node& node, const std::string& key, const AxisRegisterField& field) {
  if (!field.required && node.is_string() && Text(node, key) == "none") return kNoRegister;
  return static_cast<std::uint16_t>(WholeIn(node, key, 0, kNoRegister - 1));
}

void ReadRegisterMap(const toml::node& node, const std::string& key, AxisRegisterMap& map) {
  Setters setters;
  for (const AxisRegisterField& field : AxisRegisterFields()) {
    setters.emplace_back(field.name, [&map, &field](const toml::node& n, const std::string& name) {
      map.*field.address = AddressOf(n, name, field);
    });
  }
  for (const AxisScaleField& field : AxisScaleFields()) {
    setters.emplace_back(field.name, ToNumber(map.*field.value, -1e9, 1e9));
  }
  setters.emplace_back("word_order",
                       [&map](const toml::node& n, const std::string& name) { map.word_order = WordOrderOf(n, name); });
  setters.emplace_back("counter_registers", [&map](const toml::node& n, const std::string& name) {
    map.counter_registers = static_cast<std::uint16_t>(WholeIn(n, name, 1, 2));
  });
  ReadTable(node, key, setters);
  if (const Status sound = CheckRegisterMap(map); !sound) {
    throw toml_table::BadConfig{toml_table::LineOf(node) + ": " + sound.error().seen, sound.error().advice};
  }
}

void SetLink(const AxisKeys& keys, AxisConfig& axis) {
  if (keys.link == "sim") return;
  const toml::node& node = *keys.link_at;
  if (keys.link.starts_with("tcp:")) {
    ModbusTcpOptions tcp = TcpLink(node, keys.link);
    tcp.unit = keys.unit;
    axis.link = tcp;
    return;
  }
  if (keys.unit < 1 || keys.unit > 247) Refuse(node, "axis.unit", "1 to 247, as a serial line needs");
  if (!keys.link.starts_with('/')) Refuse(node, "axis.link", "\"sim\", a serial port's path, or \"tcp:ADDRESS:PORT\"");
  ModbusRtuOptions serial = keys.serial;
  serial.device = keys.link;
  serial.unit = keys.unit;
  serial.parity = keys.parity;
  axis.link = serial;
}

GpioBias BiasOf(const toml::node& node, const std::string& key) {
  constexpr std::array<std::pair<const char*, GpioBias>, 4> kBiases{{{"as-is", GpioBias::kAsIs},
                                                                     {"pull-up", GpioBias::kPullUp},
                                                                     {"pull-down", GpioBias::kPullDown},
                                                                     {"disabled", GpioBias::kDisabled}}};
  const std::string text = Text(node, key);
  for (const auto& [name, bias] : kBiases) {
    if (text == name) return bias;
  }
  Refuse(node, key, "\"as-is\", \"pull-up\", \"pull-down\" or \"disabled\"");
}

/// A line: its name, or a table of name and properties.
void ReadLine(const toml::node& node, const std::string& key, GpioLineSpec& line) {
  if (node.is_string()) {
    line.name = Text(node, key);
    return;
  }
  ReadTable(node, key,
            {{"line", ToText(line.name)},
             {"active_low", ToFlag(line.active_low)},
             {"bias", [&](const toml::node& n, const std::string& name) { line.bias = BiasOf(n, name); }}});
}

}  // namespace

void ReadAxisSection(const toml::node& node, AxisConfig& axis) {
  AxisKeys keys;
  ReadTable(node, "axis",
            {{"link",
              [&](const toml::node& n, const std::string& key) {
                keys.link = Text(n, key);
                keys.link_at = &n;
              }},
             {"unit", ToWhole(keys.unit, 0, 255)},
             {"baud", [&](const toml::node& n, const std::string& key) { keys.serial.baud = BaudOf(n, key); }},
             {"parity", [&](const toml::node& n, const std::string& key) { keys.parity = ParityOf(n, key); }},
             {"stop_bits", ToWhole(keys.serial.stop_bits, 1, 2)},
             {"register_map",
              [&](const toml::node& n, const std::string& key) { ReadRegisterMap(n, key, axis.register_map); }}});
  SetLink(keys, axis);
}

void ReadInterlockSection(const toml::node& node, InterlockConfig& interlock) {
  Setters setters{{"chip", ToText(interlock.wiring.chip)}};
  for (auto& [input, line] : interlock.wiring.inputs) {
    setters.emplace_back(InterlockName(input),
                         [&line = line](const toml::node& n, const std::string& key) { ReadLine(n, key, line); });
  }
  for (auto& [output, line] : interlock.wiring.outputs) {
    setters.emplace_back(InterlockName(output),
                         [&line = line](const toml::node& n, const std::string& key) { ReadLine(n, key, line); });
  }
  ReadTable(node, "interlock", setters);
  interlock.simulated = interlock.wiring.chip == "sim";
}

}  // namespace annulus
