// mmap and DMA_BUF_IOCTL_SYNC.
// SPDX-License-Identifier: MIT
#include "hal/camera/dma_buf_memory.h"

#include <cerrno>
#include <utility>

#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

namespace cupola {

namespace {

void synchronise(int descriptor, std::uint64_t flags) {
  dma_buf_sync sync{};
  sync.flags = flags;
  // The kernel asks to be called again when a signal came; more than a few of them are not waited for.
  for (int i = 0; i < 8; ++i) {
    if (ioctl(descriptor, DMA_BUF_IOCTL_SYNC, &sync) == 0 || (errno != EINTR && errno != EAGAIN)) return;
  }
}

}  // namespace

DmaBufMemory::DmaBufMemory(int descriptor, std::size_t bytes) noexcept
    : descriptor_(descriptor), bytes_(bytes) {
  void* address = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, descriptor, 0);
  if (address == MAP_FAILED) {
    error_ = errno;
  } else {
    data_ = static_cast<std::uint8_t*>(address);
  }
}

DmaBufMemory::~DmaBufMemory() {
  if (data_) munmap(data_, bytes_);
}

DmaBufMemory::DmaBufMemory(DmaBufMemory&& other) noexcept
    : descriptor_(other.descriptor_),
      data_(std::exchange(other.data_, nullptr)),
      bytes_(other.bytes_),
      error_(other.error_) {}

void DmaBufMemory::begin_reading() const noexcept {
  synchronise(descriptor_, DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ);
}

void DmaBufMemory::end_reading() const noexcept {
  synchronise(descriptor_, DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ);
}

}  // namespace cupola
