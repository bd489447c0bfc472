// Where the player listens for its operator, and who may speak.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace cupola {

struct ControlAddress {
  std::string host;  // an IPv4 or IPv6 address, without brackets
  int port = 0;      // 0: any that is free
  bool loopback = false;
};

// "127.0.0.1:8080", "[::1]:8080", "localhost:8080" or "0.0.0.0:8080". Throws InputError.
ControlAddress parse_control_address(std::string_view text);
std::string describe(const ControlAddress& address);  // the same the other way round

// The show file's [control].
struct ControlSettings {
  std::optional<ControlAddress> http;  // none: nobody listens
  std::optional<ControlAddress> osc;   // over UDP; none: nobody listens
  std::filesystem::path token_file;
};

// The first line of the file: 16 to 200 visible characters. Throws InputError.
std::string read_token(const std::filesystem::path& file);

// Takes as long for any two texts of those lengths: for tokens.
bool same_text(std::string_view a, std::string_view b);

// What a request says of itself; empty where it does not.
struct HttpClaims {
  std::string_view host;           // Host
  std::string_view origin;         // Origin: only browsers say it
  std::string_view authorization;  // Authorization
};

// Whether a request may be answered; why not, in words. With a token that is what counts. Without one, only
// requests that name this machine by a loopback name pass, so that no page from elsewhere can have a browser
// on this machine command the player, neither directly nor by a name that it makes point here.
enum class Access { kGranted, kNoToken, kForeign };
Access access(const HttpClaims& claims, std::string_view token);

}  // namespace cupola
