#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/usb_port.h"

namespace annulus::contract {

/// One ring board behind the USB seam, as a test of the seam's contract needs it.
class UsbPortFixture {
 public:
  virtual ~UsbPortFixture() = default;

  virtual Clock& clock() = 0;
  /// The port, open and idle. Lives as long as the fixture, or until Close.
  virtual UsbPort& port() = 0;
  /// The board's number; its USB serial number is "RB" and that.
  [[nodiscard]] virtual std::uint32_t serial() const = 0;
  /// Factor on every time that a test allows; about 5 on a slow emulated machine.
  [[nodiscard]] virtual double patience() const { return 1.0; }

  /// Whether Unplug does something; the tests that need it are skipped otherwise.
  [[nodiscard]] virtual bool CanUnplug() const { return false; }
  virtual void Unplug() {}
};

/// A named way to make a fixture; the parameter of the suite.
struct UsbPortCase {
  std::string name;
  std::function<std::unique_ptr<UsbPortFixture>()> make;
};
inline void PrintTo(const UsbPortCase& one, std::ostream* out) { *out << one.name; }
inline std::string NameOfPortCase(const testing::TestParamInfo<UsbPortCase>& info) { return info.param.name; }

/// What every UsbPort must do. The tests are in usb_port_contract.cpp: add that file to the program and instantiate in
/// any file of it, as for RangeRingContract.
class UsbPortContract : public testing::TestWithParam<UsbPortCase> {
 protected:
  void SetUp() override;
  void TearDown() override;

  [[nodiscard]] std::chrono::nanoseconds Patient(std::chrono::nanoseconds time) const;
  [[nodiscard]] std::chrono::nanoseconds In(std::chrono::nanoseconds time) const;
  UsbPort& port() { return fixture_->port(); }
  /// Arms the board and starts SYNC, 50 levels per second.
  void StartLevels();
  void StopLevels();
  void Submit(int count);
  /// Collects the end of everything in flight; each token must come once.
  void CollectAll();
  /// Takes a completion's token off the list and checks its time.
  void Account(const UsbCompletion& completion);

  std::unique_ptr<UsbPortFixture> fixture_;
  std::set<std::uint64_t> submitted_;  ///< Not ended.
  std::set<std::uint64_t> used_;       ///< Ever.
};

}  // namespace annulus::contract
