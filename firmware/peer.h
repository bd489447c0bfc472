// A well-known resampler to measure ours against, where it was found when this was built.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

enum class PeerFilter : std::uint8_t { kBilinear, kLanczos4 };

// OpenCV's remap, INTER_LINEAR or INTER_LANCZOS4 with fixed-point CV_16SC2 maps, 8UC3, one thread, from an
// atlas of all faces.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string name() const = 0;
  virtual void warp() = 0;
  virtual Image frame() const = 0;  // kRgb8, valid after warp()
};

// Null when this program was built without OpenCV. `faces` are copied.
std::unique_ptr<Peer> make_peer(const Rig& rig, std::span<const Image> faces, PeerFilter filter,
                                WorkerPool& pool);

}  // namespace cupola
