// What systemd hears of the player, over a real socket, and when.
// SPDX-License-Identifier: MIT
#include "firmware/player_watch.h"

#include <gmock/gmock.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "hal/time/boot_time.h"
#include "pipeline/frame/error.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::Not;

// Where systemd would listen.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : descriptor_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~NotifySocket() { ::close(descriptor_); }
  // What comes within a time.
  std::vector<std::string> heard(std::chrono::milliseconds time) const {
    std::vector<std::string> lines;
    const auto until = std::chrono::steady_clock::now() + time;
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
      pollfd end{descriptor_, POLLIN, 0};
      if (left.count() <= 0 || ::poll(&end, 1, static_cast<int>(left.count())) <= 0) return lines;
      char text[256];
      const ssize_t size = ::recv(descriptor_, text, sizeof text, 0);
      if (size > 0) lines.emplace_back(text, static_cast<std::size_t>(size));
    }
  }
  // Waits for it, ten seconds at most.
  bool hears(const std::string& line) const {
    for (int turn = 0; turn < 100; ++turn) {
      const std::vector<std::string> lines = heard(100ms);
      if (std::count(lines.begin(), lines.end(), line)) return true;
    }
    return false;
  }

 private:
  int descriptor_;
};

class Watched : public testing::Test {
 protected:
  Watched() : socket_((folder_ / "notify").string()) {
    setenv("NOTIFY_SOCKET", (folder_ / "notify").c_str(), 1);
    setenv("WATCHDOG_USEC", "80000", 1);
    facts_.show = "night";
    facts_.cues = {"opening", "dome"};
  }
  ~Watched() override {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }
  void show(std::int64_t frames, std::size_t cue = 0, std::chrono::nanoseconds position = 1s) {
    PlayerStatus status;
    status.state = PlayerState::kPlaying;
    status.counts.frames_presented = frames;
    status.show.cue = cue;
    status.show.position = position;
    status.shown_at = time_since_boot() - time_asleep();
    link_.status.publish(status);
  }
  TemporaryFolder folder_;
  NotifySocket socket_;
  ControlLink link_;
  ShowFacts facts_;
};

TEST_F(Watched, IsReadyAfterAFrameAndAliveAsLongAsFramesArePresented) {
  ServiceNotice notice;
  ASSERT_TRUE(notice.wanted());
  EXPECT_EQ(notice.watchdog(), 80ms);
  {
    PlayerWatch watch(link_, notice, facts_, {});
    EXPECT_TRUE(socket_.heard(200ms).empty()) << "nothing was presented yet";
    show(1);
    EXPECT_TRUE(socket_.hears("READY=1"));
    for (int frame = 2; frame < 5; ++frame) {
      show(frame);
      EXPECT_TRUE(socket_.hears("WATCHDOG=1")) << frame;
    }
    socket_.heard(100ms);
    EXPECT_TRUE(socket_.heard(300ms).empty()) << "the loop stands, and systemd has to hear nothing";
  }
  EXPECT_THAT(socket_.heard(100ms), Contains("STOPPING=1"));
}

TEST_F(Watched, SaysNothingWhereNobodyListens) {
  unsetenv("NOTIFY_SOCKET");
  ServiceNotice notice;
  EXPECT_FALSE(notice.wanted());
  EXPECT_FALSE(notice.say("READY=1"));
  for (const char* address : {"", "relative", "@", "/"}) {
    setenv("NOTIFY_SOCKET", address, 1);
    EXPECT_FALSE(ServiceNotice().say("READY=1")) << address;
  }
  setenv("NOTIFY_SOCKET", ("/" + std::string(200, 'x')).c_str(), 1);
  EXPECT_FALSE(ServiceNotice().wanted());
  setenv("NOTIFY_SOCKET", (folder_ / "nobody").c_str(), 1);
  EXPECT_FALSE(ServiceNotice().say("READY=1"));
}

TEST_F(Watched, LeavesTheWatchdogOfAnotherProcessAlone) {
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(ServiceNotice().watchdog(), std::nullopt);
  unsetenv("WATCHDOG_PID");
  setenv("WATCHDOG_USEC", "80x", 1);
  EXPECT_EQ(ServiceNotice().watchdog(), std::nullopt);
}

TEST_F(Watched, KeepsThePositionAtEveryChangeAndOnceASecond) {
  const std::filesystem::path file = folder_ / "position";
  ServiceNotice notice;
  const auto becomes = [&](std::size_t cue) {
    for (int turn = 0; turn < 500; ++turn, std::this_thread::sleep_for(10ms)) {
      if (!std::filesystem::exists(file)) continue;
      if (parse_position(read_text(file)).cue == cue) return true;
    }
    return false;
  };
  PlayerWatch watch(link_, notice, facts_, file);
  show(1);
  EXPECT_TRUE(becomes(0));
  show(2, 1, 30s);
  EXPECT_TRUE(becomes(1));
  const ShowPosition kept = parse_position(read_text(file));
  EXPECT_EQ(kept.show, "night");
  EXPECT_EQ(kept.cue_name, "dome");
  EXPECT_EQ(kept.position, 30s);
  EXPECT_EQ(kept.at.boot, boot_id());
  EXPECT_LE(kept.at.booted, time_since_boot());
  EXPECT_GE(kept.at.booted, time_since_boot() - 20s);
}

}  // namespace
}  // namespace cupola
