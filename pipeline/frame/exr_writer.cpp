// OpenEXR files: frames' sRGB decoded to linear light in half floats.
// SPDX-License-Identifier: MIT
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <fmt/format.h>
#include <half.h>

#include <array>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <vector>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/srgb_curve.h"
#include "pipeline/frame/still.h"

namespace cupola {
namespace {

class Memory final : public Imf::OStream {
 public:
  explicit Memory(const std::string& name) : Imf::OStream(name.c_str()) {}
  void write(const char from[], int count) override {
    const auto bytes = static_cast<std::size_t>(count);
    if (file.size() < position_ + bytes) file.resize(position_ + bytes);
    std::memcpy(file.data() + position_, from, bytes);
    position_ += bytes;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }

  std::vector<std::byte> file;

 private:
  std::size_t position_ = 0;
};

// Of every 16-bit code.
const std::vector<half>& light_of_code() {
  static const std::vector<half> light = [] {
    std::vector<half> table(65536);
    for (std::size_t code = 0; code < table.size(); ++code)
      table[code] = half(static_cast<float>(light_of_srgb(static_cast<double>(code) / 65535.0)));
    return table;
  }();
  return light;
}

void encode(const Image& image, Imf::OStream& into) {
  constexpr std::array<const char*, 3> kChannels = {"R", "G", "B"};
  Imf::Header header(image.size.width, image.size.height);
  Imf::addChromaticities(header, Imf::Chromaticities());  // sRGB's
  for (const char* channel : kChannels) header.channels().insert(channel, Imf::Channel(Imf::HALF));
  Imf::OutputFile output(into, header, 0);  // no threads but this one

  const std::vector<half>& light = light_of_code();
  const auto width = static_cast<std::size_t>(image.size.width);
  std::vector<std::uint16_t> codes(3 * width);
  std::vector<half> row(3 * width);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < 3; ++c) {
    char* const base = reinterpret_cast<char*>(row.data() + c);
    buffer.insert(kChannels[c], Imf::Slice(Imf::HALF, base, 3 * sizeof(half), 0));  // every row here
  }
  output.setFrameBuffer(buffer);
  for (int y = 0; y < image.size.height; ++y) {
    MutableImage to{PixelFormat::kRgb16, {image.size.width, 1}, {}};
    to.planes[0] = {reinterpret_cast<std::byte*>(codes.data()), 0};
    convert(row_of(image, y), to);
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = light[codes[i]];
    output.writePixels(1);
  }
}

}  // namespace

void write_exr(const std::filesystem::path& path, const Image& image) {
  AtomicFile file(path);
  Memory memory(path.string());
  try {
    encode(image, memory);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Failure(fmt::format("{}: cannot be written: {}", path.string(), error.what()));
  }
  file.write(memory.file);
  file.commit();
}

}  // namespace cupola
