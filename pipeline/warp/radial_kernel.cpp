// Gaussian and cubic straight from their formulas, the jinc from a table.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/radial_kernel.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

double cubic(double s) {
  constexpr double kB = 0.37821575509399867;
  constexpr double kC = 0.31089212245300067;
  if (s < 1.0) {
    return ((12.0 - 9.0 * kB - 6.0 * kC) * s * s * s + (-18.0 + 12.0 * kB + 6.0 * kC) * s * s + 6.0 -
            2.0 * kB) /
           6.0;
  }
  if (s >= 2.0) return 0.0;
  return ((-kB - 6.0 * kC) * s * s * s + (6.0 * kB + 30.0 * kC) * s * s - (12.0 * kB + 48.0 * kC) * s +
          8.0 * kB + 24.0 * kC) /
         6.0;
}

double jinc(double s) {
  const double x = portable::kPi * s;
  return x < 1e-9 ? 1.0 : 2.0 * portable::bessel_j1(x) / x;
}

// A jinc is smooth in q: cubic interpolation between this many samples a unit of q errs by less than 1e-9.
constexpr int kStepsAUnit = 128;
constexpr double kFirstZero = 1.2196698912665045;

}  // namespace

RadialKernel::RadialKernel(const FilterSettings& filter) : kernel_(filter.kernel), alpha_(filter.alpha) {
  if (kernel_ != Kernel::kJinc) return;
  steps_a_unit_ = kStepsAUnit;
  const int last = static_cast<int>(std::ceil(filter.radius * filter.radius * kStepsAUnit)) + 3;
  for (int i = -1; i <= last; ++i) {
    // Below 0 the mirrored value would put a kink at q = 0: the cubic through the next four goes on.
    const double s = std::sqrt(std::max(i, 0) / steps_a_unit_);
    samples_.push_back(jinc(s) * jinc(s * kFirstZero / filter.radius));
  }
  samples_[0] = 4.0 * samples_[1] - 6.0 * samples_[2] + 4.0 * samples_[3] - samples_[4];
}

double RadialKernel::interpolated(double q) const {
  const double at = q * steps_a_unit_;
  const auto cell = static_cast<std::size_t>(at);
  const double t = at - static_cast<double>(cell);
  const double* y = samples_.data() + cell;  // at -1, 0, 1, 2
  return y[1] + t * ((y[2] - y[0] / 3.0 - y[1] / 2.0 - y[3] / 6.0) +
                     t * ((y[0] + y[2]) / 2.0 - y[1] + t * ((y[1] - y[2]) / 2.0 + (y[3] - y[0]) / 6.0)));
}

double RadialKernel::operator()(double q) const {
  switch (kernel_) {
    case Kernel::kRobidoux:
      return cubic(std::sqrt(q));
    case Kernel::kJinc:
      return interpolated(q);
    default:
      return portable::exponential(-alpha_ * q);
  }
}

}  // namespace cupola
