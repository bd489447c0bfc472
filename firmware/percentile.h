// Of measured times: what a share of them does not exceed.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

namespace cupola {

class Percentiles {
 public:
  explicit Percentiles(std::vector<double> values) : values_(std::move(values)) {
    std::sort(values_.begin(), values_.end());
  }
  // `share` from 0 (the least) to 1 (the largest); 0 where nothing was measured.
  double at(double share) const {
    if (values_.empty()) return 0.0;
    return values_[static_cast<std::size_t>(share * static_cast<double>(values_.size() - 1))];
  }
  std::size_t count() const { return values_.size(); }

 private:
  std::vector<double> values_;
};

}  // namespace cupola
