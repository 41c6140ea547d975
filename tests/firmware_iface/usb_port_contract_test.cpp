#include "tests/firmware_iface/usb_port_contract.h"

#include "sim/faulty_usb_port.h"
#include "sim/usb_host_model.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::contract {
namespace {

using Ending = sim::UsbFaultPlan::UnplugEnding;

sim::BoothOptions StandingBooth() {
  sim::BoothOptions options = sim::CylinderBooth();
  options.axis.start_z_mm = 500.0;
  return options;
}

/// The firmware model itself.
class Model final : public UsbPortFixture {
 public:
  Model() : booth_(StandingBooth()) {}
  Clock& clock() override { return booth_.clock(); }
  UsbPort& port() override { return booth_.board(0); }
  [[nodiscard]] std::uint32_t serial() const override { return 1001; }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug() override { booth_.board(0).UnplugAt(booth_.clock().Now()); }

 private:
  sim::Booth booth_;
};

/// The model on a simulated bus, through a port that may be faulty.
class OnBus final : public UsbPortFixture {
 public:
  explicit OnBus(const sim::UsbFaultPlan& plan) : booth_(StandingBooth()), host_(booth_.clock()) {
    host_.Add(booth_.board(0));
    host_.wrap = [this, plan](std::unique_ptr<UsbPort> port) {
      return std::make_unique<sim::FaultyUsbPort>(std::move(port), plan, log_);
    };
    port_ = *OpenPort(host_, {kRingBoardVendor, kRingBoardProduct, "RB1001", {}}, booth_.clock(), {});
  }
  ~OnBus() override {
    port_.reset();
    EXPECT_EQ(host_.leaked_transfers(), 0U);
  }
  Clock& clock() override { return booth_.clock(); }
  UsbPort& port() override { return *port_; }
  [[nodiscard]] std::uint32_t serial() const override { return 1001; }
  [[nodiscard]] bool CanUnplug() const override { return true; }
  void Unplug() override { host_.UnplugAt(0, booth_.clock().Now()); }

 private:
  sim::Booth booth_;
  sim::UsbHostModel host_;
  sim::UsbFaultLog log_;
  std::unique_ptr<UsbPort> port_;
};

UsbPortCase Bus(const char* name, Ending ending) {
  sim::UsbFaultPlan plan;
  plan.unplug_ending = ending;
  plan.cancel_completes_share = ending == Ending::kNoDevice ? 0.0 : 0.5;
  return {name, [plan] { return std::make_unique<OnBus>(plan); }};
}

INSTANTIATE_TEST_SUITE_P(Usb, UsbPortContract,
                         testing::Values(UsbPortCase{"firmware_model", [] { return std::make_unique<Model>(); }},
                                         Bus("simulated_bus", Ending::kNoDevice), Bus("faulty_bus", Ending::kAny),
                                         Bus("unplug_ends_in_error", Ending::kError),
                                         Bus("unplug_ends_well", Ending::kCompleted)),
                         NameOfPortCase);

}  // namespace
}  // namespace annulus::contract
