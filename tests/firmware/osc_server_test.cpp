// The ear for OSC end to end: real sockets on the loopback, and liblo's own senders.
// SPDX-License-Identifier: MIT
#include "firmware/osc_server.h"

#include <gmock/gmock.h>
#include <lo/lo.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <thread>

#include "firmware/osc_packet.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::HasSubstr;

const std::string kToken = "a-token-of-twenty-si";
// It stands still, so that what comes is ahead of its time by so much however busy the machine is; a tenth of
// a second before NTP's count begins anew.
constexpr WallTime kDay{2'085'978'496s - 100ms};

// A server, its sender, and the loop's end of the link.
class OscServerTest : public testing::Test {
 protected:
  ~OscServerTest() override {
    if (to_) lo_address_free(to_);
  }

  void start(const std::string& token = "", const std::string& address = "127.0.0.1:0") {
    ShowFacts facts;
    facts.show = "film";
    facts.cues = {"opening", "dome"};
    server_ =
        start_osc_server(parse_control_address(address), token, facts, link_, clock_, [] { return kDay; });
    to_ = lo_address_new("127.0.0.1", std::to_string(server_->address().port).c_str());
  }
  // One packet: a bundle of `at_once`, and in it one of `messages` that come `ahead` of their time.
  void send(nanoseconds ahead, const std::vector<const char*>& messages,
            const std::vector<const char*>& at_once = {}) const {
    const OscTime time = osc_time(kDay + ahead);
    lo_bundle outer = lo_bundle_new(lo_timetag{0, 1});
    for (const char* address : at_once) lo_bundle_add_message(outer, address, lo_message_new());
    lo_bundle inner =
        lo_bundle_new({static_cast<std::uint32_t>(time >> 32U), static_cast<std::uint32_t>(time)});
    for (const char* address : messages) lo_bundle_add_message(inner, address, lo_message_new());
    lo_bundle_add_bundle(outer, inner);
    lo_send_bundle(to_, outer);
    lo_bundle_free_recursive(outer);
  }
  // The next command, within five seconds.
  std::optional<PlayerCommand> command() {
    for (const auto until = clock_.now() + 5s; clock_.now() < until; std::this_thread::sleep_for(1ms)) {
      if (const auto taken = link_.commands.take()) return taken;
    }
    return std::nullopt;
  }
  // What is reported once `is` is true of it, or after five seconds.
  OscReport report(const std::function<bool(const OscReport&)>& is) const {
    const auto until = clock_.now() + 5s;
    while (!is(link_.osc.read()) && clock_.now() < until) std::this_thread::sleep_for(1ms);
    return link_.osc.read();
  }
  std::string log() {
    std::string text;
    for (const EventLog::Line& line : link_.log.lines()) text += line.text + "\n";
    return text;
  }
  int lines() { return static_cast<int>(link_.log.lines().size()); }

  mutable MonotonicClock clock_;
  ControlLink link_;
  std::unique_ptr<OscServer> server_;
  lo_address to_ = nullptr;
};

// A sender of any bytes, who hears what comes back.
class Socket {
 public:
  explicit Socket(int port, const char* host = "127.0.0.1") {
    addrinfo wanted{};
    wanted.ai_flags = AI_NUMERICHOST;
    wanted.ai_socktype = SOCK_DGRAM;
    addrinfo* place = nullptr;
    EXPECT_EQ(getaddrinfo(host, std::to_string(port).c_str(), &wanted, &place), 0);
    number_ = socket(place->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(connect(number_, place->ai_addr, place->ai_addrlen), 0);
    freeaddrinfo(place);
  }
  ~Socket() { close(number_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void send(const std::string& bytes) const { ::send(number_, bytes.data(), bytes.size(), 0); }
  // Empty: nothing came for so long.
  std::string receive(int wait_ms) const {
    pollfd wait{number_, POLLIN, 0};
    char bytes[8192];
    if (poll(&wait, 1, wait_ms) <= 0) return {};
    const ssize_t size = recv(number_, bytes, sizeof bytes, 0);
    return size < 0 ? "" : std::string(bytes, static_cast<std::size_t>(size));
  }

 private:
  int number_ = -1;
};

TEST_F(OscServerTest, TakesTheCommandsThatLibloSends) {
  start();
  EXPECT_TRUE(link_.osc.read().wanted);
  lo_send(to_, "/cupola/go", "");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  lo_send(to_, "/cupola/seek", "f", 12.5F);
  EXPECT_EQ(command(), (PlayerCommand{PlayerAction::kSeek, 12500ms}));
  lo_send(to_, "/cupola/cue", "s", "dome");
  EXPECT_EQ(command(), (PlayerCommand{.action = PlayerAction::kCue, .cue = 1}));
  lo_send(to_, "/cupola/cue", "i", 1);
  EXPECT_EQ(command(), (PlayerCommand{.action = PlayerAction::kCue, .cue = 0}));
  lo_send(to_, "/cupola/blackout", "F");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kBlackoutOff});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 5; }).taken, 5);
  EXPECT_THAT(log(), HasSubstr("127.0.0.1: osc: seek 12.5\n"));
}

TEST_F(OscServerTest, TakesABundleInItsOrder) {
  start();
  lo_bundle bundle = lo_bundle_new(lo_timetag{0, 1});
  lo_bundle_add_message(bundle, "/cupola/pause", lo_message_new());
  lo_bundle_add_message(bundle, "/cupola/nonsense", lo_message_new());
  lo_bundle_add_message(bundle, "/cupola/next", lo_message_new());
  lo_send_bundle(to_, bundle);
  lo_bundle_free_recursive(bundle);
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kPause});
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kNext});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 2; }).refused, 1);
}

TEST_F(OscServerTest, KeepsABundleUntilItsTime) {
  start();
  const nanoseconds sent = clock_.now();
  send(300ms, {"/cupola/go", "/cupola/previous"}, {"/cupola/next"});
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kNext});
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  EXPECT_GE(clock_.now(), sent + 300ms);
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kPrevious});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 3; }).taken, 3);
  EXPECT_THAT(log(), HasSubstr("127.0.0.1: osc: go, sent 0.300 seconds ahead\n"));
}

TEST_F(OscServerTest, TakesABundleOfThePastAtOnce) {
  start();
  send(-1h, {"/cupola/go"});
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 1; }).taken, 1);
  EXPECT_THAT(log(), HasSubstr("osc: go\n"));
}

TEST_F(OscServerTest, RefusesAPacketWholeThatIsTooFarAhead) {
  start();
  send(10'500ms, {"/cupola/go"}, {"/cupola/pause"});
  lo_send(to_, "/cupola/next", "");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kNext});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 1; }).refused, 1);
  EXPECT_THAT(log(), HasSubstr("refused: a bundle's time is 10.5 seconds ahead; expected at most 10"));
}

TEST_F(OscServerTest, RefusesAPacketWholeThatItHasNoRoomFor) {
  start();
  const std::vector<const char*> forty(40, "/cupola/go");
  send(9s, forty);
  send(9s, forty, {"/cupola/pause"});
  lo_send(to_, "/cupola/next", "");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kNext});
  const OscReport counted = report([](const OscReport& now) { return now.taken == 1; });
  EXPECT_EQ(counted.crowded, 1);
  EXPECT_EQ(counted.refused, 0);
  EXPECT_THAT(log(), HasSubstr("too many commands wait for their time"));
}

TEST_F(OscServerTest, RefusesWhatIsWrongWhenItComes) {
  start(kToken);
  const std::string nonsense = "/cupola/" + kToken + "/nonsense";
  const std::string again = "/cupola/" + kToken + "/next";
  send(9s, std::vector<const char*>(64, "/cupola/go"));  // without the token: takes no room
  send(9s, std::vector<const char*>(64, nonsense.c_str()));
  send(100ms, {again.c_str()});
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kNext});
  const OscReport counted = report([](const OscReport& now) { return now.taken == 1; });
  EXPECT_EQ(counted.denied, 64);
  EXPECT_EQ(counted.refused, 64);
  EXPECT_EQ(counted.crowded, 0);
}

TEST_F(OscServerTest, TakesAPatternOfOneCommand) {
  start();
  const Socket sender(server_->address().port);
  sender.send(osc_packet({"/cupola/{play,pause}", {}}));
  sender.send(osc_packet({"/*/g?", {}}));
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  EXPECT_THAT(log(), HasSubstr("osc: refused: \"{play,pause}\": expected a pattern of one command"));
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 1; }).refused, 1);
}

TEST_F(OscServerTest, AnswersWhoAsksForTheStatus) {
  start();
  PlayerStatus status;
  status.state = PlayerState::kPlaying;
  status.show.cue = 1;
  status.show.position = 2500ms;
  status.volume = 70;
  status.black = true;
  status.counts.frames_late = 3;
  status.counts.frames_dropped = 4;
  link_.status.publish(status);
  const Socket asks(server_->address().port);
  asks.send(osc_packet({"/cupola/status", {}}));
  const std::string answer = asks.receive(5000);
  const auto messages =
      read_osc_packet({reinterpret_cast<const std::uint8_t*>(answer.data()), answer.size()});
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].address, "/cupola/status");
  const std::vector<OscValue> expected = {
      std::string("playing"), std::int64_t{2}, std::string("dome"), 2.5, std::int64_t{70}, true,
      std::int64_t{3},        std::int64_t{4}};
  EXPECT_TRUE(messages[0].values == expected);
  EXPECT_LT(answer.size(), 128U);
}

TEST_F(OscServerTest, SurvivesWhatIsNoCommandAndAnswersNone) {
  start();
  const Socket sender(server_->address().port);
  std::uint32_t random = 1;
  for (int i = 0; i < 60; ++i) {
    std::string noise(i * 23 % 300, '\0');
    for (char& byte : noise) byte = static_cast<char>((random = random * 1664525 + 1013904223) >> 24);
    sender.send(noise);
  }
  sender.send(std::string(6000, '/'));
  lo_send(to_, "/cupola/seek", "s", "nowhere");
  lo_send(to_, "/other/go", "");
  lo_send(to_, "/cupola/go", "f", 0.0F);
  const OscReport counted = report([](const OscReport& now) { return now.released == 1; });
  EXPECT_EQ(counted.refused, 63);
  EXPECT_EQ(counted.released, 1);
  EXPECT_EQ(counted.taken, 0);
  EXPECT_EQ(sender.receive(50), "");
  EXPECT_EQ(lines(), 1) << log();  // of all of them
  lo_send(to_, "/cupola/go", "");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
}

TEST_F(OscServerTest, WantsItsTokenWhereItHasOne) {
  start(kToken);
  const Socket sender(server_->address().port);
  sender.send(osc_packet({"/cupola/status", {}}));
  lo_send(to_, "/cupola/pause", "");
  lo_send(to_, "/cupola/a-token-of-twenty-so/pause", "");
  lo_send(to_, ("/cupola/" + kToken + "/go").c_str(), "");
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 1; }).denied, 3);
  EXPECT_EQ(sender.receive(50), "");
  sender.send(osc_packet({"/cupola/" + kToken + "/status", {}}));
  EXPECT_THAT(sender.receive(5000), HasSubstr("starting"));
  EXPECT_THAT(log(), testing::Not(HasSubstr(kToken)));
}

TEST_F(OscServerTest, TakesNoMoreCommandsThanTheQueueHolds) {
  start();
  const Socket sender(server_->address().port);
  const std::string next = osc_packet({"/cupola/next", {}});
  for (std::size_t i = 0; i < CommandQueue::kSlots + 10; ++i) sender.send(next);
  const OscReport counted = report([](const OscReport& now) { return now.crowded == 10; });
  EXPECT_EQ(counted.taken, static_cast<std::int64_t>(CommandQueue::kSlots));
  EXPECT_EQ(counted.crowded, 10);
  EXPECT_EQ(lines(), 2) << log();
}

TEST_F(OscServerTest, ListensAtItsOwnAddressAlone) {
  start("", "127.0.0.2:0");
  const Socket sender(server_->address().port);  // to 127.0.0.1
  sender.send(osc_packet({"/cupola/go", {}}));
  lo_address right = lo_address_new("127.0.0.2", std::to_string(server_->address().port).c_str());
  lo_send(right, "/cupola/pause", "");
  lo_address_free(right);
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kPause});
  EXPECT_EQ(link_.commands.take(), std::nullopt);
}

// Where the machine has none, it says so.
TEST_F(OscServerTest, ListensAtAnAddressOfIpv6) {
  const int probe = socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 loopback{};
  loopback.sin6_family = AF_INET6;
  loopback.sin6_addr = in6addr_loopback;
  const bool there = bind(probe, reinterpret_cast<const sockaddr*>(&loopback), sizeof loopback) == 0;
  close(probe);
  try {
    start("", "[::1]:0");
  } catch (const Failure& failure) {
    EXPECT_FALSE(there);
    EXPECT_THAT(failure.what(), HasSubstr("control: osc [::1]:0: cannot listen there"));
    return;
  }
  EXPECT_TRUE(there);
  const Socket asks(server_->address().port, "::1");  // Debian's liblo speaks IPv4 alone
  asks.send(osc_packet({"/cupola/go", {}}));
  EXPECT_EQ(command(), PlayerCommand{PlayerAction::kGo});
  EXPECT_EQ(report([](const OscReport& now) { return now.taken == 1; }).taken, 1);
  EXPECT_THAT(log(), HasSubstr("::1: osc: go\n"));
  asks.send(osc_packet({"/cupola/status", {}}));
  EXPECT_THAT(asks.receive(5000), HasSubstr("starting"));
  EXPECT_EQ(describe(server_->address()), "[::1]:" + std::to_string(server_->address().port));
}

TEST_F(OscServerTest, RefusesOthersWithoutATokenAndPortsThatAreTaken) {
  EXPECT_THROW(start("", "0.0.0.0:0"), InputError);
  start();
  const std::string same = "127.0.0.1:" + std::to_string(server_->address().port);
  ControlLink link;
  EXPECT_THROW(start_osc_server(parse_control_address(same), "", {}, link, clock_), Failure);
}

}  // namespace
}  // namespace cupola
