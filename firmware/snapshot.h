// The newest of a value, from one thread that must not wait to any that may.
// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <type_traits>

namespace cupola {

template <class Value>
class Snapshot {
 public:
  static_assert(std::is_trivially_copyable_v<Value>);

  // Where a reader is at it just now the value is left out: the next one will do. Never waits.
  void publish(const Value& value) noexcept {
    if (!mutex_.try_lock()) return;
    value_ = value;
    mutex_.unlock();
  }
  Value read() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  Value value_;
};

}  // namespace cupola
