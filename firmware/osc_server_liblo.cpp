// Our own socket, since liblo's servers listen at every address of the machine; packets are liblo's.
// SPDX-License-Identifier: MIT
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "firmware/due_queue.h"
#include "firmware/osc_packet.h"
#include "firmware/osc_server.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

// At most 6400 packets a second are looked at, so that a flood does not keep a core busy.
constexpr int kAtOnce = 32;
constexpr int kRestMs = 5;
constexpr auto kRefusalsApart = 10s;  // lines in the log
constexpr auto kSameApart = 1s;       // of one command: a fader sends dozens a second

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }

 private:
  int number_;
};

struct Sender {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  std::string text() const {
    std::array<char, NI_MAXHOST> host{};
    const int failed = getnameinfo(reinterpret_cast<const sockaddr*>(&address), length, host.data(),
                                   host.size(), nullptr, 0, NI_NUMERICHOST);
    return failed ? "?" : host.data();
  }
};

Sender socket_address(const ControlAddress& address) {
  Sender place;
  if (address.host.find(':') == std::string::npos) {
    auto& four = reinterpret_cast<sockaddr_in&>(place.address);
    four.sin_family = AF_INET;
    four.sin_port = htons(static_cast<std::uint16_t>(address.port));
    inet_pton(AF_INET, address.host.c_str(), &four.sin_addr);
    place.length = sizeof four;
  } else {
    auto& six = reinterpret_cast<sockaddr_in6&>(place.address);
    six.sin6_family = AF_INET6;
    six.sin6_port = htons(static_cast<std::uint16_t>(address.port));
    inet_pton(AF_INET6, address.host.c_str(), &six.sin6_addr);
    place.length = sizeof six;
  }
  return place;
}

// What a message that may asks for.
struct Order {
  std::string word;
  std::vector<OscValue> values;
  Sender from;
  std::chrono::nanoseconds ahead{0};  // it came, of its bundle's time
};

class UdpOscServer final : public OscServer {
 public:
  UdpOscServer(const ControlAddress& address, std::string token, ShowFacts facts, ControlLink& link,
               Clock& clock, std::function<WallTime()> time_of_day);
  ~UdpOscServer() override {
    eventfd_write(stop_, 1);
    thread_.join();
  }
  const ControlAddress& address() const override { return address_; }

 private:
  void listen();
  bool stopped(int wait_ms) const;
  bool hear_one();
  void hear(std::vector<OscMessage> messages, const Sender& from);
  void take(OscMessage message, std::chrono::nanoseconds now, const Sender& from);
  void obey_those_due();
  void obey(const Order& order);
  void answer(const std::string& address, const Sender& to) const;
  void note(const PlayerCommand& command, const ShowFacts& facts, const Order& order);
  void note_refusal(std::string_view why, const Sender& from);
  ShowFacts facts() const { return link_.reload ? link_.reload->facts() : facts_; }

  ControlAddress address_;
  std::string token_;
  ShowFacts facts_;
  ControlLink& link_;
  Clock& clock_;
  std::function<WallTime()> time_of_day_;
  Descriptor socket_;
  Descriptor stop_;
  // The thread's own.
  std::array<std::uint8_t, kLargestOscPacket + 1> packet_{};
  OscMoments moments_;
  DueQueue<Order, CommandQueue::kSlots> later_;
  OscReport report_;
  std::int64_t refusals_ = 0;  // that no line tells of
  std::optional<std::chrono::nanoseconds> refusal_noted_;
  std::optional<std::pair<PlayerAction, std::chrono::nanoseconds>> noted_;
  std::thread thread_;
};

UdpOscServer::UdpOscServer(const ControlAddress& address, std::string token, ShowFacts facts,
                           ControlLink& link, Clock& clock, std::function<WallTime()> time_of_day)
    : address_(address),
      token_(std::move(token)),
      facts_(std::move(facts)),
      link_(link),
      clock_(clock),
      time_of_day_(std::move(time_of_day)),
      socket_(socket(address.host.find(':') == std::string::npos ? AF_INET : AF_INET6,
                     SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      stop_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  Sender place = socket_address(address);
  auto* const where = reinterpret_cast<sockaddr*>(&place.address);
  if (socket_ < 0 || stop_ < 0 || bind(socket_, where, place.length) != 0 ||
      getsockname(socket_, where, &place.length) != 0) {
    throw Failure(
        fmt::format("control: osc {}: cannot listen there: {}", describe(address), std::strerror(errno)));
  }
  address_.port = ntohs(place.address.ss_family == AF_INET
                            ? reinterpret_cast<const sockaddr_in&>(place.address).sin_port
                            : reinterpret_cast<const sockaddr_in6&>(place.address).sin6_port);
  report_.wanted = true;
  link_.osc.publish(report_);
  thread_ = std::thread([this] {
    setpriority(PRIO_PROCESS, 0, 10);  // this thread's: the show comes first
    listen();
  });
}

void UdpOscServer::listen() {
  int heard = 0;
  while (!stopped(heard == kAtOnce ? kRestMs : 0)) {
    clock_.wait(std::array<int, 2>{socket_, stop_}, later_.next());
    obey_those_due();
    for (heard = 0; heard < kAtOnce && hear_one();) ++heard;
    link_.osc.publish(report_);
  }
}

bool UdpOscServer::stopped(int wait_ms) const {
  pollfd wait{stop_, POLLIN, 0};
  return poll(&wait, 1, wait_ms) > 0;
}

// False when nothing is left.
bool UdpOscServer::hear_one() {
  Sender from;
  const ssize_t size = recvfrom(socket_, packet_.data(), packet_.size(), 0,
                                reinterpret_cast<sockaddr*>(&from.address), &from.length);
  if (size < 0) return false;
  try {
    hear(read_osc_packet({packet_.data(), static_cast<std::size_t>(size)}), from);
  } catch (const std::exception& wrong) {
    ++report_.refused;
    note_refusal(wrong.what(), from);
  }
  return true;
}

// A packet that cannot be kept whole until its time is not kept at all.
void UdpOscServer::hear(std::vector<OscMessage> messages, const Sender& from) {
  const std::chrono::nanoseconds now = clock_.now();
  moments_.look(time_of_day_(), now);
  std::size_t later = 0;
  for (const OscMessage& message : messages) {
    const std::chrono::duration<double> ahead = moments_.due(message.time) - now;
    if (ahead > kFarthestAhead) {
      throw InputError(
          fmt::format("a bundle's time is {:.1f} seconds ahead; expected at most {}, by clocks that agree",
                      ahead.count(), kFarthestAhead.count()));
    }
    if (ahead.count() > 0.0) ++later;
  }
  if (later > later_.room()) {
    ++report_.crowded;
    return note_refusal("too many commands wait for their time", from);
  }
  for (OscMessage& message : messages) take(std::move(message), now, from);
}

// Nobody is told but those who ask and may: a refusal that is answered makes an echo of the player.
void UdpOscServer::take(OscMessage message, std::chrono::nanoseconds now, const Sender& from) {
  try {
    const std::optional<std::string_view> word = osc_word(message.address, token_);
    if (!word) {
      ++report_.denied;
      return note_refusal("expected /cupola/TOKEN/COMMAND with the token", from);
    }
    const std::chrono::nanoseconds due = moments_.due(message.time);
    Order order{std::string(*word), std::move(message.values), from, due - now};
    if (due <= now) return obey(order);
    if (*word == kOscStatus) {
      order.values.clear();  // any number of them
    } else {
      parse_osc_command(*word, order.values, facts().cues);  // what is wrong is wrong at once
    }
    later_.add(due, std::move(order));
  } catch (const InputError& wrong) {  // the packet's other messages count
    ++report_.refused;
    note_refusal(wrong.what(), from);
  }
}

void UdpOscServer::obey_those_due() {
  const std::chrono::nanoseconds now = clock_.now();
  while (const std::optional<Order> order = later_.take(now)) {
    try {
      obey(*order);
    } catch (const std::exception& wrong) {  // another show was read meanwhile
      ++report_.refused;
      note_refusal(wrong.what(), order->from);
    }
  }
}

void UdpOscServer::obey(const Order& order) {
  if (order.word == kOscStatus) {
    ++report_.taken;
    return answer("/cupola/status", order.from);
  }
  const ShowFacts facts = this->facts();
  const std::optional<PlayerCommand> command = parse_osc_command(order.word, order.values, facts.cues);
  if (!command) {
    ++report_.released;
  } else if (link_.commands.push(*command)) {
    ++report_.taken;
    note(*command, facts, order);
  } else {
    ++report_.crowded;
    note_refusal("too many commands at once", order.from);
  }
}

// State, cue's number and name, place in seconds, volume in percent, dark or not, late and dropped frames.
void UdpOscServer::answer(const std::string& address, const Sender& to) const {
  const PlayerStatus status = link_.status.read();
  const ShowFacts facts = this->facts();
  const ShowReport& show = status.show;
  const std::chrono::duration<double> place = show.position;
  const std::string bytes = osc_packet(
      {address,
       {std::string(name_of(status.state)), static_cast<std::int64_t>(show.cue + 1),
        show.cue < facts.cues.size() ? facts.cues[show.cue] : "", place.count(), std::int64_t{status.volume},
        status.black, status.counts.frames_late, status.counts.frames_dropped}});
  sendto(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&to.address), to.length);
}

void UdpOscServer::note(const PlayerCommand& command, const ShowFacts& facts, const Order& order) {
  const std::chrono::nanoseconds now = clock_.now();
  if (noted_ && noted_->first == command.action && now - noted_->second < kSameApart) return;
  noted_ = {command.action, now};
  const std::chrono::duration<double> ahead = order.ahead;
  link_.log.info(
      Topic::kControl,
      fmt::format("{}: osc: {}{}", order.from.text(), describe(command, facts.cues),
                  ahead.count() > 0.0 ? fmt::format(", sent {:.3f} seconds ahead", ahead.count()) : ""));
}

void UdpOscServer::note_refusal(std::string_view why, const Sender& from) {
  const std::chrono::nanoseconds now = clock_.now();
  if (refusal_noted_ && now - *refusal_noted_ < kRefusalsApart) {
    ++refusals_;
    return;
  }
  refusal_noted_ = now;
  const std::string more = refusals_ ? fmt::format("{} more before; ", std::exchange(refusals_, 0)) : "";
  link_.log.info(Topic::kControl, fmt::format("{}: osc: refused: {}{}", from.text(), more, why));
}

}  // namespace

std::unique_ptr<OscServer> start_osc_server(const ControlAddress& address, std::string token, ShowFacts facts,
                                            ControlLink& link, Clock& clock,
                                            std::function<WallTime()> time_of_day) {
  if (!address.loopback && token.empty()) {
    throw InputError(fmt::format(
        "control: osc {}: expected a token for an address that others can reach; --token-file FILE or "
        "control.token_file names one",
        describe(address)));
  }
  return std::make_unique<UdpOscServer>(address, std::move(token), std::move(facts), link, clock,
                                        std::move(time_of_day));
}

}  // namespace cupola
