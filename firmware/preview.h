// A picture scaled small, the dome's or a face's, for whoever looks on from elsewhere: copied by the frame
// loop a few rows a frame, and only while somebody asks.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>

#include "firmware/face_picture.h"
#include "pipeline/frame/image.h"

namespace cupola {

// The loop reads what it has just drawn, which in a projector's buffer is slow: so it takes one pixel for
// each of the preview's (the nearest), and a sixteenth of the rows a frame. What moves is a little askew in
// it. Allocates when made only.
class Preview {
 public:
  static constexpr int kLargestSide = 480;  // pixels; of the dome's
  static constexpr int kParts = 16;
  static constexpr std::chrono::milliseconds kEvery{500};  // begun no more often, by the loop's clock

  // Of pictures of that size, or of others that scaled to `longest` pixels are no larger.
  explicit Preview(Size picture, int longest = kLargestSide);

  // The loop's. Whether it should draw the frame to be seen at `flip` for the preview's sake. Does not wait.
  bool wants(std::chrono::nanoseconds flip) noexcept;
  // Takes the next rows from `picture`, if it wants them; the bytes written. One of another size than the
  // last call's begins again.
  std::int64_t copy(const FacePicture& picture, std::chrono::nanoseconds flip) noexcept;
  // The same of a picture that is all black: all rows at once.
  std::int64_t copy_black(std::chrono::nanoseconds flip) noexcept;

  // Anybody else's. Asks for a preview, and copies the newest whole one into `into`, which is made fit.
  // Returns its number, from 1: 0 when there is none yet.
  std::int64_t newest(ImageBuffer& into);
  // When that was made whole: flip time. Valid with its number.
  std::chrono::nanoseconds made_at() const;

 private:
  // In memory for the largest.
  struct Small {
    ImageBuffer buffer;
    Size size;
    MutableImage pixels() { return part_of(buffer.pixels(), 0, 0, size); }
  };
  template <class RowOf>
  std::int64_t copy_rows(Size from, RowOf row_of, std::chrono::nanoseconds flip) noexcept;
  void finish(std::chrono::nanoseconds flip) noexcept;

  Size picture_;
  int longest_;
  std::atomic<bool> asked_{false};
  // The loop's:
  Small making_;
  bool busy_ = false;
  bool whole_ = false;  // but not handed over yet
  int part_ = 0;        // the next one
  std::chrono::nanoseconds not_before_ = std::chrono::nanoseconds::min();
  // Everybody's:
  mutable std::mutex mutex_;
  Small ready_;
  std::int64_t number_ = 0;
  std::chrono::nanoseconds made_at_{0};
};

}  // namespace cupola
