// Random pixels of random rigs: the table builder's footprints against the reference, and what quantise()
// makes of them. CUPOLA_STRESS_PIXELS says how many; `./run stress` draws ten million.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <string>
#include <tuple>

#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/footprint.h"
#include "pipeline/warp/optimal_exact.h"
#include "pipeline/warp/quantise.h"
#include "pipeline/warp/warp_table.h"
#include "tests/stress/random_rigs.h"

namespace cupola {
namespace {

constexpr int kPixelsARig = 250;
// The reference of least squares takes milliseconds: every so many pixels it is asked, and for windows of up
// to 6 x 6 texels.
constexpr int kPixelsAnExact = 25;
constexpr double kWidestExact = 3.6;   // texels, of the larger side of a pixel's box
constexpr double kMostUnlike = 0.006;  // root of the weights' summed squared differences

std::string shortest(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

std::int64_t pixels_wanted() {
  const char* wanted = std::getenv("CUPOLA_STRESS_PIXELS");
  return wanted != nullptr ? std::max(1LL, std::atoll(wanted)) : 30'000;
}

struct Tally {
  std::int64_t pixels = 0;
  std::int64_t covered = 0;
  std::int64_t with_negative = 0;  // weights
  std::int64_t least_squares = 0;  // footprints compared with their reference
  std::int64_t cut = 0;            // by the edge of all views, and not compared
  std::int64_t across_views = 0;
  std::int64_t on_the_rim = 0;  // a texel lies on a footprint's very rim
  std::int64_t too_wide = 0;    // left to EllipseStress
  std::int64_t most_taps = 0;
  double largest_error = 0.0;   // relative
  double largest_unlike = 0.0;  // of least squares

  void add(const Tally& other) {
    pixels += other.pixels;
    covered += other.covered;
    with_negative += other.with_negative;
    least_squares += other.least_squares;
    cut += other.cut;
    across_views += other.across_views;
    on_the_rim += other.on_the_rim;
    too_wide += other.too_wide;
    most_taps = std::max(most_taps, other.most_taps);
    largest_error = std::max(largest_error, other.largest_error);
    largest_unlike = std::max(largest_unlike, other.largest_unlike);
  }
};

// Everything that must hold for one rig; the first thing that does not ends it, with its story in fault().
class RigCheck {
 public:
  RigCheck(std::uint64_t seed, const test::NoiseFaces& noise)
      : dice_(seed), rig_(test::random_rig(dice_)), faces_(noise.faces(rig_)), gatherer_(rig_) {}

  void run() {
    for (int i = 0; i < kPixelsARig && fault_.empty(); ++i) {
      const test::Pixel pixel = test::random_pixel(dice_, rig_);
      check(pixel.x, pixel.y, i);
      if (!fault_.empty()) fault_ += " at pixel " + std::to_string(i);
    }
  }
  const std::string& fault() const { return fault_; }
  const Tally& tally() const { return tally_; }

 private:
  bool expect(bool good, const std::string& what) {
    if (!good && fault_.empty()) fault_ = what;
    return good;
  }

  // Footprints of half the world take seconds where the views are large.
  bool too_wide(int x, int y) const {
    DirectionAndSlope looking;
    ViewSample at;
    if (!ray(rig_.frame, {x + 0.5, y + 0.5}, looking)) return false;
    const int home = owner(rig_.views, looking.direction);
    if (home < 0 || !project(rig_.views[static_cast<std::size_t>(home)], looking.direction, at)) return false;
    const double own = rig_.filter.radius * (smallest_axis(rig_.filter) + std::sqrt(rig_.filter.rec));
    const auto reach = [&](const Vec3& gradient) {
      return own + rig_.filter.radius *
                       std::hypot(glm::dot(gradient, looking.d_da), glm::dot(gradient, looking.d_db));
    };
    double texels = 0.0;
    for (const View& view : rig_.views) texels += 1.0 * view.size.width * view.size.height;
    const View& view = rig_.views[static_cast<std::size_t>(home)];
    const Size size = view.size;
    if (view.distortion != Distortion::kNone || texels > 30'000.0) {
      // As angle_around() in ewa_exact.cpp has it; past half a radian of bent views all texels are looked at.
      const double half = (glm::dot(at.du, at.du) - glm::dot(at.dv, at.dv)) / 2;
      const double mean = (glm::dot(at.du, at.du) + glm::dot(at.dv, at.dv)) / 2;
      const double fewest = mean - std::hypot(half, glm::dot(at.du, at.dv));
      if (std::hypot(reach(at.du), reach(at.dv)) > 0.2 * std::sqrt(std::max(1e-12, fewest))) return true;
    }
    return texels > 30'000.0 && (reach(at.du) > size.width / 10.0 || reach(at.dv) > size.height / 10.0);
  }

  bool least_squares() const { return rig_.filter.kernel == Kernel::kOptimal; }

  void check(int x, int y, int index) {
    ++tally_.pixels;
    if (too_wide(x, y)) {
      ++tally_.too_wide;
      return;
    }
    const Footprint found = gatherer_.gather(x, y, taps_);
    if (taps_.size() > static_cast<std::size_t>(kMostTaps)) return;  // the builder refuses those
    if (!expect(taps_.empty() == (found != Footprint::kCovered), "covered without taps, or the reverse"))
      return;
    double weights = 0.0;
    bool negative = false;
    for (const Tap& tap : taps_) {
      if (!sound(tap)) return;
      weights += tap.weight;
      negative = negative || tap.weight < 0.0;
    }
    if (!least_squares()) {
      if (!like_the_reference(x, y)) return;
    } else if (index % kPixelsAnExact == 0 && found == Footprint::kCovered) {
      if (!like_least_squares(x, y)) return;
    }
    if (found != Footprint::kCovered) return;
    ++tally_.covered;
    tally_.with_negative += negative ? 1 : 0;
    tally_.across_views += taps_.front().view != taps_.back().view ? 1 : 0;
    tally_.most_taps = std::max<std::int64_t>(tally_.most_taps, static_cast<std::int64_t>(taps_.size()));
    if (!expect(std::abs(weights - 1.0) <= 1e-12,
                "the weights sum to 1 + " + shortest(weights - 1.0) + story(x, y)))
      return;
    check_integers(negative);
    check_places();
  }

  // Whether the texels' sum is the reference's; false, too, for pixels that must not be looked at further.
  bool like_the_reference(int x, int y) {
    const auto exact = ewa_exact(rig_, faces_, x, y);
    std::array<double, 3> sum{};
    for (const Tap& tap : taps_) {
      for (int c = 0; c < 3; ++c)
        sum[c] += tap.weight * faces_[tap.view].samples<std::uint8_t>(c, tap.y)[tap.x];
    }
    for (int c = 0; c < 3; ++c) {
      const double error = std::abs(sum[c] - exact[c]) / std::max(1.0, std::abs(exact[c]));
      if (!(error < 1e-6)) {
        if (on_the_rim(x, y)) {
          ++tally_.on_the_rim;
          return false;
        }
        expect(false, "the reference has " + std::to_string(exact[c]) + ", not " + std::to_string(sum[c]) +
                          story(x, y));
        return false;
      }
      tally_.largest_error = std::max(tally_.largest_error, error);
    }
    return true;
  }

  // The same for least squares, weight by weight.
  bool like_least_squares(int x, int y) {
    DirectionAndSlope looking;
    ViewSample at;
    ray(rig_.frame, {x + 0.5, y + 0.5}, looking);
    const int home = owner(rig_.views, looking.direction);
    project(rig_.views[static_cast<std::size_t>(home)], looking.direction, at);
    for (const Vec3& gradient : {at.du, at.dv}) {
      if (std::abs(glm::dot(gradient, looking.d_da)) + std::abs(glm::dot(gradient, looking.d_db)) >
          kWidestExact)
        return true;
    }
    std::map<std::tuple<int, int, int>, double> weights;
    for (const Tap& tap : optimal_exact(rig_, home, looking, at))
      weights[{tap.view, tap.y, tap.x}] += tap.weight;
    double sum = 0.0;
    double magnitude = 0.0;
    for (const auto& [place, weight] : weights) {
      sum += weight;
      magnitude += std::abs(weight);
    }
    // Cut by the edge of all views, where negative weights are dropped.
    if (!(sum > (kLeastSignedShare + 0.01) * magnitude)) {
      ++tally_.cut;
      return true;
    }
    for (auto& [place, weight] : weights) weight /= sum;
    for (const Tap& tap : taps_) weights[{tap.view, tap.y, tap.x}] -= tap.weight;
    double squares = 0.0;
    for (const auto& [place, difference] : weights) squares += difference * difference;
    ++tally_.least_squares;
    tally_.largest_unlike = std::max(tally_.largest_unlike, std::sqrt(squares));
    return expect(std::sqrt(squares) < kMostUnlike,
                  "weights differ from least squares by " + std::to_string(std::sqrt(squares)) + story(x, y));
  }

  // What a fault needs to be understood.
  std::string story(int x, int y) const {
    DirectionAndSlope looking;
    ray(rig_.frame, {x + 0.5, y + 0.5}, looking);
    const int home = owner(rig_.views, looking.direction);
    const View& view = rig_.views[static_cast<std::size_t>(home)];
    ViewSample at;
    project(view, looking.direction, at);
    const double ux = glm::dot(at.du, looking.d_da);
    const double uy = glm::dot(at.du, looking.d_db);
    const double vx = glm::dot(at.dv, looking.d_da);
    const double vy = glm::dot(at.dv, looking.d_db);
    char text[460];
    std::snprintf(
        text, sizeof text,
        "; frame model %d, lens %d, radius %g; %zu views, home %d of %d x %d, focal %g %g, distortion %d, "
        "limit %g; (u, v) %g %g, J %g %g %g %g; kernel %d, alpha %g, radius %g, rec %g, noise %g; %zu taps",
        static_cast<int>(rig_.frame.model), static_cast<int>(rig_.frame.lens.model), rig_.frame.radius,
        rig_.views.size(), home, view.size.width, view.size.height, view.focal.x, view.focal.y,
        static_cast<int>(view.distortion), view.limit, at.uv.x, at.uv.y, ux, uy, vx, vy,
        static_cast<int>(rig_.filter.kernel), rig_.filter.alpha, rig_.filter.radius, rig_.filter.rec,
        rig_.filter.noise, taps_.size());
    return text;
  }

  bool sound(const Tap& tap) {
    const View& view = rig_.views[static_cast<std::size_t>(tap.view)];
    const bool in_range = rig_.filter.kernel == Kernel::kGaussian
                              ? tap.weight > 0.0 && tap.weight <= 1.0 + 1e-12
                              : tap.weight >= -1.0 && tap.weight <= 2.0;
    if (!expect(std::isfinite(tap.weight) && in_range, "a weight is " + std::to_string(tap.weight)))
      return false;
    if (!expect(tap.x >= 0 && tap.y >= 0 && tap.x < view.size.width && tap.y < view.size.height,
                "a tap is outside its view"))
      return false;
    if (least_squares()) return true;  // texels of other views are estimated from all around them
    return expect(owner(rig_.views, direction_at(view, {tap.x + 0.5, tap.y + 0.5})) == tap.view,
                  "a tap belongs to another view");
  }

  // Whether the answer hangs on the last bits of a texel's distance: it jumps when the radius changes by a
  // billionth.
  bool on_the_rim(int x, int y) {
    Rig changed = rig_;
    changed.filter.radius = rig_.filter.radius * (1.0 - 1e-9);
    const auto less = ewa_exact(changed, faces_, x, y);
    changed.filter.radius = rig_.filter.radius * (1.0 + 1e-9);
    const auto more = ewa_exact(changed, faces_, x, y);
    for (int c = 0; c < 3; ++c) {
      if (std::abs(less[c] - more[c]) > 5e-7) return true;
    }
    return false;
  }

  void check_integers(bool negative) {
    const std::array<int, 3> unsigned_bits = {kLeastBits8, kMostBits8, kBits16};
    const std::array<int, 3> signed_bits = {kLeastSignedBits8, kMostSignedBits8, kSignedBits16};
    for (const int bits : negative ? signed_bits : unsigned_bits) {
      if (!expect(quantise(taps_, 1 << bits, 2 << bits, integers_), "weights were refused")) return;
      if (!expect(negative || *std::min_element(integers_.begin(), integers_.end()) >= 0,
                  "an integer weight is negative, but no real one"))
        return;
      if (!expect(std::accumulate(integers_.begin(), integers_.end(), 0) == 1 << bits,
                  "integer weights do not sum to 2^" + std::to_string(bits)))
        return;
    }
  }

  void check_places() {
    const auto place = [](const Tap& tap) { return std::tuple(tap.view, tap.y, tap.x); };
    std::sort(taps_.begin(), taps_.end(), [&](const Tap& a, const Tap& b) { return place(a) < place(b); });
    const auto twice = std::adjacent_find(taps_.begin(), taps_.end(),
                                          [&](const Tap& a, const Tap& b) { return place(a) == place(b); });
    expect(twice == taps_.end(), "a texel is there twice");
  }

  test::Dice dice_;
  Rig rig_;
  std::vector<Image> faces_;
  FootprintGatherer gatherer_;
  std::vector<Tap> taps_;
  std::vector<int> integers_;
  std::string fault_;
  Tally tally_;
};

// Of this rig: one texel of the home view's plane is a stripe of some 600 texels of another view, each of
// them faint, all together more than a hundredth of the pixel.
TEST(FootprintStress, FaintTexelsAreLeftOutOnlyWhereTheyAreFew) {
  const test::NoiseFaces noise(1);
  RigCheck check(350, noise);
  check.run();
  EXPECT_EQ(check.fault(), "");
}

TEST(FootprintStress, RandomPixelsOfRandomRigsAreTheReferences) {
  const test::NoiseFaces noise(1);
  const auto rigs = static_cast<int>((pixels_wanted() + kPixelsARig - 1) / kPixelsARig);
  const char* only = std::getenv("CUPOLA_STRESS_SEED");
  const int first = only != nullptr ? std::atoi(only) : 0;
  WorkerPool pool(0);
  std::mutex adding;
  Tally all;
  int faults = 0;
  pool.run(only != nullptr ? 1 : rigs, [&](int i) {
    RigCheck check(static_cast<std::uint64_t>(first + i), noise);
    check.run();
    const std::lock_guard lock(adding);
    all.add(check.tally());
    if (!check.fault().empty() && ++faults <= 20)
      ADD_FAILURE() << "seed " << first + i << ": " << check.fault();
  });
  std::printf(
      "%lld pixels, %lld covered, %lld across views, at most %lld taps; error at most %.2e, %lld on a rim, "
      "%lld too wide; %lld with negative weights, %lld beside least squares, %lld cut, unlike by at most "
      "%.2e\n",
      static_cast<long long>(all.pixels), static_cast<long long>(all.covered),
      static_cast<long long>(all.across_views), static_cast<long long>(all.most_taps), all.largest_error,
      static_cast<long long>(all.on_the_rim), static_cast<long long>(all.too_wide),
      static_cast<long long>(all.with_negative), static_cast<long long>(all.least_squares),
      static_cast<long long>(all.cut), all.largest_unlike);
  EXPECT_EQ(faults, 0);
  EXPECT_LE(all.cut, 2 + all.least_squares / 20);
  EXPECT_GT(all.covered, only == nullptr ? all.pixels / 8 : -1);
  EXPECT_GT(all.with_negative, only == nullptr ? all.covered / 10 : -1);
  EXPECT_GT(all.least_squares, only == nullptr ? all.pixels / 4'000 : -1);
  EXPECT_LE(all.on_the_rim, 2 + all.pixels / 10'000);
}

}  // namespace
}  // namespace cupola
