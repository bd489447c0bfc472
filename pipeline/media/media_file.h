// One stream of a video or sound file: opened by libavformat, decoded by libavcodec in turn.
// SPDX-License-Identifier: MIT
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace cupola {

// What is looked for in a file.
struct MediaKind {
  AVMediaType type;
  const char* name;        // "video"
  const char* containers;  // libavformat's names, comma-separated: containers only, no lists of other files
  const char* expected;    // for people: "MP4, MKV or the like"
  int flags = 0;           // AVFMT_FLAG_...
};

// Errors are InputErrors that begin with the file's name. One thread.
class MediaFile {
 public:
  MediaFile(const std::filesystem::path& path, const MediaKind& kind);

  const std::string& name() const { return name_; }
  AVFormatContext& container() const { return *container_; }
  AVStream& stream() const { return *stream_; }

  // The stream's next packet that is not empty, the file's own until the next call; null at the end.
  const AVPacket* next_packet();

  void open_decoder(int threads);
  const AVCodecContext& decoder() const { return *decoder_; }

  // The decoder's next frame, the file's own until the next call; null at the end. Damaged packets and
  // frames are passed over and counted.
  const AVFrame* next_frame();
  std::int64_t damaged() const { return damaged_; }

  // Goes back or on to the last key frame at or before `time`, the stream's units. `key`: the time under
  // which the container lists that frame, where it differs.
  void seek(std::int64_t time, std::int64_t key);

 private:
  struct Free {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
    void operator()(AVCodecContext* decoder) const { avcodec_free_context(&decoder); }
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  };
  template <class Thing>
  using Owned = std::unique_ptr<Thing, Free>;

  // Passes the next packet on; false at the decoder's end.
  bool feed();

  std::string name_;
  std::string kind_;
  Owned<AVFormatContext> container_;
  AVStream* stream_ = nullptr;
  Owned<AVCodecContext> decoder_;
  Owned<AVPacket> packet_;
  Owned<AVFrame> frame_;
  bool drained_ = false;  // the file's end was passed on to the decoder
  std::int64_t damaged_ = 0;
};

// FFmpeg's words for one of its errors.
std::string words_of_libav(int error);

}  // namespace cupola
