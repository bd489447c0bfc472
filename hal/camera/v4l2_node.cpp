// What errno says about a camera.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_node.h"

#include <cerrno>

namespace cupola {

int V4l2Node::ask(unsigned long request, void* argument) const noexcept {
  for (;;) {
    if (calls->ioctl(descriptor, request, argument) == 0) return 0;
    if (errno != EINTR) return errno;
  }
}

CameraTrouble refused(const char* step, int error) noexcept {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {CameraCause::kMissing, step, error};
    case EBUSY:
      return {CameraCause::kBusy, step, error};
    case ENOLINK:  // nothing there
    case ENOLCK:   // not steady
      return {CameraCause::kNoSignal, step, error};
    default:
      return {CameraCause::kFailed, step, error};
  }
}

}  // namespace cupola
