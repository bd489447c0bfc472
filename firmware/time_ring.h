// How long something took, the last times it was done.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace cupola {

// Allocates at once, and in milliseconds().
class TimeRing {
 public:
  explicit TimeRing(std::size_t longest) : times_(longest) {}

  void add(std::chrono::nanoseconds time) noexcept { times_[added_++ % times_.size()] = time; }
  // In the order they were added.
  std::vector<double> milliseconds() const {
    std::vector<double> all;
    for (std::size_t i = added_ - std::min(added_, times_.size()); i < added_; ++i) {
      all.push_back(1e-6 * static_cast<double>(times_[i % times_.size()].count()));
    }
    return all;
  }

 private:
  std::vector<std::chrono::nanoseconds> times_;
  std::size_t added_ = 0;
};

}  // namespace cupola
