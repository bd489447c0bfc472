// Patches of one picture, looked for in the other as the rig says that it would look from there.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/seam_match.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr int kPatch = SeamMatch::kPatch;
constexpr int kReach = SeamMatch::kReach;
constexpr int kWindow = kPatch + 2 * kReach;  // where the patch is looked for, texels a side
constexpr int kOffsets = 2 * kReach + 1;
constexpr int kGrid = 128;     // rays of the frame along a side among which places are looked for
constexpr double kBand = 8.0;  // degrees: how much farther a view's axis may be than the nearest one's
// Squares of slopes, steps of 255 a texel. Smoothed noise has 0.42 of its variance.
constexpr double kLeastSlope = 1.0;
constexpr double kSlopeOfRest = 0.42;  // of what is left between a patch and its match: twice that of noise
constexpr double kSlopeOfNoise = 0.3;  // of the variance: a texture with more of it may be noise
constexpr double kLeastAlike = 0.8;    // correlation
constexpr double kVeryAlike = 0.95;
constexpr float kLeastAhead = 0.1F;   // of the next best place
constexpr int kOnePeak = 2;           // texels: what is so near belongs to the same peak
constexpr double kStrayTexels = 1.0;  // beyond, and beyond so many times what half of all are within
constexpr double kStrayTimes = 4.0;

using Correlations = std::array<float, kOffsets * kOffsets>;

double angle_between_unit(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
}

// Where the first view sees texel (x, y) of the second; false where it does not, with two texels to spare.
bool see(const View& first, const View& second, int x, int y, Vec2& at) {
  return project(first, direction_at(second, {x + 0.5, y + 0.5}), at) && at.x >= 2.5 && at.y >= 2.5 &&
         at.x <= first.size.width - 2.5 && at.y <= first.size.height - 2.5;
}

// Whether a window of the second view, whose corner is (x0, y0), is in its picture, and its corners are in
// the first one's, which is not tiny.
bool see_corners(const View& first, const View& second, int x0, int y0) {
  constexpr int kLast = kWindow - 1;
  Vec2 at;
  return std::min(first.size.width, first.size.height) >= kPatch + 2 && x0 >= 0 && y0 >= 0 &&
         x0 + kWindow <= second.size.width && y0 + kWindow <= second.size.height &&
         see(first, second, x0, y0, at) && see(first, second, x0 + kLast, y0, at) &&
         see(first, second, x0, y0 + kLast, at) && see(first, second, x0 + kLast, y0 + kLast, at);
}

// All of the window; empty where the first view does not see all of it.
std::vector<Vec2> see_window(const View& first, const View& second, int x0, int y0) {
  std::vector<Vec2> all(kWindow * kWindow);
  for (int i = 0; i < kWindow * kWindow; ++i) {
    if (!see(first, second, x0 + i % kWindow, y0 + i / kWindow, all[static_cast<std::size_t>(i)])) return {};
  }
  return all;
}

// Weighed 1 2 1 both ways: what is left of noise, and of detail that is between texels, matters less.
std::vector<float> smoothed(const GreyPicture& picture) {
  const int width = picture.size.width;
  const int height = picture.size.height;
  std::vector<float> across(picture.texels.size());
  std::vector<float> both(picture.texels.size());
  const auto place = [&](int x, int y) {
    return static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(std::clamp(x, 0, width - 1));
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int sum =
          picture.texels[place(x - 1, y)] + 2 * picture.texels[place(x, y)] + picture.texels[place(x + 1, y)];
      across[place(x, y)] = static_cast<float>(sum);
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      both[place(x, y)] =
          (across[place(x, y - 1)] + 2.0F * across[place(x, y)] + across[place(x, y + 1)]) / 16.0F;
    }
  }
  return both;
}

std::array<float, 4> catmull_rom(float t) {
  return {0.5F * t * (-1.0F + t * (2.0F - t)), 1.0F + 0.5F * t * t * (-5.0F + 3.0F * t),
          0.5F * t * (1.0F + t * (4.0F - 3.0F * t)), 0.5F * t * t * (t - 1.0F)};
}

float sample(const std::vector<float>& picture, int width, const Vec2& at) {
  const double x = std::floor(at.x - 0.5);
  const double y = std::floor(at.y - 0.5);
  const std::array<float, 4> across = catmull_rom(static_cast<float>(at.x - 0.5 - x));
  const std::array<float, 4> down = catmull_rom(static_cast<float>(at.y - 0.5 - y));
  const float* row =
      picture.data() + (static_cast<std::ptrdiff_t>(y) - 1) * width + (static_cast<std::ptrdiff_t>(x) - 1);
  float sum = 0.0F;
  for (std::size_t j = 0; j < 4; ++j, row += width)
    sum += down[j] * (across[0] * row[0] + across[1] * row[1] + across[2] * row[2] + across[3] * row[3]);
  return sum;
}

struct Texture {
  double slope = 0.0;  // its square's mean in the direction where it is least
  double variance = 0.0;
  bool is_enough() const { return slope >= kLeastSlope; }
  bool may_be_noise() const { return slope > kSlopeOfNoise * variance; }
};

// Of a square whose corner is `from`, with a texel to spare all around: the slope is the smaller eigenvalue
// of the slopes' mean outer product.
Texture texture_of(const float* from, std::ptrdiff_t stride, int side) {
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (int y = 0; y < side; ++y, from += stride) {
    for (int x = 0; x < side; ++x) {
      const double across = 0.5 * (from[x + 1] - from[x - 1]);
      const double down = 0.5 * (from[x + stride] - from[x - stride]);
      xx += across * across;
      xy += across * down;
      yy += down * down;
      sum += from[x];
      squares += from[x] * from[x];
    }
  }
  const double count = side * side;
  const double least = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return {least / count, squares / count - sum / count * (sum / count)};
}

// Of a patch about a place of a picture, or as near to there as fits.
Texture texture_about(const std::vector<float>& picture, Size size, const Vec2& middle) {
  const auto corner = [](double at, int side) {
    return std::clamp(static_cast<int>(at) - kPatch / 2, 1, side - kPatch - 1);
  };
  const std::ptrdiff_t row = corner(middle.y, size.height);
  return texture_of(picture.data() + row * size.width + corner(middle.x, size.width), size.width, kPatch);
}

// Of the patch with every part of the window: gains and blacks do not matter to it.
Correlations correlate(const std::array<float, kPatch * kPatch>& patch,
                       const std::array<float, kWindow * kWindow>& window) {
  constexpr float kCount = kPatch * kPatch;
  float mean = 0.0F;
  for (const float value : patch) mean += value / kCount;
  std::array<float, kPatch * kPatch> centred;
  float square = 0.0F;
  for (std::size_t i = 0; i < patch.size(); ++i) {
    centred[i] = patch[i] - mean;
    square += centred[i] * centred[i];
  }
  float window_mean = 0.0F;
  for (const float value : window) window_mean += value / (kWindow * kWindow);
  Correlations correlations{};
  for (int dy = 0; dy < kOffsets; ++dy) {
    for (int dx = 0; dx < kOffsets; ++dx) {
      float sum = 0.0F;
      float squares = 0.0F;
      float products = 0.0F;
      for (int y = 0; y < kPatch; ++y) {
        const float* row = window.data() + (y + dy) * kWindow + dx;
        const float* with = centred.data() + y * kPatch;
        for (int x = 0; x < kPatch; ++x) {
          const float value = row[x] - window_mean;
          sum += value;
          squares += value * value;
          products += value * with[x];
        }
      }
      const float variance = squares - sum * sum / kCount;
      if (variance > 0.01F * kCount)
        correlations[static_cast<std::size_t>(dy * kOffsets + dx)] = products / std::sqrt(variance * square);
    }
  }
  return correlations;
}

float alike(const Correlations& correlations, int x, int y) {
  return correlations[static_cast<std::size_t>(y * kOffsets + x)];
}

// Whether no neighbour is higher, at the border too.
bool is_peak(const Correlations& correlations, int x, int y) {
  for (int j = std::max(0, y - 1); j <= std::min(kOffsets - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(kOffsets - 1, x + 1); ++i) {
      if (alike(correlations, i, j) > alike(correlations, x, y)) return false;
    }
  }
  return true;
}

bool has_another_peak(const Correlations& correlations, int x, int y) {
  const float least = alike(correlations, x, y) - kLeastAhead;
  for (int j = 0; j < kOffsets; ++j) {
    for (int i = 0; i < kOffsets; ++i) {
      if (std::max(std::abs(i - x), std::abs(j - y)) <= kOnePeak || alike(correlations, i, j) < least)
        continue;
      if (is_peak(correlations, i, j)) return true;
    }
  }
  return false;
}

// From (x, y) to the top of the quadratic that is nearest, by least squares, to the nine about it; none where
// it has no top there.
std::optional<Vec2> top(const Correlations& correlations, int x, int y) {
  std::array<double, 9> f;
  for (int i = 0; i < 9; ++i)
    f[static_cast<std::size_t>(i)] = alike(correlations, x + i % 3 - 1, y + i / 3 - 1);
  const double fx = (f[2] + f[5] + f[8] - f[0] - f[3] - f[6]) / 6.0;
  const double fy = (f[6] + f[7] + f[8] - f[0] - f[1] - f[2]) / 6.0;
  const double fxx = (f[0] + f[3] + f[6] + f[2] + f[5] + f[8] - 2.0 * (f[1] + f[4] + f[7])) / 3.0;
  const double fyy = (f[0] + f[1] + f[2] + f[6] + f[7] + f[8] - 2.0 * (f[3] + f[4] + f[5])) / 3.0;
  const double fxy = (f[0] + f[8] - f[2] - f[6]) / 4.0;
  const double determinant = fxx * fyy - fxy * fxy;
  if (!(fxx < 0.0 && determinant > 0.0)) return std::nullopt;
  const Vec2 step{(fxy * fy - fyy * fx) / determinant, (fxy * fx - fxx * fy) / determinant};
  if (std::abs(step.x) > 1.0 || std::abs(step.y) > 1.0) return std::nullopt;
  return step;
}

// `values` are put in another order.
double quantile(std::vector<double>& values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

Vec2 median(std::span<const Vec2> shifts) {
  std::vector<double> u;
  std::vector<double> v;
  for (const Vec2& shift : shifts) {
    u.push_back(shift.x);
    v.push_back(shift.y);
  }
  return {quantile(u, 0.5), quantile(v, 0.5)};
}

}  // namespace

SeamMatch::SeamMatch(const Rig& rig, std::size_t first, std::size_t second)
    : first_size_(rig.views[first].size), second_size_(rig.views[second].size) {
  const View& one = rig.views[first];
  const View& other = rig.views[second];
  std::vector<Place> found;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    DirectionAndSlope looking;
    const Vec2 pixel{(i % kGrid + 0.5) * rig.frame.size.width / kGrid,
                     (i / kGrid + 0.5) * rig.frame.size.height / kGrid};
    if (!ray(rig.frame, pixel, looking)) continue;
    const Vec3& d = looking.direction;
    double nearest = HUGE_VAL;
    for (const View& view : rig.views) {
      if (covers(view, d)) nearest = std::min(nearest, angle_between_unit(view.forward, d));
    }
    const double farther =
        std::max(angle_between_unit(one.forward, d), angle_between_unit(other.forward, d)) - nearest;
    Vec2 there;
    if (farther > portable::radians(kBand) || !covers(one, d) || !covers(other, d) ||
        !project(other, d, there))
      continue;
    Place place;
    place.x = static_cast<int>(std::floor(there.x)) - kPatch / 2;
    place.y = static_cast<int>(std::floor(there.y)) - kPatch / 2;
    if (see_corners(one, other, place.x - kReach, place.y - kReach)) found.push_back(place);
  }
  const std::size_t count = std::min(found.size(), kMostPlaces);
  for (std::size_t i = 0; i < count; ++i) {
    Place& place = found[i * found.size() / count];
    place.in_first = see_window(one, other, place.x - kReach, place.y - kReach);
    if (!place.in_first.empty()) places_.push_back(std::move(place));
  }
}

void SeamMatch::match(Place& place, const std::vector<float>& first, const std::vector<float>& second) const {
  const float* corner = second.data() + static_cast<std::ptrdiff_t>(place.y) * second_size_.width + place.x;
  const Texture own = texture_of(corner, second_size_.width, kPatch);
  if (!own.is_enough()) return;
  std::array<float, kPatch * kPatch> patch;
  for (int y = 0; y < kPatch; ++y, corner += second_size_.width)
    std::copy_n(corner, kPatch, patch.data() + y * kPatch);
  std::array<float, kWindow * kWindow> window;
  for (std::size_t i = 0; i < window.size(); ++i)
    window[i] = sample(first, first_size_.width, place.in_first[i]);
  const Correlations correlations = correlate(patch, window);
  const auto best = std::max_element(correlations.begin(), correlations.end()) - correlations.begin();
  const int x = static_cast<int>(best) % kOffsets;
  const int y = static_cast<int>(best) / kOffsets;
  const double agrees = alike(correlations, x, y);
  const double rest = own.variance * (1.0 - agrees * agrees);
  const bool sure = own.slope >= kSlopeOfRest * rest;
  if (!sure && agrees >= kVeryAlike) return;  // but for noise it may be anywhere along a line
  const bool at_border = x == 0 || y == 0 || x == kOffsets - 1 || y == kOffsets - 1;
  if (!sure || at_border || agrees < kLeastAlike) {
    const Texture other = texture_about(first, first_size_, place.in_first[place.in_first.size() / 2]);
    if (other.is_enough() && !own.may_be_noise() && !other.may_be_noise()) place.unlike = true;
    return;
  }
  const std::optional<Vec2> step = top(correlations, x, y);
  if (!step || has_another_peak(correlations, x, y)) {
    place.repeats = true;
    return;
  }
  place.shifts.push_back(Vec2{x - kReach, y - kReach} + *step);
}

void SeamMatch::look(const GreyPicture& first, const GreyPicture& second) {
  assert(first.size == first_size_ && second.size == second_size_);
  if (places_.empty()) return;
  const std::vector<float> one = smoothed(first);
  const std::vector<float> other = smoothed(second);
  for (Place& place : places_) match(place, one, other);
}

SeamMeasure SeamMatch::measure() const {
  SeamMeasure measure;
  std::vector<Vec2> all;
  for (const Place& place : places_) {
    if (!place.shifts.empty()) {
      all.push_back(median(place.shifts));
      measure.shifts.push_back({Vec2{place.x, place.y} + Vec2{kPatch / 2.0}, all.back()});
    } else if (place.unlike) {
      ++measure.unlike;
    } else if (place.repeats) {
      ++measure.repeating;
    } else {
      ++measure.plain;
    }
  }
  if (all.empty()) return measure;
  const Vec2 middle = median(all);
  std::vector<double> off;
  for (const Vec2& shift : all) off.push_back(glm::length(shift - middle));
  std::vector<double> sorted = off;
  const double limit = std::max(kStrayTexels, kStrayTimes * quantile(sorted, 0.5));
  std::vector<Vec2> kept;
  std::vector<double> lengths;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (off[i] > limit) continue;
    kept.push_back(all[i]);
    lengths.push_back(glm::length(all[i]));
  }
  measure.strays = all.size() - kept.size();
  measure.mostly = median(kept);
  measure.median = quantile(lengths, 0.5);
  measure.most = quantile(lengths, 0.95);
  return measure;
}

}  // namespace cupola
