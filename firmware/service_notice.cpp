// One unconnected datagram socket.
// SPDX-License-Identifier: MIT
#include "firmware/service_notice.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace cupola {
namespace {

std::optional<std::int64_t> number_in(const char* name) {
  const char* text = std::getenv(name);
  if (!text) return std::nullopt;
  const char* end = text + std::strlen(text);
  std::int64_t number = 0;
  const auto [rest, error] = std::from_chars(text, end, number);
  if (error != std::errc() || rest != end || rest == text) return std::nullopt;
  return number;
}

}  // namespace

ServiceNotice::ServiceNotice() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  // A path or, with @ for its first byte, which is 0, a name without a file.
  if (!address || (address[0] != '/' && address[0] != '@') || !address[1]) return;
  if (std::strlen(address) >= sizeof(sockaddr_un::sun_path)) return;
  address_ = address;
  if (address_[0] == '@') address_[0] = '\0';
  descriptor_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const std::optional<std::int64_t> process = number_in("WATCHDOG_PID");
  const std::optional<std::int64_t> microseconds = number_in("WATCHDOG_USEC");
  if (microseconds && *microseconds > 0 && *microseconds < std::int64_t{1} << 50 &&
      (!process || *process == getpid())) {
    watchdog_ = std::chrono::microseconds(*microseconds);
  }
}

ServiceNotice::~ServiceNotice() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool ServiceNotice::say(std::string_view line) noexcept {
  if (descriptor_ < 0) return false;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  return ::sendto(descriptor_, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                  reinterpret_cast<const sockaddr*>(&to), size) == static_cast<ssize_t>(line.size());
}

}  // namespace cupola
