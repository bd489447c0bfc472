// TIFF through libtiff.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

// The file in memory as libtiff reads it, and the first error it reports.
struct Memory {
  std::span<const std::byte> file;
  std::uint64_t position = 0;
  std::string error;
};

tmsize_t read_memory(thandle_t handle, void* to, tmsize_t count) {
  auto& memory = *static_cast<Memory*>(handle);
  if (count < 0 || memory.position >= memory.file.size()) return 0;
  const std::uint64_t left = memory.file.size() - memory.position;
  const std::uint64_t got = std::min(left, static_cast<std::uint64_t>(count));
  std::memcpy(to, memory.file.data() + memory.position, got);
  memory.position += got;
  return static_cast<tmsize_t>(got);
}
tmsize_t write_memory(thandle_t, void*, tmsize_t) {
  return 0;
}
toff_t seek_memory(thandle_t handle, toff_t offset, int whence) {
  auto& memory = *static_cast<Memory*>(handle);
  if (whence == SEEK_CUR) offset += memory.position;
  if (whence == SEEK_END) offset += memory.file.size();
  return memory.position = offset;
}
int close_memory(thandle_t) {
  return 0;
}
toff_t size_memory(thandle_t handle) {
  return static_cast<Memory*>(handle)->file.size();
}

void remember(Memory& memory, const char* form, std::va_list values) {
  if (!memory.error.empty()) return;
  char text[256];
  std::vsnprintf(text, sizeof text, form, values);
  memory.error = text;
}
int on_error(TIFF*, void* user, const char*, const char* form, std::va_list values) {
  remember(*static_cast<Memory*>(user), form, values);
  return 1;
}
int on_warning(TIFF*, void* user, const char* module, const char* form, std::va_list values) {
  // JPEG data within a TIFF that ends early is only a warning there.
  if (module != nullptr && std::string_view(module) == "JPEGLib")
    remember(*static_cast<Memory*>(user), form, values);
  return 1;
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
struct FreeOptions {
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};

class Decoder {
 public:
  Decoder(std::span<const std::byte> file, const std::string& name) : name_(name), memory_{file, 0, {}} {
    const std::unique_ptr<TIFFOpenOptions, FreeOptions> options(TIFFOpenOptionsAlloc());
    if (!options) throw std::bad_alloc();
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(kLargestFile));
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &memory_);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, &memory_);
    tiff_.reset(TIFFClientOpenExt(name.c_str(), "rm", &memory_, read_memory, write_memory, seek_memory,
                                  close_memory, size_memory, nullptr, nullptr, options.get()));
    if (!tiff_) refuse_damage();
    read_tags();
  }

  StillInfo info() const {
    return {size_, bits_ == 16 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8};
  }

  int read(const MutableImage& into, RowRange rows) {
    const auto width = static_cast<std::size_t>(size_.width);
    const std::uint64_t line = (std::uint64_t{width} * samples_ * bits_ + 7) / 8;
    const tmsize_t promised = TIFFScanlineSize(tiff_.get());
    if (promised < 0 || static_cast<std::uint64_t>(promised) < line) refuse("has rows of a wrong length");
    std::vector<std::uint8_t> row(static_cast<std::size_t>(promised));
    std::vector<std::uint16_t> rgb(width * 3);
    for (int y = 0; y < rows.last; ++y) {  // compressed strips can only be read from their beginning
      if (TIFFReadScanline(tiff_.get(), row.data(), static_cast<std::uint32_t>(y), 0) != 1 ||
          !memory_.error.empty()) {
        refuse_damage();
      }
      if (y < rows.first) continue;
      if (bits_ == 16) {
        spread<std::uint16_t>(row.data(), rgb.data());
        store_row(rgb.data(), PixelFormat::kRgb16, into, y);
      } else {
        auto* target = reinterpret_cast<std::uint8_t*>(rgb.data());
        spread<std::uint8_t>(row.data(), target);
        store_row(target, PixelFormat::kRgb8, into, y);
      }
    }
    return size_.height - rows.last;
  }

 private:
  [[noreturn]] void refuse(std::string_view what) const {
    throw InputError(fmt::format("{}: the TIFF {}", name_, what));
  }
  [[noreturn]] void refuse_damage() const {
    refuse(memory_.error.empty() ? "is damaged" : "is damaged: " + memory_.error);
  }

  void read_tags() {
    std::uint32_t width = 0, height = 0;
    std::uint16_t form = SAMPLEFORMAT_UINT, planes = PLANARCONFIG_CONTIG, compression = COMPRESSION_NONE;
    TIFF* tiff = tiff_.get();
    if (TIFFNumberOfDirectories(tiff) != 1) refuse("has several pages; expected a single picture");
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    check_size(name_, width, height);
    size_ = {static_cast<int>(width), static_cast<int>(height)};
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits_);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples_);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &form);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planes);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric_) != 1)
      refuse("does not say what its samples mean");

    if (form != SAMPLEFORMAT_UINT && form != SAMPLEFORMAT_VOID) {
      refuse(form == SAMPLEFORMAT_IEEEFP ? "has floating-point samples; expected unsigned integers"
                                         : "has signed or complex samples; expected unsigned integers");
    }
    if (planes != PLANARCONFIG_CONTIG) refuse("keeps its planes apart; expected RGB pixel by pixel");
    if (TIFFIsTiled(tiff) != 0) refuse("is tiled; expected strips");
    if (compression == COMPRESSION_OJPEG) refuse("is compressed by old-style JPEG; expected any other way");
    if (photometric_ == PHOTOMETRIC_SEPARATED) refuse("is CMYK; expected grey, palette or RGB");
    if (photometric_ == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG) {
      TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
      photometric_ = PHOTOMETRIC_RGB;
    }
    const bool grey = photometric_ == PHOTOMETRIC_MINISBLACK || photometric_ == PHOTOMETRIC_MINISWHITE;
    const bool palette = photometric_ == PHOTOMETRIC_PALETTE;
    if (!grey && !palette && photometric_ != PHOTOMETRIC_RGB) {
      refuse(fmt::format("has colours of kind {}; expected grey, palette or RGB", photometric_));
    }
    const bool shallow = bits_ == 1 || bits_ == 2 || bits_ == 4;
    if (bits_ != 8 && !(bits_ == 16 && !palette) && !(shallow && samples_ == 1)) {
      refuse(fmt::format("has {} samples of {} bits a pixel; expected 8 or 16 bits", samples_, bits_));
    }
    if (samples_ < (photometric_ == PHOTOMETRIC_RGB ? 3 : 1) || samples_ > 16) {
      refuse(fmt::format("has {} samples a pixel; expected 1 to 4", samples_));
    }
    if (palette) read_palette();
  }

  void read_palette() {
    std::uint16_t* channels[3] = {};
    if (TIFFGetField(tiff_.get(), TIFFTAG_COLORMAP, &channels[0], &channels[1], &channels[2]) != 1) {
      refuse("has no palette");
    }
    const std::size_t entries = std::size_t{1} << bits_;
    bool deep = false;  // some writers put 8-bit values where 16 bits belong
    for (std::size_t i = 0; i < entries; ++i)
      for (const std::uint16_t* channel : channels) deep = deep || channel[i] > 255;
    for (std::size_t i = 0; i < entries; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        palette_[i][c] = static_cast<std::uint8_t>(deep ? (channels[c][i] + 128) / 257 : channels[c][i]);
      }
    }
  }

  // One stored row to RGB.
  template <class Sample>
  void spread(const std::uint8_t* row, Sample* rgb) const {
    constexpr unsigned kMost = sizeof(Sample) == 2 ? 65'535 : 255;
    const unsigned largest = (1U << bits_) - 1;
    const unsigned flip = photometric_ == PHOTOMETRIC_MINISWHITE ? largest : 0;
    const bool coloured = photometric_ == PHOTOMETRIC_RGB;
    for (std::size_t x = 0; x < static_cast<std::size_t>(size_.width); ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = x * samples_ + (coloured ? c : 0);
        unsigned value = 0;
        if (bits_ < 8) {  // the first pixel is in the highest bits
          value = (row[at * bits_ / 8] >> (8 - bits_ - at * bits_ % 8)) & largest;
        } else {
          Sample sample;
          std::memcpy(&sample, row + at * sizeof(Sample), sizeof(Sample));
          value = sample;
        }
        const bool palette = photometric_ == PHOTOMETRIC_PALETTE;
        rgb[3 * x + c] =
            static_cast<Sample>(palette ? palette_[value][c] : (value ^ flip) * (kMost / largest));
      }
    }
  }

  const std::string& name_;
  Memory memory_;
  std::unique_ptr<TIFF, CloseTiff> tiff_;
  Size size_;
  std::uint16_t bits_ = 1;
  std::uint16_t samples_ = 1;
  std::uint16_t photometric_ = PHOTOMETRIC_MINISBLACK;
  std::array<std::array<std::uint8_t, 3>, 256> palette_{};
};

}  // namespace

StillInfo probe_tiff(std::span<const std::byte> file, const std::string& name) {
  return Decoder(file, name).info();
}

int read_tiff(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
              RowRange rows) {
  return Decoder(file, name).read(into, rows);
}

}  // namespace cupola
