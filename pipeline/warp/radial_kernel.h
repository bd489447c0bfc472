// The filter's weight by q, the squared distance in output pixels, for the kernels that are functions of it.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/filter.h"

namespace cupola {

// The same bits on every machine. const after construction.
class RadialKernel {
 public:
  explicit RadialKernel(const FilterSettings& filter);
  // 0 <= q < radius^2. kOptimal has no kernel and is not to be asked.
  double operator()(double q) const;

 private:
  double interpolated(double q) const;

  Kernel kernel_;
  double alpha_;
  double steps_a_unit_ = 0.0;
  std::vector<double> samples_;  // kJinc: at (i - 1) / steps_a_unit_
};

}  // namespace cupola
