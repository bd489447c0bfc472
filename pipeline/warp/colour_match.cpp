// Patches of overlapping pictures, weighed by how well they agree, and small systems of equations.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/colour_match.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/portable/cholesky.h"
#include "pipeline/portable/portable_math.h"
#include "pipeline/warp/texels_read.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {
namespace {

constexpr int kGrid = 128;                // rays of the frame along a side among which samples are looked for
constexpr double kBand = 12.0;            // degrees: how much farther a view's axis may be than the other's
constexpr std::size_t kLeastSamples = 8;  // of a pair; of a view in a round
constexpr double kDark = 12.0;            // 8-bit steps: below and above, samples say nothing of gains
constexpr double kBright = 243.0;
constexpr int kClippedLuma = 8;       // steps from the ends of luma's range
constexpr double kLeastScale = 1.5;   // steps: what agreeing samples may differ by
constexpr double kSeconds = 4.0;      // the time constant
constexpr double kLongestStep = 1.0;  // seconds: after a gap nothing jumps
constexpr double kBegin = 1.0;        // the dead band, steps
constexpr double kEnd = 0.25;
constexpr double kSeen = 0.125;  // steps: lesser changes are not passed on
// Offsets are held at 0 as if by samples of this share of the view's: they count where brightnesses differ by
// more than about 7 steps.
constexpr double kOffsetRidge = 0.003;
constexpr double kGainRidge = 1e-4;
constexpr std::array<double, 2> kLevels = {32.0, 200.0};  // at which colours are compared

// The larger difference at both levels, steps.
double apart(const ViewColour& a, const ViewColour& b, std::size_t channel) {
  double most = 0.0;
  for (const double level : kLevels)
    most = std::max(most, std::abs(a.of(channel, level) - b.of(channel, level)));
  return most;
}

double median(std::array<double, ColourMatch::kMostSamples>& values, std::size_t count) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

// The corner of a patch about the place where the view sees `d`, even; none where it is not all in the
// picture.
std::optional<std::array<int, 2>> patch_at(const View& view, const Vec3& d) {
  Vec2 uv;
  if (!project(view, d, uv)) return std::nullopt;
  const int x = static_cast<int>(std::floor(uv.x / 2.0 + 0.5)) * 2 - ColourMatch::kPatch / 2;
  const int y = static_cast<int>(std::floor(uv.y / 2.0 + 0.5)) * 2 - ColourMatch::kPatch / 2;
  const bool inside = x >= 2 && y >= 2 && x + ColourMatch::kPatch + 2 <= view.size.width &&
                      y + ColourMatch::kPatch + 2 <= view.size.height;
  if (!inside) return std::nullopt;
  return std::array{x, y};
}

}  // namespace

ColourMatch::ColourMatch(const Rig& rig, NativeLayout layout, YuvColour colour,
                         std::span<const std::optional<ViewColour>> locked)
    : layout_(layout), colour_(colour), reads_(rig.views.size()), moving_(rig.views.size()) {
  for (const std::optional<ViewColour>& view : locked) {
    locked_.push_back(view.has_value());
    now_.push_back(view.value_or(ViewColour{}));
  }
  applied_ = now_;
  find_samples(rig);
  weights_.resize(samples_.size());
}

void ColourMatch::find_samples(const Rig& rig) {
  const Size size = rig.frame.size;
  for (std::size_t a = 0; a < rig.views.size(); ++a) {
    for (std::size_t b = a + 1; b < rig.views.size(); ++b) {
      std::vector<Sample> found;
      for (int i = 0; i < kGrid * kGrid; ++i) {
        DirectionAndSlope looking;
        const Vec2 pixel{(i % kGrid + 0.5) * size.width / kGrid, (i / kGrid + 0.5) * size.height / kGrid};
        if (!ray(rig.frame, pixel, looking)) continue;
        const Vec3& d = looking.direction;
        const double from_a = std::acos(std::clamp(glm::dot(d, rig.views[a].forward), -1.0, 1.0));
        const double from_b = std::acos(std::clamp(glm::dot(d, rig.views[b].forward), -1.0, 1.0));
        if (std::abs(from_a - from_b) > portable::radians(kBand)) continue;
        const auto in_a = patch_at(rig.views[a], d);
        const auto in_b = patch_at(rig.views[b], d);
        if (!in_a || !in_b) continue;
        Sample sample;
        sample.at = {Patch{static_cast<std::uint16_t>(a), (*in_a)[0], (*in_a)[1]},
                     Patch{static_cast<std::uint16_t>(b), (*in_b)[0], (*in_b)[1]}};
        sample.pair = static_cast<std::uint16_t>(pairs_);
        found.push_back(sample);
      }
      if (found.size() < kLeastSamples) continue;
      const std::size_t count = std::min(found.size(), kMostSamples);
      for (std::size_t i = 0; i < count; ++i) samples_.push_back(found[i * found.size() / count]);
      ++pairs_;
    }
  }
  for (const Sample& sample : samples_) {
    for (const Patch& patch : sample.at) {
      TexelBox& box = reads_[patch.view];
      const TexelBox own{patch.x, patch.y, patch.x + kPatch, patch.y + kPatch};
      box = box_around(box, own);
    }
  }
}

bool ColourMatch::mean(const NativeImage& face, const Patch& patch,
                       std::array<double, 3>& rgb) const noexcept {
  int sum = 0;
  int least = 255;
  int most = 0;
  for (int y = 0; y < kPatch; ++y) {
    for (int x = 0; x < kPatch; ++x) {
      const int value = *sample_at(face, 0, patch.x + x, patch.y + y);
      sum += value;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  const bool limited = colour_.range == YuvRange::kLimited;
  if (least < (limited ? 16 : 0) + kClippedLuma || most > (limited ? 235 : 255) - kClippedLuma) return false;
  const int rows = has_chroma_in_every_row(layout_) ? kPatch : kPatch / 2;
  const int top = has_chroma_in_every_row(layout_) ? patch.y : patch.y / 2;
  std::array<int, 2> chroma{};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < kPatch / 2; ++x) {
      for (int c = 0; c < 2; ++c)
        chroma[static_cast<std::size_t>(c)] += *sample_at(face, c + 1, patch.x / 2 + x, top + y);
    }
  }
  const double of_chroma = rows * (kPatch / 2);
  rgb = rgb_of(colour_, sum / double{kPatch * kPatch}, chroma[0] / of_chroma, chroma[1] / of_chroma);
  return std::all_of(rgb.begin(), rgb.end(), [](double value) { return value > kDark && value < kBright; });
}

void ColourMatch::measure(Sample& sample, std::span<const NativeImage> faces, unsigned seen) const noexcept {
  sample.good = true;
  for (std::size_t side = 0; side < 2; ++side) {
    const Patch& patch = sample.at[side];
    sample.good =
        sample.good && (seen >> patch.view & 1) != 0 && mean(faces[patch.view], patch, sample.rgb[side]);
  }
}

// By how far each sample is from its pair's median, in the pair's own spread.
void ColourMatch::weigh(std::size_t channel) noexcept {
  const auto difference = [&](const Sample& sample) {
    return now_[sample.at[0].view].of(channel, sample.rgb[0][channel]) -
           now_[sample.at[1].view].of(channel, sample.rgb[1][channel]);
  };
  for (std::size_t first = 0; first < samples_.size();) {
    std::size_t last = first;
    std::size_t count = 0;
    std::array<double, kMostSamples> values{};
    for (; last < samples_.size() && samples_[last].pair == samples_[first].pair; ++last) {
      if (samples_[last].good) values[count++] = difference(samples_[last]);
    }
    const double middle = count > 0 ? median(values, count) : 0.0;
    for (std::size_t i = 0; i < count; ++i) values[i] = std::abs(values[i] - middle);
    const double scale = std::max(kLeastScale, count > 0 ? 1.4826 * median(values, count) : 0.0);
    const double trust = kLeastScale / scale * (kLeastScale / scale);  // in a pair whose samples disagree
    for (std::size_t i = first; i < last; ++i) {
      const double off = (difference(samples_[i]) - middle) / (2.0 * scale);
      const double share = 1.0 / (1.0 + off * off);
      weights_[i] = samples_[i].good && count >= kLeastSamples ? trust * share * share : 0.0;
    }
    first = last;
  }
}

// Unknown are, for each view that is free, 128 times the relative change of its gain, and the change of its
// offset.
void ColourMatch::solve(std::size_t channel, double share) noexcept {
  weigh(channel);
  std::array<double, kMostViews> weight{};
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    for (const Patch& patch : samples_[i].at) weight[patch.view] += weights_[i];
  }
  std::array<std::size_t, kMostViews> place{};
  std::size_t free = 0;
  bool anchored = false;
  for (std::size_t v = 0; v < now_.size(); ++v) {
    place[v] = SIZE_MAX;
    anchored = anchored || locked_[v];
    if (!locked_[v] && weight[v] >= 0.25 * kLeastSamples) place[v] = free++;
  }
  const std::size_t unknowns = 2 * free;
  std::array<double, 4 * kMostViews * kMostViews> m{};  // by rows
  std::array<double, 2 * kMostViews> x{};
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Sample& sample = samples_[i];
    if (!(weights_[i] > 0.0)) continue;
    std::array<std::size_t, 4> at{};
    std::array<double, 4> factor{};
    std::size_t count = 0;
    double difference = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const double sign = side == 0 ? 1.0 : -1.0;
      const std::size_t view = sample.at[side].view;
      const double made = now_[view].of(channel, sample.rgb[side][channel]);
      difference += sign * made;
      if (place[view] == SIZE_MAX) continue;
      at[count] = 2 * place[view];
      factor[count++] = sign * made / 128.0;
      at[count] = 2 * place[view] + 1;
      factor[count++] = sign;
    }
    for (std::size_t p = 0; p < count; ++p) {
      x[at[p]] -= weights_[i] * factor[p] * difference;
      for (std::size_t q = 0; q < count; ++q)
        m[at[p] * unknowns + at[q]] += weights_[i] * factor[p] * factor[q];
    }
  }
  for (std::size_t v = 0; v < now_.size(); ++v) {
    if (place[v] == SIZE_MAX) continue;
    const std::size_t gain = 2 * place[v];
    m[gain * unknowns + gain] += kGainRidge * weight[v];
    x[gain] -= kGainRidge * weight[v] * 128.0 * std::log(now_[v].gain[channel]);
    m[(gain + 1) * unknowns + gain + 1] += kOffsetRidge * weight[v];
    x[gain + 1] -= kOffsetRidge * weight[v] * now_[v].offset[channel];
  }
  if (!factorise(std::span(m).first(unknowns * unknowns), unknowns)) return;
  cupola::solve(m, unknowns, x);

  std::array<ViewColour, kMostViews> goal;
  double sum = 0.0;
  for (std::size_t v = 0; v < now_.size(); ++v) {
    goal[v] = now_[v];
    if (place[v] != SIZE_MAX) {
      const double grows = std::max(0.25, 1.0 + x[2 * place[v]] / 128.0);
      goal[v].gain[channel] *= grows;
      goal[v].offset[channel] = goal[v].offset[channel] * grows + x[2 * place[v] + 1];
    }
    sum += std::log(goal[v].gain[channel]);
  }
  // The geometric mean is 1: nobody's brightness is everybody's.
  const double common =
      anchored || free < now_.size() ? 1.0 : std::exp(-sum / static_cast<double>(now_.size()));
  for (std::size_t v = 0; v < now_.size(); ++v) {
    if (place[v] == SIZE_MAX) continue;
    ViewColour& to = goal[v];
    to.gain[channel] = std::clamp(common * to.gain[channel], ViewColour::kLeastGain, ViewColour::kMostGain);
    to.offset[channel] =
        std::clamp(common * to.offset[channel], -ViewColour::kMostOffset, ViewColour::kMostOffset);
    const double off = apart(to, now_[v], channel);
    moving_[v][channel] = off > (moving_[v][channel] ? kEnd : kBegin);
    if (!moving_[v][channel]) continue;
    now_[v].gain[channel] += share * (to.gain[channel] - now_[v].gain[channel]);
    now_[v].offset[channel] += share * (to.offset[channel] - now_[v].offset[channel]);
  }
}

bool ColourMatch::apply() noexcept {
  bool changed = false;
  for (std::size_t v = 0; v < now_.size(); ++v) {
    for (std::size_t channel = 0; channel < 3; ++channel)
      changed = changed || apart(now_[v], applied_[v], channel) >= kSeen;
  }
  if (changed) std::copy(now_.begin(), now_.end(), applied_.begin());
  return changed;
}

bool ColourMatch::look(std::span<const NativeImage> faces, unsigned seen,
                       std::chrono::nanoseconds now) noexcept {
  if (next_ < samples_.size()) {
    const std::size_t last = std::min(samples_.size(), next_ + kSamplesALook);
    for (; next_ < last; ++next_) measure(samples_[next_], faces, seen);
    return false;
  }
  if (samples_.empty()) return false;
  const double passed = std::chrono::duration<double>(now - solved_at_).count();
  solve(next_ - samples_.size(), -std::expm1(-std::clamp(passed, 0.0, kLongestStep) / kSeconds));
  if (++next_ < samples_.size() + 3) return false;
  next_ = 0;
  solved_at_ = now;
  return apply();
}

}  // namespace cupola
