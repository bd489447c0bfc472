// One camera: a device that streams frames into buffers of its own, which are lent, not copied.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cupola {

// As V4L2 and libcamera know them; rows run top to bottom. Recordings hold the numbers: new ones go to the
// end.
enum class CameraFormat : std::uint8_t {
  kYuyv,    // 4:2:2, bytes Y0 U Y1 V
  kUyvy,    // 4:2:2, bytes U Y0 V Y1
  kNv12,    // 4:2:0, a plane of Y, a plane of bytes U V
  kI420,    // 4:2:0, planes Y, U, V (V4L2's YU12)
  kI422,    // 4:2:2, planes Y, U, V (422P)
  kRgb24,   // bytes R G B (V4L2's RGB3)
  kBgr24,   // bytes B G R (BGR3)
  kXrgb32,  // little-endian words 0x--RRGGBB (XR24)
  kGrey,    // bytes Y
  kMjpeg,   // a JPEG picture: one plane of `bytes` bytes, no stride
  kP010,    // NV12 in little-endian words, whose upper 10 bits are the sample
};
inline constexpr std::size_t kCameraFormats = 11;

// Texels of the sensor's whole picture; width 0: all of it.
struct CameraArea {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  friend bool operator==(const CameraArea&, const CameraArea&) = default;
};

// "exposure" (microseconds), "gain" (1 is none), "white_balance" (kelvin), "auto_exposure",
// "auto_white_balance" and "trigger" (0 or 1), which each driver turns into its own, or the driver's own name
// for one of its controls and a number as the driver takes it.
struct CameraControl {
  std::string name;
  double value = 0.0;
};

// What is asked of a camera. What it then does is its CameraMode.
struct CameraSetup {
  std::string device;                 // its path, bus or card's name (V4L2); its id or model (libcamera)
  std::vector<CameraFormat> formats;  // best first: the first that the device has is taken; none: any of ours
  int width = 0;                      // texels; 0: whatever the device is set to
  int height = 0;
  double rate = 0.0;  // frames a second; 0: as the device is set
  CameraArea crop;    // the part that is needed; a device that cannot crop sends everything
  std::vector<CameraControl> controls;
  int buffers = 4;  // 2 to 32
};

struct CameraMode {
  CameraFormat format = CameraFormat::kYuyv;
  int width = 0;  // texels of a frame
  int height = 0;
  double rate = 0.0;        // frames a second; 0: the driver does not say
  CameraArea crop;          // what the frame shows of the sensor's whole picture
  bool bt709 = false;       // else BT.601
  bool full_range = false;  // else 16 to 235
  friend bool operator==(const CameraMode&, const CameraMode&) = default;
};

enum class CameraCause : std::uint8_t {
  kMissing,      // there is no such device (any more)
  kBusy,         // somebody else has it
  kUnsupported,  // it is no camera, or has no format, size or control as asked
  kNoSignal,     // nothing is plugged into its input
  kChanged,      // what it sends is not what was agreed: size, stride or format
  kFailed,       // the driver refused a call
  kSilent,       // no frame within the watchdog's time
};
inline constexpr std::size_t kCameraCauses = 7;

struct CameraTrouble {
  CameraCause cause = CameraCause::kFailed;
  const char* step = "";  // the call or setting that failed, in static storage
  int error = 0;          // errno, or 0
};

struct CameraPlane {
  const std::uint8_t* data = nullptr;
  std::ptrdiff_t stride = 0;  // bytes from one row to the next
  std::size_t bytes = 0;      // that the driver filled
  int dma_buf =
      -1;  // the same memory as a DMA-BUF, where the driver exports it: the camera's own, do not close
  std::size_t offset = 0;  // of `data` within the DMA-BUF
};

// Lent until it is given back or the camera stops.
struct CameraFrame {
  CameraFormat format = CameraFormat::kYuyv;
  int width = 0;
  int height = 0;
  std::array<CameraPlane, 3> planes;
  std::uint64_t sequence = 0;  // a gap means that the device dropped frames. Drivers count modulo 2^32
  // CLOCK_MONOTONIC, as the driver says: at most a frame's time ahead of the poll.
  std::chrono::nanoseconds captured_at{0};
  int buffer = -1;  // which of the camera's
};

enum class CameraPoll : std::uint8_t {
  kFrame,    // `frame` is the oldest that was not polled yet
  kNothing,  // none is ready
  kDamaged,  // one came and could not be used (error flag, too short): it was handed back to the device;
             // of `frame` only the sequence is set
  kLost,     // the stream is over until the camera is started again; `trouble` says why. Frames that are
             // lent stay readable until then or until stop(); while stopped, poll() says kNothing
};

// A driver's side; it neither retries nor watches the time: CameraWatch does. One thread at a time. Nothing
// throws. start() and stop() may take as long as the device does and may allocate; the others do not.
class Camera {
 public:
  virtual ~Camera() = default;
  // Opens the device, sets it up and starts its stream; stops it first where it runs. When it fails, the
  // device is closed.
  virtual std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept = 0;
  // Ends the stream and closes the device; every lent frame is gone.
  virtual void stop() noexcept = 0;
  virtual CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept = 0;
  // What is not lent (any more) is passed over.
  virtual void give_back(const CameraFrame& frame) noexcept = 0;
  // Can be read when poll() has something to say; -1 while stopped.
  virtual int descriptor() const noexcept = 0;
  // Of CameraControl's names "exposure", "gain" and "frame_time" (microseconds from one frame to the next),
  // for the frames to come, as near as the device can. False while stopped, and where it has no such control
  // or does not take the value. May take as long as the device does and may allocate; another thread may poll
  // meanwhile.
  virtual bool set_control(const CameraControl& /*control*/) noexcept { return false; }
};

// "YUYV", as V4L2's FourCCs; and the format of such a name, or false.
const char* name_of(CameraFormat format);
bool format_of(std::string_view name, CameraFormat& format);
// "no such device", ...
const char* name_of(CameraCause cause);
// "VIDIOC_STREAMON: busy: Device or resource busy"
std::string describe(const CameraTrouble& trouble);

}  // namespace cupola
