// Making faces and comparing frames.
// SPDX-License-Identifier: MIT
#include "tests/warp/faces.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "pipeline/frame/still.h"

namespace cupola::test {

Rig omnimax_rig(Size frame, double diameter, Size face, const std::vector<std::string>& names) {
  Rig rig;
  rig.frame.size = frame;
  rig.frame.center = {diameter / 2, diameter / 2};
  rig.frame.radius = diameter / 2;
  rig.frame.lens = omnimax_c430();
  for (const std::string& name : names) {
    View view;
    view.name = name;
    named_pose(name, view);
    view.size = face;
    rig.views.push_back(view);
  }
  return rig;
}

Rig paper_rig(Size face) {
  return omnimax_rig({1966, 1436}, 1966, face, {"front", "left", "right", "top"});
}

namespace {

// Fills every texel of every view by put(view, x, y, buffer).
template <class Put>
Faces fill_faces(const Rig& rig, PixelFormat format, Put&& put) {
  Faces faces;
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    ImageBuffer buffer(format, rig.views[i].size);
    for (int y = 0; y < buffer.size().height; ++y) {
      for (int x = 0; x < buffer.size().width; ++x) put(static_cast<int>(i), x, y, buffer.pixels());
    }
    faces.buffers.push_back(std::move(buffer));
  }
  for (const ImageBuffer& buffer : faces.buffers) faces.images.push_back(buffer.pixels());
  return faces;
}

}  // namespace

Faces make_faces(const Rig& rig, const TexelFunction& texel, PixelFormat format) {
  return fill_faces(rig, format, [&](int view, int x, int y, const MutableImage& face) {
    for (int channel = 0; channel < 3; ++channel) {
      const unsigned value = texel(view, channel, x, y);
      if (format == PixelFormat::kRgbPlanar16) {
        face.samples<std::uint16_t>(channel, y)[x] = static_cast<std::uint16_t>(value);
      } else {
        face.samples<std::uint8_t>(channel, y)[x] = static_cast<std::uint8_t>(value);
      }
    }
  });
}

Faces make_faces(const Rig& rig, const std::function<Vec3(const Vec3&)>& colour, int side) {
  return fill_faces(rig, PixelFormat::kRgbPlanar8, [&](int view, int x, int y, const MutableImage& face) {
    Vec3 mean{0.0};
    for (int sample = 0; sample < side * side; ++sample) {
      const Vec2 at{x + (sample % side + 0.5) / side, y + (sample / side + 0.5) / side};
      mean += colour(direction_at(rig.views[static_cast<std::size_t>(view)], at));
    }
    for (int channel = 0; channel < 3; ++channel) {
      face.samples<std::uint8_t>(channel, y)[x] =
          static_cast<std::uint8_t>(std::clamp(mean[channel] / (side * side), 0.0, 1.0) * 255.0 + 0.5);
    }
  });
}

TexelFunction noise(unsigned seed, unsigned most) {
  auto random = std::make_shared<std::mt19937>(seed);
  return [random, most](int, int, int, int) {
    return std::uniform_int_distribution<unsigned>(0, most)(*random);
  };
}

TexelFunction checkerboard(int side) {
  return [side](int, int channel, int x, int y) {
    const bool white = (x / side + y / side) % 2 == 0;
    return white != (channel == 1) ? 255U : 0U;
  };
}

std::function<Vec3(const Vec3&)> photograph() {
  auto panorama = std::make_shared<ImageBuffer>(read_still(std::string(CUPOLA_GOLDEN) + "/mars.jpg"));
  return [panorama](const Vec3& d) {
    const Image picture = std::as_const(*panorama).pixels();
    const double u = (std::atan2(d.x, -d.z) / (2 * std::numbers::pi) + 0.5) * picture.size.width - 0.5;
    const double v =
        (0.5 - std::asin(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi) * picture.size.height - 0.5;
    const int x = static_cast<int>(std::floor(u));
    const int y = static_cast<int>(std::floor(v));
    Vec3 sum{0.0};
    for (int corner = 0; corner < 4; ++corner) {
      const int cx = (x + corner % 2 + picture.size.width) % picture.size.width;
      const int cy = std::clamp(y + corner / 2, 0, picture.size.height - 1);
      const double weight = (corner % 2 == 0 ? 1 - (u - x) : u - x) * (corner / 2 == 0 ? 1 - (v - y) : v - y);
      for (int channel = 0; channel < 3; ++channel) {
        sum[channel] += weight * picture.samples<std::uint8_t>(channel, cy)[cx] / 255.0;
      }
    }
    return sum;
  };
}

Difference difference(const Rig& rig, const Image& frame, const std::vector<double>& exact) {
  Difference found;
  double squares = 0.0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) {
      DirectionAndSlope looking;
      if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking) || owner(rig.views, looking.direction) < 0) continue;
      for (int channel = 0; channel < 3; ++channel) {
        const double value = frame.format == PixelFormat::kRgbPlanar16
                                 ? frame.samples<std::uint16_t>(channel, y)[x]
                                 : frame.samples<std::uint8_t>(channel, y)[x];
        const double error =
            std::abs(value - exact[(static_cast<std::size_t>(y) * frame.size.width + x) * 3 + channel]);
        squares += error * error;
        ++found.samples;
        if (error > found.max) {
          found.max = error;
          found.x = x;
          found.y = y;
        }
      }
    }
  }
  found.rms = std::sqrt(squares / static_cast<double>(std::max<std::int64_t>(1, found.samples)));
  return found;
}

bool same_pixels(const Image& a, const Image& b) {
  if (a.format != b.format || !(a.size == b.size)) return false;
  const auto row_bytes = static_cast<std::size_t>(a.size.width) * pixel_step(a.format);
  for (int plane = 0; plane < plane_count(a.format); ++plane) {
    for (int y = 0; y < a.size.height; ++y) {
      if (std::memcmp(a.planes[plane].row(y), b.planes[plane].row(y), row_bytes) != 0) return false;
    }
  }
  return true;
}

}  // namespace cupola::test
