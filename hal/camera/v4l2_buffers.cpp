// REQBUFS, QUERYBUF, mmap and EXPBUF, and back again in reverse.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_buffers.h"

#include <algorithm>
#include <cerrno>

#include <fcntl.h>
#include <sys/mman.h>

namespace cupola {

namespace {

v4l2_buffer buffer_of(const V4l2Node& node, std::array<v4l2_plane, VIDEO_MAX_PLANES>& planes) noexcept {
  v4l2_buffer buffer{};
  buffer.type = node.type();
  buffer.memory = V4L2_MEMORY_MMAP;
  if (node.multi_planar) {
    planes = {};
    buffer.m.planes = planes.data();
    buffer.length = static_cast<__u32>(planes.size());
  }
  return buffer;
}

}  // namespace

std::optional<CameraTrouble> V4l2Buffers::request(const V4l2Node& node, const V4l2Layout& layout,
                                                  int count) noexcept {
  v4l2_requestbuffers wanted{};
  wanted.count = static_cast<__u32>(count);
  wanted.type = node.type();
  wanted.memory = V4L2_MEMORY_MMAP;
  if (const int error = node.ask(VIDIOC_REQBUFS, &wanted)) return refused("VIDIOC_REQBUFS", error);
  count_ = std::min<std::size_t>(wanted.count, kMost);
  memories_ = layout.memories;
  queued_.fill(false);
  if (count_ < 2) return CameraTrouble{CameraCause::kFailed, "VIDIOC_REQBUFS", ENOMEM};
  for (std::size_t index = 0; index < count_; ++index) {
    if (const auto trouble = map(node, layout, index)) return trouble;
  }
  for (std::size_t index = 0; index < count_; ++index) {
    if (const int error = queue(node, index)) return refused("VIDIOC_QBUF", error);
  }
  return std::nullopt;
}

std::optional<CameraTrouble> V4l2Buffers::map(const V4l2Node& node, const V4l2Layout& layout,
                                              std::size_t index) noexcept {
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes;
  v4l2_buffer buffer = buffer_of(node, planes);
  buffer.index = static_cast<__u32>(index);
  if (const int error = node.ask(VIDIOC_QUERYBUF, &buffer)) return refused("VIDIOC_QUERYBUF", error);
  for (std::size_t m = 0; m < memories_; ++m) {
    V4l2Memory& memory = memory_[index][m];
    const std::size_t bytes = node.multi_planar ? planes[m].length : buffer.length;
    const __u32 offset = node.multi_planar ? planes[m].m.mem_offset : buffer.m.offset;
    if (bytes < layout.memory_bytes[m]) return CameraTrouble{CameraCause::kChanged, "VIDIOC_QUERYBUF", 0};
    void* mapped = node.calls->mmap(bytes, node.descriptor, static_cast<long>(offset));
    if (mapped == MAP_FAILED) return refused("mmap", errno);
    memory = {static_cast<std::uint8_t*>(mapped), bytes, -1};
    v4l2_exportbuffer exported{};
    exported.type = node.type();
    exported.index = static_cast<__u32>(index);
    exported.plane = static_cast<__u32>(m);
    exported.flags = O_RDONLY | O_CLOEXEC;
    if (node.ask(VIDIOC_EXPBUF, &exported) == 0) memory.dma_buf = exported.fd;  // not every driver can
  }
  return std::nullopt;
}

void V4l2Buffers::release(const V4l2Node& node, bool stream_is_off) noexcept {
  for (auto& pieces : memory_) {
    for (V4l2Memory& memory : pieces) {
      if (memory.dma_buf >= 0) node.calls->close(memory.dma_buf);
      if (memory.data) node.calls->munmap(memory.data, memory.bytes);
      memory = {};
    }
  }
  if (count_ > 0 && stream_is_off) {
    v4l2_requestbuffers none{};
    none.type = node.type();
    none.memory = V4L2_MEMORY_MMAP;
    node.ask(VIDIOC_REQBUFS, &none);  // where it fails, closing the device frees them
  }
  count_ = 0;
}

int V4l2Buffers::queue(const V4l2Node& node, std::size_t index) noexcept {
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes;
  v4l2_buffer buffer = buffer_of(node, planes);
  if (node.multi_planar) buffer.length = static_cast<__u32>(memories_);
  buffer.index = static_cast<__u32>(index);
  const int error = node.ask(VIDIOC_QBUF, &buffer);
  if (error == 0) queued_[index] = true;
  return error;
}

int V4l2Buffers::dequeue(const V4l2Node& node, Filled& filled) noexcept {
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes;
  filled.buffer = buffer_of(node, planes);
  if (const int error = node.ask(VIDIOC_DQBUF, &filled.buffer)) return error;
  const std::size_t index = filled.buffer.index;
  if (index >= count_ || !queued_[index]) return EBADMSG;  // a buffer that the driver does not have
  queued_[index] = false;
  for (std::size_t m = 0; m < memories_; ++m) {
    const std::size_t all = memory_[index][m].bytes;
    const std::size_t end = node.multi_planar ? planes[m].bytesused : filled.buffer.bytesused;
    filled.begins[m] = std::min<std::size_t>(node.multi_planar ? planes[m].data_offset : 0, all);
    filled.used[m] = std::max(std::min(end, all), filled.begins[m]) - filled.begins[m];
  }
  filled.buffer.m.planes = nullptr;  // ours, and gone
  return 0;
}

}  // namespace cupola
