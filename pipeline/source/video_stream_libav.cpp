// Videos through libavformat and libavcodec: an index of all frames' times, and a decoder that goes on where
// it can and back to a key frame where it must.
// SPDX-License-Identifier: MIT
#include "pipeline/source/video_stream.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "pipeline/frame/yuv_to_rgb.h"
#include "pipeline/media/media_file.h"

namespace cupola {
namespace {

constexpr int kMostThreads = 16;  // the libraries' own limit

constexpr MediaKind kVideo = {AVMEDIA_TYPE_VIDEO, "video",
                              "matroska,webm,mov,mp4,m4a,3gp,3g2,mj2,avi,mpegts,mpeg,nut,mxf,ogg,asf,flv,ivf",
                              "MP4, MOV, MKV, AVI, MXF or the like", AVFMT_FLAG_GENPTS};

// Streams may hold values that the enumeration does not have.
template <class Enumeration>
int number_of(const Enumeration& value) {
  static_assert(sizeof value == sizeof(int));
  int number = 0;
  std::memcpy(&number, &value, sizeof number);
  return number;
}

struct FrameEntry {
  std::int64_t time = 0;  // to be shown, in the stream's units
  std::int64_t seek = 0;  // of a key frame: to where to seek for it
  bool key = false;
};

class VideoStream final : public PictureStream {
 public:
  explicit VideoStream(const std::filesystem::path& path);

  Size size() const override { return size_; }
  PixelFormat format() const override { return PixelFormat::kRgbPlanar8; }
  std::optional<std::int64_t> length() const override { return static_cast<std::int64_t>(index_.size()); }
  std::string name() const override { return file_.name(); }
  double rate() const override { return rate_; }
  std::uint64_t stamp() const override { return stamp_of(file_.name()); }
  bool read(std::int64_t frame, RowRange rows, const MutableImage& into, bool) override;

 private:
  void read_size();
  void make_index();
  void start_decoder();
  // The decoder's next frame that has a time; false at the end.
  bool decode_next();
  void seek(const FrameEntry& key);
  // Decodes until frame_ is the one of `time`; false when it is not among those that come.
  bool find(std::int64_t time);
  void to_rgb(RowRange rows, const MutableImage& into);
  void copy_rgb(const AVPixFmtDescriptor& format, RowRange rows, const MutableImage& into);
  PlanarVideo kind_of_frame(const AVPixFmtDescriptor& format) const;
  Plane<const std::byte> apart(const AVComponentDescriptor& chroma, std::size_t c, RowRange rows);

  MediaFile file_;
  const AVFrame* frame_ = nullptr;  // the file's
  std::vector<FrameEntry> index_;   // by time
  std::optional<std::int64_t> at_;  // the time of frame_; none: it holds none
  Size size_;
  double rate_ = 0.0;
  std::optional<YuvToRgb> to_rgb_;
  std::array<std::vector<std::byte>, 2> chroma_;  // U and V where the file has them in one plane
  ImageBuffer row_;                               // one row of RGB
};

VideoStream::VideoStream(const std::filesystem::path& path) : file_(path, kVideo) {
  read_size();
  make_index();
  start_decoder();
}

void VideoStream::read_size() {
  size_ = {file_.stream().codecpar->width, file_.stream().codecpar->height};
  if (size_.width < 1 || size_.height < 1 || size_.width > kLargestSide || size_.height > kLargestSide ||
      std::int64_t{size_.width} * size_.height > kMostPixels) {
    throw InputError(fmt::format("{}: the video is {} x {}; expected sides of 1 to {}", name(), size_.width,
                                 size_.height, kLargestSide));
  }
  const AVRational rate = av_guess_frame_rate(&file_.container(), &file_.stream(), nullptr);
  rate_ = rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0.0;
}

void VideoStream::make_index() {
  for (;;) {
    const AVPacket* packet = file_.next_packet();
    if (!packet) break;
    const std::int64_t decoded_at = packet->dts;
    const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : decoded_at;
    const int flags = packet->flags;
    if ((flags & AV_PKT_FLAG_DISCARD) != 0) continue;  // cut off by the file's own list of edits
    if (time == AV_NOPTS_VALUE) {
      throw InputError(
          fmt::format("{}: frame {} has no time; expected a container that gives them, like MP4 or MKV",
                      name(), index_.size()));
    }
    index_.push_back(
        {time, decoded_at != AV_NOPTS_VALUE ? decoded_at : time, (flags & AV_PKT_FLAG_KEY) != 0});
  }
  if (index_.empty()) throw InputError(fmt::format("{}: holds no frame", name()));
  std::ranges::stable_sort(index_, {}, &FrameEntry::time);
  const auto twice = std::ranges::adjacent_find(index_, {}, &FrameEntry::time);
  if (twice != index_.end()) {
    throw InputError(fmt::format("{}: frames {} and {} are of one time; expected each to have its own",
                                 name(), twice - index_.begin(), twice - index_.begin() + 1));
  }
  index_.front().key = true;  // where else to begin
}

void VideoStream::start_decoder() {
  // One core is the frame loop's.
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  file_.open_decoder(std::clamp(cores - 1, 1, kMostThreads));
  seek(index_.front());
  if (!decode_next()) throw InputError(fmt::format("{}: not one frame can be decoded", name()));
  to_rgb({0, 0}, {});  // what kind it is
}

void VideoStream::seek(const FrameEntry& key) {
  at_.reset();
  file_.seek(key.time, key.seek);
}

bool VideoStream::decode_next() {
  at_.reset();
  for (;;) {
    frame_ = file_.next_frame();
    if (!frame_) return false;
    const std::int64_t time = frame_->pts != AV_NOPTS_VALUE ? frame_->pts : frame_->best_effort_timestamp;
    if (time == AV_NOPTS_VALUE) continue;
    at_ = time;
    return true;
  }
}

bool VideoStream::find(std::int64_t time) {
  while (!at_ || *at_ < time) {
    if (!decode_next()) return false;
  }
  return *at_ == time;
}

// How a format of luma and chroma lies in memory: a plane each, or U and V by turns in one, as in NV12 and
// P010. Samples in the upper bits of 16, as P010's, are as good as 16 bits.
bool is_known_yuv(const AVPixFmtDescriptor& format) {
  const AVComponentDescriptor& luma = format.comp[0];
  const int bytes = luma.depth > 8 ? 2 : 1;
  if (luma.depth < 8 || luma.depth > 16) return false;
  for (int c = 0; c < format.nb_components; ++c) {
    const AVComponentDescriptor& component = format.comp[c];
    const bool own_plane = component.plane == c && component.step == bytes;
    const bool by_turns =
        c > 0 && format.nb_components == 3 && component.plane == 1 && component.step == 2 * bytes;
    if (component.depth != luma.depth || component.shift != 0 || !(own_plane || by_turns)) return false;
  }
  return true;
}

bool is_known_rgb(const AVPixFmtDescriptor& format) {
  for (int c = 0; c < format.nb_components; ++c) {
    if (format.comp[c].depth != 8 || format.comp[c].shift != 0) return false;
  }
  return format.nb_components >= 3;
}

bool VideoStream::read(std::int64_t frame, RowRange rows, const MutableImage& into, bool) {
  const FrameEntry& wanted = index_[static_cast<std::size_t>(frame)];
  auto key = index_.begin() + frame;
  while (!key->key) --key;
  // On from where the decoder is, unless it is past, or there is a nearer place to begin.
  const bool goes_on = at_ && *at_ <= wanted.time && *at_ >= key->time;
  bool found = goes_on && find(wanted.time);
  if (!found && !goes_on) {
    seek(*key);
    found = find(wanted.time);
    // Seeking is inexact in some containers.
    for (auto earlier = key; !found && at_ && *at_ > wanted.time && earlier != index_.begin();) {
      do --earlier;
      while (!earlier->key);
      seek(*earlier);
      found = find(wanted.time);
    }
  }
  if (!found) throw InputError(fmt::format("{}: frame {} cannot be decoded", name(), frame));
  if (frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0)
    throw InputError(fmt::format("{}: frame {} is damaged", name(), frame));
  to_rgb(rows.within(size_.height), into);
  return true;
}

PlanarVideo VideoStream::kind_of_frame(const AVPixFmtDescriptor& format) const {
  PlanarVideo kind;
  kind.size = size_;
  kind.bits = format.comp[0].depth;
  kind.colour = format.nb_components >= 3;
  kind.chroma_shift_x = kind.colour ? format.log2_chroma_w : 0;
  kind.chroma_shift_y = kind.colour ? format.log2_chroma_h : 0;
  const bool jpeg = std::string_view(format.name).starts_with("yuvj");
  kind.full_range = jpeg || number_of(frame_->color_range) == AVCOL_RANGE_JPEG;
  const int place = number_of(frame_->chroma_location);
  const bool centre = place == AVCHROMA_LOC_CENTER || (place == AVCHROMA_LOC_UNSPECIFIED && jpeg);
  kind.siting_x = centre || place == AVCHROMA_LOC_TOP ? Siting::kBetween : Siting::kOnFirst;
  kind.siting_y =
      place == AVCHROMA_LOC_TOPLEFT || place == AVCHROMA_LOC_TOP ? Siting::kOnFirst : Siting::kBetween;
  constexpr LumaWeights kBt601 = weights_of(YuvMatrix::kBt601);
  constexpr LumaWeights kBt2020{0.2627, 0.0593};
  switch (number_of(frame_->colorspace)) {
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      kind.weights = kBt601;
      break;
    case AVCOL_SPC_BT2020_NCL:
      kind.weights = kBt2020;
      break;
    case AVCOL_SPC_UNSPECIFIED:
      if (jpeg) kind.weights = kBt601;
      break;
    default:
      break;
  }
  return kind;
}

// The rows `rows` of one of two chromas that lie by turns in a plane.
Plane<const std::byte> VideoStream::apart(const AVComponentDescriptor& chroma, std::size_t c, RowRange rows) {
  const PlanarVideo& video = to_rgb_->video();
  const auto bytes = static_cast<std::size_t>(video.bytes_per_sample());
  const auto width = static_cast<std::size_t>(video.chroma_width());
  chroma_[c].resize(bytes * width * static_cast<std::size_t>(video.chroma_height()));
  std::byte* to = chroma_[c].data();
  for (int y = rows.first; y < rows.last; ++y) {
    const std::uint8_t* from = frame_->data[1] + std::ptrdiff_t{y} * frame_->linesize[1] + chroma.offset;
    for (std::size_t x = 0; x < width; ++x, to += bytes) std::memcpy(to, from + 2 * bytes * x, bytes);
  }
  return {chroma_[c].data(), static_cast<std::ptrdiff_t>(bytes * width)};
}

void VideoStream::copy_rgb(const AVPixFmtDescriptor& format, RowRange rows, const MutableImage& into) {
  if (row_.empty()) row_ = ImageBuffer(PixelFormat::kRgbPlanar8, {size_.width, 1});
  for (int y = rows.first; y < rows.last; ++y) {
    for (std::size_t c = 0; c < 3; ++c) {
      const AVComponentDescriptor& component = format.comp[c];
      const std::uint8_t* from = frame_->data[component.plane] +
                                 std::ptrdiff_t{y} * frame_->linesize[component.plane] + component.offset;
      auto* to = row_.pixels().samples<std::uint8_t>(static_cast<int>(c), 0);
      for (int x = 0; x < size_.width; ++x) to[x] = from[x * component.step];
    }
    convert(as_const(row_.pixels()), row_of(into, y));
  }
}

void VideoStream::to_rgb(RowRange rows, const MutableImage& into) {
  if (frame_->width != size_.width || frame_->height != size_.height) {
    throw InputError(fmt::format("{}: a frame is {} x {}; expected {} x {}", name(), frame_->width,
                                 frame_->height, size_.width, size_.height));
  }
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame_->format));
  constexpr std::uint64_t kForeign = AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                     AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BAYER;
  const bool rgb = format && (format->flags & AV_PIX_FMT_FLAG_RGB) != 0;
  if (!format || (format->flags & kForeign) != 0 || format->log2_chroma_w > 1 || format->log2_chroma_h > 1 ||
      !(rgb ? is_known_rgb(*format) : is_known_yuv(*format))) {
    throw InputError(fmt::format("{}: its pixels are {}; expected 4:2:0, 4:2:2, 4:4:4 or grey, or 8-bit RGB",
                                 name(), format ? format->name : "of an unknown kind"));
  }
  if (rows.empty()) return;
  if (rgb) {
    copy_rgb(*format, rows, into);
    return;
  }
  const PlanarVideo kind = kind_of_frame(*format);
  if (!to_rgb_ || to_rgb_->video() != kind) to_rgb_.emplace(kind);
  const RowRange chroma = to_rgb_->chroma_rows(rows);
  std::array<Plane<const std::byte>, 3> from;
  for (std::size_t p = 0; p < (kind.colour ? 3U : 1U); ++p) {
    const AVComponentDescriptor& component = format->comp[p];
    if (p > 0 && component.plane == 1 && component.step == 2 * kind.bytes_per_sample()) {
      from[p] = apart(component, p - 1, chroma);
      continue;
    }
    from[p] = {reinterpret_cast<const std::byte*>(frame_->data[p]), frame_->linesize[p]};
    from[p].data = from[p].row(p == 0 ? rows.first : chroma.first);
  }
  to_rgb_->convert(from, rows, into);
}

}  // namespace

std::unique_ptr<PictureStream> open_video(const std::filesystem::path& path) {
  return std::make_unique<VideoStream>(path);
}

}  // namespace cupola
