// Requests, buffers and the way round.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_stream.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <utility>

#include "hal/camera/camera_planes.h"
#include "hal/camera/libcamera_controls.h"
#include "hal/camera/libcamera_format.h"
#include "hal/time/boot_time.h"

namespace cupola {

namespace {

constexpr std::size_t kMostBuffers = 32;  // as CameraSetup says; HandOver holds them all
constexpr int kDisconnected = -1;         // in `arrived_`
constexpr int kEnd = -1;                  // in `returned_`
static_assert(kMostBuffers < HandOver::kCapacity);

// `error`: an errno, positive.
CameraCause cause_of(int error) {
  switch (error) {
    case ENODEV:
    case ENXIO:
    case ENOENT:
      return CameraCause::kMissing;
    case EBUSY:
      return CameraCause::kBusy;
    default:
      return CameraCause::kFailed;
  }
}

CameraTrouble trouble_of(const char* step, int error) {
  return {cause_of(error), step, error};
}

std::size_t offset_of(const libcamera::FrameBuffer::Plane& part) {
  return part.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : part.offset;
}

// Tries one format after the other on the first stream; kUnsupported when the camera has none of them in the
// size that was asked for.
std::optional<CameraTrouble> choose_format(libcamera::CameraConfiguration& configuration,
                                           const CameraSetup& setup, CameraFormat& chosen) {
  libcamera::StreamConfiguration& stream = configuration.at(0);
  const libcamera::StreamConfiguration first = stream;
  std::vector<CameraFormat> formats = setup.formats;
  const char* missing = "StreamConfiguration::pixelFormat";
  if (formats.empty()) {
    if (const auto own = format_of_libcamera(first.pixelFormat.fourcc())) formats.push_back(*own);
    for (const LibcameraFormat& known : kLibcameraFormats) formats.push_back(known.format);
  }
  for (const CameraFormat format : formats) {
    stream = first;
    stream.pixelFormat = libcamera::PixelFormat(libcamera_fourcc(format));
    const bool sized = setup.width > 0 && setup.height > 0;
    const libcamera::Size size(static_cast<unsigned int>(setup.width),
                               static_cast<unsigned int>(setup.height));
    if (sized) stream.size = size;
    stream.stride = 0;
    stream.bufferCount = static_cast<unsigned int>(std::clamp(setup.buffers, 2, int{kMostBuffers}));
    const libcamera::PixelFormat wanted = stream.pixelFormat;
    // What the camera has not, this replaces by the nearest that it has.
    const auto status = configuration.validate();
    if (status == libcamera::CameraConfiguration::Invalid || stream.pixelFormat != wanted) continue;
    if (sized && stream.size != size) {
      missing = "StreamConfiguration::size";
      continue;
    }
    chosen = format;
    return std::nullopt;
  }
  return CameraTrouble{CameraCause::kUnsupported, missing, 0};
}

}  // namespace

LibcameraStream::LibcameraStream(LibcameraSystem& system, Clock& clock) : system_(system), clock_(clock) {}

LibcameraStream::~LibcameraStream() {
  if (courier_.joinable()) {
    returned_.push(kEnd);
    courier_.join();
  }
  if (!camera_) return;
  camera_->stop();  // every request that is on its way comes back cancelled
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
  // A camera that was unplugged is not stopped any more; its last requests, and slots that are being called,
  // may still be on their way.
  system_.settle();
  buffers_.clear();
  allocator_.reset();
  configuration_.reset();
  system_.put_back(std::move(camera_), gone_);
}

std::variant<CameraMode, CameraTrouble> LibcameraStream::open(const CameraSetup& setup) {
  if (arrived_.descriptor() < 0 || returned_.descriptor() < 0) return trouble_of("eventfd", EMFILE);
  auto taken = system_.take(setup.device);
  if (const auto* trouble = std::get_if<CameraTrouble>(&taken)) return *trouble;
  camera_ = std::get<std::shared_ptr<libcamera::Camera>>(std::move(taken));
  if (const Answer trouble = prepare(setup)) {
    gone_ = trouble->cause == CameraCause::kMissing;
    return *trouble;
  }
  return mode_;
}

LibcameraStream::Answer LibcameraStream::prepare(const CameraSetup& setup) {
  if (Answer trouble = configure(setup)) return trouble;
  CameraSetup settled = setup;
  if (const auto size = size_of_crop(setup, *camera_, mode_)) {
    settled.formats = {mode_.format};
    settled.width = size->width;
    settled.height = size->height;
    if (configure(settled)) {
      settled = setup;
      settled.crop = {};
      if (Answer trouble = configure(settled)) return trouble;
    }
  }
  if (Answer trouble = allocate()) return trouble;
  return begin(settled);
}

LibcameraStream::Answer LibcameraStream::configure(const CameraSetup& setup) {
  configuration_ = generate_configuration(*camera_, libcamera::StreamRole::VideoRecording);
  if (!configuration_ || configuration_->empty()) {
    configuration_ = generate_configuration(*camera_, libcamera::StreamRole::Viewfinder);
  }
  if (!configuration_ || configuration_->empty()) {
    return CameraTrouble{CameraCause::kUnsupported, "Camera::generateConfiguration", 0};
  }
  if (configuration_->validate() == libcamera::CameraConfiguration::Invalid) {
    // What it proposed itself: there is no device behind it.
    return trouble_of("CameraConfiguration::validate", ENODEV);
  }
  if (const Answer trouble = choose_format(*configuration_, setup, mode_.format)) return trouble;
  if (const int error = camera_->configure(configuration_.get())) {
    if (error == -EINVAL) return CameraTrouble{CameraCause::kUnsupported, "Camera::configure", EINVAL};
    return trouble_of("Camera::configure", -error);
  }
  const libcamera::StreamConfiguration& stream = configuration_->at(0);
  stream_ = stream.stream();
  mode_.width = static_cast<int>(stream.size.width);
  mode_.height = static_cast<int>(stream.size.height);
  mode_.full_range = mode_.format == CameraFormat::kMjpeg;
  if (stream.colorSpace) {
    mode_.bt709 = stream.colorSpace->ycbcrEncoding == libcamera::ColorSpace::YcbcrEncoding::Rec709;
    mode_.full_range = stream.colorSpace->range == libcamera::ColorSpace::Range::Full;
  }
  const std::ptrdiff_t row = plane_shape(mode_.format, 0, mode_.width, mode_.height).row_bytes;
  stride_ = stream.stride > 0 ? static_cast<std::ptrdiff_t>(stream.stride) : row;
  if (stride_ < row) return CameraTrouble{CameraCause::kUnsupported, "StreamConfiguration::stride", 0};
  return std::nullopt;
}

LibcameraStream::Answer LibcameraStream::allocate() {
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  const int count = allocator_->allocate(stream_);
  if (count < 0) return trouble_of("FrameBufferAllocator::allocate", -count);
  const auto& frames = allocator_->buffers(stream_);
  if (frames.empty()) return trouble_of("FrameBufferAllocator::allocate", ENOMEM);
  buffers_.resize(std::min(frames.size(), kMostBuffers));
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    Buffer& buffer = buffers_[i];
    buffer.frame = frames[i].get();
    if (const Answer trouble = map(buffer)) return trouble;
    buffer.request = camera_->createRequest(i);
    if (!buffer.request) return trouble_of("Camera::createRequest", EIO);
    if (const int error = buffer.request->addBuffer(stream_, buffer.frame)) {
      return trouble_of("Request::addBuffer", -error);
    }
  }
  return std::nullopt;
}

LibcameraStream::Answer LibcameraStream::map(Buffer& buffer) {
  const auto& parts = buffer.frame->planes();
  const auto planes = static_cast<std::size_t>(plane_count(mode_.format));
  // A plane each, or all planes in one part, one behind the other.
  if (parts.size() != planes && parts.size() != 1) {
    return CameraTrouble{CameraCause::kUnsupported, "FrameBuffer::planes", 0};
  }
  buffer.memory.reserve(parts.size());
  std::size_t behind = 0;  // the planes so far, in the one part
  for (std::size_t p = 0; p < planes; ++p) {
    const libcamera::FrameBuffer::Plane& part = parts[parts.size() == planes ? p : 0];
    const DmaBufMemory& memory = memory_of(part, buffer);
    if (!memory.data()) return trouble_of("mmap", memory.error());
    CameraPlane& plane = buffer.planes[p];
    plane.dma_buf = memory.descriptor();
    plane.offset = offset_of(part) + behind;
    plane.data = memory.data() + plane.offset;
    if (mode_.format == CameraFormat::kMjpeg) continue;
    const PlaneShape shape = plane_shape(mode_.format, static_cast<int>(p), mode_.width, mode_.height);
    plane.stride = plane_count(mode_.format) == 3 && p > 0 ? (stride_ + 1) / 2 : stride_;
    const std::ptrdiff_t least = plane.stride * (shape.rows - 1) + shape.row_bytes;
    if (plane.stride < shape.row_bytes || plane.offset + static_cast<std::size_t>(least) > memory.bytes()) {
      return CameraTrouble{CameraCause::kUnsupported, "FrameBuffer::planes", 0};
    }
    if (parts.size() != planes) behind += static_cast<std::size_t>(plane.stride * shape.rows);
  }
  return std::nullopt;
}

// Maps what the part lies in, as far as any part of the buffer goes, unless that was done.
const DmaBufMemory& LibcameraStream::memory_of(const libcamera::FrameBuffer::Plane& part, Buffer& buffer) {
  const int descriptor = part.fd.get();
  for (const DmaBufMemory& known : buffer.memory) {
    if (known.descriptor() == descriptor) return known;
  }
  std::size_t bytes = 0;
  for (const libcamera::FrameBuffer::Plane& other : buffer.frame->planes()) {
    if (other.fd.get() == descriptor) bytes = std::max(bytes, offset_of(other) + other.length);
  }
  return buffer.memory.emplace_back(descriptor, bytes);
}

LibcameraStream::Answer LibcameraStream::begin(const CameraSetup& setup) {
  libcamera::ControlList controls(camera_->controls());
  if (Answer trouble = set_controls(setup, *camera_, controls, mode_)) return trouble;
  camera_->requestCompleted.connect(this, &LibcameraStream::complete);
  camera_->disconnected.connect(this, &LibcameraStream::disconnect);
  if (const int error = camera_->start(&controls)) return trouble_of("Camera::start", -error);
  // Pipelines differ in whether they look at the controls of start() or of requests.
  for (const auto& [id, value] : controls) buffers_.front().request->controls().set(id, value);
  for (Buffer& buffer : buffers_) {
    if (const int error = camera_->queueRequest(buffer.request.get())) {
      return trouble_of("Camera::queueRequest", -error);
    }
  }
  courier_ = std::thread([this] { carry_back(); });
  return std::nullopt;
}

CameraPoll LibcameraStream::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  if (lost_) {
    trouble = *lost_;
    return CameraPoll::kLost;
  }
  if (const int error = refused_.load()) {
    return lose(cause_of(error), "Camera::queueRequest", error, trouble);
  }
  // More than once only for frames of the sensor's start.
  for (std::size_t i = 0; i < HandOver::kCapacity; ++i) {
    const std::optional<int> number = arrived_.pop();
    if (!number) return CameraPoll::kNothing;
    if (*number == kDisconnected) {
      return lose(CameraCause::kMissing, "Camera::disconnected", ENODEV, trouble);
    }
    Buffer& buffer = buffers_[static_cast<std::size_t>(*number)];
    const libcamera::FrameMetadata& metadata = buffer.frame->metadata();
    frame.sequence = metadata.sequence;
    if (buffer.request->status() == libcamera::Request::RequestCancelled ||
        metadata.status == libcamera::FrameMetadata::FrameCancelled) {
      // The driver did not take the buffer. One that takes none any more would turn them round without end.
      if (++cancelled_ > 2 * buffers_.size()) {
        return lose(CameraCause::kFailed, "Request::RequestCancelled", EIO, trouble);
      }
      returned_.push(*number);
      return CameraPoll::kDamaged;
    }
    cancelled_ = 0;
    if (is_startup(metadata.status)) {
      returned_.push(*number);
      continue;
    }
    for (const DmaBufMemory& memory : buffer.memory) memory.begin_reading();
    buffer.lent = true;
    if (metadata.status == libcamera::FrameMetadata::FrameSuccess && fill(buffer, frame)) {
      frame.buffer = *number;
      return CameraPoll::kFrame;
    }
    give_back(*number);
    return CameraPoll::kDamaged;
  }
  return CameraPoll::kNothing;
}

// False when the picture is not whole.
bool LibcameraStream::fill(const Buffer& buffer, CameraFrame& frame) const noexcept {
  const libcamera::FrameMetadata& metadata = buffer.frame->metadata();
  frame.format = mode_.format;
  frame.width = mode_.width;
  frame.height = mode_.height;
  frame.planes = buffer.planes;
  const auto parts = metadata.planes();
  const auto planes = static_cast<std::size_t>(plane_count(mode_.format));
  if (parts.size() != planes && parts.size() != 1) return false;
  for (std::size_t p = 0; p < planes; ++p) {
    const bool apart = parts.size() == planes;
    const std::size_t before = apart ? 0 : frame.planes[p].offset - frame.planes[0].offset;
    const std::size_t filled = parts[apart ? p : 0].bytesused;
    frame.planes[p].bytes = filled > before ? filled - before : 0;
  }
  // Of the sensor where the pipeline knows it, else of the driver. By its documentation CLOCK_BOOTTIME; in
  // fact most pipelines pass on V4L2's stamps, which are CLOCK_MONOTONIC.
  const auto exposed = buffer.request->metadata().get(libcamera::controls::SensorTimestamp);
  const auto stamp = exposed ? *exposed : static_cast<std::int64_t>(metadata.timestamp);
  const std::chrono::nanoseconds captured(stamp);
  const std::chrono::nanoseconds now = clock_.now();
  frame.captured_at = captured > now ? monotonic_stamp(captured, now, time_asleep()) : captured;
  return is_whole(frame);
}

void LibcameraStream::give_back(int number) noexcept {
  if (number < 0 || static_cast<std::size_t>(number) >= buffers_.size()) return;
  Buffer& buffer = buffers_[static_cast<std::size_t>(number)];
  if (!std::exchange(buffer.lent, false)) return;
  for (const DmaBufMemory& memory : buffer.memory) memory.end_reading();
  returned_.push(number);
}

CameraPoll LibcameraStream::lose(CameraCause cause, const char* step, int error,
                                 CameraTrouble& trouble) noexcept {
  lost_ = trouble = {cause, step, error};
  arrived_.wake();  // poll() goes on saying so
  return CameraPoll::kLost;
}

void LibcameraStream::complete(libcamera::Request* request) {
  [[maybe_unused]] const bool room = arrived_.push(static_cast<int>(request->cookie()));
  assert(room);
}

void LibcameraStream::disconnect() {
  arrived_.push(kDisconnected);
}

void LibcameraStream::carry_back() noexcept {
  for (;;) {
    const int number = returned_.wait();
    if (number == kEnd) return;
    queue_again(buffers_[static_cast<std::size_t>(number)]);
  }
}

bool LibcameraStream::set_control(const CameraControl& control) noexcept {
  try {
    const std::lock_guard lock(waiting_mutex_);
    if (!waiting_) waiting_.emplace(camera_->controls());
    return cupola::set_control(control, *camera_, *waiting_);
  } catch (const std::exception&) {
    return false;
  }
}

void LibcameraStream::queue_again(Buffer& buffer) noexcept {
  int error = ENOMEM;
  try {
    buffer.request->reuse(libcamera::Request::ReuseBuffers);
    if (const std::lock_guard lock(waiting_mutex_); waiting_) {
      for (const auto& [id, value] : *waiting_) buffer.request->controls().set(id, value);
      waiting_.reset();
    }
    error = -camera_->queueRequest(buffer.request.get());
  } catch (const std::exception&) {
  }
  if (error == 0 || refused_.exchange(error) != 0) return;
  arrived_.wake();
}

}  // namespace cupola
