// Pictures go round: free, being decoded, ready, lent, free. Whoever has a picture's number has the picture.
// SPDX-License-Identifier: MIT
#include "hal/camera/mjpeg_camera.h"

#include <algorithm>
#include <cerrno>
#include <exception>
#include <utility>

#include "hal/camera/camera_planes.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr nanoseconds kFirstPicture = std::chrono::seconds(2);
constexpr int kStop = -1;

std::span<const std::uint8_t> bytes_of(const CameraFrame& frame) {
  return {frame.planes[0].data, frame.planes[0].bytes};
}

// Rows of the picture that show the crop, an even number or all.
int rows_of(const CameraArea& crop, const CameraMode& sent) {
  const bool is_whole = sent.crop.width == sent.width && sent.crop.height == sent.height;
  if (crop.width == 0 || !is_whole) return sent.height;
  const int bottom = (crop.y + crop.height - sent.crop.y + 1) / 2 * 2;
  return std::clamp(bottom, std::min(2, sent.height), sent.height);
}

}  // namespace

MjpegCamera::MjpegCamera(std::unique_ptr<Camera> device, Clock& clock, Decoding decoding)
    : device_(std::move(device)), clock_(clock), decoding_(decoding) {}

MjpegCamera::~MjpegCamera() {
  stop();
}

std::variant<CameraMode, CameraTrouble> MjpegCamera::start(const CameraSetup& setup) noexcept {
  stop();
  const auto answer = device_->start(setup);
  const CameraMode* sent = std::get_if<CameraMode>(&answer);
  if (!sent || sent->format != CameraFormat::kMjpeg) return answer;
  decodes_ = true;
  if (*sent != sent_ || std::exchange(kind_changed_, false)) kind_.reset();
  sent_ = *sent;
  std::optional<CameraTrouble> trouble;
  if (free_.descriptor() < 0 || ready_.descriptor() < 0 || stop_.descriptor() < 0) {
    trouble = CameraTrouble{CameraCause::kFailed, "eventfd", EMFILE};
  }
  try {
    if (!trouble && !kind_) trouble = learn_kind();
    if (!trouble) {
      mode_ = sent_;
      mode_.format = kind_->format;
      mode_.height = rows_of(setup.crop, sent_);
      if (mode_.height != sent_.height) mode_.crop.height = mode_.height;
      mode_.bt709 = false;
      mode_.full_range = true;
      const bool threaded = decoding_ == Decoding::kOnAThread;
      make_pictures(setup.buffers + (threaded ? 1 : 0));  // one is always being decoded
      if (threaded) worker_ = std::thread([this] { work(); });
    }
  } catch (const std::exception&) {
    trouble = CameraTrouble{CameraCause::kFailed, "out of memory or threads", 0};
  }
  if (!trouble) return mode_;
  stop();
  return *trouble;
}

std::optional<CameraTrouble> MjpegCamera::learn_kind() {
  const nanoseconds deadline = clock_.now() + kFirstPicture;
  for (;;) {
    const Event event = poll_device();
    if (event.kind == CameraPoll::kLost) return event.trouble;
    if (event.kind == CameraPoll::kFrame) {
      kind_ = decoder_.look(bytes_of(event.frame));
      device_->give_back(event.frame);
      if (!kind_)
        return CameraTrouble{CameraCause::kUnsupported, "JPEG: expected baseline 4:2:0, 4:2:2 or grey", 0};
      if (kind_->width == sent_.width && kind_->height == sent_.height) return std::nullopt;
      kind_.reset();
      return CameraTrouble{CameraCause::kChanged, "JPEG: size", 0};
    }
    if (event.kind == CameraPoll::kDamaged) continue;
    if (clock_.now() >= deadline) return CameraTrouble{CameraCause::kSilent, "first JPEG picture", 0};
    const std::array<int, 1> descriptors = {device_->descriptor()};
    clock_.wait(descriptors, deadline);
  }
}

void MjpegCamera::make_pictures(int count) {
  pictures_.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    Picture& picture = pictures_[i];
    std::array<std::size_t, 3> begins{};
    std::size_t bytes = 0;
    for (int p = 0; p < plane_count(mode_.format); ++p) {
      const PlaneShape shape = plane_shape(mode_.format, p, jpeg_room(mode_.width), jpeg_room(mode_.height));
      begins[static_cast<std::size_t>(p)] = bytes;
      picture.planes[static_cast<std::size_t>(p)].stride = shape.row_bytes;
      bytes += static_cast<std::size_t>(shape.row_bytes * shape.rows);
    }
    picture.memory.resize(bytes);
    for (std::size_t p = 0; p < 3; ++p) picture.planes[p].data = picture.memory.data() + begins[p];
    picture.lent = false;
    free_.push(static_cast<int>(i));
  }
}

void MjpegCamera::stop() noexcept {
  join();
  device_->stop();
  while (free_.pop()) continue;
  while (ready_.pop()) continue;
  if (stopping_.exchange(false)) stop_.pop();
  next_.reset();
  lost_.reset();
  decodes_ = false;
}

void MjpegCamera::join() noexcept {
  if (!worker_.joinable()) return;
  stopping_.store(true);
  stop_.wake();
  free_.push(kStop);
  worker_.join();
}

CameraPoll MjpegCamera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  if (!decodes_) return device_->poll(frame, trouble);
  if (lost_) {
    trouble = *lost_;
    return CameraPoll::kLost;
  }
  std::optional<int> number = ready_.pop();
  if (!number && decoding_ == Decoding::kInPoll) {
    const Event event = poll_device();
    if (event.kind == CameraPoll::kNothing) return event.kind;
    number = free_.pop();
    if (!number) {
      // All are lent: the picture has nowhere to go, and its number is missing.
      if (event.kind == CameraPoll::kFrame) device_->give_back(event.frame);
      if (event.kind != CameraPoll::kLost) return CameraPoll::kNothing;
      lost_ = trouble = event.trouble;
      return CameraPoll::kLost;
    }
    receive(event, static_cast<std::size_t>(*number));
  }
  if (!number) return CameraPoll::kNothing;
  Picture& picture = pictures_[static_cast<std::size_t>(*number)];
  frame = picture.event.frame;
  frame.buffer = *number;
  if (picture.event.kind == CameraPoll::kFrame) {
    picture.lent = true;
    return CameraPoll::kFrame;
  }
  if (picture.event.kind == CameraPoll::kLost) lost_ = trouble = picture.event.trouble;
  free_.push(*number);
  return picture.event.kind;
}

void MjpegCamera::give_back(const CameraFrame& frame) noexcept {
  if (!decodes_) return device_->give_back(frame);
  const auto number = static_cast<std::size_t>(frame.buffer);
  if (number >= pictures_.size() || !std::exchange(pictures_[number].lent, false)) return;
  free_.push(frame.buffer);
}

int MjpegCamera::descriptor() const noexcept {
  return decodes_ && decoding_ == Decoding::kOnAThread ? ready_.descriptor() : device_->descriptor();
}

MjpegCamera::Event MjpegCamera::poll_device() noexcept {
  Event event;
  event.kind = device_->poll(event.frame, event.trouble);
  return event;
}

// Pictures that wait while a newer one does are passed over: decoding them would only make that one late.
MjpegCamera::Event MjpegCamera::newest_of_device() noexcept {
  Event newest = next_ ? *std::exchange(next_, std::nullopt) : poll_device();
  while (newest.kind == CameraPoll::kFrame) {
    const Event after = poll_device();
    if (after.kind == CameraPoll::kNothing) break;
    if (after.kind != CameraPoll::kFrame) {
      next_ = after;
      break;
    }
    device_->give_back(newest.frame);
    newest = after;
  }
  return newest;
}

void MjpegCamera::receive(const Event& event, std::size_t number) noexcept {
  Picture& picture = pictures_[number];
  picture.event = event;
  if (event.kind != CameraPoll::kFrame) return;
  const auto outcome = decoder_.decode(bytes_of(event.frame), *kind_, picture.planes, mode_.height);
  device_->give_back(event.frame);
  if (outcome == JpegDecoder::Outcome::kDamaged) picture.event.kind = CameraPoll::kDamaged;
  if (outcome == JpegDecoder::Outcome::kOther) {
    picture.event.kind = CameraPoll::kLost;
    picture.event.trouble = {CameraCause::kChanged, "JPEG: kind", 0};
    kind_changed_ = true;
  }
  CameraFrame& frame = picture.event.frame;
  frame.format = mode_.format;
  frame.width = mode_.width;
  frame.height = mode_.height;
  frame.planes = {};
  for (int p = 0; p < plane_count(mode_.format); ++p) {
    const JpegPlane& plane = picture.planes[static_cast<std::size_t>(p)];
    const PlaneShape shape = plane_shape(mode_.format, p, mode_.width, mode_.height);
    const auto bytes = static_cast<std::size_t>(plane.stride * shape.rows);
    frame.planes[static_cast<std::size_t>(p)] = {plane.data, plane.stride, bytes, -1, 0};
  }
}

void MjpegCamera::work() noexcept {
  for (;;) {
    const int number = free_.wait();
    if (number == kStop) return;
    Event event = newest_of_device();
    while (event.kind == CameraPoll::kNothing) {
      if (stopping_.load()) return;
      const std::array<int, 2> descriptors = {device_->descriptor(), stop_.descriptor()};
      clock_.wait(descriptors, nanoseconds::max());
      event = newest_of_device();
    }
    const auto place = static_cast<std::size_t>(number);
    receive(event, place);
    const bool over = pictures_[place].event.kind == CameraPoll::kLost;
    ready_.push(number);
    if (over) return;
  }
}

}  // namespace cupola
