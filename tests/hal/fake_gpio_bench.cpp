// The fake lines keep what all lines promise.
// SPDX-License-Identifier: MIT
#include "hal/gpio/fake_gpio.h"
#include "tests/hal/gpio_contract.h"

namespace cupola {
namespace {

class FakeBench final : public GpioBench {
 public:
  FakeBench() { fake_.take("taken", true); }
  Clock& clock() override { return clock_; }
  Gpio& gpio() override { return fake_; }
  void pull(const std::string& line, bool high) override {
    clock_.advance(1ms);
    fake_.pull(line, high, clock_.now());
  }
  void storm(const std::string& line, int edges) override {
    fake_.bounce(line, fake_.high(line), clock_.now(), edges, 10us);
    clock_.advance(edges * 10us);
  }
  bool high(const std::string& line) override { return fake_.high(line); }
  void unplug() override { fake_.unplug("panel", clock_.now()); }
  void plug() override { fake_.plug("panel", clock_.now()); }

 private:
  FakeClock clock_;
  FakeGpio fake_{
      clock_,
      {{"panel", {"play", "next", "blackout", "lamp", "shutter", "taken"}}, {"stage", {"sensor", "tally"}}}};
};

INSTANTIATE_TEST_SUITE_P(Fake, GpioContract,
                         testing::Values(GpioBenchMaker{
                             "Lines",
                             [] { return std::unique_ptr<GpioBench>(std::make_unique<FakeBench>()); }}),
                         [](const auto& maker) { return std::string(maker.param.name); });

[[maybe_unused]] const auto* const kCount = testing::AddGlobalTestEnvironment(new EdgeCount("gpio-fake"));

}  // namespace
}  // namespace cupola
