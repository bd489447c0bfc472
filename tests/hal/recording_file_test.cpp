// Recordings as files: what is written is read, and of broken ones what is whole.
// SPDX-License-Identifier: MIT
#include "hal/camera/recording_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <system_error>

#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

std::vector<std::uint8_t> bytes_of(std::size_t count, int first) {
  std::vector<std::uint8_t> bytes(count);
  std::iota(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(first));
  return bytes;
}

// One of each kind, the frame of three planes whose bytes are no multiple of anything.
class Recording : public testing::Test {
 protected:
  std::vector<CameraRecord> records() const {
    std::vector<CameraRecord> made(6);
    made[0].kind = RecordKind::kRefused;
    made[0].trouble = {CameraCause::kBusy, "VIDIOC_S_FMT", EBUSY};
    made[1].kind = RecordKind::kStarted;
    made[1].seen_at = 5ms;
    made[1].mode = {CameraFormat::kI420, 9, 7, 59.94, {2, 4, 9, 7}, true, true};
    made[2].kind = RecordKind::kFrame;
    made[2].seen_at = 16ms;
    made[2].frame.format = CameraFormat::kI420;
    made[2].frame.width = 9;
    made[2].frame.height = 7;
    made[2].frame.planes = {CameraPlane{luma_.data(), 12, luma_.size(), 7, 64},
                            {u_.data(), 5, u_.size(), -1, 0},
                            {v_.data(), 6, v_.size(), -1, 0}};
    made[2].frame.sequence = 0xfffffffffU;
    made[2].frame.captured_at = -3ms;
    made[3].kind = RecordKind::kDamaged;
    made[3].frame.sequence = 12;
    made[4].kind = RecordKind::kFrame;
    made[4].frame.format = CameraFormat::kMjpeg;
    made[4].frame.width = 9;
    made[4].frame.height = 7;
    made[4].frame.planes[0] = {jpeg_.data(), 0, jpeg_.size(), -1, 0};
    made[5].kind = RecordKind::kLost;
    made[5].seen_at = 1h;
    made[5].trouble = {CameraCause::kNoSignal, "signal", ENOLINK};
    return made;
  }
  std::string write(const std::vector<CameraRecord>& records) {
    {
      RecordingWriter writer(file_);
      for (const CameraRecord& record : records) EXPECT_TRUE(writer.append(record));
      EXPECT_EQ(writer.error(), 0);
    }
    return read_text(file_);
  }
  static void expect_same(const CameraRecord& read, const CameraRecord& written) {
    ASSERT_EQ(read.kind, written.kind);
    EXPECT_EQ(read.seen_at, written.seen_at);
    EXPECT_TRUE(written.kind != RecordKind::kStarted || read.mode == written.mode);
    EXPECT_STREQ(read.trouble.step, written.trouble.step);
    EXPECT_EQ(read.trouble.error, written.trouble.error);
    EXPECT_TRUE(!*written.trouble.step || read.trouble.cause == written.trouble.cause);
    EXPECT_EQ(read.frame.sequence, written.frame.sequence);
    EXPECT_EQ(read.frame.captured_at, written.frame.captured_at);
    if (written.kind != RecordKind::kFrame) return;
    EXPECT_EQ(read.frame.format, written.frame.format);
    EXPECT_EQ(read.frame.width, written.frame.width);
    EXPECT_EQ(read.frame.height, written.frame.height);
    for (std::size_t p = 0; p < 3; ++p) {
      const CameraPlane& plane = read.frame.planes[p];
      EXPECT_EQ(plane.stride, written.frame.planes[p].stride);
      EXPECT_EQ(plane.dma_buf, -1);
      ASSERT_EQ(plane.bytes, written.frame.planes[p].bytes);
      EXPECT_TRUE(std::equal(plane.data, plane.data + plane.bytes, written.frame.planes[p].data));
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "front.camera";
  std::vector<std::uint8_t> luma_ = bytes_of(81, 3);
  std::vector<std::uint8_t> u_ = bytes_of(20, 100);
  std::vector<std::uint8_t> v_ = bytes_of(23, 200);
  std::vector<std::uint8_t> jpeg_ = bytes_of(1000, 7);
};

TEST_F(Recording, IsReadAsItWasWritten) {
  const std::vector<CameraRecord> written = records();
  write(written);
  const RecordingReader reader(file_);
  ASSERT_EQ(reader.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) expect_same(reader.at(i), written[i]);
  EXPECT_TRUE(reader.is_whole());
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"front.camera"});
}

TEST_F(Recording, OfOneWhoWasKilledIsReadUpToTheLastWholeRecord) {
  const std::vector<CameraRecord> written = records();
  const std::string whole = write(written);
  std::vector<std::size_t> ends;
  for (std::size_t count = 0; count <= written.size(); ++count) {
    const auto end = written.begin() + static_cast<std::ptrdiff_t>(count);
    ends.push_back(write(std::vector<CameraRecord>(written.begin(), end)).size());
  }
  for (std::size_t bytes = ends.front(); bytes <= whole.size(); ++bytes) {
    const RecordingReader reader(std::as_bytes(std::span(whole)).first(bytes));
    const auto fits = [&](std::size_t end) { return end <= bytes; };
    const auto count = static_cast<std::size_t>(std::ranges::count_if(ends, fits)) - 1;
    ASSERT_EQ(reader.size(), count) << bytes;
    ASSERT_EQ(reader.readable_bytes(), ends[count]) << bytes;
    ASSERT_EQ(reader.is_whole(), bytes == ends[count]) << bytes;
    if (count > 0) expect_same(reader.at(count - 1), written[count - 1]);
  }
  std::filesystem::rename(file_, file_.string() + ".part");
  EXPECT_EQ(RecordingReader(file_).size(), written.size()) << "under the name that it was written with";
}

TEST_F(Recording, WithAnyBitOfItsHeadsTurnedIsReadWithoutHarm) {
  const std::string whole = write(records());
  for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 3) {
    std::string turned = whole;
    turned[bit / 8] = static_cast<char>(turned[bit / 8] ^ (1 << bit % 8));
    try {
      const RecordingReader reader(std::as_bytes(std::span(turned)));
      std::uint64_t sum = 0;
      for (std::size_t i = 0; i < reader.size(); ++i) {
        const CameraRecord record = reader.at(i);
        sum += std::strlen(record.trouble.step);
        for (const CameraPlane& plane : record.frame.planes)
          sum = std::accumulate(plane.data, plane.data + plane.bytes, sum);
      }
      EXPECT_LE(sum, 255U * whole.size());
    } catch (const std::runtime_error&) {
      EXPECT_LT(bit / 8, 64U) << "only a wrong head of the file is none at all";
    }
  }
}

TEST_F(Recording, ThatIsNoneIsRefusedByName) {
  EXPECT_THROW(RecordingReader{file_}, std::runtime_error);
  for (const std::string& text : {std::string(), std::string("Cupola camera"), std::string(64, 'x')}) {
    write_text(file_, text);
    try {
      RecordingReader{file_};
      ADD_FAILURE() << "read " << text;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), file_.string() + ": expected a camera's recording of version 1");
    }
  }
  EXPECT_THROW(RecordingReader{folder_.path()}, std::runtime_error);
  EXPECT_THROW(RecordingWriter{folder_ / "none" / "file"}, std::system_error);
}

// A limit on the size of files stands in for a disk that is full.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : before_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit lower{bytes, limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &lower);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &limit_);
    signal(SIGXFSZ, before_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  void (*before_)(int);
  rlimit limit_{};
};

TEST_F(Recording, KeepsWhatWasWholeWhenTheDiskIsFull) {
  const std::vector<CameraRecord> written = records();
  const std::size_t three = write({written[0], written[1], written[2]}).size();
  {
    const FileLimit full(three + 100);
    RecordingWriter writer(file_);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(writer.append(written[i]));
    EXPECT_FALSE(writer.append(written[4]));
    EXPECT_FALSE(writer.append(written[3])) << "it has ended";
    EXPECT_EQ(writer.error(), EFBIG);
  }
  const RecordingReader reader(file_);
  EXPECT_EQ(reader.size(), 3U);
  EXPECT_TRUE(reader.is_whole()) << "cut to what is whole";
}

}  // namespace
}  // namespace cupola
