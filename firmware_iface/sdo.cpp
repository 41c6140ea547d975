#include "firmware_iface/sdo.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/little_endian.h"

namespace annulus {
namespace {

// Command specifiers, the three highest bits of a frame's first byte (CiA 301, 7.2.4.3). What a client sends is named
// k…Request, what a server sends k…Reply; the same number means another thing in the other direction.
constexpr std::uint8_t kDownloadSegmentRequest = 0;
constexpr std::uint8_t kDownloadRequest = 1;
constexpr std::uint8_t kUploadRequest = 2;
constexpr std::uint8_t kUploadSegmentRequest = 3;
constexpr std::uint8_t kUploadSegmentReply = 0;
constexpr std::uint8_t kDownloadSegmentReply = 1;
constexpr std::uint8_t kUploadReply = 2;
constexpr std::uint8_t kDownloadReply = 3;
constexpr std::uint8_t kAbort = 4;

constexpr std::uint8_t kExpedited = 0x02;
constexpr std::uint8_t kSizeIndicated = 0x01;
constexpr std::uint8_t kToggleBit = 0x10;
constexpr std::uint8_t kLastSegment = 0x01;
constexpr std::size_t kSegmentBytes = 7;
constexpr std::size_t kExpeditedBytes = 4;
constexpr std::size_t kFrameBytes = 8;

using Bytes8 = std::array<std::byte, kFrameBytes>;

std::uint8_t CommandByte(std::uint8_t specifier, unsigned bits = 0) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(specifier) << 5 | bits);
}
std::uint8_t SpecifierOf(std::uint8_t command) { return static_cast<std::uint8_t>(command >> 5); }
/// Bytes of the 7 that carry no data, in the place where segments tell it.
unsigned UnusedOf(std::uint8_t command) { return command >> 1 & 0x07U; }

Bytes8 InitiateBytes(std::uint8_t command, SdoAddress address) {
  Bytes8 bytes{};
  bytes[0] = std::byte{command};
  PutLittleEndian(std::span<std::byte>(bytes).subspan(1), address.index);
  bytes[3] = std::byte{address.sub_index};
  return bytes;
}

SdoAddress AddressOf(const CanFrame& frame) {
  return {GetLittleEndian<std::uint16_t>(std::span<const std::byte>(frame.data).subspan(1)),
          std::to_integer<std::uint8_t>(frame.data[3])};
}

std::uint32_t LongOf(const CanFrame& frame) {
  return GetLittleEndian<std::uint32_t>(std::span<const std::byte>(frame.data).subspan(4));
}

/// An initiate frame of either direction: expedited if the data fit, else the announcement of their size.
Bytes8 InitiateWithData(std::uint8_t specifier, SdoAddress address, std::span<const std::byte> data) {
  if (data.size() > kExpeditedBytes || data.empty()) {
    Bytes8 bytes = InitiateBytes(CommandByte(specifier, kSizeIndicated), address);
    PutLittleEndian(std::span<std::byte>(bytes).subspan(4), static_cast<std::uint32_t>(data.size()));
    return bytes;
  }
  const auto unused = static_cast<unsigned>(kExpeditedBytes - data.size());
  Bytes8 bytes = InitiateBytes(CommandByte(specifier, unused << 2 | kExpedited | kSizeIndicated), address);
  std::copy(data.begin(), data.end(), bytes.begin() + 4);
  return bytes;
}

/// The data of an initiate frame that carries them itself.
std::vector<std::byte> ExpeditedData(const CanFrame& frame, std::uint8_t command) {
  const std::size_t unused = (command & kSizeIndicated) != 0 ? (command >> 2 & 0x03U) : 0;
  return {frame.data.begin() + 4, frame.data.begin() + static_cast<std::ptrdiff_t>(kFrameBytes - unused)};
}

/// A segment of either direction, from `at` on.
Bytes8 SegmentBytes(std::uint8_t specifier, bool toggle, std::span<const std::byte> data, std::size_t at) {
  const std::size_t count = std::min(kSegmentBytes, data.size() - at);
  const bool last = at + count == data.size();
  Bytes8 bytes{};
  bytes[0] =
      std::byte{CommandByte(specifier, (toggle ? kToggleBit : 0U) | static_cast<unsigned>(kSegmentBytes - count) << 1 |
                                           (last ? kLastSegment : 0U))};
  std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(at), count, bytes.begin() + 1);
  return bytes;
}

Bytes8 AbortBytes(SdoAddress address, SdoAbort reason) {
  Bytes8 bytes = InitiateBytes(CommandByte(kAbort), address);
  PutLittleEndian(std::span<std::byte>(bytes).subspan(4), static_cast<std::uint32_t>(reason));
  return bytes;
}

bool IsSdoFrame(const CanFrame& frame, CobId function, NodeId node) {
  return IsCanopenFrame(frame) && !frame.fd && frame.id == CobIdOf(function, node) && frame.size == kFrameBytes;
}

std::uint8_t CommandOf(const CanFrame& frame) { return std::to_integer<std::uint8_t>(frame.data[0]); }

}  // namespace

std::string SdoAddressText(SdoAddress address) {
  char text[16];
  std::snprintf(text, sizeof(text), "%04Xh:%02X", static_cast<unsigned>(address.index),
                static_cast<unsigned>(address.sub_index));
  return text;
}

std::string SdoAbortText(std::uint32_t code) {
  const char* text = "unknown reason";
  switch (static_cast<SdoAbort>(code)) {
    case SdoAbort::kToggle:
      text = "toggle bit not alternated";
      break;
    case SdoAbort::kTimeout:
      text = "protocol timed out";
      break;
    case SdoAbort::kCommand:
      text = "command not known";
      break;
    case SdoAbort::kWriteOnly:
      text = "object is write-only";
      break;
    case SdoAbort::kReadOnly:
      text = "object is read-only";
      break;
    case SdoAbort::kNoObject:
      text = "no such object";
      break;
    case SdoAbort::kLength:
      text = "length does not fit";
      break;
    case SdoAbort::kNoSubIndex:
      text = "no such sub-index";
      break;
    case SdoAbort::kValueRange:
      text = "value out of range";
      break;
    case SdoAbort::kGeneral:
      text = "general error";
      break;
    case SdoAbort::kDeviceState:
      text = "not in the present state of the device";
      break;
  }
  char hex[16];
  std::snprintf(hex, sizeof(hex), "%08Xh: ", static_cast<unsigned>(code));
  return std::string(hex) + text;
}

SdoTransfer SdoTransfer::Upload(NodeId node, SdoAddress address) {
  SdoTransfer transfer(node, address);
  transfer.request_ =
      ClassicFrame(CobIdOf(CobId::kSdoRequest, node), InitiateBytes(CommandByte(kUploadRequest), address));
  return transfer;
}

SdoTransfer SdoTransfer::Download(NodeId node, SdoAddress address, std::vector<std::byte> data) {
  ENSURE(!data.empty() && data.size() <= kMostSdoBytes, "an object of 1 to 256 bytes is written");
  SdoTransfer transfer(node, address);
  transfer.upload_ = false;
  transfer.data_ = std::move(data);
  transfer.segmented_ = transfer.data_.size() > kExpeditedBytes;
  transfer.request_ =
      ClassicFrame(CobIdOf(CobId::kSdoRequest, node), InitiateWithData(kDownloadRequest, address, transfer.data_));
  return transfer;
}

std::optional<CanFrame> SdoTransfer::TakeRequest() { return std::exchange(request_, std::nullopt); }

CanFrame SdoTransfer::AbortFrame(SdoAbort reason) const {
  return ClassicFrame(CobIdOf(CobId::kSdoRequest, node_), AbortBytes(address_, reason));
}

bool SdoTransfer::IsOfThisObject(const CanFrame& frame) const { return AddressOf(frame) == address_; }

bool SdoTransfer::GiveUp(SdoAbort reason) {
  state_ = State::kAborted;
  abort_code_ = static_cast<std::uint32_t>(reason);
  request_ = AbortFrame(reason);
  return true;
}

bool SdoTransfer::Take(const CanFrame& frame) {
  if (state_ != State::kRunning || !IsSdoFrame(frame, CobId::kSdoReply, node_)) return false;
  const std::uint8_t command = CommandOf(frame);
  if (SpecifierOf(command) == kAbort) {
    if (!IsOfThisObject(frame)) return false;
    state_ = State::kAborted;
    abort_code_ = LongOf(frame);
    return true;
  }
  return upload_ ? TakeUpload(frame, command) : TakeDownload(frame, command);
}

bool SdoTransfer::TakeUpload(const CanFrame& frame, std::uint8_t command) {
  if (segmented_) return TakeUploadSegment(frame, command);
  if (SpecifierOf(command) != kUploadReply || !IsOfThisObject(frame)) return false;
  if ((command & kExpedited) != 0) {
    data_ = ExpeditedData(frame, command);
    state_ = State::kDone;
    return true;
  }
  size_ = (command & kSizeIndicated) != 0 ? LongOf(frame) : 0;
  if (size_ > kMostSdoBytes) return GiveUp(SdoAbort::kLength);
  segmented_ = true;
  RequestSegment();
  return true;
}

void SdoTransfer::RequestSegment() {
  Bytes8 bytes{};
  bytes[0] = std::byte{CommandByte(kUploadSegmentRequest, toggle_ ? kToggleBit : 0U)};
  request_ = ClassicFrame(CobIdOf(CobId::kSdoRequest, node_), bytes);
}

bool SdoTransfer::TakeUploadSegment(const CanFrame& frame, std::uint8_t command) {
  if (SpecifierOf(command) != kUploadSegmentReply || ((command & kToggleBit) != 0) != toggle_) return false;
  const std::size_t count = kSegmentBytes - UnusedOf(command);
  data_.insert(data_.end(), frame.data.begin() + 1, frame.data.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  toggle_ = !toggle_;
  if (data_.size() > kMostSdoBytes) return GiveUp(SdoAbort::kLength);
  if ((command & kLastSegment) == 0) {
    RequestSegment();
    return true;
  }
  if (size_ != 0 && data_.size() != size_) return GiveUp(SdoAbort::kLength);
  state_ = State::kDone;
  return true;
}

bool SdoTransfer::TakeDownload(const CanFrame& frame, std::uint8_t command) {
  if (!segmented_ || sent_ == 0) {
    if (SpecifierOf(command) != kDownloadReply || !IsOfThisObject(frame)) return false;
  } else {
    // The acknowledged segment had the toggle bit before this one.
    if (SpecifierOf(command) != kDownloadSegmentReply || ((command & kToggleBit) != 0) == toggle_) return false;
  }
  if (!segmented_ || sent_ == data_.size()) {
    state_ = State::kDone;
    return true;
  }
  SendSegment();
  return true;
}

void SdoTransfer::SendSegment() {
  request_ =
      ClassicFrame(CobIdOf(CobId::kSdoRequest, node_), SegmentBytes(kDownloadSegmentRequest, toggle_, data_, sent_));
  sent_ += std::min(kSegmentBytes, data_.size() - sent_);
  toggle_ = !toggle_;
}

CanFrame SdoServer::Reply(std::span<const std::byte> bytes) const {
  return ClassicFrame(CobIdOf(CobId::kSdoReply, node_), bytes);
}

CanFrame SdoServer::Abort(SdoAbort reason) {
  mode_ = Mode::kIdle;
  return Reply(AbortBytes(address_, reason));
}

CanFrame SdoServer::Acknowledge(std::uint8_t command) const {
  Bytes8 bytes{};
  bytes[0] = std::byte{command};
  return Reply(bytes);
}

std::optional<CanFrame> SdoServer::Answer(const CanFrame& request) {
  if (!IsSdoFrame(request, CobId::kSdoRequest, node_)) return std::nullopt;
  const std::uint8_t command = CommandOf(request);
  switch (SpecifierOf(command)) {
    case kUploadRequest:
      address_ = AddressOf(request);
      return BeginUpload();
    case kUploadSegmentRequest:
      return UploadSegment(command);
    case kDownloadRequest:
      address_ = AddressOf(request);
      return BeginDownload(request, command);
    case kDownloadSegmentRequest:
      return DownloadSegment(request, command);
    case kAbort:
      mode_ = Mode::kIdle;
      return std::nullopt;
    default:
      return Abort(SdoAbort::kCommand);
  }
}

CanFrame SdoServer::BeginUpload() {
  auto value = objects_.read(address_);
  if (!value) return Abort(value.error());
  data_ = std::move(*value);
  at_ = 0;
  toggle_ = false;
  mode_ = data_.size() > kExpeditedBytes || data_.empty() ? Mode::kUploading : Mode::kIdle;
  return Reply(InitiateWithData(kUploadReply, address_, data_));
}

CanFrame SdoServer::UploadSegment(std::uint8_t command) {
  if (mode_ != Mode::kUploading) return Abort(SdoAbort::kCommand);
  if (((command & kToggleBit) != 0) != toggle_) return Abort(SdoAbort::kToggle);
  const CanFrame reply = Reply(SegmentBytes(kUploadSegmentReply, toggle_, data_, at_));
  at_ += std::min(kSegmentBytes, data_.size() - at_);
  toggle_ = !toggle_;
  if (at_ == data_.size()) mode_ = Mode::kIdle;
  return reply;
}

CanFrame SdoServer::BeginDownload(const CanFrame& request, std::uint8_t command) {
  data_.clear();
  toggle_ = false;
  if ((command & kExpedited) == 0) {
    announced_ = (command & kSizeIndicated) != 0 ? LongOf(request) : 0;
    if (announced_ > kMostSdoBytes) return Abort(SdoAbort::kLength);
    mode_ = Mode::kDownloading;
    return Reply(InitiateBytes(CommandByte(kDownloadReply), address_));
  }
  mode_ = Mode::kIdle;
  if (const auto written = objects_.write(address_, ExpeditedData(request, command)); !written) {
    return Abort(written.error());
  }
  return Reply(InitiateBytes(CommandByte(kDownloadReply), address_));
}

CanFrame SdoServer::DownloadSegment(const CanFrame& request, std::uint8_t command) {
  if (mode_ != Mode::kDownloading) return Abort(SdoAbort::kCommand);
  if (((command & kToggleBit) != 0) != toggle_) return Abort(SdoAbort::kToggle);
  const std::size_t count = kSegmentBytes - UnusedOf(command);
  data_.insert(data_.end(), request.data.begin() + 1, request.data.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  if (data_.size() > kMostSdoBytes) return Abort(SdoAbort::kLength);
  const std::uint8_t acknowledgement = CommandByte(kDownloadSegmentReply, toggle_ ? kToggleBit : 0U);
  toggle_ = !toggle_;
  if ((command & kLastSegment) == 0) return Acknowledge(acknowledgement);
  mode_ = Mode::kIdle;
  if (announced_ != 0 && data_.size() != announced_) return Abort(SdoAbort::kLength);
  if (const auto written = objects_.write(address_, data_); !written) return Abort(written.error());
  return Acknowledge(acknowledgement);
}

}  // namespace annulus
