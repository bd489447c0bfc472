// Parsing the header line of a YUV4MPEG2 file.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/y4m_header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

constexpr std::string_view kMagic = "YUV4MPEG2";

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size() && number >= 0;
}

bool take(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

bool read_colour(std::string_view tag, Y4mHeader& header) {
  header.chroma_shift_x = header.chroma_shift_y = 0;
  if (take(tag, "mono")) {
    header.colour = false;
    return tag.empty() || (read_number(tag, header.bits) && header.bits > 8 && header.bits <= 16);
  }
  if (take(tag, "420")) {
    header.chroma_shift_x = header.chroma_shift_y = 1;
    // MPEG-2 and everything since put chroma on the even columns; JPEG and plain 420 between.
    if (tag.starts_with("mpeg2") || tag.starts_with("paldv") || tag.starts_with("p1")) {
      header.siting_x = Siting::kOnFirst;
    }
    if (take(tag, "paldv")) header.siting_y = Siting::kOnFirst;
    if (!take(tag, "jpeg")) take(tag, "mpeg2");
  } else if (take(tag, "422")) {
    header.chroma_shift_x = 1;
    header.siting_x = Siting::kOnFirst;
  } else if (!take(tag, "444")) {
    return false;
  }
  if (tag.empty()) return true;
  return take(tag, "p") && read_number(tag, header.bits) && header.bits > 8 && header.bits <= 16;
}

}  // namespace

Y4mHeader parse_y4m_header(std::string_view start, const std::string& name) {
  const auto refuse = [&](std::string_view what) { throw InputError(fmt::format("{}: {}", name, what)); };
  if (!start.starts_with(kMagic)) refuse("not a Y4M video; expected YUV4MPEG2 as its first word");
  const std::size_t end = start.substr(0, kLongestY4mHeader).find('\n');
  if (end == std::string_view::npos)
    refuse(fmt::format("the Y4M header does not end within {} bytes", kLongestY4mHeader));

  Y4mHeader header;
  header.bytes = end + 1;
  header.chroma_shift_x = header.chroma_shift_y = 1;  // without a C tag: 420jpeg
  std::string_view rest = start.substr(kMagic.size(), end - kMagic.size());
  while (!rest.empty()) {
    rest.remove_prefix(1);
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(word.size());
    if (word.empty()) continue;
    const std::string_view value = word.substr(1);
    bool understood = true;
    switch (word[0]) {
      case 'W':
        understood = read_number(value, header.size.width);
        break;
      case 'H':
        understood = read_number(value, header.size.height);
        break;
      case 'F': {
        const std::size_t colon = value.find(':');
        understood = colon != std::string_view::npos &&
                     read_number(value.substr(0, colon), header.rate.numerator) &&
                     read_number(value.substr(colon + 1), header.rate.denominator);
        break;
      }
      case 'I':
        if (value != "p" && value != "?")
          refuse(fmt::format("the Y4M video is interlaced ({}); expected Ip", word));
        break;
      case 'C':
        if (!read_colour(value, header)) {
          refuse(fmt::format(
              "Y4M colour space {}; expected C420, C420jpeg, C420mpeg2, C420paldv, C422, C444 or Cmono, "
              "of 8 to 16 bits",
              word));
        }
        break;
      case 'X':
        if (value == "COLORRANGE=FULL") header.full_range = true;
        break;  // other extensions are for other programs
      case 'A':
        break;  // shape of the pixels: always square here
      default:
        understood = false;
    }
    if (!understood) refuse(fmt::format("Y4M header: {} is not understood", word));
  }
  check_size(name, header.size.width, header.size.height);
  if (header.rate.denominator == 0) header.rate = {};
  return header;
}

FrameRate frame_rate(double rate) {
  const double thousand_and_first = rate * 1.001;
  FrameRate result{std::llround(rate * 1000.0), 1000};
  if (std::abs(rate - std::round(rate)) > 1e-6 &&
      std::abs(thousand_and_first - std::round(thousand_and_first)) < 0.002) {
    result = {std::llround(thousand_and_first) * 1000, 1001};
  }
  const std::int64_t common = std::gcd(result.numerator, result.denominator);
  return {result.numerator / common, result.denominator / common};
}

}  // namespace cupola
