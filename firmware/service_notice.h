// What the player tells systemd: that it is ready, and that it still lives.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace cupola {

// The datagrams of sd_notify(3), to the socket that NOTIFY_SOCKET names: its protocol is documented and kept
// for good, and a few lines long. Without NOTIFY_SOCKET nothing is said. Nothing waits.
class ServiceNotice {
 public:
  ServiceNotice();  // reads the environment: NOTIFY_SOCKET, WATCHDOG_USEC, WATCHDOG_PID
  ~ServiceNotice();
  ServiceNotice(const ServiceNotice&) = delete;
  ServiceNotice& operator=(const ServiceNotice&) = delete;

  bool wanted() const { return descriptor_ >= 0; }
  // How long systemd waits for a sign of life; none where it does not.
  std::optional<std::chrono::nanoseconds> watchdog() const { return watchdog_; }
  // "READY=1", "WATCHDOG=1", "STOPPING=1". False where it did not get through.
  bool say(std::string_view line) noexcept;

 private:
  std::string address_;
  int descriptor_ = -1;
  std::optional<std::chrono::nanoseconds> watchdog_;
};

}  // namespace cupola
