// JPEG through libjpeg-turbo. Errors come by longjmp, so between a guard and the library's calls there are no
// objects with destructors.
// SPDX-License-Identifier: MIT
#include <csetjmp>
#include <cstdio>

#include <fmt/format.h>
#include <jerror.h>
#include <jpeglib.h>

#include <string>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

constexpr int kMostScans = 500;  // a hostile progressive file can hold millions

class Decoder {
 public:
  explicit Decoder(std::span<const std::byte> file, const std::string& name) : name_(name) {
    decompress_.err = jpeg_std_error(&errors_);
    errors_.error_exit = [](j_common_ptr common) { self(common).leave(common); };
    errors_.output_message = [](j_common_ptr) {};
    errors_.emit_message = [](j_common_ptr common, int level) {
      const int code = common->err->msg_code;
      const bool harmless =
          code == JWRN_EXTRANEOUS_DATA || code == JWRN_ADOBE_XFORM || code == JWRN_JFIF_MAJOR;
      if (level < 0 && !harmless) self(common).leave(common);
    };
    progress_.progress_monitor = [](j_common_ptr common) {
      const auto* decompress = reinterpret_cast<j_decompress_ptr>(common);
      if (decompress->input_scan_number <= kMostScans) return;
      std::snprintf(self(common).message_, JMSG_LENGTH_MAX, "it has more than %d scans", kMostScans);
      std::longjmp(self(common).out_, 1);
    };
    decompress_.client_data = this;
    if (setjmp(out_) != 0) {
      jpeg_destroy_decompress(&decompress_);
      refuse();
    }
    jpeg_create_decompress(&decompress_);
    decompress_.client_data = this;
    decompress_.progress = &progress_;
    jpeg_mem_src(&decompress_, reinterpret_cast<const unsigned char*>(file.data()),
                 static_cast<unsigned long>(file.size()));
    jpeg_read_header(&decompress_, TRUE);
  }
  ~Decoder() { jpeg_destroy_decompress(&decompress_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  StillInfo info() const {
    const J_COLOR_SPACE space = decompress_.jpeg_color_space;
    if (space == JCS_CMYK || space == JCS_YCCK) {
      throw InputError(fmt::format("{}: is a {} JPEG; expected grey, YCbCr or RGB", name_,
                                   space == JCS_CMYK ? "CMYK" : "YCCK"));
    }
    if (space != JCS_GRAYSCALE && space != JCS_YCbCr && space != JCS_RGB) {
      throw InputError(fmt::format("{}: is a JPEG of {} unknown components; expected grey, YCbCr or RGB",
                                   name_, decompress_.num_components));
    }
    check_size(name_, decompress_.image_width, decompress_.image_height);
    return {{static_cast<int>(decompress_.image_width), static_cast<int>(decompress_.image_height)},
            PixelFormat::kRgbPlanar8};
  }

  void start() {
    if (setjmp(out_) != 0) refuse();
    decompress_.out_color_space = JCS_RGB;
    decompress_.dct_method = JDCT_ISLOW;  // the same bits with and without SIMD
    jpeg_start_decompress(&decompress_);
  }
  void skip(int rows) {
    if (setjmp(out_) != 0) refuse();
    jpeg_skip_scanlines(&decompress_, static_cast<JDIMENSION>(rows));
  }
  void read_row(unsigned char* row) {
    if (setjmp(out_) != 0) refuse();
    jpeg_read_scanlines(&decompress_, &row, 1);
  }
  void finish() {
    if (setjmp(out_) != 0) refuse();
    jpeg_finish_decompress(&decompress_);
  }

 private:
  static Decoder& self(j_common_ptr common) { return *static_cast<Decoder*>(common->client_data); }
  [[noreturn]] void leave(j_common_ptr common) {
    common->err->format_message(common, message_);
    std::longjmp(out_, 1);
  }
  [[noreturn]] void refuse() const {
    throw InputError(fmt::format("{}: the JPEG is damaged: {}", name_, message_));
  }

  const std::string& name_;
  jpeg_decompress_struct decompress_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf out_{};
  char message_[JMSG_LENGTH_MAX] = {};
};

}  // namespace

StillInfo probe_jpeg(std::span<const std::byte> file, const std::string& name) {
  return Decoder(file, name).info();
}

int read_jpeg(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
              RowRange rows) {
  Decoder decoder(file, name);
  decoder.start();
  std::vector<unsigned char> row(static_cast<std::size_t>(into.size.width) * 3);
  if (rows.first > 0) decoder.skip(rows.first);
  for (int y = rows.first; y < rows.last; ++y) {
    decoder.read_row(row.data());
    store_row(row.data(), PixelFormat::kRgb8, into, y);
  }
  if (rows.last == into.size.height) decoder.finish();
  return into.size.height - (rows.last - rows.first);
}

}  // namespace cupola
