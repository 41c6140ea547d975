#include <libusb.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "base/ensure.h"
#include "base/log.h"
#include "firmware_iface/libusb_context.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// How long closing waits for callbacks.
constexpr nanoseconds kCloseDeadline = seconds(1);

constexpr std::uint8_t kVendorOut = LIBUSB_REQUEST_TYPE_VENDOR;  // to the device as a whole
constexpr std::uint8_t kVendorIn = kVendorOut | std::uint8_t{LIBUSB_ENDPOINT_IN};

UsbStatus StatusOf(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return UsbStatus::kCompleted;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return UsbStatus::kTimedOut;
    case LIBUSB_TRANSFER_CANCELLED:
      return UsbStatus::kCancelled;
    case LIBUSB_TRANSFER_STALL:
      return UsbStatus::kStall;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return UsbStatus::kNoDevice;
    case LIBUSB_TRANSFER_OVERFLOW:
      return UsbStatus::kOverflow;
    default:
      return UsbStatus::kError;
  }
}

/// libusb counts whole milliseconds and takes 0 for ever.
unsigned int Milliseconds(nanoseconds timeout) {
  const auto whole = std::chrono::ceil<milliseconds>(timeout).count();
  return static_cast<unsigned int>(std::clamp<std::int64_t>(whole, 1, 60'000));
}

struct FreeTransfer {
  void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); }
};
struct CloseHandle {
  void operator()(libusb_device_handle* handle) const {
    libusb_release_interface(handle, kBoardInterface);
    libusb_close(handle);
  }
};

class LibusbPort final : public UsbPort {
 public:
  LibusbPort(LibusbContext& context, libusb_device_handle* handle, UsbIdentity identity, std::uint64_t transfer_memory)
      : context_(context), handle_(handle), identity_(std::move(identity)), transfer_memory_(transfer_memory) {}
  ~LibusbPort() override { Close(); }
  LibusbPort(const LibusbPort&) = delete;
  LibusbPort& operator=(const LibusbPort&) = delete;

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) override;
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) override;
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override;
  void Cancel(UsbToken token) override;
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override;
  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override;
  [[nodiscard]] std::size_t in_flight() const override { return CountActive() + completed_.size(); }

 private:
  /// A buffer and libusb's record of it, used again and again.
  struct Transfer {
    LibusbPort* port = nullptr;  ///< Null: the port is gone, the transfer was left behind on purpose.
    UsbToken token;
    bool active = false;  ///< Submitted, and its callback has not come.
    std::vector<unsigned char> buffer;
    std::unique_ptr<libusb_transfer, FreeTransfer> record;
  };

  static void LIBUSB_CALL OnEnd(libusb_transfer* record);
  [[nodiscard]] std::size_t CountActive() const;
  Transfer* FindIdle();
  [[nodiscard]] UsbFailure Failure(int code, const char* what) const;
  void Close();

  LibusbContext& context_;
  std::unique_ptr<libusb_device_handle, CloseHandle> handle_;
  UsbIdentity identity_;
  std::uint64_t transfer_memory_;
  std::uint64_t next_token_ = 1;
  std::vector<std::unique_ptr<Transfer>> transfers_;
  std::deque<UsbCompletion> completed_;
};

UsbFailure LibusbPort::Failure(int code, const char* what) const {
  UsbFailure failure = FailureOf(code, what);
  if (failure.status == UsbStatus::kNoMemory && transfer_memory_ > 0) {
    failure.detail += "; all USB transfers in flight may use " + std::to_string(transfer_memory_ >> 20) +
                      " MB together (usbfs_memory_mb)";
  }
  return failure;
}

UsbResult<std::vector<std::byte>> LibusbPort::ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) {
  ENSURE(length <= UINT16_MAX, "a control request has at most 65535 bytes");
  std::vector<std::byte> data(length);
  const int code = libusb_control_transfer(handle_.get(), kVendorIn, request.request, request.value, request.index,
                                           reinterpret_cast<unsigned char*>(data.data()),
                                           static_cast<std::uint16_t>(length), Milliseconds(timeout));
  if (code < 0) return tl::unexpected<UsbFailure>(Failure(code, "control request"));
  data.resize(static_cast<std::size_t>(code));
  return data;
}

UsbResult<void> LibusbPort::ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) {
  ENSURE(data.size() <= UINT16_MAX, "a control request has at most 65535 bytes");
  std::vector<std::byte> copy(data.begin(), data.end());
  const int code = libusb_control_transfer(handle_.get(), kVendorOut, request.request, request.value, request.index,
                                           reinterpret_cast<unsigned char*>(copy.data()),
                                           static_cast<std::uint16_t>(copy.size()), Milliseconds(timeout));
  if (code < 0) return tl::unexpected<UsbFailure>(Failure(code, "control request"));
  return {};
}

std::size_t LibusbPort::CountActive() const {
  return static_cast<std::size_t>(
      std::count_if(transfers_.begin(), transfers_.end(), [](const auto& transfer) { return transfer->active; }));
}

LibusbPort::Transfer* LibusbPort::FindIdle() {
  for (const auto& transfer : transfers_) {
    if (!transfer->active) return transfer.get();
  }
  auto fresh = std::make_unique<Transfer>();
  fresh->port = this;
  fresh->record.reset(libusb_alloc_transfer(0));
  if (fresh->record == nullptr) return nullptr;
  return transfers_.emplace_back(std::move(fresh)).get();
}

UsbResult<UsbToken> LibusbPort::SubmitBulkIn(std::uint8_t endpoint, std::size_t length) {
  ENSURE(length > 0 && length <= (std::size_t{1} << 24), "a transfer has room, and not too much");
  Transfer* const transfer = FindIdle();
  if (transfer == nullptr) return tl::unexpected<UsbFailure>(Failure(LIBUSB_ERROR_NO_MEM, "bulk transfer"));
  transfer->buffer.resize(length);
  transfer->token = {next_token_++};
  libusb_fill_bulk_transfer(transfer->record.get(), handle_.get(), endpoint, transfer->buffer.data(),
                            static_cast<int>(length), &OnEnd, transfer, 0);
  const int code = libusb_submit_transfer(transfer->record.get());
  if (code < 0) return tl::unexpected<UsbFailure>(Failure(code, "bulk transfer"));
  transfer->active = true;
  return transfer->token;
}

/// Runs inside libusb: puts the outcome away and does nothing else.
void LibusbPort::OnEnd(libusb_transfer* record) {
  auto& transfer = *static_cast<Transfer*>(record->user_data);
  transfer.active = false;
  if (transfer.port == nullptr) return;
  const auto* const data = reinterpret_cast<const std::byte*>(record->buffer);
  UsbCompletion completion;
  completion.token = transfer.token;
  completion.status = StatusOf(record->status);
  completion.data.assign(data, data + std::max(record->actual_length, 0));
  completion.host_time = transfer.port->context_.clock().Now();
  transfer.port->completed_.push_back(std::move(completion));
}

void LibusbPort::Cancel(UsbToken token) {
  for (const auto& transfer : transfers_) {
    // Its failures mean that the transfer has ended or is about to: the callback tells.
    if (transfer->active && transfer->token == token) libusb_cancel_transfer(transfer->record.get());
  }
}

UsbResult<void> LibusbPort::ClearHalt(std::uint8_t endpoint) {
  const int code = libusb_clear_halt(handle_.get(), endpoint);
  if (code < 0) return tl::unexpected<UsbFailure>(Failure(code, "clear the halted endpoint"));
  return {};
}

std::optional<UsbCompletion> LibusbPort::WaitCompletion(nanoseconds deadline) {
  while (completed_.empty()) {
    context_.HandleEvents(deadline);
    if (completed_.empty() && context_.clock().Now() >= deadline) return std::nullopt;
  }
  UsbCompletion completion = std::move(completed_.front());
  completed_.pop_front();
  return completion;
}

void LibusbPort::Close() {
  for (const auto& transfer : transfers_) {
    if (transfer->active) libusb_cancel_transfer(transfer->record.get());
  }
  const nanoseconds deadline = context_.clock().Now() + kCloseDeadline;
  while (CountActive() > 0 && context_.clock().Now() < deadline) context_.HandleEvents(deadline);
  if (CountActive() == 0) return;
  // Freeing memory that the kernel may still write to, or closing under it, crashes. A leak does not.
  Log(LogLevel::kError, "USB device " + DeviceName(identity_) + ": " + std::to_string(CountActive()) +
                            " transfers did not end within 1 s; left open");
  for (auto& transfer : transfers_) {
    if (!transfer->active) continue;
    transfer->port = nullptr;
    static_cast<void>(transfer.release());
  }
  static_cast<void>(handle_.release());
  context_.Abandon();
}

}  // namespace

std::unique_ptr<UsbPort> MakeLibusbPort(LibusbContext& context, libusb_device_handle* handle, UsbIdentity identity,
                                        std::uint64_t transfer_memory) {
  return std::make_unique<LibusbPort>(context, handle, std::move(identity), transfer_memory);
}

}  // namespace annulus
