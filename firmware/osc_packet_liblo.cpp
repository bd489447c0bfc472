// Messages are liblo's; bundles are taken apart here: liblo does so only in a server of its own.
// SPDX-License-Identifier: MIT
#include "firmware/osc_packet.h"

#include <fmt/format.h>
#include <lo/lo.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kBundleName = 8;     // "#bundle", 0
constexpr std::size_t kBundleHeader = 16;  // and a time
constexpr int kDeepest = 8;                // bundles within bundles

struct FreeMessage {
  using pointer = lo_message;
  void operator()(lo_message message) const { lo_message_free(message); }
};
using Message = std::unique_ptr<lo_message, FreeMessage>;

// An argument lies at a multiple of four bytes, whatever its own alignment.
template <class Value>
Value read_value(const lo_arg* argument) {
  Value value{};
  std::memcpy(&value, argument, sizeof value);
  return value;
}

OscValue value_of(char type, const lo_arg* argument) {
  switch (type) {
    case LO_INT32:
      return std::int64_t{read_value<std::int32_t>(argument)};
    case LO_INT64:
      return read_value<std::int64_t>(argument);
    case LO_FLOAT:
      return double{read_value<float>(argument)};
    case LO_DOUBLE:
      return read_value<double>(argument);
    case LO_STRING:
    case LO_SYMBOL:
      return std::string(reinterpret_cast<const char*>(argument));
    case LO_TRUE:
      return true;
    case LO_FALSE:
      return false;
    case LO_INFINITUM:
      return OscImpulse();
    default:
      throw InputError("a value of a type other than i, h, f, d, s, S, T, F and I");
  }
}

std::uint64_t read_big_endian(Bytes bytes) {
  std::uint64_t number = 0;
  for (const std::uint8_t byte : bytes) number = number << 8U | byte;
  return number;
}

OscMessage read_message(Bytes bytes) {
  std::vector<std::uint8_t> data(bytes.begin(), bytes.end());  // liblo wants it to be writable
  const auto end = std::find(data.begin(), data.end(), 0);
  if (data.empty() || data[0] != '/' || end == data.end() || data.size() % 4 != 0) {
    throw InputError("no OSC packet");
  }
  OscMessage read;
  read.address.assign(data.begin(), end);
  const std::size_t padded = (read.address.size() / 4 + 1) * 4;
  if (padded == data.size()) return read;  // as old senders have it: no types, no values
  int result = 0;
  const Message message(lo_message_deserialise(data.data(), data.size(), &result));
  if (!message) throw InputError(fmt::format("an ill-formed OSC message (liblo's error {})", result));
  const char* types = lo_message_get_types(message.get());
  lo_arg** arguments = lo_message_get_argv(message.get());
  const int count = lo_message_get_argc(message.get());
  for (int i = 0; i < count; ++i) read.values.push_back(value_of(types[i], arguments[i]));
  return read;
}

// Of a bundle within one that counts at `time`.
OscTime read_time(Bytes bytes, OscTime time) {
  const OscTime own = read_big_endian(bytes);
  if (own <= kOscAtOnce) return time;
  if (time != kOscAtOnce && earlier(own, time)) {
    throw InputError("an OSC bundle that is to count before the one around it");
  }
  return own;
}

void read_element(Bytes bytes, int depth, OscTime time, std::vector<OscMessage>& messages) {
  if (bytes.size() < kBundleName || std::memcmp(bytes.data(), "#bundle", kBundleName) != 0) {
    messages.push_back(read_message(bytes));
    messages.back().time = time;
    return;
  }
  if (bytes.size() < kBundleHeader || depth == kDeepest) throw InputError("an ill-formed OSC bundle");
  time = read_time(bytes.subspan(kBundleName, kBundleHeader - kBundleName), time);
  for (bytes = bytes.subspan(kBundleHeader); !bytes.empty();) {
    if (bytes.size() < 4) throw InputError("an ill-formed OSC bundle");
    const std::size_t size = read_big_endian(bytes.first(4));
    bytes = bytes.subspan(4);
    if (size > bytes.size()) throw InputError("an ill-formed OSC bundle");
    read_element(bytes.first(size), depth + 1, time, messages);
    bytes = bytes.subspan(size);
  }
}

}  // namespace

std::vector<OscMessage> read_osc_packet(std::span<const std::uint8_t> packet) {
  if (packet.size() > kLargestOscPacket) {
    throw InputError(fmt::format("an OSC packet of over {} bytes", kLargestOscPacket));
  }
  std::vector<OscMessage> messages;
  read_element(packet, 0, kOscAtOnce, messages);
  return messages;
}

std::string osc_packet(const OscMessage& message) {
  const Message made(lo_message_new());
  for (const OscValue& value : message.values) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
      const bool fits = *whole >= std::numeric_limits<std::int32_t>::min() &&
                        *whole <= std::numeric_limits<std::int32_t>::max();
      if (fits) {
        lo_message_add_int32(made.get(), static_cast<std::int32_t>(*whole));
      } else {
        lo_message_add_int64(made.get(), *whole);
      }
    } else if (const auto* number = std::get_if<double>(&value)) {
      lo_message_add_float(made.get(), static_cast<float>(*number));
    } else if (const auto* text = std::get_if<std::string>(&value)) {
      lo_message_add_string(made.get(), text->c_str());
    } else if (const auto* flag = std::get_if<bool>(&value)) {
      *flag ? lo_message_add_true(made.get()) : lo_message_add_false(made.get());
    } else {
      lo_message_add_infinitum(made.get());
    }
  }
  std::size_t size = 0;
  const std::unique_ptr<void, void (*)(void*)> bytes(
      lo_message_serialise(made.get(), message.address.c_str(), nullptr, &size), std::free);
  if (!bytes) throw Failure("an OSC message cannot be made");
  return {static_cast<const char*>(bytes.get()), size};
}

}  // namespace cupola
