// A FakeV4l2 device's format, crop, rate, input and controls.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "tests/hal/fake_v4l2_node.h"

namespace cupola {

namespace {

constexpr __u32 kHdmiBlanking = 16;  // texels a row and rows a frame

CameraFormat format_of_fourcc(__u32 fourcc) {
  switch (fourcc) {
    case V4L2_PIX_FMT_UYVY:
      return CameraFormat::kUyvy;
    case V4L2_PIX_FMT_NV12:
    case V4L2_PIX_FMT_NV12M:
      return CameraFormat::kNv12;
    case V4L2_PIX_FMT_P010:
      return CameraFormat::kP010;
    case V4L2_PIX_FMT_YUV420:
    case V4L2_PIX_FMT_YUV420M:
      return CameraFormat::kI420;
    case V4L2_PIX_FMT_YUV422P:
    case V4L2_PIX_FMT_YUV422M:
      return CameraFormat::kI422;
    case V4L2_PIX_FMT_RGB24:
      return CameraFormat::kRgb24;
    case V4L2_PIX_FMT_BGR24:
      return CameraFormat::kBgr24;
    case V4L2_PIX_FMT_XBGR32:
      return CameraFormat::kXrgb32;
    case V4L2_PIX_FMT_GREY:
      return CameraFormat::kGrey;
    case V4L2_PIX_FMT_MJPEG:
      return CameraFormat::kMjpeg;
    default:
      return CameraFormat::kYuyv;
  }
}

template <std::size_t n>
void write(__u8 (&field)[n], const std::string& text) {
  std::memset(field, 0, n);
  std::memcpy(field, text.data(), std::min(text.size(), n - 1));
}

}  // namespace

FakeV4l2Node::Sizes FakeV4l2Node::sizes() const {
  Sizes result;
  result.format = format_of_fourcc(settings_.fourcc);
  const int width = static_cast<int>(settings_.width);
  const int height = static_cast<int>(settings_.height);
  if (result.format == CameraFormat::kMjpeg) {
    result.strides = {0};
    result.bytes = {static_cast<__u32>(FakePicture(result.format, width, height, 0).bytes())};
    return result;
  }
  const bool apart = settings_.fourcc == V4L2_PIX_FMT_NV12M || settings_.fourcc == V4L2_PIX_FMT_YUV420M ||
                     settings_.fourcc == V4L2_PIX_FMT_YUV422M;
  for (int p = 0; p < plane_count(result.format); ++p) {
    const PlaneShape shape = plane_shape(result.format, p, width, height);
    const bool half = plane_count(result.format) == 3 && p > 0;
    auto stride = static_cast<__u32>(shape.row_bytes) + (half ? device_.padding / 2 : device_.padding);
    const __u32 bytes = stride * static_cast<__u32>(shape.rows);
    if (has(CameraFault::kWrongStride)) stride /= 2;
    if (p == 0 || apart) {
      result.strides.push_back(stride);
      result.bytes.push_back(bytes);
    } else {
      result.bytes[0] += bytes;
    }
  }
  return result;
}

void FakeV4l2Node::change_signal(int width, int height, double rate) {
  catch_up();
  device_.width = width;
  device_.height = height;
  device_.rate = rate;
  send_event(V4L2_EVENT_SOURCE_CHANGE);
}

std::int64_t FakeV4l2Node::control(const std::string& name) const {
  const auto found = std::ranges::find(device_.controls, name, &FakeV4l2Control::name);
  return found == device_.controls.end() ? -1 : found->value;
}

int FakeV4l2Node::settings_ioctl(FakeV4l2File& file, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      write(capability.driver, "fake");
      write(capability.card, device_.card);
      write(capability.bus_info, device_.bus);
      const __u32 video = device_.multi_planar ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE;
      capability.device_caps = V4L2_CAP_STREAMING | (device_.captures ? video : V4L2_CAP_META_CAPTURE);
      capability.capabilities = V4L2_CAP_STREAMING | video | V4L2_CAP_META_CAPTURE | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& listed = *static_cast<v4l2_fmtdesc*>(argument);
      if (listed.type != type() || listed.index >= device_.fourccs.size()) return EINVAL;
      listed.pixelformat = device_.fourccs[listed.index];
      return 0;
    }
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT:
      if (request == VIDIOC_S_FMT && owner_)
        return owner_ == &file ? misuse("S_FMT with buffers", EBUSY) : EBUSY;
      return set_format(*static_cast<v4l2_format*>(argument), request == VIDIOC_S_FMT);
    case VIDIOC_G_SELECTION:
    case VIDIOC_S_SELECTION:
      return select(*static_cast<v4l2_selection*>(argument), request == VIDIOC_S_SELECTION);
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& parameters = *static_cast<v4l2_streamparm*>(argument);
      if (parameters.type != type()) return misuse("PARM: type", EINVAL);
      if (device_.hdmi) return ENOTTY;
      const v4l2_fract asked = parameters.parm.capture.timeperframe;
      if (request == VIDIOC_S_PARM && asked.numerator > 0) rate_ = 1.0 * asked.denominator / asked.numerator;
      parameters.parm.capture.capability = device_.sets_rate ? V4L2_CAP_TIMEPERFRAME : 0;
      parameters.parm.capture.timeperframe = {1000, static_cast<__u32>(std::lround(rate_ * 1000.0))};
      return 0;
    }
    default: {
      const int error = input_ioctl(request, argument);
      return error == ENOTTY ? control_ioctl(request, argument) : error;
    }
  }
}

int FakeV4l2Node::set_format(v4l2_format& format, bool is_set) {
  if (format.type != type()) return misuse("FMT: type", EINVAL);
  if (is_set) {
    const __u32 asked = device_.multi_planar ? format.fmt.pix_mp.pixelformat : format.fmt.pix.pixelformat;
    // Drivers take the nearest they have: ours has two sizes, all of the crop or a quarter of it.
    const __u32 width = device_.multi_planar ? format.fmt.pix_mp.width : format.fmt.pix.width;
    const bool small = width <= crop_.width / 2 && crop_.width / 2 >= FakePicture::kLeastWidth;
    settings_.width = small ? crop_.width / 2 : crop_.width;
    settings_.height = small ? crop_.height / 2 : crop_.height;
    if (std::ranges::count(device_.fourccs, asked) > 0) settings_.fourcc = asked;
    if (has(CameraFault::kWrongFormat)) settings_.fourcc = V4L2_PIX_FMT_GREY;
    if (has(CameraFault::kWrongSize)) settings_.height /= 2;
  }
  const Sizes layout = sizes();
  if (!device_.multi_planar) {
    format.fmt.pix = {};
    format.fmt.pix.pixelformat = settings_.fourcc;
    format.fmt.pix.width = settings_.width;
    format.fmt.pix.height = settings_.height;
    format.fmt.pix.field = device_.field;
    format.fmt.pix.colorspace = device_.colorspace;
    format.fmt.pix.bytesperline = layout.strides[0];
    format.fmt.pix.sizeimage = layout.bytes[0] - device_.missing_image_bytes;
    return 0;
  }
  format.fmt.pix_mp = {};
  format.fmt.pix_mp.pixelformat = settings_.fourcc;
  format.fmt.pix_mp.width = settings_.width;
  format.fmt.pix_mp.height = settings_.height;
  format.fmt.pix_mp.field = device_.field;
  format.fmt.pix_mp.colorspace = device_.colorspace;
  format.fmt.pix_mp.num_planes = static_cast<__u8>(layout.bytes.size());
  for (std::size_t m = 0; m < layout.bytes.size(); ++m) {
    format.fmt.pix_mp.plane_fmt[m].bytesperline = layout.strides[m];
    format.fmt.pix_mp.plane_fmt[m].sizeimage = layout.bytes[m];
  }
  return 0;
}

// The sensor's picture begins at (8, 4) of its array; crops grow to multiples of 8.
int FakeV4l2Node::select(v4l2_selection& selection, bool is_set) {
  if (selection.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return misuse("SELECTION: type", EINVAL);
  if (!device_.can_crop) return ENOTTY;
  const v4l2_rect whole = {0, 0, static_cast<__u32>(device_.width), static_cast<__u32>(device_.height)};
  v4l2_rect answer = whole;
  if (selection.target == V4L2_SEL_TGT_CROP) {
    if (is_set) {
      if (owner_) return EBUSY;
      if (selection.flags != V4L2_SEL_FLAG_GE)
        return misuse("S_SELECTION may cut off what is needed", EINVAL);
      const int left = (selection.r.left - 8) & ~7;
      const int top = (selection.r.top - 4) & ~7;
      const int right = (selection.r.left - 8 + static_cast<int>(selection.r.width) + 7) & ~7;
      const int bottom = (selection.r.top - 4 + static_cast<int>(selection.r.height) + 7) & ~7;
      if (left < 0 || top < 0 || left >= device_.width || top >= device_.height) return EINVAL;
      crop_ = {left, top, static_cast<__u32>(std::min(right, device_.width) - left),
               static_cast<__u32>(std::min(bottom, device_.height) - top)};
    }
    answer = crop_;
  } else if (selection.target != V4L2_SEL_TGT_CROP_DEFAULT || is_set) {
    return EINVAL;
  }
  selection.r = {answer.left + 8, answer.top + 4, answer.width, answer.height};
  return 0;
}

int FakeV4l2Node::input_ioctl(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_G_INPUT:
      *static_cast<int*>(argument) = 0;
      return 0;
    case VIDIOC_ENUMINPUT: {
      auto& input = *static_cast<v4l2_input*>(argument);
      if (input.index != 0) return EINVAL;
      input.capabilities = device_.hdmi ? V4L2_IN_CAP_DV_TIMINGS : 0;
      input.status = has(CameraFault::kNoSignal) ? V4L2_IN_ST_NO_SIGNAL : 0;
      return 0;
    }
    case VIDIOC_QUERY_DV_TIMINGS:
    case VIDIOC_S_DV_TIMINGS: {
      if (!device_.hdmi) return ENODATA;
      auto& timings = *static_cast<v4l2_dv_timings*>(argument);
      if (request == VIDIOC_S_DV_TIMINGS) {
        if (owner_) return EBUSY;
        settings_.width = timings.bt.width;
        settings_.height = timings.bt.height;
        crop_ = {0, 0, timings.bt.width, timings.bt.height};
        rate_ = device_.rate;
        return 0;
      }
      if (has(CameraFault::kNoSignal)) return ENOLINK;
      timings = {};
      timings.type = V4L2_DV_BT_656_1120;
      timings.bt.width = static_cast<__u32>(device_.width);
      timings.bt.height = static_cast<__u32>(device_.height);
      timings.bt.hfrontporch = kHdmiBlanking;
      timings.bt.vfrontporch = kHdmiBlanking;
      timings.bt.pixelclock = static_cast<__u64>(std::lround(
          device_.rate * (timings.bt.width + kHdmiBlanking) * (timings.bt.height + kHdmiBlanking)));
      return 0;
    }
    default:
      return ENOTTY;
  }
}

int FakeV4l2Node::control_ioctl(unsigned long request, void* argument) {
  if (request == VIDIOC_QUERY_EXT_CTRL) {
    auto& asked = *static_cast<v4l2_query_ext_ctrl*>(argument);
    const bool next = (asked.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
    const __u32 id = asked.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
    const FakeV4l2Control* found = nullptr;
    for (const FakeV4l2Control& control : device_.controls) {
      if (next ? control.id > id && (!found || control.id < found->id) : control.id == id) found = &control;
    }
    if (!found) return EINVAL;
    asked = {};
    asked.id = found->id;
    asked.type = found->type;
    asked.minimum = found->minimum;
    asked.maximum = found->maximum;
    std::memcpy(asked.name, found->name.data(), std::min(found->name.size(), sizeof(asked.name) - 1));
    return 0;
  }
  if (request == VIDIOC_S_EXT_CTRLS) {
    auto& all = *static_cast<v4l2_ext_controls*>(argument);
    if (all.which != V4L2_CTRL_WHICH_CUR_VAL || all.count != 1) return misuse("S_EXT_CTRLS", EINVAL);
    const v4l2_ext_control& set = all.controls[0];
    const auto found = std::ranges::find(device_.controls, set.id, &FakeV4l2Control::id);
    if (found == device_.controls.end()) return EINVAL;
    const std::int64_t value = found->type == V4L2_CTRL_TYPE_INTEGER64 ? set.value64 : set.value;
    if (value < found->minimum || value > found->maximum || std::ranges::count(found->refused, value) > 0) {
      return ERANGE;
    }
    found->value = value;
    return 0;
  }
  return ENOTTY;
}

}  // namespace cupola
