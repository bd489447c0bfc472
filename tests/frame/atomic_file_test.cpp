// Files that appear whole or not at all.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "pipeline/frame/error.h"
#include "pipeline/frame/numbered_frames.h"
#include "pipeline/frame/still.h"
#include "pipeline/frame/y4m_writer.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// As a full disk, for root too: writing past `bytes` of any file fails.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit small = before_;
    small.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(AtomicFile, AppearsUnderItsNameOnlyWhenCommitted) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "stats.json");
  file.write("{}\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "stats.json"));
  file.commit();
  EXPECT_EQ(read_text(folder / "stats.json"), "{}\n");
  EXPECT_THAT(folder.names(), ElementsAre("stats.json"));
}

TEST(AtomicFile, LeavesNothingBehindWhenItIsGivenUp) {
  const TemporaryFolder folder;
  {
    AtomicFile file(folder / "stats.json");
    file.write(std::string(1'000'000, 'x'));
  }
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(AtomicFile, LeavesTheOldFileAsItWasUntilItIsCommitted) {
  const TemporaryFolder folder;
  write_text(folder / "a", "old");
  {
    AtomicFile file(folder / "a");
    file.write("new");
  }
  EXPECT_EQ(read_text(folder / "a"), "old");
  AtomicFile file(folder / "a");
  file.write("new");
  file.commit();
  EXPECT_EQ(read_text(folder / "a"), "new");
}

TEST(AtomicFile, WritesManySmallPiecesInOrder) {
  const TemporaryFolder folder;
  std::string expected;
  AtomicFile file(folder / "a");
  for (int i = 0; i < 100'000; ++i) {
    const std::string line = std::to_string(i) + "\n";
    file.write(line);
    expected += line;
  }
  file.commit();
  EXPECT_EQ(read_text(folder / "a"), expected);
}

TEST(AtomicFile, GoesRoundATemporaryNameLeftByARunThatWasKilled) {
  const TemporaryFolder folder;
  write_text(folder / ("a." + std::to_string(::getpid()) + "-0.tmp"), "left over");
  AtomicFile file(folder / "a");
  file.write("new");
  file.commit();
  EXPECT_EQ(read_text(folder / "a"), "new");
}

TEST(AtomicFile, WritesThroughALinkToTheFileItPointsAt) {
  const TemporaryFolder folder;
  write_text(folder / "real", "old");
  std::filesystem::create_symlink("real", folder / "link");
  AtomicFile file(folder / "link");
  file.write("new");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text(folder / "real"), "new");
}

TEST(AtomicFile, WritesADeviceStraightInsteadOfReplacingIt) {
  AtomicFile file("/dev/null");
  file.write("gone");
  file.commit();
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, FailsOnAFullDeviceNamingIt) {
  AtomicFile file("/dev/full");
  file.write("text");
  try {
    file.commit();
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("/dev/full: cannot be written: No space left"));
  }
}

TEST(AtomicFile, RemovesWhatItWroteWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  write_text(folder / "a", "old");
  {
    const SmallDisk disk(100'000);
    AtomicFile file(folder / "a");
    EXPECT_THROW(
        {
          for (int i = 0; i < 1000; ++i) file.write(std::string(1000, 'x'));
          file.commit();
        },
        Failure);
    EXPECT_THAT(folder.names(), ElementsAre("a"));  // even before the object is gone
  }
  EXPECT_EQ(read_text(folder / "a"), "old");
}

TEST(AtomicFile, RefusesPlacesWhereNothingCanBeWritten) {
  const TemporaryFolder folder;
  write_text(folder / "file", "x");
  EXPECT_THROW(AtomicFile(folder / "missing/a"), Failure);
  EXPECT_THROW(AtomicFile(folder / "file/a"), Failure);
  EXPECT_THROW(AtomicFile{folder.path()}, Failure);
  EXPECT_THROW(AtomicFile("/proc/cupola"), Failure);
  if (::geteuid() == 0) return;  // root may write anywhere
  std::filesystem::permissions(folder.path(),
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  EXPECT_THROW(AtomicFile(folder / "a"), Failure);
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

TEST(AtomicFile, FailsWhenThePipeIsClosed) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[0]);
  auto* handler = std::signal(SIGPIPE, SIG_IGN);
  AtomicFile pipe(ends[1], "standard output");
  pipe.write("text");
  EXPECT_THROW(pipe.commit(), Failure);
  std::signal(SIGPIPE, handler);
  EXPECT_EQ(::close(ends[1]), 0);  // it stays the lender's
}

TEST(WritePng, LeavesNoHalfPictureWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const SmallDisk disk(10'000);
  const ImageBuffer image = noise_picture(PixelFormat::kRgb8, {100, 100});
  EXPECT_THROW(write_png(folder / "a.png", image.pixels()), Failure);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(Y4mWriter, LeavesNoHalfVideoWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const SmallDisk disk(100'000);
  const ImageBuffer image = noise_picture(PixelFormat::kRgb8, {100, 100});
  EXPECT_THROW(
      {
        Y4mWriter writer(folder / "a.y4m", {100, 100}, {30, 1});
        for (int i = 0; i < 20; ++i) writer.write(image.pixels());
        writer.finish();
      },
      Failure);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(NumberedFrames, CountFilesFromOneWithSixDigits) {
  const TemporaryFolder folder;
  const NumberedFrames frames(folder / "deep/out", "dome");
  const ImageBuffer image = noise_picture(PixelFormat::kRgbPlanar8, {8, 8});
  frames.write(0, image.pixels());
  frames.write(41, image.pixels());
  EXPECT_EQ(frames.path_of(0), folder / "deep/out/dome_000001.png");
  EXPECT_EQ(frames.path_of(1'234'566), folder / "deep/out/dome_1234567.png");
  EXPECT_TRUE(std::filesystem::exists(folder / "deep/out/dome_000001.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "deep/out/dome_000042.png"));
}

TEST(NumberedFrames, FailWhereNoFolderCanBeMade) {
  const TemporaryFolder folder;
  write_text(folder / "file", "x");
  EXPECT_THROW(NumberedFrames(folder / "file", "dome"), Failure);
  EXPECT_THROW(NumberedFrames(folder / "file/below", "dome"), Failure);
}

}  // namespace
}  // namespace cupola
