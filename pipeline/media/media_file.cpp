// Opening, decoding in turn, seeking.
// SPDX-License-Identifier: MIT
#include "pipeline/media/media_file.h"

#include <fmt/format.h>

#include <array>
#include <new>

#include "pipeline/frame/error.h"
#include "pipeline/frame/file_bytes.h"

namespace cupola {

std::string words_of_libav(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> words{};
  av_strerror(error, words.data(), words.size());
  return words.data();
}

MediaFile::MediaFile(const std::filesystem::path& path, const MediaKind& kind)
    : name_(path.string()), kind_(kind.name) {
  av_log_set_level(AV_LOG_QUIET);  // what is wrong is in our own words
  const RegularFile there(path, ("a " + kind_).c_str());
  packet_.reset(av_packet_alloc());
  frame_.reset(av_frame_alloc());
  if (!packet_ || !frame_) throw std::bad_alloc();

  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", kind.containers, 0);
  AVFormatContext* container = nullptr;
  const int error = avformat_open_input(&container, ("file:" + name_).c_str(), nullptr, &options);
  av_dict_free(&options);
  if (error < 0) {
    throw InputError(fmt::format("{}: not a {} that can be read: {}; expected {}", name_, kind_,
                                 words_of_libav(error), kind.expected));
  }
  container_.reset(container);
  container_->flags |= kind.flags;
  if (const int failed = avformat_find_stream_info(container, nullptr); failed < 0)
    throw InputError(fmt::format("{}: the {} is damaged: {}", name_, kind_, words_of_libav(failed)));
  const int place = av_find_best_stream(container, kind.type, -1, -1, nullptr, 0);
  if (place < 0) throw InputError(fmt::format("{}: holds no {}", name_, kind_));
  stream_ = container->streams[place];
  for (unsigned i = 0; i < container->nb_streams; ++i) {
    if (container->streams[i] != stream_) container->streams[i]->discard = AVDISCARD_ALL;
  }
}

const AVPacket* MediaFile::next_packet() {
  for (;;) {
    av_packet_unref(packet_.get());
    const int error = av_read_frame(container_.get(), packet_.get());
    if (error == AVERROR_EOF) return nullptr;
    if (error < 0)
      throw InputError(fmt::format("{}: the {} is damaged: {}", name_, kind_, words_of_libav(error)));
    if (packet_->stream_index == stream_->index && packet_->size > 0) return packet_.get();
  }
}

void MediaFile::open_decoder(int threads) {
  const AVCodec* codec = avcodec_find_decoder(stream_->codecpar->codec_id);
  const char* called = avcodec_get_name(stream_->codecpar->codec_id);
  if (!codec)
    throw InputError(
        fmt::format("{}: its {} is coded as {}, for which there is no decoder", name_, kind_, called));
  decoder_.reset(avcodec_alloc_context3(codec));
  if (!decoder_) throw std::bad_alloc();
  if (const int error = avcodec_parameters_to_context(decoder_.get(), stream_->codecpar); error < 0)
    throw InputError(fmt::format("{}: the {} is damaged: {}", name_, kind_, words_of_libav(error)));
  decoder_->pkt_timebase = stream_->time_base;
  decoder_->thread_count = threads;
  if (const int error = avcodec_open2(decoder_.get(), codec, nullptr); error < 0) {
    throw InputError(
        fmt::format("{}: the {} decoder cannot be opened: {}", name_, called, words_of_libav(error)));
  }
}

const AVFrame* MediaFile::next_frame() {
  for (;;) {
    const int got = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (got == 0) return frame_.get();
    if (got == AVERROR(EAGAIN) ? !feed() : got == AVERROR_EOF) return nullptr;
    if (got != AVERROR(EAGAIN)) ++damaged_;  // the next one may be whole
  }
}

bool MediaFile::feed() {
  if (drained_) return false;
  if (av_read_frame(container_.get(), packet_.get()) < 0) {
    drained_ = true;
    avcodec_send_packet(decoder_.get(), nullptr);
    return true;
  }
  const bool ours = packet_->stream_index == stream_->index;
  if (ours && avcodec_send_packet(decoder_.get(), packet_.get()) < 0) ++damaged_;
  av_packet_unref(packet_.get());
  return true;
}

void MediaFile::seek(std::int64_t time, std::int64_t key) {
  avcodec_flush_buffers(decoder_.get());
  drained_ = false;
  if (av_seek_frame(container_.get(), stream_->index, key, AVSEEK_FLAG_BACKWARD) < 0 &&
      avformat_seek_file(container_.get(), stream_->index, INT64_MIN, time, time, 0) < 0 &&
      av_seek_frame(container_.get(), stream_->index, 0, AVSEEK_FLAG_BYTE) < 0) {
    throw InputError(fmt::format("{}: one cannot go back in it", name_));
  }
}

}  // namespace cupola
