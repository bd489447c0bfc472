// The control server end to end: real sockets on the loopback, a real loop, and requests good and bad.
// SPDX-License-Identifier: MIT
#include "firmware/control_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "firmware/frame_loop.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kJson = "application/json";
const std::string kToken = "a-token-of-twenty-si";

Show small_show() {
  const std::string lines[] = {
      "rig.frame.width=64", "rig.frame.height=48", "rig.frame.center=[32, 24]", "rig.frame.radius=30",
      R"(cue=[{name="a", source="generated", world="demo", face_size=[32, 32], duration_s=1000},)"
      R"({name="b", source="generated", world="tree", face_size=[32, 32], duration_s=0.1, then="wait"},)"
      R"({name="c", source="generated", world="grid", face_size=[32, 32]}])"};
  return load_show("demo", lines);
}

// A show that plays in real time on a thread of its own until the test ends it.
class PlayingShow {
 public:
  explicit PlayingShow(const std::string& token = "", const std::string& address = "127.0.0.1:0") {
    link_.preview = &preview_;
    link_.faces = &faces_;
    server_ =
        start_control_server(parse_control_address(address), token, facts_of(show_, "fake"), link_, clock_);
    thread_ = std::thread([this] { end_ = loop_.run(60s); });
  }
  ~PlayingShow() { stop(); }
  void stop() {
    if (!thread_.joinable()) return;
    display_.close();
    thread_.join();
    EXPECT_EQ(end_, LoopEnd::kClosed);
  }
  httplib::Client client() const {
    httplib::Client client("127.0.0.1", server_->address().port);
    client.set_read_timeout(10s);
    return client;
  }
  httplib::Result command(const std::string& body) const {
    return client().Post("/api/command", body, kJson);
  }
  json status() const { return json::parse(client().Get("/api/status")->body); }
  // Asks until `is` is true of the status, for ten seconds.
  bool becomes(const std::function<bool(const json&)>& is) const {
    for (const auto until = clock_.now() + 10s; clock_.now() < until; std::this_thread::sleep_for(5ms)) {
      if (is(status())) return true;
    }
    return false;
  }
  int port() const { return server_->address().port; }
  const LoopCounts& counts() const { return loop_.counts(); }

 private:
  // Flips until it is closed from another thread.
  class Screen final : public Display {
   public:
    explicit Screen(Clock& clock) : display_(clock, 64, 48) {}
    DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
    Presented present(std::chrono::nanoseconds when) noexcept override {
      return fate(display_.present(when));
    }
    Presented repeat(std::chrono::nanoseconds when) noexcept override { return fate(display_.repeat(when)); }
    std::chrono::nanoseconds period() const noexcept override { return display_.period(); }
    const char* trouble() const noexcept override { return ""; }
    void close() { closed_ = true; }

   private:
    Presented fate(Presented presented) const noexcept {
      if (closed_) presented.result = Present::kClosed;
      return presented;
    }
    FakeDisplay display_;
    std::atomic<bool> closed_{false};
  };

  Show show_ = small_show();
  mutable MonotonicClock clock_;
  WorkerPool pool_{1};
  Preview preview_{{64, 48}};
  FacePreviews faces_;
  ControlLink link_;
  ShowFrames frames_{show_, Method::kEwa, Cpu::kScalar, pool_};
  Screen display_{clock_};
  FrameLoop loop_{frames_, display_, clock_, pool_, nullptr, &link_};
  LoopEnd end_ = LoopEnd::kOver;
  std::unique_ptr<ControlServer> server_;
  std::thread thread_;
};

TEST(ControlServer, SaysWhatThePlayerDoes) {
  PlayingShow show;
  ASSERT_TRUE(show.becomes([](const json& now) { return now["state"] == "playing"; }));
  const json now = show.status();
  EXPECT_EQ(now["show"], "demo");
  EXPECT_EQ(now["cue"], 1);
  EXPECT_EQ(now["cue_name"], "a");
  EXPECT_EQ(now["duration_s"], 1000.0);
  EXPECT_EQ(now["display"], "fake");
  EXPECT_NEAR(now["rate_hz"].get<double>(), 60.0, 0.01);
  EXPECT_GT(now["frames"]["presented"], 0);
  const json cues = json::parse(show.client().Get("/api/cues")->body);
  ASSERT_EQ(cues["cues"].size(), 3U);
  EXPECT_EQ(cues["cues"][1]["name"], "b");
  EXPECT_EQ(cues["cues"][1]["current"], false);
  EXPECT_EQ(cues["cues"][0]["current"], true);
}

TEST(ControlServer, CommandsReachTheShow) {
  PlayingShow show;
  EXPECT_EQ(show.command(R"({"command": "pause"})")->status, 200);
  ASSERT_TRUE(show.becomes([](const json& now) { return now["state"] == "paused"; }));
  EXPECT_EQ(show.command(R"({"command": "seek", "argument": 500.5})")->status, 200);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["position_s"] == 500.5; }));
  EXPECT_EQ(show.command(R"({"command": "play"})")->status, 200);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["position_s"] > 500.5; }));
  EXPECT_EQ(show.command(R"({"command": "cue", "argument": "b"})")->status, 200);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["state"] == "waiting" && now["cue"] == 2; }));
  EXPECT_EQ(show.command(R"({"command": "go"})")->status, 200);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["cue_name"] == "c"; }));
  EXPECT_TRUE(show.status()["duration_s"].is_null());
  EXPECT_EQ(show.command(R"({"command": "blackout", "argument": "on"})")->status, 200);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["blackout"] == true; }));
  const std::string log = show.client().Get("/api/log")->body;
  for (const char* line : {"127.0.0.1: seek 500.5", "127.0.0.1: cue b", "waiting", "cue 3", "dark"}) {
    EXPECT_THAT(log, HasSubstr(line));
  }
}

TEST(ControlServer, RefusesWhatIsNoCommand) {
  PlayingShow show;
  const std::pair<const char*, const char*> wrong[] = {
      {"", "expected JSON like"},
      {"{", "expected JSON like"},
      {"[1, 2]", "expected JSON like"},
      {R"({"command": 3})", "expected JSON like"},
      {R"({"command": "next", "file": "/etc/passwd"})", "\\\"file\\\""},
      {R"({"command": "seek", "argument": {"a": 1}})", "expected a text or a number"},
      {R"({"command": "seek", "argument": -1})", "expected seconds from 0"},
      {R"({"command": "seek", "argument": 1e999})", "expected"},
      {R"({"command": "cue", "argument": "../x"})", "expected a cue's name"},
      {R"({"command": "nxt"})", "did you mean next?"},
      {"{\"command\": \"\xff\xfe\"}", "expected JSON like"},
      {R"({"command": "volume"})", "volume: expected percent from 0 to 100"}};
  for (const auto& [body, words] : wrong) {
    const httplib::Result result = show.command(body);
    ASSERT_TRUE(result) << body;
    EXPECT_EQ(result->status, 400) << body;
    EXPECT_THAT(result->body, HasSubstr(words)) << body;
    EXPECT_TRUE(json::parse(result->body)["error"].is_string());
  }
  EXPECT_EQ(show.command(std::string(5000, ' '))->status, 413);
  EXPECT_EQ(show.command(std::string(4000, '['))->status, 400);
  EXPECT_EQ(show.client().Post("/api/command", R"({"command": "next"})", "text/plain")->status, 415);
  EXPECT_EQ(show.client().Get("/api/command")->status, 404);
  EXPECT_EQ(show.client().Get("/../../etc/passwd")->status, 404);
  EXPECT_EQ(show.client().Post("/api/command", {{"Transfer-Encoding", "chunked"}}, "x", kJson)->status, 411);
  EXPECT_EQ(show.status()["cue"], 1) << "none of it did anything";
}

TEST(ControlServer, AnswersOnlyThisMachineWithoutAToken) {
  PlayingShow show;
  const std::string port = std::to_string(show.port());
  const auto status = [&](httplib::Headers headers) {
    return show.client().Post("/api/command", headers, R"({"command": "next"})", kJson)->status;
  };
  EXPECT_EQ(status({{"Host", "rebound.example"}}), 403);
  EXPECT_EQ(status({{"Host", "127.0.0.1.example:" + port}}), 403);
  EXPECT_EQ(status({{"Host", "192.168.1.2:" + port}}), 403);
  EXPECT_EQ(status({{"Host", "localhost:" + port}, {"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(status({{"Host", "localhost:" + port}, {"Origin", "null"}}), 403);
  EXPECT_EQ(status({{"Host", "localhost:" + port}, {"Origin", "http://localhost:1"}}), 403);
  EXPECT_EQ(show.status()["cue"], 1);
  EXPECT_EQ(status({{"Host", "localhost:" + port}, {"Origin", "http://localhost:" + port}}), 200);
  EXPECT_EQ(status({{"Host", "[::1]:" + port}}), 200);
}

TEST(ControlServer, WantsItsTokenWhereItHasOne) {
  PlayingShow show(kToken, "0.0.0.0:0");
  httplib::Client client = show.client();
  for (const char* path :
       {"/api/status", "/api/cues", "/api/log", "/metrics", "/preview.jpg", "/faces/2.jpg"}) {
    EXPECT_EQ(client.Get(path)->status, 401) << path;
    EXPECT_EQ(client.Get(path, {{"Authorization", "Bearer " + kToken.substr(1)}})->status, 401) << path;
    EXPECT_EQ(client.Get(path, {{"Authorization", kToken}})->status, 401) << path;
    EXPECT_EQ(client.Get(path, {{"Authorization", "Bearer " + kToken}})->status, 200) << path;
  }
  EXPECT_EQ(client.Post("/api/command", R"({"command": "next"})", kJson)->status, 401);
  EXPECT_EQ(client.Get("/")->status, 200) << "the page asks for the token";
  EXPECT_THROW(ask_status({"127.0.0.1", show.port(), true}, ""), Failure);
  EXPECT_THAT(status_text(ask_status({"127.0.0.1", show.port(), true}, kToken)), HasSubstr("demo: "));
}

TEST(ControlServer, RefusesToListenToOthersWithoutAToken) {
  ControlLink link;
  MonotonicClock clock;
  for (const char* address : {"0.0.0.0:0", "192.168.1.2:0", "[::]:0"}) {
    EXPECT_THROW(start_control_server(parse_control_address(address), "", {}, link, clock), InputError)
        << address;
  }
}

TEST(ControlServer, DoesNotShareItsPort) {
  PlayingShow show;
  ControlLink link;
  MonotonicClock clock;
  EXPECT_THROW(start_control_server({"127.0.0.1", show.port(), true}, "", {}, link, clock), Failure);
}

// Asks again where a busy machine's loop took too long.
ImageBuffer get_picture(const PlayingShow& show, const std::string& path) {
  httplib::Result result = show.client().Get(path);
  for (int again = 0; again < 20 && result->status == 503; ++again) result = show.client().Get(path);
  EXPECT_EQ(result->status, 200) << path;
  EXPECT_EQ(result->get_header_value("Content-Type"), "image/jpeg");
  TemporaryFolder folder;
  write_text(folder / "picture.jpg", result->body);
  return read_still(folder / "picture.jpg");
}

TEST(ControlServer, ShowsThePictureAndTheFaces) {
  PlayingShow show;
  EXPECT_EQ(get_picture(show, "/preview.jpg").size(), (Size{64, 48}));
  const json views = show.status()["views"];
  EXPECT_EQ(views, (json{"front", "left", "right", "top"}));
  for (std::size_t view = 1; view <= views.size(); ++view) {
    EXPECT_EQ(get_picture(show, fmt::format("/faces/{}.jpg", view)).size(), (Size{32, 32}));
  }
  for (const char* none : {"/faces/5.jpg", "/faces/0.jpg", "/faces/10.jpg", "/faces/front.jpg"}) {
    EXPECT_EQ(show.client().Get(none)->status, 404) << none;
  }
}

TEST(ControlServer, FinishedFramesHaveNoViews) {
  ShowFacts facts;
  facts.views = {"front", "left"};
  facts.finished = {false, true};
  PlayerStatus status;
  EXPECT_EQ(views_of(facts, status).size(), 2u);
  status.show.cue = 1;
  EXPECT_TRUE(views_of(facts, status).empty());
}

TEST(ControlServer, HasMetricsForPrometheus) {
  PlayingShow show;
  ASSERT_TRUE(show.becomes([](const json& now) { return now["frames"]["presented"] > 10; }));
  const std::string text = show.client().Get("/metrics")->body;
  for (const char* line :
       {"cupola_state{state=\"playing\"} 1", "cupola_frames_dropped_total{cause=\"warp\"} ",
        "cupola_warp_seconds_bucket{le=\"0.013\"} ", "cupola_warp_seconds_count "}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(line.starts_with("# HELP cupola_") || line.starts_with("# TYPE cupola_") ||
                std::regex_match(line, std::regex(R"(cupola_[a-z0-9_]+(\{[a-z]+="[^"]*"\})? -?[0-9.e+-]+)")))
        << line;
  }
}

TEST(ControlServer, SaysHowFarDecodersAreAheadWhereThereIsAQueue) {
  PlayerStatus status;
  EXPECT_THAT(metrics_text(status, {}), testing::Not(HasSubstr("queue")));
  status.show.queue = {4, 6};
  EXPECT_THAT(metrics_text(status, {}), HasSubstr("cupola_queue_frames 4\n"));
  EXPECT_THAT(metrics_text(status, {}), HasSubstr("cupola_queue_frames_most 6\n"));
  EXPECT_EQ(json::parse(status_json(status, {}))["queue"]["frames"], 4);
}

TEST(ControlServer, SendsItsPageWithAPolicy) {
  PlayingShow show;
  const httplib::Result page = show.client().Get("/");
  ASSERT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("</html>"));
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'none'"));
}

TEST(ControlServer, AcceptsNoMoreConnectionsThanItCanBear) {
  PlayingShow show;
  const auto descriptors = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  };
  const auto before = descriptors();
  std::vector<int> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(show.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connect(idle.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  std::this_thread::sleep_for(300ms);
  EXPECT_LE(descriptors() - before, 100 + 20);
  for (const int one : idle) close(one);
  EXPECT_TRUE(show.becomes([](const json& now) { return now["state"] == "playing"; })) << "it recovers";
}

TEST(ControlServer, TheLoopAllocatesNothingHoweverManyAsk) {
  PlayingShow show;
  std::atomic<bool> stop{false};
  std::atomic<int> answers{0};
  const auto ask = [&](int turn) {
    const char* paths[] = {"/api/status", "/preview.jpg", "/faces/1.jpg", "/metrics", "/api/log", "/nothing"};
    show.client().Get(paths[turn % 6]);
    const char* bodies[] = {R"({"command": "blackout"})", R"({"command": "seek", "argument": 3})", "{"};
    show.command(bodies[turn % 3]);
    ++answers;
  };
  // Once alone: the library builds statics of its own on the way, under a guard that the thread sanitizer
  // does not see in code that was not compiled for it.
  for (int turn = 0; turn < 6; ++turn) ask(turn);
  std::vector<std::thread> askers;
  for (int i = 0; i < 3; ++i) {
    askers.emplace_back([&, i] {
      for (int turn = i; !stop; ++turn) ask(turn);
    });
  }
  std::this_thread::sleep_for(2s);
  stop = true;
  for (std::thread& asker : askers) asker.join();
  show.stop();
  EXPECT_GT(answers, 10);
  EXPECT_GT(show.counts().frames_presented, 10);
  EXPECT_EQ(show.counts().heap_allocations, 0);
  EXPECT_GT(show.counts().preview_bytes_copied, 0);
  EXPECT_EQ(show.counts().pixel_bytes_copied, 0);
}

TEST(ControlAddress, IsReadStrictly) {
  EXPECT_TRUE(parse_control_address("127.0.0.1:8080").loopback);
  EXPECT_TRUE(parse_control_address("localhost:80").loopback);
  EXPECT_TRUE(parse_control_address("[::1]:80").loopback);
  EXPECT_FALSE(parse_control_address("0.0.0.0:80").loopback);
  EXPECT_FALSE(parse_control_address("[::]:80").loopback);
  EXPECT_EQ(parse_control_address("[::1]:80").host, "::1");
  EXPECT_EQ(describe(parse_control_address("[fe80::1]:80")), "[fe80::1]:80");
  for (const char* wrong :
       {"", ":", "8080", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:70000", "::1:80",
        "[127.0.0.1]:80", "dome.example:80", "127.1:80", "127.0.0.1:-1", "127.0.0.1:80 "}) {
    EXPECT_THROW(parse_control_address(wrong), InputError) << wrong;
  }
}

TEST(ControlToken, IsAWholeLineOfSigns) {
  TemporaryFolder folder;
  write_text(folder / "good", kToken + "\nand a remark\n");
  EXPECT_EQ(read_token(folder / "good"), kToken);
  for (const char* wrong : {"", "short\n", "with spaces in the middle\n"}) {
    write_text(folder / "bad", wrong);
    EXPECT_THROW(read_token(folder / "bad"), InputError) << wrong;
  }
  EXPECT_THROW(read_token(folder / "none"), InputError);
}

}  // namespace
}  // namespace cupola
