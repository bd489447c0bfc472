// Errors come by longjmp, so between a guard and the library's calls there are no objects with destructors.
// SPDX-License-Identifier: MIT
#include "hal/camera/jpeg_decoder.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <new>

#include <jerror.h>
#include <jpeglib.h>

namespace cupola {

namespace {

constexpr int kMostRows = 4 * DCTSIZE;  // of a component in a row of blocks

}  // namespace

struct JpegDecoder::Library {
  jpeg_decompress_struct decompress{};
  jpeg_error_mgr errors{};
  std::jmp_buf out{};

  [[noreturn]] static void leave(j_common_ptr common) {
    std::longjmp(static_cast<Library*>(common->client_data)->out, 1);
  }
  // Data that had to be guessed is damage.
  static void warn(j_common_ptr common, int level) {
    if (level < 0 && common->err->msg_code != JWRN_EXTRANEOUS_DATA) leave(common);
  }

  // After setjmp(out).
  std::optional<JpegKind> read_header(std::span<const std::uint8_t> jpeg) {
    jpeg_mem_src(&decompress, jpeg.data(), static_cast<unsigned long>(jpeg.size()));
    if (jpeg_read_header(&decompress, TRUE) != JPEG_HEADER_OK) return std::nullopt;
    if (decompress.progressive_mode || jpeg_has_multiple_scans(&decompress) ||
        decompress.data_precision != 8) {
      return std::nullopt;
    }
    JpegKind kind;
    kind.width = static_cast<int>(decompress.image_width);
    kind.height = static_cast<int>(decompress.image_height);
    const jpeg_component_info* component = decompress.comp_info;
    if (decompress.num_components == 1 && component[0].h_samp_factor == 1 &&
        component[0].v_samp_factor == 1) {
      kind.format = CameraFormat::kGrey;
      return kind;
    }
    if (decompress.num_components != 3 || decompress.jpeg_color_space != JCS_YCbCr) return std::nullopt;
    const int rows = component[0].v_samp_factor;
    if (component[0].h_samp_factor != 2 || rows > 2) return std::nullopt;
    for (int c = 1; c < 3; ++c) {
      if (component[c].h_samp_factor != 1 || component[c].v_samp_factor != 1) return std::nullopt;
    }
    kind.format = rows == 2 ? CameraFormat::kI420 : CameraFormat::kI422;
    return kind;
  }

  // A row of blocks of each component at a time.
  void read_rows(const std::array<JpegPlane, 3>& planes, int rows) {
    decompress.raw_data_out = TRUE;
    decompress.out_color_space = decompress.jpeg_color_space;
    decompress.do_fancy_upsampling = FALSE;
    decompress.dct_method = JDCT_ISLOW;  // the same bits with and without SIMD
    jpeg_start_decompress(&decompress);
    JSAMPROW pointers[3][kMostRows];
    JSAMPARRAY components[3] = {pointers[0], pointers[1], pointers[2]};
    const auto height = static_cast<JDIMENSION>(decompress.max_v_samp_factor * DCTSIZE);
    for (int y = 0; y < rows; y += static_cast<int>(height)) {
      for (int c = 0; c < decompress.num_components; ++c) {
        const int factor = decompress.comp_info[c].v_samp_factor;
        const int first = y / decompress.max_v_samp_factor * factor;
        const JpegPlane& plane = planes[static_cast<std::size_t>(c)];
        for (int i = 0; i < factor * DCTSIZE; ++i) pointers[c][i] = plane.data + (first + i) * plane.stride;
      }
      jpeg_read_raw_data(&decompress, components, height);
    }
  }
};

JpegDecoder::JpegDecoder() : library_(std::make_unique<Library>()) {
  Library& library = *library_;
  library.decompress.err = jpeg_std_error(&library.errors);
  library.errors.error_exit = Library::leave;
  library.errors.emit_message = Library::warn;
  library.errors.output_message = [](j_common_ptr) {};
  library.decompress.client_data = &library;
  if (setjmp(library.out) != 0) throw std::bad_alloc();
  jpeg_create_decompress(&library.decompress);
  library.decompress.client_data = &library;
}

JpegDecoder::~JpegDecoder() {
  jpeg_destroy_decompress(&library_->decompress);
}

std::optional<JpegKind> JpegDecoder::look(std::span<const std::uint8_t> jpeg) noexcept {
  Library& library = *library_;
  if (setjmp(library.out) != 0) {
    jpeg_abort_decompress(&library.decompress);
    return std::nullopt;
  }
  const std::optional<JpegKind> kind = library.read_header(jpeg);
  jpeg_abort_decompress(&library.decompress);
  return kind;
}

JpegDecoder::Outcome JpegDecoder::decode(std::span<const std::uint8_t> jpeg, const JpegKind& kind,
                                         const std::array<JpegPlane, 3>& planes, int rows) noexcept {
  Library& library = *library_;
  if (setjmp(library.out) != 0) {
    jpeg_abort_decompress(&library.decompress);
    return Outcome::kDamaged;
  }
  const std::optional<JpegKind> found = library.read_header(jpeg);
  const bool as_agreed = found == kind;
  if (as_agreed) library.read_rows(planes, std::min(rows, kind.height));
  jpeg_abort_decompress(&library.decompress);
  return as_agreed ? Outcome::kDone : Outcome::kOther;
}

}  // namespace cupola
