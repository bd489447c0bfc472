// Edges as runs of texels that rise or fall.
// SPDX-License-Identifier: MIT
#include "firmware/camera_picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cupola {
namespace {

constexpr int kRowStep = 4;
constexpr int kLeastRise = 40;  // steps of 255; below it may be noise
constexpr std::size_t kFewestEdges = 50;

struct Brightness {  // of the format's first plane, in bytes
  int first;
  int step;
  bool rgb;
};

std::optional<Brightness> brightness(CameraFormat format) {
  switch (format) {
    case CameraFormat::kYuyv:
      return Brightness{0, 2, false};
    case CameraFormat::kUyvy:
    case CameraFormat::kP010:  // its upper byte
      return Brightness{1, 2, false};
    case CameraFormat::kNv12:
    case CameraFormat::kI420:
    case CameraFormat::kI422:
    case CameraFormat::kGrey:
      return Brightness{0, 1, false};
    case CameraFormat::kRgb24:
    case CameraFormat::kBgr24:
      return Brightness{1, 3, true};
    case CameraFormat::kXrgb32:
      return Brightness{1, 4, true};
    case CameraFormat::kMjpeg:
      break;
  }
  return std::nullopt;
}

// Of frames that have all their rows.
std::optional<Brightness> brightness_of(const CameraFrame& frame) {
  const std::optional<Brightness> where = brightness(frame.format);
  const CameraPlane& plane = frame.planes[0];
  if (!where || !plane.data || frame.width < 2 || frame.height < 1 || plane.stride < 1) return std::nullopt;
  const auto row_bytes = static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(where->step);
  if (plane.bytes <
      row_bytes + static_cast<std::size_t>(plane.stride) * static_cast<std::size_t>(frame.height - 1))
    return std::nullopt;
  return where;
}

void find_edges(const std::vector<int>& row, std::vector<double>& widths) {
  std::size_t begin = 0;
  int steepest = 0;
  int sign = 0;
  for (std::size_t i = 1; i <= row.size(); ++i) {
    const int change = i < row.size() ? row[i] - row[i - 1] : 0;
    const int now = (change > 0) - (change < 0);
    if (now != 0 && now == sign) {
      steepest = std::max(steepest, std::abs(change));
      continue;
    }
    const int rise = std::abs(row[i - 1] - row[begin]);
    if (sign != 0 && rise >= kLeastRise) widths.push_back(static_cast<double>(rise) / steepest);
    begin = i - 1;
    steepest = std::abs(change);
    sign = now;
  }
}

}  // namespace

std::optional<PictureFacts> look_at(const CameraFrame& frame, const CameraMode& mode) {
  const std::optional<Brightness> where = brightness_of(frame);
  if (!where) return std::nullopt;
  const CameraPlane& plane = frame.planes[0];
  const bool full = where->rgb || mode.full_range;
  const int black = full ? 0 : 16;
  const int white = full ? 255 : 235;
  std::vector<int> row(static_cast<std::size_t>(frame.width));
  std::vector<double> widths;
  double sum = 0.0;
  double at_white = 0.0;
  double texels = 0.0;
  for (int y = 0; y < frame.height; y += kRowStep) {
    const std::uint8_t* from = plane.data + y * plane.stride + where->first;
    for (int& value : row) {
      value = *from;
      from += where->step;
      sum += value;
      at_white += value >= white ? 1.0 : 0.0;
    }
    texels += static_cast<double>(row.size());
    find_edges(row, widths);
  }
  PictureFacts facts;
  facts.mean = std::clamp((sum / texels - black) / (white - black), 0.0, 1.0);
  facts.white_share = at_white / texels;
  if (widths.size() >= kFewestEdges) {
    const auto tenth = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 10);
    std::nth_element(widths.begin(), tenth, widths.end());
    facts.edge_texels = *tenth;
  }
  return facts;
}

std::optional<GreyPicture> grey_of(const CameraFrame& frame) {
  const std::optional<Brightness> where = brightness_of(frame);
  if (!where) return std::nullopt;
  GreyPicture picture{{frame.width, frame.height}, {}};
  picture.texels.resize(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
  auto to = picture.texels.begin();
  for (int y = 0; y < frame.height; ++y) {
    const std::uint8_t* from = frame.planes[0].data + y * frame.planes[0].stride + where->first;
    for (int x = 0; x < frame.width; ++x, from += where->step) *to++ = *from;
  }
  return picture;
}

}  // namespace cupola
