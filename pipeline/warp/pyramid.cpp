// One separable reduction a level, rows first summed down and then across.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/pyramid.h"

#include <algorithm>
#include <cmath>

#include "pipeline/portable/portable_math.h"
#include "pipeline/warp/quantise.h"

namespace cupola {
namespace {

constexpr int kShift = 14;
constexpr int kMostParts =
    64;  // a level's rows are shared out in this many parts, each with a line of its own

int reduced(int side, double scale) {
  return std::max(1, static_cast<int>(std::lround(side / scale)));
}

// The inputs that a span of outputs is made from.
RowSpan columns_of(const LineReduction& across, RowSpan outputs) {
  const ReductionTaps& last = across.taps[static_cast<std::size_t>(outputs.last) - 1];
  return {across.taps[static_cast<std::size_t>(outputs.first)].first, last.first + last.count};
}

}  // namespace

PyramidShape shape_pyramid(const Rig& rig, Reduction reduction) {
  PyramidShape shape{reduction, {}};
  const int octave = reduction == Reduction::kGaussian ? kLevelsAnOctave : 1;
  for (int i = 0;; ++i) {
    PyramidLevel level;
    // Between octaves from a level that is well finer, so that a Gaussian is wide enough for its samples.
    level.parent = i % octave == 0 ? i - octave : std::max(0, i / octave - 1) * octave;
    level.scale = std::exp2(static_cast<double>(i) / octave);
    int largest = 0;
    for (const View& view : rig.views) {
      level.sizes.push_back({reduced(view.size.width, level.scale), reduced(view.size.height, level.scale)});
      largest = std::max({largest, level.sizes.back().width, level.sizes.back().height});
    }
    shape.levels.push_back(std::move(level));
    if (largest <= 1) return shape;
  }
}

LineReduction reduce_line(int from, int to, Reduction reduction, double from_variance) {
  LineReduction line;
  const double ratio = static_cast<double>(from) / to;
  // What is missing of the level's own variance, in texels^2 of the source.
  const double variance = std::max(1e-3, kLevelVariance * ratio * ratio - from_variance);
  const double reach = reduction == Reduction::kBox ? ratio / 2 : 3.2 * std::sqrt(variance);
  std::vector<Tap> taps;
  std::vector<int> weights;
  for (int i = 0; i < to; ++i) {
    const double centre = (i + 0.5) * ratio;
    taps.clear();
    double sum = 0.0;
    for (int k = std::max(0, static_cast<int>(std::floor(centre - reach)));
         k < std::min<int>(from, static_cast<int>(std::ceil(centre + reach))); ++k) {
      const double distance = k + 0.5 - centre;
      const double weight = reduction == Reduction::kBox
                                ? std::min(k + 1.0, centre + reach) - std::max<double>(k, centre - reach)
                                : portable::exponential(-distance * distance / (2.0 * variance));
      taps.push_back({k, 0, 0, weight});
      sum += weight;
    }
    for (Tap& tap : taps) tap.weight /= sum;
    quantise(taps, 1 << kShift, 1 << kShift, weights);
    std::size_t first = 0;
    std::size_t last = weights.size();
    while (weights[first] == 0) ++first;
    while (weights[last - 1] == 0) --last;
    line.taps.push_back({taps[first].x, static_cast<std::int32_t>(last - first),
                         static_cast<std::uint32_t>(line.weights.size())});
    for (std::size_t k = first; k < last; ++k) line.weights.push_back(static_cast<std::uint16_t>(weights[k]));
  }
  return line;
}

Pyramid::Pyramid(const PyramidShape& shape, std::vector<TexelSpans> used)
    : views_(shape.views()), made_(std::move(used)), images_(made_.size()) {
  // From the smallest level up, since each adds to what its parent must have.
  for (std::size_t to = made_.size(); to-- > views_;) {
    made_[to].join();
    Step step;
    step.to = to;
    const PyramidLevel& level = shape.levels[to / views_];
    const std::size_t view = to % views_;
    step.from = static_cast<std::size_t>(level.parent) * views_ + view;
    const TexelSpans& wanted = made_[to];
    for (int y = 0; y < wanted.size.height; ++y) {
      if (!wanted.rows[static_cast<std::size_t>(y)].empty()) step.rows.push_back(y);
    }
    if (step.rows.empty()) continue;
    const Size from = shape.levels[static_cast<std::size_t>(level.parent)].sizes[view];
    const double variance = level.parent == 0 ? 0.0 : kLevelVariance;
    step.across = reduce_line(from.width, wanted.size.width, shape.reduction, variance);
    step.down = reduce_line(from.height, wanted.size.height, shape.reduction, variance);
    for (const int y : step.rows) {
      const ReductionTaps& down = step.down.taps[static_cast<std::size_t>(y)];
      for (const RowSpan& span : wanted.rows[static_cast<std::size_t>(y)]) {
        const RowSpan columns = columns_of(step.across, span);
        for (int v = down.first; v < down.first + down.count; ++v) made_[step.from].add(v, columns);
      }
    }
    images_[to] = ImageBuffer(PixelFormat::kRgbPlanar16, wanted.size);
    line_ = std::max(line_, static_cast<std::size_t>(from.width));
    steps_.push_back(std::move(step));
  }
  for (std::size_t face = 0; face < views_; ++face) {
    needed_.push_back(NeededRegion::none(made_[face].size));
    for (int y = 0; y < made_[face].size.height; ++y) {
      for (const RowSpan& span : made_[face].rows[static_cast<std::size_t>(y)]) {
        needed_.back().include(span.first, y);
        needed_.back().include(span.last - 1, y);
      }
    }
  }
  std::reverse(steps_.begin(), steps_.end());
  if (!steps_.empty()) lines_.resize(line_ * kMostParts);
}

std::size_t Pyramid::bytes() const {
  std::size_t sum = lines_.size() * sizeof(std::uint32_t);
  for (const ImageBuffer& image : images_) sum += image.bytes();
  return sum;
}

void Pyramid::build(std::span<const Image> faces, WorkerPool& pool) noexcept {
  for (const Step& step : steps_) {
    const Image source = step.from < views_ ? faces[step.from] : image(step.from);
    const auto rows = static_cast<int>(step.rows.size());
    const int parts = std::min(rows, kMostParts);
    pool.run(parts, [&](int part) {
      const std::span<std::uint32_t> line(lines_.data() + static_cast<std::size_t>(part) * line_, line_);
      for (int i = rows * part / parts; i < rows * (part + 1) / parts; ++i) {
        const int row = step.rows[static_cast<std::size_t>(i)];
        for (const RowSpan& span : made_[step.to].rows[static_cast<std::size_t>(row)]) {
          make_span(step, source, row, span, line);
        }
      }
    });
  }
}

// Weights sum to 2^14 and samples are below 2^16: sums stay below 2^30. Samples of 8 bits are summed as they
// are and shifted by 8 less.
template <class Sample>
void Pyramid::add_rows(const Step& step, const Image& source, int channel, int row, RowSpan columns,
                       std::span<std::uint32_t> line) noexcept {
  constexpr int kDown = sizeof(Sample) == 1 ? kShift - 8 : kShift;
  const ReductionTaps& down = step.down.taps[static_cast<std::size_t>(row)];
  const std::uint16_t* weights = step.down.weights.data() + down.weights;
  std::uint32_t* const sums = line.data();
  std::fill(sums + columns.first, sums + columns.last, 1U << (kDown - 1));
  for (int k = 0; k < down.count; ++k) {
    const Sample* samples = source.samples<Sample>(channel, down.first + k);
    const std::uint16_t weight = weights[k];
    for (int x = columns.first; x < columns.last; ++x) {
      // Sixteen bits times sixteen: what compilers have an instruction for.
      const std::uint16_t sample = samples[x];
      sums[x] += std::uint32_t{weight} * std::uint32_t{sample};
    }
  }
  for (int x = columns.first; x < columns.last; ++x) sums[x] >>= kDown;
}

void Pyramid::make_span(const Step& step, const Image& source, int row, RowSpan span,
                        std::span<std::uint32_t> line) noexcept {
  const RowSpan columns = columns_of(step.across, span);
  for (int channel = 0; channel < 3; ++channel) {
    if (source.format == PixelFormat::kRgbPlanar16) {
      add_rows<std::uint16_t>(step, source, channel, row, columns, line);
    } else {
      add_rows<std::uint8_t>(step, source, channel, row, columns, line);
    }
    auto* const out = images_[step.to].pixels().samples<std::uint16_t>(channel, row);
    for (int x = span.first; x < span.last; ++x) {
      const ReductionTaps& taps = step.across.taps[static_cast<std::size_t>(x)];
      const std::uint16_t* weights = step.across.weights.data() + taps.weights;
      const std::uint32_t* samples = line.data() + taps.first;
      std::uint32_t sum = 1U << (kShift - 1);
      for (int k = 0; k < taps.count; ++k) sum += weights[k] * samples[k];
      out[x] = static_cast<std::uint16_t>(sum >> kShift);
    }
  }
}

}  // namespace cupola
