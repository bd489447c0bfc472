// Sound as FFmpeg's libraries decode and resample it: in turn, sought where it must.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/sound_track.h"

extern "C" {
#include <libavutil/channel_layout.h>
#include <libswresample/swresample.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/media/media_file.h"

namespace cupola {
namespace {

constexpr int kMostChannels = 64;
constexpr int kMostRate = 768'000;
constexpr double kPreroll = 0.2;      // seconds decoded before the place wanted: codecs need some to settle
constexpr double kGap = 0.04;         // seconds: what times of packets may be wrong without being a gap
constexpr double kLongestGap = 10.0;  // seconds filled with silence at a time: times may be nonsense

constexpr MediaKind kSound = {AVMEDIA_TYPE_AUDIO, "sound",
                              "wav,w64,aiff,caf,au,flac,mp3,ogg,aac,ac3,eac3,matroska,webm,mov,mp4,m4a,3gp,"
                              "3g2,mj2,avi,mpegts,mpeg,nut,mxf,asf,flv",
                              "WAV, FLAC, MP3, Ogg, M4A or the like"};

struct FreeResampler {
  void operator()(SwrContext* resampler) const { swr_free(&resampler); }
};

class LibavTrack final : public SoundTrack {
 public:
  LibavTrack(const std::filesystem::path& path, int rate, int channels);
  ~LibavTrack() override { av_channel_layout_uninit(&layout_); }
  LibavTrack(const LibavTrack&) = delete;
  LibavTrack& operator=(const LibavTrack&) = delete;

  std::string name() const override { return file_.name(); }
  std::int64_t length() const override { return length_; }
  std::size_t read(std::int64_t first, std::span<float> into) override;
  std::int64_t damaged() const override { return file_.damaged(); }
  int file_channels() const override { return file_channels_; }

 private:
  void find_times();
  void start_decoder();
  void seek(std::int64_t frame);
  // More frames at the end of samples_; false at the track's end.
  bool decode_next();
  void resample(const AVFrame* frame);
  void make_resampler(const AVFrame& frame);
  void take(const AVFrame& frame);
  std::size_t held() const { return (samples_.size() - begin_) / static_cast<std::size_t>(channels_); }

  MediaFile file_;
  int rate_;
  int channels_;
  int file_channels_ = 0;
  std::unique_ptr<SwrContext, FreeResampler> resampler_;
  AVChannelLayout layout_{};  // of what goes into the resampler
  int format_ = -1;
  int file_rate_ = 0;
  std::int64_t origin_ = 0;  // in the stream's units
  std::int64_t length_ = 0;
  std::vector<float> samples_;  // decoded; those before begin_ are used
  std::size_t begin_ = 0;
  std::int64_t place_ = 0;      // the frame at begin_
  std::optional<double> next_;  // seconds: where the next packet's sound should begin
  bool ended_ = false;
};

LibavTrack::LibavTrack(const std::filesystem::path& path, int rate, int channels)
    : file_(path, kSound), rate_(rate), channels_(channels) {
  find_times();
  start_decoder();
  if (channels_ == 0) channels_ = file_channels_;
  if (!decode_next()) throw InputError(fmt::format("{}: nothing of its sound can be decoded", name()));
}

// Its length, and where its time begins: where the picture's does, if there is one.
void LibavTrack::find_times() {
  const AVFormatContext& container = file_.container();
  const AVStream& stream = file_.stream();
  const AVStream* origin = &stream;
  for (unsigned i = 0; i < container.nb_streams; ++i) {
    const AVStream* other = container.streams[i];
    const bool cover = (other->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0;
    if (other->codecpar->codec_type == AVMEDIA_TYPE_VIDEO && !cover && origin == &stream) origin = other;
  }
  if (origin->start_time != AV_NOPTS_VALUE)
    origin_ = av_rescale_q(origin->start_time, origin->time_base, stream.time_base);
  double seconds = 0.0;
  if (stream.duration != AV_NOPTS_VALUE) {
    const std::int64_t begin = stream.start_time != AV_NOPTS_VALUE ? stream.start_time : origin_;
    seconds = static_cast<double>(begin + stream.duration - origin_) * av_q2d(stream.time_base);
  } else if (container.duration != AV_NOPTS_VALUE) {
    seconds = static_cast<double>(container.duration) / AV_TIME_BASE;
  }
  if (seconds > 0.0 && seconds < 1e9) length_ = std::llround(seconds * rate_);
}

void LibavTrack::start_decoder() {
  file_.open_decoder(1);
  file_channels_ = file_.decoder().ch_layout.nb_channels;
  file_rate_ = file_.decoder().sample_rate;
  if (file_channels_ < 1 || file_channels_ > kMostChannels || file_rate_ < 1 || file_rate_ > kMostRate) {
    throw InputError(
        fmt::format("{}: the sound has {} channels and {} frames a second; expected 1 to {} and "
                    "1 to {}",
                    name(), file_channels_, file_rate_, kMostChannels, kMostRate));
  }
}

// As many channels as there are loudspeakers go straight through, whatever they are called.
void LibavTrack::make_resampler(const AVFrame& frame) {
  AVChannelLayout out{};
  if (frame.ch_layout.nb_channels == channels_) {
    av_channel_layout_copy(&out, &frame.ch_layout);
  } else {
    av_channel_layout_default(&out, channels_);
  }
  av_channel_layout_uninit(&layout_);
  av_channel_layout_copy(&layout_, &frame.ch_layout);
  SwrContext* resampler = nullptr;
  int error = swr_alloc_set_opts2(&resampler, &out, AV_SAMPLE_FMT_FLT, rate_, &layout_,
                                  static_cast<AVSampleFormat>(frame.format), frame.sample_rate, 0, nullptr);
  resampler_.reset(resampler);
  av_channel_layout_uninit(&out);
  if (error >= 0) error = swr_init(resampler);
  if (error < 0) {
    resampler_.reset();
    throw InputError(fmt::format("{}: {} channels of sound cannot be made {}: {}", name(),
                                 frame.ch_layout.nb_channels, channels_, words_of_libav(error)));
  }
  format_ = frame.format;
  file_rate_ = frame.sample_rate;
}

// Null: what the resampler still holds.
void LibavTrack::resample(const AVFrame* frame) {
  if (!resampler_) return;
  const int most = swr_get_out_samples(resampler_.get(), frame ? frame->nb_samples : 0);
  if (most <= 0) return;
  const std::size_t before = samples_.size();
  samples_.resize(before + static_cast<std::size_t>(most) * static_cast<std::size_t>(channels_));
  auto* to = reinterpret_cast<std::uint8_t*>(samples_.data() + before);
  const int made = swr_convert(resampler_.get(), &to, most,
                               frame ? const_cast<const std::uint8_t**>(frame->extended_data) : nullptr,
                               frame ? frame->nb_samples : 0);
  samples_.resize(before + static_cast<std::size_t>(std::max(made, 0)) * static_cast<std::size_t>(channels_));
}

void LibavTrack::take(const AVFrame& frame) {
  if (frame.nb_samples <= 0 || frame.sample_rate <= 0 || frame.ch_layout.nb_channels < 1) return;
  const std::int64_t time = frame.pts != AV_NOPTS_VALUE ? frame.pts : frame.best_effort_timestamp;
  const double lasts = static_cast<double>(frame.nb_samples) / frame.sample_rate;
  const double begins = time != AV_NOPTS_VALUE
                            ? static_cast<double>(time - origin_) * av_q2d(file_.stream().time_base)
                            : next_.value_or(0.0);
  if (!next_) {  // the first one after a jump
    samples_.clear();
    begin_ = 0;
    place_ = std::llround(begins * rate_);
    resampler_.reset();
  } else if (const double gap = begins - *next_; gap > kGap) {
    resample(nullptr);
    resampler_.reset();
    const auto frames = std::llround(std::min(gap, kLongestGap) * rate_);
    samples_.insert(samples_.end(), static_cast<std::size_t>(frames * channels_), 0.0F);
  } else if (gap < -kGap) {
    return;  // it was heard already
  }
  const bool same = resampler_ && frame.format == format_ && frame.sample_rate == file_rate_ &&
                    av_channel_layout_compare(&frame.ch_layout, &layout_) == 0;
  if (!same) {
    resample(nullptr);
    make_resampler(frame);
  }
  resample(&frame);
  // Counted, not read: times of packets are rounded.
  const bool apart = !next_ || std::abs(begins - *next_) > kGap;
  next_ = (apart ? begins : *next_) + lasts;
}

bool LibavTrack::decode_next() {
  if (ended_) return false;
  if (const AVFrame* frame = file_.next_frame()) {
    take(*frame);
    return true;
  }
  ended_ = true;
  resample(nullptr);
  return held() > 0;
}

void LibavTrack::seek(std::int64_t frame) {
  resampler_.reset();
  samples_.clear();
  begin_ = 0;
  place_ = 0;
  next_.reset();
  ended_ = false;
  const double seconds = std::max(0.0, static_cast<double>(frame) / rate_ - kPreroll);
  const std::int64_t time = origin_ + std::llround(seconds / av_q2d(file_.stream().time_base));
  file_.seek(time, time);
}

std::size_t LibavTrack::read(std::int64_t first, std::span<float> into) {
  const auto channels = static_cast<std::size_t>(channels_);
  // A little ahead is sooner decoded than sought.
  const bool near =
      next_ && first >= place_ && first - place_ <= static_cast<std::int64_t>(held()) + rate_ / 2;
  if (!near) {
    const std::int64_t from = std::max<std::int64_t>(first, 0);
    seek(from);
    // Where the seek came out behind the place, the file's beginning is never wrong.
    if (decode_next() && place_ > from && from > 0) {
      seek(0);
      decode_next();
    }
  }
  std::size_t written = 0;
  const std::size_t wanted = into.size() / channels;
  while (written < wanted) {
    const std::int64_t at = first + static_cast<std::int64_t>(written);
    if (at < place_) {  // the sound begins later than that
      const auto silent = std::min(static_cast<std::int64_t>(wanted - written), place_ - at);
      std::fill_n(into.begin() + static_cast<std::ptrdiff_t>(written * channels),
                  static_cast<std::size_t>(silent) * channels, 0.0F);
      written += static_cast<std::size_t>(silent);
      continue;
    }
    const auto skipped =
        static_cast<std::size_t>(std::min<std::int64_t>(at - place_, static_cast<std::int64_t>(held())));
    begin_ += skipped * channels;
    place_ += static_cast<std::int64_t>(skipped);
    if (held() == 0) {
      samples_.clear();
      begin_ = 0;
      if (!decode_next()) break;
      continue;
    }
    const std::size_t count = std::min(wanted - written, held());
    std::copy_n(samples_.begin() + static_cast<std::ptrdiff_t>(begin_), count * channels,
                into.begin() + static_cast<std::ptrdiff_t>(written * channels));
    begin_ += count * channels;
    place_ += static_cast<std::int64_t>(count);
    written += count;
  }
  return written;
}

}  // namespace

std::unique_ptr<SoundTrack> open_sound(const std::filesystem::path& path, int rate, int channels) {
  return std::make_unique<LibavTrack>(path, rate, channels);
}

}  // namespace cupola
