#include "station/booth_messages.h"

#include <algorithm>
#include <array>
#include <utility>

#include "station/booth_json.h"

namespace annulus {
namespace {

constexpr int kMaxDepth = 16;
constexpr std::size_t kMaxBoards = 256;
constexpr std::size_t kMaxProfiles = 64;
constexpr std::size_t kMaxSensors = 65'536;
constexpr std::size_t kMaxPathBytes = 4096;
constexpr double kMinHeightMm = 300.0;
constexpr double kMaxHeightMm = 2500.0;
constexpr std::uint32_t kMaxEvery = 10'000;

template <class... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};

std::string Dump(const BoothJson& json) { return json.dump(-1, ' ', false, BoothJson::error_handler_t::replace); }

BoothJson Envelope(const char* type) { return {{"v", kBoothProtocol}, {"type", type}}; }

/// Brackets nested too deeply to be ours. What is no JSON is for the parser to say.
bool TooDeep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

/// The text as an object of our protocol; `wrong` says what it is otherwise.
BoothJson ParseObject(std::string_view text, std::string& wrong) {
  if (text.size() > kMaxBoothMessage) {
    wrong = "it has " + std::to_string(text.size()) + " bytes";
  } else if (TooDeep(text)) {
    wrong = "it is nested more than " + std::to_string(kMaxDepth) + " deep";
  }
  if (!wrong.empty()) return {};
  BoothJson json = BoothJson::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object()) wrong = "it is not a JSON object";
  return json;
}

void CheckVersion(FieldReader& fields) {
  const auto version = fields.Count("v");
  if (version != kBoothProtocol) {
    fields.Wrong("v", std::to_string(version) + ", not " + std::to_string(kBoothProtocol) + ", the protocol here");
  }
}

const char* RoleName(BoothRole role) { return role == BoothRole::kTechnician ? "technician" : "operator"; }

HelloOrder ReadHello(FieldReader& fields) {
  HelloOrder hello;
  const std::string role = fields.Text("role", 32);
  if (role == "technician") {
    hello.role = BoothRole::kTechnician;
  } else if (role != "operator") {
    fields.Wrong("role", "neither operator nor technician");
  }
  hello.control = fields.Flag("control");
  hello.client = fields.OptionalText("client", 64);
  return hello;
}

ArmOrder ReadArm(FieldReader& fields) {
  ArmOrder arm;
  arm.profile = fields.Text("profile", 64);
  if (fields.Has("height_mm")) arm.height = Millimetres(fields.Number("height_mm", kMinHeightMm, kMaxHeightMm));
  if (fields.Has("search")) arm.search = fields.Flag("search");
  arm.out = arm.search ? fields.OptionalText("out", kMaxPathBytes) : fields.Text("out", kMaxPathBytes);
  if (!arm.search && arm.out.empty()) fields.Wrong("out", "empty");
  arm.subject_id = fields.OptionalText("subject_id", 128);
  arm.consent = fields.OptionalText("consent", 256);
  return arm;
}

JogOrder ReadJog(FieldReader& fields) {
  const std::string direction = fields.Text("direction", 32);
  if (direction != "up" && direction != "down") fields.Wrong("direction", "neither up nor down");
  return {direction == "down" ? Scanner::JogDirection::kDown : Scanner::JogDirection::kUp};
}

SubscribeOrder ReadSubscribe(FieldReader& fields) {
  SubscribeOrder order;
  order.levels = static_cast<std::uint32_t>(fields.Count("levels", kMaxEvery));
  if (fields.Has("sensors")) order.sensors = static_cast<std::uint32_t>(fields.Count("sensors", kMaxEvery));
  if (order.sensors == 0) fields.Wrong("sensors", "0, not at least 1");
  return order;
}

BoothOrder ReadOrder(const std::string& type, FieldReader& fields) {
  if (type == "hello") return ReadHello(fields);
  if (type == "home") return HomeOrder{};
  if (type == "arm") return ReadArm(fields);
  if (type == "start") return StartOrder{fields.Count("version")};
  if (type == "cancel") return CancelOrder{};
  if (type == "acknowledge") return AcknowledgeOrder{};
  if (type == "jog") return ReadJog(fields);
  if (type == "subscribe") return ReadSubscribe(fields);
  if (type == "status") return StatusOrder{};
  return UnknownOrder{type};
}

void PutArm(const ArmOrder& arm, BoothJson& json) {
  json["profile"] = Clipped(arm.profile, 64);
  if (arm.height) json["height_mm"] = arm.height->value();
  if (arm.search) json["search"] = true;
  json["out"] = Clipped(arm.out, kMaxPathBytes);
  json["subject_id"] = Clipped(arm.subject_id, 128);
  json["consent"] = Clipped(arm.consent, 256);
}

BoothJson JsonFromOrder(const BoothOrder& order) {
  return std::visit(Overloaded{[](const HelloOrder& hello) {
                                 BoothJson json = Envelope("hello");
                                 json["role"] = RoleName(hello.role);
                                 json["control"] = hello.control;
                                 json["client"] = Clipped(hello.client, 64);
                                 return json;
                               },
                               [](const HomeOrder&) { return Envelope("home"); },
                               [](const ArmOrder& arm) {
                                 BoothJson json = Envelope("arm");
                                 PutArm(arm, json);
                                 return json;
                               },
                               [](const StartOrder& start) {
                                 BoothJson json = Envelope("start");
                                 json["version"] = start.version;
                                 return json;
                               },
                               [](const CancelOrder&) { return Envelope("cancel"); },
                               [](const AcknowledgeOrder&) { return Envelope("acknowledge"); },
                               [](const JogOrder& jog) {
                                 BoothJson json = Envelope("jog");
                                 json["direction"] = jog.direction == Scanner::JogDirection::kUp ? "up" : "down";
                                 return json;
                               },
                               [](const SubscribeOrder& subscribe) {
                                 BoothJson json = Envelope("subscribe");
                                 json["levels"] = subscribe.levels;
                                 json["sensors"] = subscribe.sensors;
                                 return json;
                               },
                               [](const StatusOrder&) { return Envelope("status"); },
                               [](const UnknownOrder& unknown) { return Envelope(unknown.type.c_str()); }},
                    order);
}

BoothJson JsonFromBooth(const BoothDescription& booth) {
  BoothJson boards = BoothJson::array();
  for (const BoothBoard& board : booth.boards) {
    boards.push_back({{"serial", board.serial},
                      {"first_sensor", board.first_sensor},
                      {"sensor_count", board.sensor_count},
                      {"firmware_version", Clipped(board.firmware_version, 64)}});
  }
  BoothJson profiles = BoothJson::array();
  for (const std::string& profile : booth.profiles) profiles.push_back(Clipped(profile, 64));
  return {{"station_id", Clipped(booth.station_id)},
          {"program_version", Clipped(booth.program_version)},
          {"simulated", booth.simulated},
          {"ring_radius_mm", FiniteOrNull(booth.ring_radius_mm)},
          {"boards", std::move(boards)},
          {"axis",
           {{"z_min_mm", FiniteOrNull(booth.axis.z_min.value())},
            {"z_max_mm", FiniteOrNull(booth.axis.z_max.value())},
            {"max_speed_mm_s", FiniteOrNull(booth.axis.max_speed.value())},
            {"max_acceleration_mm_s2", FiniteOrNull(booth.axis.max_acceleration.value())}}},
          {"profiles", std::move(profiles)}};
}

BoothDescription ReadBooth(FieldReader& fields) {
  BoothDescription booth;
  booth.station_id = fields.Words("station_id");
  booth.program_version = fields.Words("program_version");
  booth.simulated = fields.Flag("simulated");
  booth.ring_radius_mm = fields.NumberOrNan("ring_radius_mm");
  fields.Objects("boards", kMaxBoards, [&](FieldReader& one) {
    BoothBoard board;
    board.serial = static_cast<std::uint32_t>(one.Count("serial", 0xFFFF'FFFFU));
    board.first_sensor = static_cast<std::uint16_t>(one.Count("first_sensor", 0xFFFFU));
    board.sensor_count = static_cast<std::uint16_t>(one.Count("sensor_count", 0xFFFFU));
    board.firmware_version = one.Words("firmware_version");
    booth.boards.push_back(std::move(board));
  });
  fields.Object("axis", [&](FieldReader& axis) {
    booth.axis.z_min = Millimetres(axis.NumberOrNan("z_min_mm"));
    booth.axis.z_max = Millimetres(axis.NumberOrNan("z_max_mm"));
    booth.axis.max_speed = MillimetresPerSecond(axis.NumberOrNan("max_speed_mm_s"));
    booth.axis.max_acceleration = MillimetresPerSecondSquared(axis.NumberOrNan("max_acceleration_mm_s2"));
  });
  booth.profiles = fields.Texts("profiles", kMaxProfiles);
  return booth;
}

BoothJson JsonFromLevel(const LevelMessage& level) {
  BoothJson json = Envelope("level");
  json["sweep"] = level.sweep;
  json["level"] = level.level;
  json["time_ns"] = level.time.count();
  json["z_mm"] = FiniteOrNull(level.z_mm);
  json["sensor_step"] = level.sensor_step;
  BoothJson ranges = BoothJson::array();
  for (const double range : level.range_mm) ranges.push_back(FiniteOrNull(std::round(range * 100.0) / 100.0));
  json["range_mm"] = std::move(ranges);
  return json;
}

LevelMessage ReadLevel(FieldReader& fields) {
  LevelMessage level;
  level.sweep = static_cast<std::uint16_t>(fields.Count("sweep", 0xFFFFU));
  level.level = static_cast<std::uint32_t>(fields.Count("level", 0xFFFF'FFFFU));
  level.time = std::chrono::nanoseconds(fields.Integer("time_ns"));
  level.z_mm = fields.NumberOrNan("z_mm");
  level.sensor_step = static_cast<std::uint32_t>(fields.Count("sensor_step", 0xFFFF'FFFFU));
  fields.Array("range_mm", kMaxSensors, [&](const BoothJson& range) {
    if (!range.is_number() && !range.is_null()) return fields.Wrong("range_mm", range, "a list of numbers");
    level.range_mm.push_back(range.is_null() ? std::numeric_limits<double>::quiet_NaN() : range.get<double>());
  });
  return level;
}

BoothMessage ReadMessage(const std::string& type, FieldReader& fields) {
  if (type == "welcome") {
    WelcomeMessage welcome;
    welcome.id = fields.Count("id");
    welcome.control = fields.Flag("control");
    fields.Object("booth", [&](FieldReader& booth) { welcome.booth = ReadBooth(booth); });
    return welcome;
  }
  if (type == "reply") {
    ReplyMessage reply{fields.Count("id"), {}};
    if (fields.Flag("ok")) return reply;
    fields.Object("error", [&](FieldReader& error) { reply.result = tl::unexpected(ReadError(error)); });
    return reply;
  }
  if (type == "status") return ReadStatus(fields);
  if (type == "level") return ReadLevel(fields);
  if (type == "result") return ResultMessage{ReadResult(fields)};
  if (type == "bye") return ByeMessage{fields.Words("reason")};
  return UnknownMessage{type};
}

}  // namespace

BoothJson JsonFromError(const Error& error) {
  return {{"attempted", Clipped(error.attempted)}, {"seen", Clipped(error.seen)}, {"advice", Clipped(error.advice)}};
}

Error ReadError(FieldReader& fields) {
  return {fields.Words("attempted"), fields.Words("seen"), fields.Words("advice")};
}

std::string EncodeRequest(const BoothRequest& request) {
  BoothJson json = JsonFromOrder(request.order);
  json["id"] = request.id;
  return Dump(json);
}

tl::expected<BoothRequest, BadRequest> DecodeRequest(std::string_view text) {
  std::string wrong;
  const BoothJson json = ParseObject(text, wrong);
  BoothRequest request;
  std::string type;
  if (wrong.empty()) {
    FieldReader fields(json, wrong);
    request.id = fields.Count("id");
    if (!wrong.empty()) request.id = 0;
    CheckVersion(fields);
    type = fields.Text("type", 64);
    if (wrong.empty()) request.order = ReadOrder(type, fields);
  }
  if (wrong.empty()) return request;
  return tl::unexpected(BadRequest{
      request.id,
      {type.empty() ? "read a request" : "read the request '" + type + "'", wrong, "see docs/wire_protocol.md"}});
}

std::string EncodeMessage(const BoothMessage& message) {
  return Dump(std::visit(Overloaded{[](const WelcomeMessage& welcome) {
                                      BoothJson json = Envelope("welcome");
                                      json["id"] = welcome.id;
                                      json["control"] = welcome.control;
                                      json["booth"] = JsonFromBooth(welcome.booth);
                                      return json;
                                    },
                                    [](const ReplyMessage& reply) {
                                      BoothJson json = Envelope("reply");
                                      json["id"] = reply.id;
                                      json["ok"] = reply.result.has_value();
                                      if (!reply.result) json["error"] = JsonFromError(reply.result.error());
                                      return json;
                                    },
                                    [](const StatusMessage& status) {
                                      BoothJson json = Envelope("status");
                                      PutStatus(status, json);
                                      return json;
                                    },
                                    [](const LevelMessage& level) { return JsonFromLevel(level); },
                                    [](const ResultMessage& result) {
                                      BoothJson json = Envelope("result");
                                      json.update(JsonFromResult(result.result));
                                      return json;
                                    },
                                    [](const ByeMessage& bye) {
                                      BoothJson json = Envelope("bye");
                                      json["reason"] = Clipped(bye.reason);
                                      return json;
                                    },
                                    [](const UnknownMessage& unknown) { return Envelope(unknown.type.c_str()); }},
                         message));
}

Result<BoothMessage> DecodeMessage(std::string_view text) {
  std::string wrong;
  const BoothJson json = ParseObject(text, wrong);
  if (wrong.empty()) {
    FieldReader fields(json, wrong);
    CheckVersion(fields);
    const std::string type = fields.Text("type", 64);
    if (wrong.empty()) {
      BoothMessage message = ReadMessage(type, fields);
      if (wrong.empty()) return message;
    }
  }
  return Fail("read a message of boothd", wrong, "use programs of one version on both sides");
}

std::optional<std::string> BoothFrame(std::string_view json) {
  if (json.empty() || json.size() > kMaxBoothMessage) return std::nullopt;
  const auto size = static_cast<std::uint32_t>(json.size());
  std::string frame;
  frame.reserve(sizeof(size) + json.size());
  for (unsigned shift = 0; shift < 32; shift += 8) frame.push_back(static_cast<char>((size >> shift) & 0xFFU));
  return frame.append(json);
}

Result<std::optional<std::string>> BoothFrameReader::Next() {
  constexpr std::size_t kPrefix = 4;
  // What has been read is let go before it is more than what waits, so that moving costs no more than reading did.
  if (begin_ > buffer_.size() / 2) {
    buffer_.erase(0, begin_);
    begin_ = 0;
  }
  if (waiting() < kPrefix) return std::nullopt;
  std::uint32_t size = 0;
  for (std::size_t k = 0; k < kPrefix; ++k) {
    size |= static_cast<std::uint32_t>(static_cast<unsigned char>(buffer_[begin_ + k])) << (8 * k);
  }
  if (size == 0 || size > max_text_) {
    return Fail("read a frame", "its length is " + std::to_string(size),
                "send 1 to " + std::to_string(max_text_) + " bytes of JSON after their length");
  }
  if (waiting() < kPrefix + size) return std::nullopt;
  std::string text = buffer_.substr(begin_ + kPrefix, size);
  begin_ += kPrefix + size;
  return text;
}

}  // namespace annulus
