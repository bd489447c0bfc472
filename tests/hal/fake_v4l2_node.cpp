// Buffers and frames, with the kernel's rules for them.
// SPDX-License-Identifier: MIT
#include "tests/hal/fake_v4l2_node.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <sys/mman.h>

namespace cupola {

using std::chrono::nanoseconds;

FakeV4l2Node::FakeV4l2Node(FakeClock& clock, FakeV4l2Ledger& ledger, FakeV4l2Device device)
    : clock_(clock), ledger_(ledger), device_(std::move(device)), rate_(device_.rate) {
  settings_ = {device_.fourccs.front(), static_cast<__u32>(device_.width),
               static_cast<__u32>(device_.height)};
  crop_ = {0, 0, settings_.width, settings_.height};
}

void FakeV4l2Node::begin_fault(CameraFault fault, std::int64_t amount) {
  catch_up();
  faults_.push_back({fault, amount});
  if (fault == CameraFault::kUnplugged) {
    for (FakeV4l2File* file : files_) file->gone = true;
    stop();
  }
  if (fault == CameraFault::kNoSignal) send_event(V4L2_EVENT_SOURCE_CHANGE);
  wind_alarms();
}

void FakeV4l2Node::end_faults() {
  catch_up();
  const bool signal = has(CameraFault::kNoSignal) != nullptr;
  faults_.clear();
  if (signal) send_event(V4L2_EVENT_SOURCE_CHANGE);
  wind_alarms();
}

void FakeV4l2Node::send_event(__u32 type) {
  for (FakeV4l2File* file : files_) {
    if (std::ranges::count(file->subscriptions, type) == 0) continue;
    v4l2_event event{};
    event.type = type;
    file->events.push_back(event);
  }
  wind_alarms();
}

void FakeV4l2Node::join(FakeV4l2File& file) {
  files_.push_back(&file);
}

void FakeV4l2Node::leave(FakeV4l2File& file) {
  std::erase(files_, &file);
  if (owner_ != &file) return;
  stop();
  owner_ = nullptr;
  buffers_.clear();
}

void FakeV4l2Node::stop() {
  streaming_ = false;
  queued_.clear();
  done_.clear();
  for (Buffer& buffer : buffers_) buffer.place = Buffer::Place::kCaller;
}

const FakeV4l2Node::Fault* FakeV4l2Node::has(CameraFault kind) const {
  const auto found = std::ranges::find(faults_, kind, &Fault::kind);
  return found == faults_.end() ? nullptr : &*found;
}

bool FakeV4l2Node::hits(CameraFault kind) const {
  const Fault* found = has(kind);
  if (!found) return false;
  const auto percent = static_cast<std::uint64_t>(found->amount);
  return (made_ + 1) * percent / 100 != made_ * percent / 100;
}

int FakeV4l2Node::misuse(const char* what, int error) {
  ledger_.misuse.emplace_back(what);
  return error;
}

v4l2_buf_type FakeV4l2Node::type() const {
  return device_.multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

nanoseconds FakeV4l2Node::due(std::uint64_t frame) const {
  return started_at_ + nanoseconds(static_cast<std::int64_t>(1e9 / rate_ * static_cast<double>(frame + 1)));
}

void FakeV4l2Node::catch_up() {
  for (nanoseconds when{}; streaming_ && (when = due(next_)) <= clock_.now();) {
    ++next_;
    if (has(CameraFault::kSilent) || has(CameraFault::kNoSignal)) continue;
    const __u32 sequence = sequence_++;
    const bool dropped = hits(CameraFault::kDropped);
    const bool damaged = hits(CameraFault::kDamaged);
    ++made_;
    if (dropped || queued_.empty() || past_end_) continue;
    Buffer& buffer = buffers_[queued_.front()];
    done_.push_back(queued_.front());
    queued_.pop_front();
    buffer.sequence = sequence;
    buffer.flags = device_.stamps ? V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC : V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
    if (damaged) buffer.flags |= V4L2_BUF_FLAG_ERROR;
    past_end_ = ended_;
    fill(buffer, when);
  }
}

void FakeV4l2Node::fill(Buffer& buffer, nanoseconds when) {
  buffer.place = Buffer::Place::kDone;
  buffer.stamp_ns = device_.stamps ? static_cast<std::uint64_t>(when.count()) : 12345;
  if (const Fault* step = has(CameraFault::kTimestampStep)) {
    buffer.stamp_ns += static_cast<std::uint64_t>(step->amount);
  }
  buffer.used.clear();
  for (const Piece& piece : buffer.pieces) buffer.used.push_back(piece.bytes);
  paint(buffer);
  if (has(CameraFault::kShort)) {
    for (std::size_t& used : buffer.used) used /= 2;
  }
}

// FakePicture's planes lie close together: their rows are moved to where this device has them.
void FakeV4l2Node::paint(Buffer& buffer) {
  for (const Piece& piece : buffer.pieces) {
    if (!ledger_.mappings.contains(piece.mapped)) return;
  }
  const Sizes layout = sizes();
  CameraFrame drawn;
  picture_->describe(drawn_.data(), picture_->draw(drawn_, buffer.sequence), drawn);
  std::size_t offset = device_.header;
  for (int p = 0; p < plane_count(drawn.format); ++p) {
    const CameraPlane& from = drawn.planes[static_cast<std::size_t>(p)];
    const std::size_t m = buffer.pieces.size() > 1 ? static_cast<std::size_t>(p) : 0;
    if (m > 0) offset = device_.header;
    auto* to = static_cast<std::uint8_t*>(buffer.pieces[m].mapped) + offset;
    if (drawn.format == CameraFormat::kMjpeg) {
      std::memcpy(to, from.data, from.bytes);
      buffer.used[0] = device_.header + from.bytes;
      return;
    }
    const PlaneShape shape = plane_shape(drawn.format, p, drawn.width, drawn.height);
    std::size_t stride = layout.strides[m];
    if (plane_count(drawn.format) == 3 && p > 0 && buffer.pieces.size() == 1) stride /= 2;
    if (stride < static_cast<std::size_t>(shape.row_bytes)) return;  // a fault: no picture fits
    for (int y = 0; y < shape.rows; ++y, to += stride) {
      std::memcpy(to, from.data + y * from.stride, static_cast<std::size_t>(shape.row_bytes));
    }
    offset += stride * static_cast<std::size_t>(shape.rows);
  }
}

void FakeV4l2Node::wind_alarms() {
  for (FakeV4l2File* file : files_) {
    nanoseconds when = nanoseconds::max();
    if (file == owner_ && streaming_) when = due(next_);
    const bool readable = file->gone || !file->events.empty() || (file == owner_ && !done_.empty());
    if (readable) when = nanoseconds::min();
    clock_.set_alarm(file->descriptor, when);
  }
}

void* FakeV4l2Node::map(std::size_t length, long offset) {
  const auto index = static_cast<std::size_t>(offset / 0x10000);
  const auto m = static_cast<std::size_t>(offset / 0x1000 % 0x10);
  if (index >= buffers_.size() || m >= buffers_[index].pieces.size() ||
      length != buffers_[index].pieces[m].bytes) {
    errno = misuse("mmap of no buffer", EINVAL);
    return MAP_FAILED;
  }
  auto memory = std::make_unique<std::uint8_t[]>(length);
  void* address = memory.get();
  buffers_[index].pieces[m].mapped = address;
  ledger_.mappings[address] = {std::move(memory), length};
  return address;
}

int FakeV4l2Node::ioctl(FakeV4l2File& file, unsigned long request, void* argument) {
  catch_up();
  int error = stream_ioctl(file, request, argument);
  if (error == ENOTTY) error = settings_ioctl(file, request, argument);
  wind_alarms();
  return error;
}

int FakeV4l2Node::stream_ioctl(FakeV4l2File& file, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_REQBUFS:
      return request_buffers(file, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return describe_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_EXPBUF: {
      auto& exported = *static_cast<v4l2_exportbuffer*>(argument);
      if (!device_.can_export) return ENOTTY;
      if (exported.type != type() || exported.index >= buffers_.size()) return misuse("EXPBUF", EINVAL);
      exported.fd = ledger_.next_dma_buf++;
      ledger_.dma_bufs.push_back(exported.fd);
      return 0;
    }
    case VIDIOC_STREAMON:
      if (*static_cast<int*>(argument) != static_cast<int>(type())) return misuse("STREAMON: type", EINVAL);
      if (owner_ != &file || buffers_.empty()) return misuse("STREAMON without buffers", EINVAL);
      if (has(CameraFault::kStartFails)) return EIO;
      streaming_ = true;
      ended_ = past_end_ = false;
      started_at_ = clock_.now();
      next_ = 0;
      sequence_ = device_.first_sequence;
      return 0;
    case VIDIOC_STREAMOFF:
      if (*static_cast<int*>(argument) != static_cast<int>(type())) return misuse("STREAMOFF: type", EINVAL);
      stop();
      return 0;
    case VIDIOC_SUBSCRIBE_EVENT:
      return subscribe(file, *static_cast<v4l2_event_subscription*>(argument));
    case VIDIOC_DQEVENT:
      return dequeue_event(file, *static_cast<v4l2_event*>(argument));
    default:
      return ENOTTY;
  }
}

int FakeV4l2Node::request_buffers(FakeV4l2File& file, v4l2_requestbuffers& wanted) {
  if (wanted.type != type() || wanted.memory != V4L2_MEMORY_MMAP) return misuse("REQBUFS: type", EINVAL);
  if (owner_ && owner_ != &file) return EBUSY;
  if (streaming_) return misuse("REQBUFS while it streams", EBUSY);
  for (const Buffer& buffer : buffers_) {
    for (const Piece& piece : buffer.pieces) {
      if (ledger_.mappings.contains(piece.mapped)) return misuse("REQBUFS while buffers are mapped", EBUSY);
    }
  }
  buffers_.clear();
  stop();
  owner_ = wanted.count > 0 ? &file : nullptr;
  if (wanted.count == 0) return 0;
  wanted.count = std::min(std::max(wanted.count, device_.least_buffers), device_.most_buffers);
  const Sizes layout = sizes();
  buffers_.resize(wanted.count);
  for (Buffer& buffer : buffers_) {
    for (const __u32 bytes : layout.bytes)
      buffer.pieces.push_back({device_.header + bytes - device_.missing_bytes, nullptr});
  }
  picture_.emplace(layout.format, static_cast<int>(settings_.width), static_cast<int>(settings_.height),
                   device_.number);
  drawn_.resize(picture_->bytes());
  picture_->prepare(drawn_);
  return 0;
}

int FakeV4l2Node::describe_buffer(v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.index >= buffers_.size()) return misuse("QUERYBUF", EINVAL);
  const Buffer& asked = buffers_[buffer.index];
  const auto cookie = [&](std::size_t m) { return static_cast<__u32>(buffer.index * 0x10000 + m * 0x1000); };
  if (!device_.multi_planar) {
    buffer.length = static_cast<__u32>(asked.pieces[0].bytes);
    buffer.m.offset = cookie(0);
    return 0;
  }
  if (!buffer.m.planes || buffer.length < asked.pieces.size()) return misuse("QUERYBUF: planes", EINVAL);
  for (std::size_t m = 0; m < asked.pieces.size(); ++m) {
    buffer.m.planes[m].length = static_cast<__u32>(asked.pieces[m].bytes);
    buffer.m.planes[m].m.mem_offset = cookie(m);
  }
  return 0;
}

int FakeV4l2Node::queue_buffer(const v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.memory != V4L2_MEMORY_MMAP) return misuse("QBUF: type", EINVAL);
  if (buffer.index >= buffers_.size()) return misuse("QBUF of no buffer", EINVAL);
  Buffer& queued = buffers_[buffer.index];
  if (device_.multi_planar && (!buffer.m.planes || buffer.length != queued.pieces.size())) {
    return misuse("QBUF: planes", EINVAL);
  }
  if (queued.place != Buffer::Place::kCaller) return misuse("QBUF of a queued buffer", EINVAL);
  queued.place = Buffer::Place::kQueued;
  queued_.push_back(buffer.index);
  return 0;
}

int FakeV4l2Node::dequeue_buffer(v4l2_buffer& buffer) {
  if (buffer.type != type() || buffer.memory != V4L2_MEMORY_MMAP) return misuse("DQBUF: type", EINVAL);
  if (!streaming_) return misuse("DQBUF without STREAMON", EINVAL);
  if (done_.empty()) return past_end_ ? EPIPE : EAGAIN;
  const std::size_t index = done_.front();
  Buffer& done = buffers_[index];
  if (device_.multi_planar && (!buffer.m.planes || buffer.length < done.pieces.size())) {
    return misuse("DQBUF: planes", EINVAL);
  }
  done_.pop_front();
  done.place = Buffer::Place::kCaller;
  buffer.index = device_.numbers_buffers ? static_cast<__u32>(index) : 77;
  buffer.flags = done.flags;
  buffer.sequence = done.sequence;
  buffer.field = V4L2_FIELD_NONE;
  buffer.timestamp.tv_sec = static_cast<decltype(buffer.timestamp.tv_sec)>(done.stamp_ns / 1'000'000'000U);
  buffer.timestamp.tv_usec =
      static_cast<decltype(buffer.timestamp.tv_usec)>(done.stamp_ns % 1'000'000'000U / 1000);
  buffer.bytesused = device_.multi_planar ? 0 : static_cast<__u32>(done.used[0]);
  if (device_.multi_planar) {
    buffer.length = static_cast<__u32>(done.pieces.size());
    for (std::size_t m = 0; m < done.pieces.size(); ++m) {
      buffer.m.planes[m].bytesused = static_cast<__u32>(done.used[m]);
      buffer.m.planes[m].data_offset = device_.header;
      buffer.m.planes[m].length = static_cast<__u32>(done.pieces[m].bytes);
    }
  }
  return 0;
}

int FakeV4l2Node::subscribe(FakeV4l2File& file, const v4l2_event_subscription& subscription) {
  if (subscription.type != V4L2_EVENT_SOURCE_CHANGE && subscription.type != V4L2_EVENT_EOS) return EINVAL;
  file.subscriptions.push_back(subscription.type);
  return 0;
}

int FakeV4l2Node::dequeue_event(FakeV4l2File& file, v4l2_event& event) {
  if (file.subscriptions.empty()) return misuse("DQEVENT without SUBSCRIBE_EVENT", ENOENT);
  if (file.events.empty()) return ENOENT;
  event = file.events.front();
  file.events.pop_front();
  return 0;
}

}  // namespace cupola
