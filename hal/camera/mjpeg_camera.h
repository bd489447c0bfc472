// Any camera, with its JPEG pictures decoded: frames are kI420, kI422 or kGrey, as they were compressed.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/camera/hand_over.h"
#include "hal/camera/jpeg_decoder.h"
#include "hal/time/clock.h"

namespace cupola {

// A device that sends something else than kMjpeg is passed on as it is. The setup's crop is done from below:
// rows under it are not decoded.
class MjpegCamera final : public Camera {
 public:
  enum class Decoding : std::uint8_t {
    kInPoll,     // each picture in poll(): the same steps every time, for fake clocks
    kOnAThread,  // ahead of poll(), the newest picture first; needs a real clock
  };
  // `clock` is borrowed for the camera's life.
  MjpegCamera(std::unique_ptr<Camera> device, Clock& clock, Decoding decoding);
  ~MjpegCamera() override;

  // The first time, and after pictures of another kind came, waits for a picture, at most two seconds: only
  // it tells how chroma is sampled. Pictures of 4:4:4, 4:1:1 or RGB, and progressive ones, are kUnsupported.
  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override;
  bool set_control(const CameraControl& control) noexcept override { return device_->set_control(control); }

 private:
  struct Event {
    CameraPoll kind = CameraPoll::kNothing;
    CameraFrame frame;
    CameraTrouble trouble;
  };
  struct Picture {
    std::vector<std::uint8_t> memory;
    std::array<JpegPlane, 3> planes;
    Event event;  // what became of it
    bool lent = false;
  };

  std::optional<CameraTrouble> learn_kind();
  void make_pictures(int count);
  Event poll_device() noexcept;
  Event newest_of_device() noexcept;
  // Into the picture; what comes of a frame of the device, which is given back to it.
  void receive(const Event& event, std::size_t picture) noexcept;
  void work() noexcept;
  void join() noexcept;

  std::unique_ptr<Camera> device_;
  Clock& clock_;
  Decoding decoding_;
  JpegDecoder decoder_;
  bool decodes_ = false;          // what the device sends is kMjpeg
  CameraMode sent_;               // by the device
  std::optional<JpegKind> kind_;  // of its pictures, in mode `sent_`
  bool kind_changed_ = false;     // whoever decodes writes it
  CameraMode mode_;
  std::vector<Picture> pictures_;
  std::optional<CameraTrouble> lost_;

  HandOver free_;   // pictures to the worker; or kStop
  HandOver ready_;  // and back
  HandOver stop_;   // only woken
  std::atomic<bool> stopping_{false};
  std::optional<Event> next_;  // the worker's: polled and not yet received
  std::thread worker_;
};

}  // namespace cupola
