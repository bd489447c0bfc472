// Found among the codes' least lights, from where the leading bits of the number say.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/srgb_code.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <vector>

#include "pipeline/frame/srgb_curve.h"

namespace cupola {
namespace {

constexpr unsigned kShift = 13;             // leaves 10 bits of the mantissa: all of a half's
constexpr std::uint32_t kOne = 0x3f800000;  // 1.0F
constexpr std::size_t kCodes = 65536;

struct Codes {
  std::vector<double> least;           // light that is rounded to the code
  std::vector<std::uint16_t> nearest;  // of the numbers' leading bits, the code at least
  Codes() : least(kCodes), nearest((kOne >> kShift) + 2) {
    for (std::size_t k = 1; k < kCodes; ++k)
      least[k] = light_of_srgb((static_cast<double>(k) - 0.5) / 65535.0);
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      const auto light = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(i << kShift)));
      nearest[i] =
          static_cast<std::uint16_t>(std::upper_bound(least.begin(), least.end(), light) - least.begin() - 1);
    }
  }
};

}  // namespace

std::uint16_t srgb16_code(float light) {
  static const Codes codes;
  if (!(light > 0.0F)) return 0;
  if (light >= 1.0F) return 65535;
  const std::size_t at = std::bit_cast<std::uint32_t>(light) >> kShift;
  const auto first = codes.least.begin() + codes.nearest[at];
  const auto last = codes.least.begin() + codes.nearest[at + 1] + 1;
  return static_cast<std::uint16_t>(std::upper_bound(first, last, static_cast<double>(light)) -
                                    codes.least.begin() - 1);
}

}  // namespace cupola
