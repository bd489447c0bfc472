// Records as bytes, and whether bytes are records.
// SPDX-License-Identifier: MIT
#include "hal/camera/recording_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kStep = 64;
constexpr std::uint32_t kMark = 0x43455243;  // "CREC"
constexpr std::uint32_t kBt709 = 1;
constexpr std::uint32_t kFullRange = 2;

struct FileHead {
  std::array<char, 16> name = {'C', 'u', 'p', 'o', 'l', 'a', ' ', 'c', 'a', 'm', 'e', 'r', 'a'};
  std::uint32_t version = 1;
  std::array<std::uint32_t, 11> zeros{};
};
static_assert(sizeof(FileHead) == kStep);

struct RecordHead {
  std::uint32_t mark = kMark;
  std::uint32_t kind = 0;
  std::int64_t seen_at = 0;
  std::uint64_t payload = 0;  // bytes of all planes
  std::uint32_t format = 0;   // of the mode or frame, as all up to the crop
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::uint32_t colour = 0;
  double rate = 0.0;
  std::array<std::int32_t, 4> crop{};  // x, y, width, height
  std::uint64_t sequence = 0;
  std::int64_t captured_at = 0;
  std::array<std::int64_t, 3> strides{};
  std::array<std::uint64_t, 3> bytes{};
  std::uint32_t cause = 0;
  std::int32_t error = 0;
  std::array<char, 48> step{};  // ends with a zero
  std::uint64_t zeros = 0;
};
static_assert(sizeof(RecordHead) == 3 * kStep && std::is_trivially_copyable_v<RecordHead>);

std::size_t padding_of(std::uint64_t bytes) {
  return static_cast<std::size_t>((kStep - bytes % kStep) % kStep);
}

RecordHead head_of(const CameraRecord& record) {
  RecordHead head;
  head.kind = static_cast<std::uint32_t>(record.kind);
  head.seen_at = record.seen_at.count();
  if (record.kind == RecordKind::kStarted) {
    const CameraMode& mode = record.mode;
    head.format = static_cast<std::uint32_t>(mode.format);
    head.width = mode.width;
    head.height = mode.height;
    head.colour = (mode.bt709 ? kBt709 : 0) | (mode.full_range ? kFullRange : 0);
    head.rate = mode.rate;
    head.crop = {mode.crop.x, mode.crop.y, mode.crop.width, mode.crop.height};
  } else if (record.kind == RecordKind::kFrame) {
    const CameraFrame& frame = record.frame;
    head.format = static_cast<std::uint32_t>(frame.format);
    head.width = frame.width;
    head.height = frame.height;
    for (std::size_t p = 0; p < frame.planes.size(); ++p) {
      head.strides[p] = frame.planes[p].stride;
      head.bytes[p] = frame.planes[p].data ? frame.planes[p].bytes : 0;
      head.payload += head.bytes[p];
    }
    head.captured_at = frame.captured_at.count();
  } else if (record.kind != RecordKind::kDamaged) {
    head.cause = static_cast<std::uint32_t>(record.trouble.cause);
    head.error = record.trouble.error;
    std::strncpy(head.step.data(), record.trouble.step, head.step.size() - 1);
  }
  head.sequence = record.frame.sequence;
  return head;
}

// Whether a record can be made of it, its payload aside.
bool is_sane(const RecordHead& head) {
  if (head.mark != kMark || head.kind > static_cast<std::uint32_t>(RecordKind::kLost)) return false;
  if (head.format >= kCameraFormats) return false;
  if (head.cause >= kCameraCauses || head.step.back() != 0) return false;
  if (!(head.rate >= 0.0 && head.rate <= 1e6)) return false;
  constexpr std::int32_t kLongest = 1 << 16;  // texels of a side
  for (const std::int32_t side :
       {head.width, head.height, head.crop[0], head.crop[1], head.crop[2], head.crop[3]}) {
    if (side < 0 || side > kLongest) return false;
  }
  std::uint64_t payload = 0;
  for (std::size_t p = 0; p < 3; ++p) {
    if (head.bytes[p] > head.payload || head.strides[p] < 0 || head.strides[p] > std::int64_t{1} << 32)
      return false;
    payload += head.bytes[p];
  }
  return payload == head.payload;
}

// All of it, or false with errno.
bool write_all(int descriptor, std::span<iovec> parts) {
  while (!parts.empty()) {
    ssize_t written = writev(descriptor, parts.data(), static_cast<int>(parts.size()));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    while (!parts.empty() && static_cast<std::size_t>(written) >= parts.front().iov_len) {
      written -= static_cast<ssize_t>(parts.front().iov_len);
      parts = parts.subspan(1);
    }
    if (written == 0) continue;
    parts.front().iov_base = static_cast<char*>(parts.front().iov_base) + written;
    parts.front().iov_len -= static_cast<std::size_t>(written);
  }
  return true;
}

// writev() only reads.
iovec part(const void* data, std::size_t bytes) {
  return {const_cast<void*>(data), bytes};
}

std::filesystem::path part_of(const std::filesystem::path& file) {
  return file.string() + ".part";
}

}  // namespace

RecordingWriter::RecordingWriter(std::filesystem::path file) : file_(std::move(file)) {
  const std::filesystem::path name = part_of(file_);
  descriptor_ = open(name.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), name.string());
  const FileHead head;
  std::array<iovec, 1> parts = {part(&head, sizeof head)};
  if (write_all(descriptor_, parts)) {
    whole_ = sizeof head;
  } else {
    error_ = errno;
  }
}

RecordingWriter::~RecordingWriter() {
  const bool cut = error_ == 0 || ftruncate(descriptor_, static_cast<off_t>(whole_)) == 0;
  close(descriptor_);
  std::error_code failed;  // the file keeps its other name, under which it is found too
  if (cut && whole_ > 0) std::filesystem::rename(part_of(file_), file_, failed);
}

bool RecordingWriter::append(const CameraRecord& record) noexcept {
  if (error_ != 0) return false;
  static constexpr std::array<std::byte, kStep> kZeros{};
  const RecordHead head = head_of(record);
  std::array<iovec, 5> parts;
  parts[0] = part(&head, sizeof head);
  for (std::size_t p = 0; p < 3; ++p) {
    parts[p + 1] = part(record.frame.planes[p].data, static_cast<std::size_t>(head.bytes[p]));
  }
  parts[4] = part(kZeros.data(), padding_of(head.payload));
  if (!write_all(descriptor_, parts)) {
    error_ = errno;
    return false;
  }
  whole_ += sizeof head + head.payload + padding_of(head.payload);
  return true;
}

void RecordingReader::Unmap::operator()(const std::byte* memory) const {
  munmap(const_cast<std::byte*>(memory), count);
}

RecordingReader::RecordingReader(const std::filesystem::path& file) {
  int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) descriptor = open(part_of(file).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw std::runtime_error(file.string() + ": " + std::generic_category().message(errno));
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const auto bytes = known ? static_cast<std::size_t>(status.st_size) : 0;
  void* memory = bytes > 0 ? mmap(nullptr, bytes, PROT_READ, MAP_SHARED, descriptor, 0) : MAP_FAILED;
  close(descriptor);
  if (memory != MAP_FAILED) {
    madvise(memory, bytes, MADV_SEQUENTIAL);
    mapped_ = {static_cast<const std::byte*>(memory), Unmap{bytes}};
    bytes_ = {mapped_.get(), bytes};
  }
  try {
    find_records();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

RecordingReader::RecordingReader(std::span<const std::byte> bytes) : bytes_(bytes) {
  find_records();
}

void RecordingReader::find_records() {
  const FileHead expected;
  if (bytes_.size() < sizeof expected || std::memcmp(bytes_.data(), &expected, sizeof expected) != 0) {
    throw std::runtime_error("expected a camera's recording of version 1");
  }
  readable_ = sizeof expected;
  RecordHead head;
  while (bytes_.size() - readable_ >= sizeof head) {
    std::memcpy(&head, bytes_.data() + readable_, sizeof head);
    const std::size_t room = bytes_.size() - readable_ - sizeof head;
    if (!is_sane(head) || head.payload > room || padding_of(head.payload) > room - head.payload) return;
    begins_.push_back(readable_);
    readable_ += sizeof head + static_cast<std::size_t>(head.payload) + padding_of(head.payload);
  }
}

CameraRecord RecordingReader::at(std::size_t record) const {
  const std::byte* begin = bytes_.data() + begins_[record];
  RecordHead head;
  std::memcpy(&head, begin, sizeof head);
  CameraRecord read;
  read.kind = static_cast<RecordKind>(head.kind);
  read.seen_at = nanoseconds(head.seen_at);
  const auto format = static_cast<CameraFormat>(head.format);
  read.mode = {format,
               head.width,
               head.height,
               head.rate,
               {head.crop[0], head.crop[1], head.crop[2], head.crop[3]},
               (head.colour & kBt709) != 0,
               (head.colour & kFullRange) != 0};
  const auto* step = reinterpret_cast<const char*>(begin + offsetof(RecordHead, step));
  read.trouble = {static_cast<CameraCause>(head.cause), step, head.error};
  CameraFrame& frame = read.frame;
  frame.format = format;
  frame.width = head.width;
  frame.height = head.height;
  frame.sequence = head.sequence;
  frame.captured_at = nanoseconds(head.captured_at);
  const auto* data = reinterpret_cast<const std::uint8_t*>(begin + sizeof head);
  for (std::size_t p = 0; p < 3; ++p) {
    const auto bytes = static_cast<std::size_t>(head.bytes[p]);
    if (bytes > 0) frame.planes[p] = {data, static_cast<std::ptrdiff_t>(head.strides[p]), bytes, -1, 0};
    data += bytes;
  }
  return read;
}

}  // namespace cupola
