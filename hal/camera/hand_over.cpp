// The ring, and an eventfd that counts.
// SPDX-License-Identifier: MIT
#include "hal/camera/hand_over.h"

#include <cstdint>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace cupola {

HandOver::HandOver() noexcept : descriptor_(eventfd(0, EFD_SEMAPHORE | EFD_NONBLOCK | EFD_CLOEXEC)) {}

HandOver::~HandOver() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool HandOver::push(int value) noexcept {
  const std::size_t at = pushed_.load(std::memory_order_relaxed);
  if (at - popped_.load(std::memory_order_acquire) == kCapacity) return false;
  ring_[at % kCapacity] = value;
  pushed_.store(at + 1, std::memory_order_release);
  wake();
  return true;
}

std::optional<int> HandOver::pop() noexcept {
  std::uint64_t one = 0;
  // A value whose wake-up is still on its way waits for the next call.
  if (read(descriptor_, &one, sizeof one) != sizeof one) return std::nullopt;
  const std::size_t at = popped_.load(std::memory_order_relaxed);
  if (at == pushed_.load(std::memory_order_acquire)) return std::nullopt;
  const int value = ring_[at % kCapacity];
  popped_.store(at + 1, std::memory_order_release);
  return value;
}

int HandOver::wait() noexcept {
  for (;;) {
    if (const std::optional<int> value = pop()) return *value;
    pollfd readable{descriptor_, POLLIN, 0};
    ::poll(&readable, 1, -1);
  }
}

void HandOver::wake() noexcept {
  const std::uint64_t one = 1;
  // Fails only at 2^64 - 2 values.
  [[maybe_unused]] const ssize_t written = write(descriptor_, &one, sizeof one);
}

}  // namespace cupola
