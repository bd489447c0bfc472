// One run of a libcamera camera, from its configuration to its release.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/camera/dma_buf_memory.h"
#include "hal/camera/hand_over.h"
#include "hal/camera/libcamera_system.h"
#include "hal/camera/libcamera_version.h"
#include "hal/time/clock.h"

namespace cupola {

// Three threads: libcamera's completes requests, the caller's polls them and gives them back, the courier
// queues them again. A buffer's number goes round among them, and whoever has it has the buffer.
class LibcameraStream {
 public:
  LibcameraStream(LibcameraSystem& system, Clock& clock);
  ~LibcameraStream();
  LibcameraStream(const LibcameraStream&) = delete;
  LibcameraStream& operator=(const LibcameraStream&) = delete;

  // Once; may throw.
  std::variant<CameraMode, CameraTrouble> open(const CameraSetup& setup);
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept;
  void give_back(int buffer) noexcept;
  int descriptor() const noexcept { return arrived_.descriptor(); }
  // For the next request; any thread.
  bool set_control(const CameraControl& control) noexcept;

 private:
  struct Buffer {
    libcamera::FrameBuffer* frame = nullptr;  // the allocator's
    std::unique_ptr<libcamera::Request> request;
    std::vector<DmaBufMemory> memory;  // each of the frame's descriptors once
    std::array<CameraPlane, 3> planes;
    bool lent = false;
  };
  using Answer = std::optional<CameraTrouble>;

  Answer prepare(const CameraSetup& setup);
  Answer configure(const CameraSetup& setup);
  Answer allocate();
  Answer map(Buffer& buffer);
  static const DmaBufMemory& memory_of(const libcamera::FrameBuffer::Plane& part, Buffer& buffer);
  Answer begin(const CameraSetup& setup);
  bool fill(const Buffer& buffer, CameraFrame& frame) const noexcept;
  CameraPoll lose(CameraCause cause, const char* step, int error, CameraTrouble& trouble) noexcept;
  // On libcamera's thread.
  void complete(libcamera::Request* request);
  void disconnect();
  // On the courier's.
  void carry_back() noexcept;
  void queue_again(Buffer& buffer) noexcept;

  LibcameraSystem& system_;
  Clock& clock_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  libcamera::Stream* stream_ = nullptr;
  CameraMode mode_;
  std::ptrdiff_t stride_ = 0;
  std::vector<Buffer> buffers_;
  HandOver arrived_;             // numbers of completed buffers, to the caller's thread
  HandOver returned_;            // numbers of buffers given back, to the courier
  std::atomic<int> refused_{0};  // errno of the courier's failure
  std::mutex waiting_mutex_;
  std::optional<libcamera::ControlList> waiting_;  // controls for the next request
  std::thread courier_;
  std::size_t cancelled_ = 0;  // requests in a row
  std::optional<CameraTrouble> lost_;
  bool gone_ = false;  // the device does not answer
};

}  // namespace cupola
