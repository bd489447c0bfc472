// Addresses, tokens, and who is let in.
// SPDX-License-Identifier: MIT
#include "firmware/control_settings.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestToken = 200;

bool is_loopback(const std::string& host) {
  in_addr four{};
  in6_addr six{};
  if (inet_pton(AF_INET, host.c_str(), &four) == 1) return (ntohl(four.s_addr) >> 24) == 127;
  return inet_pton(AF_INET6, host.c_str(), &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six);
}

bool is_address(const std::string& host) {
  in6_addr any{};
  return inet_pton(AF_INET, host.c_str(), &any) == 1 || inet_pton(AF_INET6, host.c_str(), &any) == 1;
}

// "host:port" without the port, "[::1]" without brackets.
std::string_view host_of(std::string_view text) {
  if (text.starts_with('[')) return text.substr(1, text.find(']') == text.npos ? 0 : text.find(']') - 1);
  return text.substr(0, text.find(':'));
}

}  // namespace

ControlAddress parse_control_address(std::string_view text) {
  ControlAddress address;
  const std::size_t colon = text.rfind(':');
  const std::string_view port = colon == text.npos ? "" : text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  const bool whole = !port.empty() && error == std::errc() && end == port.data() + port.size() &&
                     address.port >= 0 && address.port <= 65535;
  if (whole) {
    std::string_view host = text.substr(0, colon);
    const bool bracketed = host.starts_with('[') && host.ends_with(']');
    if (bracketed) host = host.substr(1, host.size() - 2);
    address.host = host == "localhost" ? "127.0.0.1" : std::string(host);
    const bool six = address.host.find(':') != std::string::npos;
    if (is_address(address.host) && six == bracketed) {
      address.loopback = is_loopback(address.host);
      return address;
    }
  }
  throw InputError(fmt::format(
      "\"{}\": expected an address and a port, like 127.0.0.1:8080, [::1]:8080 or 0.0.0.0:8080", text));
}

std::string describe(const ControlAddress& address) {
  const bool six = address.host.find(':') != std::string::npos;
  return six ? fmt::format("[{}]:{}", address.host, address.port)
             : fmt::format("{}:{}", address.host, address.port);
}

std::string read_token(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string token;
  if (!in || !std::getline(in, token)) {
    throw InputError(fmt::format("{}: expected a file whose first line is the token", file.string()));
  }
  const bool visible = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!visible || token.size() < kShortestToken || token.size() > kLongestToken) {
    throw InputError(
        fmt::format("{}:1: expected a token of {} to {} letters, digits and signs, without spaces",
                    file.string(), kShortestToken, kLongestToken));
  }
  return token;
}

bool same_text(std::string_view a, std::string_view b) {
  unsigned differs = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    differs |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return differs == 0;
}

Access access(const HttpClaims& claims, std::string_view token) {
  if (!token.empty()) {
    constexpr std::string_view kBearer = "Bearer ";
    const bool right = claims.authorization.starts_with(kBearer) &&
                       same_text(claims.authorization.substr(kBearer.size()), token);
    return right ? Access::kGranted : Access::kNoToken;
  }
  const std::string host(host_of(claims.host));
  if (host != "localhost" && !is_loopback(host)) return Access::kForeign;
  if (!claims.origin.empty() && claims.origin != fmt::format("http://{}", claims.host))
    return Access::kForeign;
  return Access::kGranted;
}

}  // namespace cupola
