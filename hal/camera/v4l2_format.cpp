// Single- and multi-planar formats, both turned into one layout.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_format.h"

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "hal/camera/camera_planes.h"
#include "hal/camera/v4l2_crop.h"

namespace cupola {

namespace {

constexpr __u32 kMostFormats = 256;  // that a device can list

struct KnownFormat {
  CameraFormat format;
  __u32 fourcc;
  std::size_t memories;  // more than one: multi-planar devices only
};

constexpr std::array<KnownFormat, 14> kKnown = {{
    {CameraFormat::kYuyv, V4L2_PIX_FMT_YUYV, 1},
    {CameraFormat::kUyvy, V4L2_PIX_FMT_UYVY, 1},
    {CameraFormat::kNv12, V4L2_PIX_FMT_NV12, 1},
    {CameraFormat::kNv12, V4L2_PIX_FMT_NV12M, 2},
    {CameraFormat::kP010, V4L2_PIX_FMT_P010, 1},
    {CameraFormat::kI420, V4L2_PIX_FMT_YUV420, 1},
    {CameraFormat::kI420, V4L2_PIX_FMT_YUV420M, 3},
    {CameraFormat::kI422, V4L2_PIX_FMT_YUV422P, 1},
    {CameraFormat::kI422, V4L2_PIX_FMT_YUV422M, 3},
    {CameraFormat::kRgb24, V4L2_PIX_FMT_RGB24, 1},
    {CameraFormat::kBgr24, V4L2_PIX_FMT_BGR24, 1},
    {CameraFormat::kXrgb32, V4L2_PIX_FMT_XBGR32, 1},
    {CameraFormat::kGrey, V4L2_PIX_FMT_GREY, 1},
    {CameraFormat::kMjpeg, V4L2_PIX_FMT_MJPEG, 1},
}};

// A format as either API says it.
struct Picture {
  __u32 fourcc = 0;
  __u32 width = 0;
  __u32 height = 0;
  __u32 field = V4L2_FIELD_NONE;
  __u32 colorspace = 0;
  __u32 encoding = 0;
  __u32 quantization = 0;
  std::size_t memories = 1;
  std::array<__u32, 3> strides{};
  std::array<__u32, 3> bytes{};
};

Picture read(const v4l2_format& format, bool multi_planar) noexcept {
  Picture picture;
  if (!multi_planar) {
    const v4l2_pix_format& pix = format.fmt.pix;
    picture = {pix.pixelformat, pix.width,        pix.height, pix.field, pix.colorspace,
               pix.ycbcr_enc,   pix.quantization, 1,          {},        {}};
    picture.strides[0] = pix.bytesperline;
    picture.bytes[0] = pix.sizeimage;
    return picture;
  }
  const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
  picture = {pix.pixelformat, pix.width,        pix.height,     pix.field, pix.colorspace,
             pix.ycbcr_enc,   pix.quantization, pix.num_planes, {},        {}};
  for (std::size_t m = 0; m < std::min<std::size_t>(pix.num_planes, 3); ++m) {
    picture.strides[m] = pix.plane_fmt[m].bytesperline;
    picture.bytes[m] = pix.plane_fmt[m].sizeimage;
  }
  return picture;
}

int get(const V4l2Node& node, Picture& picture) noexcept {
  v4l2_format format{};
  format.type = node.type();
  const int error = node.ask(VIDIOC_G_FMT, &format);
  if (error == 0) picture = read(format, node.multi_planar);
  return error;
}

int set(const V4l2Node& node, Picture& picture) noexcept {
  v4l2_format format{};
  format.type = node.type();
  if (node.multi_planar) {
    format.fmt.pix_mp.pixelformat = picture.fourcc;
    format.fmt.pix_mp.width = picture.width;
    format.fmt.pix_mp.height = picture.height;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
    format.fmt.pix_mp.num_planes = static_cast<__u8>(picture.memories);
  } else {
    format.fmt.pix.pixelformat = picture.fourcc;
    format.fmt.pix.width = picture.width;
    format.fmt.pix.height = picture.height;
    format.fmt.pix.field = V4L2_FIELD_NONE;
  }
  const int error = node.ask(VIDIOC_S_FMT, &format);
  if (error == 0) picture = read(format, node.multi_planar);
  return error;
}

// The best known format that the device lists: the first of the wish, or the device's own first.
std::variant<KnownFormat, CameraTrouble> choose(const V4l2Node& node, const CameraSetup& setup) noexcept {
  const KnownFormat* best = nullptr;
  std::size_t best_rank = setup.formats.size() + 1;
  for (__u32 index = 0; index < kMostFormats; ++index) {
    v4l2_fmtdesc listed{};
    listed.type = node.type();
    listed.index = index;
    const int error = node.ask(VIDIOC_ENUM_FMT, &listed);
    if (error == EINVAL) break;  // the end of the list
    if (error != 0) return refused("VIDIOC_ENUM_FMT", error);
    for (const KnownFormat& known : kKnown) {
      if (known.fourcc != listed.pixelformat || (known.memories > 1 && !node.multi_planar)) continue;
      const auto wish = std::ranges::find(setup.formats, known.format);
      if (wish == setup.formats.end() && !setup.formats.empty()) continue;
      const auto rank = static_cast<std::size_t>(wish - setup.formats.begin());
      if (rank < best_rank) {
        best = &known;
        best_rank = rank;
      }
    }
  }
  if (best) return *best;
  return CameraTrouble{CameraCause::kUnsupported, "VIDIOC_ENUM_FMT", 0};
}

// Planes lie behind each other where they share a piece of memory.
bool lay_out(const Picture& picture, V4l2Layout& layout) noexcept {
  const CameraMode& mode = layout.mode;
  layout.memories = picture.memories;
  for (std::size_t m = 0; m < layout.memories; ++m) layout.memory_bytes[m] = picture.bytes[m];
  if (mode.format == CameraFormat::kMjpeg) {
    layout.planes[0] = {0, 0, 0, layout.memory_bytes[0]};
    return layout.memory_bytes[0] > 0;
  }
  std::size_t end = 0;
  for (int p = 0; p < plane_count(mode.format); ++p) {
    const auto index = static_cast<std::size_t>(p);
    const PlaneShape shape = plane_shape(mode.format, p, mode.width, mode.height);
    V4l2PlanePlace& place = layout.planes[index];
    if (layout.memories > 1) {
      place.memory = index;
      place.stride = picture.strides[index];
      end = 0;
    } else {
      place.stride = picture.strides[0];
      if (plane_count(mode.format) == 3 && p > 0) place.stride /= 2;
    }
    if (place.stride < shape.row_bytes) return false;
    place.offset = end;
    place.bytes = static_cast<std::size_t>(place.stride * shape.rows);
    end += place.bytes;
    const auto padding = static_cast<std::size_t>(place.stride - shape.row_bytes);
    if (end - padding > layout.memory_bytes[place.memory]) return false;
  }
  return true;
}

void read_colours(const Picture& picture, CameraMode& mode) noexcept {
  const bool rgb = mode.format == CameraFormat::kRgb24 || mode.format == CameraFormat::kBgr24 ||
                   mode.format == CameraFormat::kXrgb32;
  const __u32 encoding = picture.encoding != V4L2_YCBCR_ENC_DEFAULT
                             ? picture.encoding
                             : static_cast<__u32>(V4L2_MAP_YCBCR_ENC_DEFAULT(picture.colorspace));
  const __u32 quantization =
      picture.quantization != V4L2_QUANTIZATION_DEFAULT
          ? picture.quantization
          : static_cast<__u32>(V4L2_MAP_QUANTIZATION_DEFAULT(rgb, picture.colorspace, encoding));
  mode.bt709 = encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709;
  mode.full_range = quantization == V4L2_QUANTIZATION_FULL_RANGE;
}

double settle_rate(const V4l2Node& node, double wanted) noexcept {
  v4l2_streamparm parameters{};
  parameters.type = node.type();
  if (node.ask(VIDIOC_G_PARM, &parameters) != 0) return 0.0;
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  if (wanted > 0.0 && (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0) {
    const v4l2_fract before = period;
    period = {1000, static_cast<__u32>(std::lround(wanted * 1000.0))};
    if (node.ask(VIDIOC_S_PARM, &parameters) != 0) period = before;
  }
  return period.numerator > 0 ? static_cast<double>(period.denominator) / period.numerator : 0.0;
}

}  // namespace

std::variant<V4l2Layout, CameraTrouble> settle_format(const V4l2Node& node,
                                                      const CameraSetup& setup) noexcept {
  const auto chosen = choose(node, setup);
  if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&chosen)) return *trouble;
  const KnownFormat& known = *std::get_if<KnownFormat>(&chosen);

  const V4l2Whole whole = uncrop(node);
  Picture picture;
  if (const int error = get(node, picture)) return refused("VIDIOC_G_FMT", error);
  picture.fourcc = known.fourcc;
  picture.memories = known.memories;
  if (setup.width > 0) {
    picture.width = static_cast<__u32>(setup.width);
    picture.height = static_cast<__u32>(setup.height);
  }
  const Picture asked = picture;
  int error = set(node, picture);
  const bool size_as_asked = picture.width == asked.width && picture.height == asked.height;
  if (error == 0 && setup.width > 0 && !size_as_asked) {
    return CameraTrouble{CameraCause::kUnsupported, "VIDIOC_S_FMT: size", 0};
  }
  CameraArea crop = setup.crop;
  if (error == 0 && crop.width > 0 && set_crop(node, whole, crop)) {
    // As many texels for each of the sensor's as before.
    picture.width = static_cast<__u32>(std::lround(1.0 * crop.width * picture.width / whole.area.width));
    picture.height = static_cast<__u32>(std::lround(1.0 * crop.height * picture.height / whole.area.height));
    error = set(node, picture);
  }
  if (error != 0) {
    CameraTrouble trouble = refused("VIDIOC_S_FMT", error);
    if (error == EINVAL) trouble.cause = CameraCause::kUnsupported;
    return trouble;
  }
  if (picture.fourcc != known.fourcc || picture.memories != known.memories) {
    return CameraTrouble{CameraCause::kUnsupported, "VIDIOC_S_FMT: format", 0};
  }
  if (picture.field != V4L2_FIELD_NONE && picture.field != V4L2_FIELD_INTERLACED) {
    return CameraTrouble{CameraCause::kUnsupported, "VIDIOC_S_FMT: fields", 0};
  }
  V4l2Layout layout;
  layout.mode.format = known.format;
  layout.mode.width = static_cast<int>(picture.width);
  layout.mode.height = static_cast<int>(picture.height);
  layout.mode.crop = crop_of(node, layout.mode);
  read_colours(picture, layout.mode);
  if (!lay_out(picture, layout)) return CameraTrouble{CameraCause::kChanged, "VIDIOC_S_FMT: stride", 0};
  layout.mode.rate = settle_rate(node, setup.rate);
  return layout;
}

}  // namespace cupola
