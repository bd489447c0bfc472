// The cache of tables: built once, found again, replaced when it is damaged, never in the way.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "pipeline/warp/table_build.h"
#include "tests/frame/picture_files.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {
namespace fs = std::filesystem;

// Tables of different numbers have much the same size.
Rig small_rig(int number = 0) {
  Rig rig = test::omnimax_rig({70, 52}, 70, {48, 48}, {"front", "left", "right", "top"});
  rig.filter.alpha += number * 1e-6;
  return rig;
}

class Cache : public testing::Test {
 protected:
  // Whether a fresh cache on the folder has the rig's table; it has it afterwards.
  bool finds(const Rig& rig) {
    TableCache cache(folder_ / "c");
    const WarpTable table = cache.table(rig, pool_);
    EXPECT_EQ(cache.trouble(), "");
    EXPECT_TRUE(std::ranges::equal(table.memory.bytes(), build_warp_table(rig, pool_).memory.bytes()));
    return cache.found() == 1;
  }
  fs::path only_file() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / "c")) files.push_back(entry.path());
    EXPECT_EQ(files.size(), 1U);
    return files.front();
  }

  WorkerPool pool_{2};
  TemporaryFolder folder_;
};

TEST_F(Cache, HasATableFromTheSecondTimeOn) {
  EXPECT_FALSE(finds(small_rig()));
  EXPECT_TRUE(finds(small_rig()));
  EXPECT_FALSE(finds(small_rig(1)));
  EXPECT_TRUE(finds(small_rig()));
  EXPECT_TRUE(finds(small_rig(1)));
}

TEST_F(Cache, ReplacesWhatIsDamaged) {
  EXPECT_FALSE(finds(small_rig()));
  const fs::path file = only_file();
  const auto whole = static_cast<std::int64_t>(fs::file_size(file));
  for (const std::int64_t at : {std::int64_t{12}, std::int64_t{100}, whole / 2, whole - 1}) {
    {
      std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
      damaged.seekg(at);
      const auto byte = static_cast<char>(damaged.get() ^ 0x10);
      damaged.seekp(at);
      damaged.put(byte);
    }
    EXPECT_FALSE(finds(small_rig())) << at;
    EXPECT_TRUE(finds(small_rig())) << at;
  }
  fs::resize_file(file, static_cast<std::uintmax_t>(whole / 2));
  EXPECT_FALSE(finds(small_rig()));
  fs::resize_file(file, 0);
  EXPECT_FALSE(finds(small_rig()));
  EXPECT_TRUE(finds(small_rig()));
  only_file();
}

TEST_F(Cache, ThatIsOffKeepsNothing) {
  TableCache off;
  EXPECT_GT(off.table(small_rig(), pool_).lines.size(), 0U);
  EXPECT_EQ(off.found(), 0);
  EXPECT_EQ(off.built(), 1);
  EXPECT_EQ(off.trouble(), "");
}

TEST_F(Cache, ThatCannotBeWrittenSaysSoAndBuilds) {
  write_text(folder_ / "c", "a file where the folder should be");
  TableCache cache(folder_ / "c");
  EXPECT_GT(cache.table(small_rig(), pool_).lines.size(), 0U);
  EXPECT_GT(cache.table(small_rig(1), pool_).lines.size(), 0U);
  EXPECT_EQ(cache.built(), 2);
  EXPECT_NE(cache.trouble().find((folder_ / "c").string()), std::string::npos) << cache.trouble();
}

TEST_F(Cache, MakesRoomByDroppingWhatWasUsedLongestAgo) {
  const auto bytes = static_cast<std::int64_t>(build_warp_table(small_rig(), pool_).memory.bytes().size());
  TableCache cache(folder_ / "c", 3 * bytes + bytes / 2);
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  for (const int number : {0, 1, 2}) {
    cache.table(small_rig(number), pool_);
    wait();
  }
  cache.table(small_rig(0), pool_);  // used again: 1 is the oldest now
  EXPECT_EQ(cache.found(), 1);
  wait();
  write_text(folder_ / "c" / "notes.txt", std::string(1 << 20, 'x'));  // somebody else's
  cache.table(small_rig(3), pool_);
  EXPECT_TRUE(fs::exists(folder_ / "c" / "notes.txt"));
  fs::remove(folder_ / "c" / "notes.txt");
  EXPECT_TRUE(finds(small_rig(0)));
  EXPECT_TRUE(finds(small_rig(2)));
  EXPECT_TRUE(finds(small_rig(3)));
  EXPECT_FALSE(finds(small_rig(1)));

  TableCache tiny(folder_ / "t", bytes / 2);
  tiny.table(small_rig(), pool_);
  EXPECT_FALSE(fs::exists(folder_ / "t")) << "a table that is larger than the cache";
}

TEST_F(Cache, MayBeSharedByWhoeverWritesAtTheSameTime) {
  std::vector<std::thread> writers;
  for (int i = 0; i < 6; ++i) {
    writers.emplace_back([&, i] {
      WorkerPool own(1);
      for (int round = 0; round < 4; ++round) {
        TableCache cache(folder_ / "c");
        const WarpTable table = cache.table(small_rig((i + round) % 2), own);
        EXPECT_GT(table.lines.size(), 0U);
        EXPECT_EQ(cache.trouble(), "");
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_TRUE(finds(small_rig(0)));
  EXPECT_TRUE(finds(small_rig(1)));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "c"), fs::directory_iterator()), 2);
}

TEST(CacheFolder, IsWhatTheEnvironmentSays) {
  const auto with = [](const char* ours, const char* caches, const char* home) {
    const auto set = [](const char* name, const char* value) {
      value == nullptr ? unsetenv(name) : setenv(name, value, 1);
    };
    set("CUPOLA_CACHE", ours);
    set("XDG_CACHE_HOME", caches);
    set("HOME", home);
    return cache_folder();
  };
  EXPECT_EQ(with("off", "/x", "/h"), "");
  EXPECT_EQ(with("/my/own", "/x", "/h"), "/my/own");
  EXPECT_EQ(with(nullptr, "/x", "/h"), "/x/cupola");
  EXPECT_EQ(with("", "relative", "/h"), "/h/.cache/cupola");
  EXPECT_EQ(with(nullptr, nullptr, "/h"), "/h/.cache/cupola");
  EXPECT_EQ(with(nullptr, nullptr, nullptr), "");
}

}  // namespace
}  // namespace cupola
