// OpenEXR: linear light, encoded as sRGB in 16 bits, so that it is as any other deep picture from here on.
// SPDX-License-Identifier: MIT
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfTileDescriptionAttribute.h>
#include <ImfVersion.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <memory>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/frame/srgb_code.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

constexpr int kMostChannels = 64;
constexpr unsigned kLargestTile = 1024;  // pixels; whole rows of tiles are decoded at once

class Memory final : public Imf::IStream {
 public:
  Memory(std::span<const std::byte> file, const std::string& name)
      : Imf::IStream(name.c_str()), file_(file) {}
  bool read(char into[], int count) override {
    if (count < 0 || static_cast<std::uint64_t>(count) > file_.size() - std::min(position_, file_.size()))
      throw std::runtime_error("it is cut short");
    std::memcpy(into, file_.data() + position_, static_cast<std::size_t>(count));
    position_ += static_cast<std::size_t>(count);
    return position_ < file_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }

 private:
  std::span<const std::byte> file_;
  std::size_t position_ = 0;
};

struct Exr {
  Imf::Header header;
  Imath::Box2i window;                  // what is shown
  std::array<std::string, 3> channels;  // of red, green, blue; three times Y of a grey one
};

// Side of a box, from inclusive ends that may be anything.
std::int64_t side(int first, int last) {
  return std::int64_t{last} - first + 1;
}

[[noreturn]] void refuse(const std::string& name, std::string_view what) {
  throw InputError(fmt::format("{}: the EXR {}", name, what));
}

// Everything is looked at before the library allocates by it.
void read_header(std::span<const std::byte> file, const std::string& name, Exr& exr) {
  Memory memory(file, name);
  std::array<unsigned char, 8> start{};
  memory.read(reinterpret_cast<char*>(start.data()), start.size());
  int version = 0;
  for (int i = 0; i < 4; ++i) version |= start[static_cast<std::size_t>(4 + i)] << (8 * i);
  if (Imf::getVersion(version) != Imf::EXR_VERSION) refuse(name, "is of another version; expected 2");
  if (Imf::isMultiPart(version)) refuse(name, "has several parts; expected a single picture");
  if (Imf::isNonImage(version)) refuse(name, "has deep pixels; expected a flat picture");
  exr.header.readFrom(memory, version);
  const Imath::Box2i& data = exr.header.dataWindow();
  exr.window = exr.header.displayWindow();
  check_size(name, side(data.min.x, data.max.x), side(data.min.y, data.max.y));
  check_size(name, side(exr.window.min.x, exr.window.max.x), side(exr.window.min.y, exr.window.max.y));
  exr.header.sanityCheck(Imf::isTiled(version), false);
  if (Imf::isTiled(version)) {
    const Imf::TileDescription& tiles = exr.header.tileDescription();
    if (tiles.xSize > kLargestTile || tiles.ySize > kLargestTile)
      refuse(name, fmt::format("has tiles of {} x {}; expected at most {}", tiles.xSize, tiles.ySize,
                               kLargestTile));
  }
  const Imf::ChannelList& channels = exr.header.channels();
  std::vector<std::string> names;
  for (auto at = channels.begin(); at != channels.end(); ++at) names.emplace_back(at.name());
  if (names.size() > kMostChannels) refuse(name, fmt::format("has {} channels", names.size()));
  const bool coloured = channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B");
  if (!coloured && (!channels.findChannel("Y") || channels.findChannel("RY") || channels.findChannel("BY")))
    refuse(name, fmt::format("has channels {}; expected R, G and B, or Y alone", fmt::join(names, " ")));
  exr.channels = {"Y", "Y", "Y"};
  if (coloured) exr.channels = {"R", "G", "B"};
  for (const std::string& channel : exr.channels) {
    const Imf::Channel& one = channels[channel];
    if (one.type == Imf::UINT) refuse(name, "has whole numbers; expected half or float");
    if (one.xSampling != 1 || one.ySampling != 1) refuse(name, "has channels of different sizes");
  }
}

// What the library throws becomes an InputError.
template <class Read>
auto guarded(const std::string& name, const Read& read) {
  try {
    return read();
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    std::string text = error.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    refuse(name, "is damaged: " + text);
  }
}

}  // namespace

StillInfo probe_exr(std::span<const std::byte> file, const std::string& name) {
  return guarded(name, [&] {
    Exr exr;
    read_header(file, name, exr);
    const Size size{static_cast<int>(side(exr.window.min.x, exr.window.max.x)),
                    static_cast<int>(side(exr.window.min.y, exr.window.max.y))};
    return StillInfo{size, PixelFormat::kRgbPlanar16};
  });
}

int read_exr(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
             RowRange rows) {
  return guarded(name, [&] {
    Exr exr;
    read_header(file, name, exr);
    Memory memory(file, name);
    Imf::InputFile input(memory, 0);  // no threads but this one
    const Imath::Box2i data = exr.header.dataWindow();
    const auto across = static_cast<std::size_t>(side(data.min.x, data.max.x));
    std::vector<float> light(3 * across);
    std::vector<std::uint16_t> codes(3 * static_cast<std::size_t>(into.size.width));
    for (int y = rows.first; y < rows.last; ++y) {
      const std::int64_t stored = std::int64_t{exr.window.min.y} + y;
      std::fill(codes.begin(), codes.end(), std::uint16_t{0});
      if (stored >= data.min.y && stored <= data.max.y) {
        // The library adds x and y of the data window to the base itself: strides of 0 leave out y.
        Imf::FrameBuffer buffer;
        for (std::size_t c = 0; c < 3; ++c) {
          if (c > 0 && exr.channels[c] == exr.channels[0]) break;
          char* base = reinterpret_cast<char*>(light.data() + c) - std::ptrdiff_t{data.min.x} * 12;
          buffer.insert(exr.channels[c], Imf::Slice(Imf::FLOAT, base, 12, 0));
        }
        input.setFrameBuffer(buffer);
        input.readPixels(static_cast<int>(stored));
        const bool grey = exr.channels[1] == exr.channels[0];
        const std::int64_t first = std::max(data.min.x, exr.window.min.x);
        const std::int64_t last = std::min(data.max.x, exr.window.max.x);
        for (std::int64_t x = first; x <= last; ++x) {
          const float* from = &light[3 * static_cast<std::size_t>(x - data.min.x)];
          std::uint16_t* to = &codes[3 * static_cast<std::size_t>(x - exr.window.min.x)];
          for (std::size_t c = 0; c < 3; ++c) to[c] = srgb16_code(from[grey ? 0 : c]);
        }
      }
      store_row(codes.data(), PixelFormat::kRgb16, into, y);
    }
    return into.size.height - (rows.last - rows.first);
  });
}

}  // namespace cupola
