// The driver's buffers, mapped once a stream.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/camera/v4l2_format.h"
#include "hal/camera/v4l2_node.h"

namespace cupola {

struct V4l2Memory {
  std::uint8_t* data = nullptr;
  std::size_t bytes = 0;
  int dma_buf = -1;
};

class V4l2Buffers {
 public:
  static constexpr std::size_t kMost = 32;

  // Asks for `count` buffers, maps them and hands all to the driver. Where that fails, release() is due.
  std::optional<CameraTrouble> request(const V4l2Node& node, const V4l2Layout& layout, int count) noexcept;
  // Unmaps what there is, and frees it where the stream is off; else closing the device does.
  void release(const V4l2Node& node, bool stream_is_off) noexcept;

  // Hands a buffer to the driver; 0 or errno.
  int queue(const V4l2Node& node, std::size_t index) noexcept;
  // 0, or errno: EAGAIN when none is filled. `filled` says which and when, `used` the bytes in its pieces of
  // memory, headers of the driver's not among them, which end at `begins`.
  struct Filled {
    v4l2_buffer buffer{};
    std::array<std::size_t, 3> begins{};
    std::array<std::size_t, 3> used{};
  };
  int dequeue(const V4l2Node& node, Filled& filled) noexcept;

  std::size_t count() const { return count_; }
  bool is_lent(std::size_t index) const { return index < count_ && !queued_[index]; }
  const V4l2Memory& memory(std::size_t index, std::size_t m) const { return memory_[index][m]; }

 private:
  std::optional<CameraTrouble> map(const V4l2Node& node, const V4l2Layout& layout,
                                   std::size_t index) noexcept;

  std::size_t count_ = 0;
  std::size_t memories_ = 1;
  std::array<std::array<V4l2Memory, 3>, kMost> memory_{};
  std::array<bool, kMost> queued_{};
};

}  // namespace cupola
