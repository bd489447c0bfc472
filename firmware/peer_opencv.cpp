// OpenCV's fixed-point remap over the same rays.
// SPDX-License-Identifier: MIT
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "firmware/peer.h"

namespace cupola {
namespace {

class OpencvRemap final : public Peer {
 public:
  OpencvRemap(const Rig& rig, std::span<const Image> faces, PeerFilter filter, WorkerPool& pool)
      : lanczos_(filter == PeerFilter::kLanczos4) {
    cv::setNumThreads(1);
    int width = 0;
    int height = 0;
    std::vector<int> left;
    for (const Image& face : faces) {
      left.push_back(width);
      width += face.size.width;
      height = std::max(height, face.size.height);
    }
    atlas_.create(height, width, CV_8UC3);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      convert(faces[i], borrowed(atlas_, left[i], faces[i].size));
    }
    cv::Mat map_x(rig.frame.size.height, rig.frame.size.width, CV_32FC1, cv::Scalar(-10));
    cv::Mat map_y(rig.frame.size.height, rig.frame.size.width, CV_32FC1, cv::Scalar(-10));
    pool.run(rig.frame.size.height, [&](int y) {
      for (int x = 0; x < rig.frame.size.width; ++x) {
        DirectionAndSlope looking;
        Vec2 uv;
        if (!ray(rig.frame, {x + 0.5, y + 0.5}, looking)) continue;
        const int view = owner(rig.views, looking.direction);
        if (view < 0 || !project(rig.views[static_cast<std::size_t>(view)], looking.direction, uv)) continue;
        map_x.at<float>(y, x) = static_cast<float>(uv.x - 0.5 + left[static_cast<std::size_t>(view)]);
        map_y.at<float>(y, x) = static_cast<float>(uv.y - 0.5);
      }
    });
    cv::convertMaps(map_x, map_y, map_, fractions_, CV_16SC2);
    out_.create(rig.frame.size.height, rig.frame.size.width, CV_8UC3);
  }

  std::string name() const override {
    return std::string("OpenCV " CV_VERSION " remap ") + (lanczos_ ? "INTER_LANCZOS4" : "INTER_LINEAR") +
           " CV_16SC2";
  }
  void warp() override {
    cv::remap(atlas_, out_, map_, fractions_, lanczos_ ? cv::INTER_LANCZOS4 : cv::INTER_LINEAR,
              cv::BORDER_CONSTANT);
  }
  Image frame() const override {
    cv::Mat header = out_;  // shares the pixels
    return borrowed(header, 0, {out_.cols, out_.rows});
  }

 private:
  static MutableImage borrowed(cv::Mat& mat, int x, Size size) {
    MutableImage image{PixelFormat::kRgb8, size, {}};
    image.planes[0] = {reinterpret_cast<std::byte*>(mat.data) + x * 3, static_cast<std::ptrdiff_t>(mat.step)};
    return image;
  }

  bool lanczos_;
  cv::Mat atlas_, map_, fractions_, out_;
};

}  // namespace

std::unique_ptr<Peer> make_peer(const Rig& rig, std::span<const Image> faces, PeerFilter filter,
                                WorkerPool& pool) {
  return std::make_unique<OpencvRemap>(rig, faces, filter, pool);
}

}  // namespace cupola
