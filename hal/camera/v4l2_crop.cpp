// VIDIOC_S_SELECTION; coordinates of ours begin at the sensor's default rectangle.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_crop.h"

#include <algorithm>

namespace cupola {

namespace {

// The single-planar type serves both APIs here.
v4l2_selection selection(__u32 target) noexcept {
  v4l2_selection selected{};
  selected.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  selected.target = target;
  return selected;
}

V4l2Whole whole_of(const V4l2Node& node) noexcept {
  v4l2_selection standard = selection(V4L2_SEL_TGT_CROP_DEFAULT);
  if (node.ask(VIDIOC_G_SELECTION, &standard) != 0) return {};
  const v4l2_rect& r = standard.r;
  return {{0, 0, static_cast<int>(r.width), static_cast<int>(r.height)}, r.left, r.top};
}

}  // namespace

V4l2Whole uncrop(const V4l2Node& node) noexcept {
  const V4l2Whole whole = whole_of(node);
  if (whole.area.width > 0) {
    CameraArea everything = whole.area;
    set_crop(node, whole, everything);
  }
  return whole;
}

bool set_crop(const V4l2Node& node, const V4l2Whole& whole, CameraArea& area) noexcept {
  const int left = std::max(area.x, 0);
  const int top = std::max(area.y, 0);
  const int right = std::min(area.x + area.width, whole.area.width);
  const int bottom = std::min(area.y + area.height, whole.area.height);
  if (left >= right || top >= bottom) return false;
  v4l2_selection crop = selection(V4L2_SEL_TGT_CROP);
  crop.flags = V4L2_SEL_FLAG_GE;
  crop.r = {whole.left + left, whole.top + top, static_cast<__u32>(right - left),
            static_cast<__u32>(bottom - top)};
  if (node.ask(VIDIOC_S_SELECTION, &crop) != 0) return false;
  area = {crop.r.left - whole.left, crop.r.top - whole.top, static_cast<int>(crop.r.width),
          static_cast<int>(crop.r.height)};
  return true;
}

CameraArea crop_of(const V4l2Node& node, const CameraMode& mode) noexcept {
  const V4l2Whole whole = whole_of(node);
  v4l2_selection crop = selection(V4L2_SEL_TGT_CROP);
  if (whole.area.width == 0 || node.ask(VIDIOC_G_SELECTION, &crop) != 0) {
    return {0, 0, mode.width, mode.height};
  }
  return {crop.r.left - whole.left, crop.r.top - whole.top, static_cast<int>(crop.r.width),
          static_cast<int>(crop.r.height)};
}

}  // namespace cupola
