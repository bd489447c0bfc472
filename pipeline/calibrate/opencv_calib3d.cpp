// OpenCV's chessboards by sectors, and its two calibrations.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/opencv.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace cupola {
namespace {

// OpenCV's pixel centres are whole numbers, a view's halves.
constexpr double kHalf = 0.5;

cv::Mat grey(const Image& picture) {
  ImageBuffer rgb(PixelFormat::kRgb8, picture.size);
  convert(picture, rgb.pixels());
  cv::Mat mat(picture.size.height, picture.size.width, CV_8UC1);
  for (int y = 0; y < picture.size.height; ++y) {
    const auto* from = rgb.pixels().samples<std::uint8_t>(0, y);
    auto* to = mat.ptr<std::uint8_t>(y);
    // Rec. 601, as shares of 256.
    for (int x = 0; x < picture.size.width; ++x, from += 3)
      to[x] = static_cast<std::uint8_t>((77 * from[0] + 150 * from[1] + 29 * from[2] + 128) >> 8);
  }
  return mat;
}

double mean_within(const cv::Mat& mat, const std::vector<cv::Point2f>& corners, int columns, int x, int y) {
  const auto at = [&](int i, int j) { return corners[static_cast<std::size_t>(j * columns + i)]; };
  const cv::Point2f middle = (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) * 0.25F;
  const int px = std::clamp(static_cast<int>(std::lround(middle.x)), 0, mat.cols - 1);
  const int py = std::clamp(static_cast<int>(std::lround(middle.y)), 0, mat.rows - 1);
  return mat.at<std::uint8_t>(py, px);
}

// The distance to the nearest neighbour, texels.
float spacing(const std::vector<cv::Point2f>& corners, const Board& board, std::size_t which) {
  const auto columns = static_cast<std::size_t>(board.columns);
  float least = 1e9F;
  const auto look = [&](bool there, std::size_t other) {
    if (!there) return;
    const cv::Point2f apart = corners[other] - corners[which];
    least = std::min(least, std::hypot(apart.x, apart.y));
  };
  look(which % columns > 0, which - 1);
  look(which % columns + 1 < columns, which + 1);
  look(which >= columns, which - columns);
  look(which + columns < corners.size(), which + columns);
  return least;
}

// By the gradients around each corner, as far as its own four squares reach: finding them uses windows so
// wide that a lens bends squares within them.
void refine(const cv::Mat& mat, const Board& board, std::vector<cv::Point2f>& corners) {
  const std::vector<cv::Point2f> found = corners;
  const cv::TermCriteria enough(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const int reach = std::clamp(static_cast<int>(0.4F * spacing(found, board, i)), 2, 8);
    std::vector<cv::Point2f> one = {found[i]};
    cv::cornerSubPix(mat, one, cv::Size(reach, reach), cv::Size(-1, -1), enough);
    corners[i] = one[0];
  }
}

double bilinear(const cv::Mat& mat, cv::Point2f at) {
  const float x = std::clamp(at.x, 0.0F, static_cast<float>(mat.cols) - 1.001F);
  const float y = std::clamp(at.y, 0.0F, static_cast<float>(mat.rows) - 1.001F);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const float u = x - static_cast<float>(i);
  const float v = y - static_cast<float>(j);
  const auto* above = mat.ptr<std::uint8_t>(j) + i;
  const auto* below = mat.ptr<std::uint8_t>(j + 1) + i;
  return (1.0F - v) * ((1.0F - u) * above[0] + u * above[1]) + v * ((1.0F - u) * below[0] + u * below[1]);
}

// From a tenth to nine tenths of the step between two squares, along the line that joins their middles; the
// median over all neighbours. 0 where squares are too small to have a level of their own.
double edge_width(const cv::Mat& mat, const Board& board, const std::vector<cv::Point2f>& corners) {
  constexpr int kSteps = 64;
  constexpr float kSmallest = 6.0F;  // texels from middle to middle
  std::vector<double> widths;
  const auto middle = [&](int x, int y) {
    const auto at = static_cast<std::size_t>(y * board.columns + x);
    const auto below = at + static_cast<std::size_t>(board.columns);
    return (corners[at] + corners[at + 1] + corners[below] + corners[below + 1]) * 0.25F;
  };
  const auto measure = [&](cv::Point2f from, cv::Point2f to) {
    const cv::Point2f step = (to - from) * (1.0F / kSteps);
    const double first = bilinear(mat, from);
    const double rise = bilinear(mat, to) - first;
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    if (length < kSmallest || std::abs(rise) < 20.0) return;
    double low = -1.0;
    double before = 0.0;
    for (int i = 1; i <= kSteps; ++i) {
      const double share = (bilinear(mat, from + step * static_cast<float>(i)) - first) / rise;
      const auto crossed = [&](double level) { return i - 1 + (level - before) / (share - before); };
      if (low < 0.0 && share >= 0.1) low = crossed(0.1);
      if (share >= 0.9) {
        widths.push_back((crossed(0.9) - low) * length / kSteps);
        return;
      }
      before = share;
    }
  };
  for (int y = 0; y + 1 < board.rows; ++y) {
    for (int x = 0; x + 1 < board.columns; ++x) {
      if (x + 2 < board.columns) measure(middle(x, y), middle(x + 1, y));
      if (y + 2 < board.rows) measure(middle(x, y), middle(x, y + 1));
    }
  }
  if (widths.empty()) return 0.0;
  const auto half = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), half, widths.end());
  return *half;
}

// Rows run as on the board: x to y clockwise in the picture, and the first inner square dark.
void put_in_order(const cv::Mat& mat, const Board& board, std::vector<cv::Point2f>& corners) {
  const auto columns = static_cast<std::size_t>(board.columns);
  const cv::Point2f along = corners[columns - 1] - corners[0];
  const cv::Point2f down = corners[corners.size() - columns] - corners[0];
  if (along.x * down.y - along.y * down.x < 0.0F) {
    for (std::size_t row = 0; row < corners.size(); row += columns)
      std::reverse(corners.begin() + static_cast<std::ptrdiff_t>(row),
                   corners.begin() + static_cast<std::ptrdiff_t>(row + columns));
  }
  double balance = 0.0;  // of squares that the first one's colour has, less the others
  for (int y = 0; y + 1 < board.rows; ++y) {
    for (int x = 0; x + 1 < board.columns; ++x)
      balance += ((x + y) % 2 == 0 ? 1.0 : -1.0) * mean_within(mat, corners, board.columns, x, y);
  }
  // With even times odd corners there are as many of either.
  if (balance > 0.0) std::reverse(corners.begin(), corners.end());
}

using Points = std::vector<std::vector<cv::Point2f>>;
using Corners = std::vector<std::vector<cv::Point3f>>;

Pose pose_of(const cv::Mat& turn, const cv::Mat& place) {
  cv::Matx33d matrix;
  cv::Rodrigues(turn, matrix);
  Pose pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) pose.turn[column][row] = matrix(row, column);
    pose.place[row] = place.at<double>(row);
  }
  return pose;
}

struct Found {
  cv::Mat matrix, coefficients;
  std::vector<cv::Mat> turns, places;
};

// Begun with pictures of several angles, of which the best is taken: from the library's own, 180 degrees,
// narrower lenses are not always found. The last two coefficients are left for later.
Found calibrate_fisheye(const Corners& boards, const Points& seen, const cv::Size& pixels) {
  using namespace cv::fisheye;
  constexpr int kFlags =
      CALIB_USE_INTRINSIC_GUESS | CALIB_RECOMPUTE_EXTRINSIC | CALIB_FIX_SKEW | CALIB_FIX_K3 | CALIB_FIX_K4;
  Found best;
  double least = HUGE_VAL;
  for (const double degrees : {180.0, 130.0, 95.0}) {
    const double focal = std::max(pixels.width, pixels.height) / (degrees * CV_PI / 180.0);
    Found found;
    found.matrix = (cv::Mat_<double>(3, 3) << focal, 0.0, (pixels.width - 1) / 2.0, 0.0, focal,
                    (pixels.height - 1) / 2.0, 0.0, 0.0, 1.0);
    found.coefficients = cv::Mat::zeros(4, 1, CV_64F);
    try {
      const double rms = cv::fisheye::calibrate(boards, seen, pixels, found.matrix, found.coefficients,
                                                found.turns, found.places, kFlags);
      if (rms < least) {
        least = rms;
        best = found;
      }
    } catch (const cv::Exception&) {  // it came to nothing
    }
  }
  if (least == HUGE_VAL) CV_Error(cv::Error::StsNoConv, "no such lens");
  return best;
}

}  // namespace

bool have_opencv() {
  return true;
}

bool find_board(const Image& picture, const Board& board, Sighting& sighting) {
  static const bool kOneThread = (cv::setNumThreads(1), true);  // pictures are shared out, not parts of them
  static_cast<void>(kOneThread);
  const cv::Mat mat = grey(picture);
  const cv::Size size(board.columns, board.rows);
  std::vector<cv::Point2f> corners;
  try {
    if (!cv::findChessboardCornersSB(mat, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) return false;
    if (corners.size() != static_cast<std::size_t>(board.corners())) return false;
    refine(mat, board, corners);
    sighting.edge_texels = edge_width(mat, board, corners);
  } catch (const cv::Exception&) {
    return false;
  }
  put_in_order(mat, board, corners);
  sighting.corners.clear();
  for (const cv::Point2f& corner : corners) sighting.corners.emplace_back(corner.x + kHalf, corner.y + kHalf);
  return true;
}

std::optional<CameraGuess> guess_camera(std::span<const Sighting* const> sightings, const Board& board,
                                        Size size, Distortion model) {
  std::vector<cv::Point3f> plane;
  for (const Vec3& corner : board_corners(board))
    plane.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y), 0.0F);
  const Corners boards(sightings.size(), plane);
  Points seen;
  for (const Sighting* sighting : sightings) {
    std::vector<cv::Point2f>& corners = seen.emplace_back();
    for (const Vec2& at : sighting->corners)
      corners.emplace_back(static_cast<float>(at.x - kHalf), static_cast<float>(at.y - kHalf));
  }
  const cv::Size pixels(size.width, size.height);
  Found found;
  try {
    if (model == Distortion::kFisheye) {
      found = calibrate_fisheye(boards, seen, pixels);
    } else {
      cv::calibrateCamera(boards, seen, pixels, found.matrix, found.coefficients, found.turns, found.places);
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  CameraGuess guess;
  guess.view.size = size;
  guess.view.distortion = model;
  guess.view.focal = {found.matrix.at<double>(0, 0) / size.width,
                      found.matrix.at<double>(1, 1) / size.height};
  guess.view.principal = {(found.matrix.at<double>(0, 2) + kHalf) / size.width,
                          (found.matrix.at<double>(1, 2) + kHalf) / size.height};
  const int count = std::min(8, static_cast<int>(found.coefficients.total()));
  for (int i = 0; i < count; ++i)
    guess.view.coefficients[static_cast<std::size_t>(i)] = found.coefficients.at<double>(i);
  for (std::size_t i = 0; i < found.turns.size(); ++i)
    guess.boards.push_back(pose_of(found.turns[i], found.places[i]));
  return guess;
}

}  // namespace cupola
