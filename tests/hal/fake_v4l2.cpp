// Descriptors, mappings and calls that fail on order; what a device does lies in fake_v4l2_node.cpp.
// SPDX-License-Identifier: MIT
#include "tests/hal/fake_v4l2.h"

#include <algorithm>
#include <cerrno>

#include <fcntl.h>
#include <sys/mman.h>

#include "tests/hal/fake_v4l2_node.h"
#include "tests/hal/heap_allocations.h"

namespace cupola {

FakeV4l2::FakeV4l2(FakeClock& clock) : clock_(clock) {
  for (int i = 0; i < 16; ++i) free_alarms_.push_back(clock.add_alarm());
}

FakeV4l2::~FakeV4l2() = default;

FakeV4l2Node& FakeV4l2::add(FakeV4l2Device device) {
  nodes_.push_back(std::make_unique<FakeV4l2Node>(clock_, ledger_, std::move(device)));
  return *nodes_.back();
}

void FakeV4l2::fail(unsigned long call, std::uint64_t nth, int error, bool for_good) {
  failing_ = call;
  until_failure_ = nth;
  failure_ = error;
  for_good_ = for_good;
  has_failed_ = false;
}

bool FakeV4l2::fails(unsigned long call) noexcept {
  ++calls_;
  if (call != failing_) return false;
  if (until_failure_ > 0 && --until_failure_ > 0) return false;
  if (has_failed_ && !for_good_) return false;
  has_failed_ = true;
  errno = failure_;
  return true;
}

std::string FakeV4l2::complaints() const {
  std::string text;
  for (const std::string& wrong : ledger_.misuse) text += wrong + "\n";
  if (!files_.empty()) text += std::to_string(files_.size()) + " descriptors open\n";
  if (!ledger_.mappings.empty()) text += std::to_string(ledger_.mappings.size()) + " mappings left\n";
  if (!ledger_.dma_bufs.empty()) text += std::to_string(ledger_.dma_bufs.size()) + " DMA-BUFs open\n";
  return text;
}

FakeV4l2File* FakeV4l2::file(int descriptor) {
  for (const auto& open : files_) {
    if (open->descriptor == descriptor) return open.get();
  }
  ledger_.misuse.push_back("descriptor " + std::to_string(descriptor) + " is not open");
  errno = EBADF;
  return nullptr;
}

int FakeV4l2::open(const char* path, int flags) noexcept {
  const UncountedHeap of_the_kernel;
  if ((flags & (O_RDWR | O_NONBLOCK | O_CLOEXEC)) != (O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
    ledger_.misuse.push_back("open without O_RDWR, O_NONBLOCK or O_CLOEXEC");
  }
  const auto found = std::ranges::find_if(
      nodes_, [&](const auto& node) { return !node->is_unplugged() && node->path() == path; });
  if (found == nodes_.end()) {
    errno = ENOENT;
    return -1;
  }
  if (fails(kOpen)) return -1;
  if (free_alarms_.empty()) {
    errno = EMFILE;
    return -1;
  }
  auto file = std::make_unique<FakeV4l2File>();
  file->descriptor = free_alarms_.front();
  free_alarms_.pop_front();
  file->node = found->get();
  clock_.set_alarm(file->descriptor, std::chrono::nanoseconds::max());
  file->node->join(*file);
  files_.push_back(std::move(file));
  return files_.back()->descriptor;
}

int FakeV4l2::close(int descriptor) noexcept {
  const UncountedHeap of_the_kernel;
  const bool failed = fails(kClose);
  if (std::erase(ledger_.dma_bufs, descriptor) > 0) return failed ? -1 : 0;
  FakeV4l2File* closed = file(descriptor);
  if (!closed) return -1;
  closed->node->leave(*closed);
  free_alarms_.push_back(descriptor);
  std::erase_if(files_, [&](const auto& open) { return open.get() == closed; });
  if (failed) errno = failure_;
  return failed ? -1 : 0;
}

int FakeV4l2::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  const UncountedHeap of_the_kernel;
  FakeV4l2File* asked = file(descriptor);
  if (!asked) return -1;
  if (fails(request)) return -1;
  const int error = asked->gone ? ENODEV : asked->node->ioctl(*asked, request, argument);
  if (error == 0) return 0;
  errno = error;
  return -1;
}

void* FakeV4l2::mmap(std::size_t length, int descriptor, long offset) noexcept {
  const UncountedHeap of_the_kernel;
  FakeV4l2File* asked = file(descriptor);
  if (!asked || fails(kMmap)) return MAP_FAILED;
  if (asked->gone) {
    errno = ENODEV;
    return MAP_FAILED;
  }
  return asked->node->map(length, offset);
}

int FakeV4l2::munmap(void* address, std::size_t length) noexcept {
  const UncountedHeap of_the_kernel;
  const auto mapping = ledger_.mappings.find(address);
  if (mapping == ledger_.mappings.end() || mapping->second.length != length) {
    ledger_.misuse.push_back("munmap of what is not mapped");
    errno = EINVAL;
    return -1;
  }
  ledger_.mappings.erase(mapping);
  return fails(kMunmap) ? -1 : 0;
}

}  // namespace cupola
