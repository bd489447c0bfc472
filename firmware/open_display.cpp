// The one place that knows every display.
// SPDX-License-Identifier: MIT
#include "firmware/open_display.h"

#include <cstdlib>

#include "firmware/command.h"
#include "firmware/file_display.h"
#include "hal/display/fake_display.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/numbered_frames.h"
#ifdef CUPOLA_KMS
#include "hal/display/kms_display.h"
#endif
#ifdef CUPOLA_WINDOW
#include "hal/display/window_display.h"
#endif

namespace cupola {
namespace {

bool has_desktop() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value && *value) return true;
  }
  return false;
}

bool has_projector() {
#ifdef CUPOLA_KMS
  for (const KmsCard& card : list_kms_cards()) {
    if (choose_kms_connector(card.connectors, "")) return true;
  }
#endif
  return false;
}

}  // namespace

std::unique_ptr<Display> open_display(const std::string& kind, const std::string& out, Clock& clock,
                                      const Show& show, double rate, std::optional<Y4mWriter>& video,
                                      [[maybe_unused]] CommandQueue& commands) {
  const Size size = show.rig.frame.size;
  if (kind == "fake") {
    auto fake = std::make_unique<FakeDisplay>(clock, size.width, size.height);
    fake->take_nv12();
    return fake;
  }
  if (kind == "file" && is_video_name(out)) {
    video.emplace(out, size, frame_rate(rate));
    return std::make_unique<FileDisplay>(clock, size, [&video](const Image& frame) { video->write(frame); });
  }
  if (kind == "file") {
    return std::make_unique<FileDisplay>(clock, size,
                                         [files = NumberedFrames(out, show.name), count = std::int64_t{0}](
                                             const Image& frame) mutable { files.write(count++, frame); });
  }
  if (kind == "kms" || (kind == "auto" && !has_desktop() && has_projector())) {
#ifdef CUPOLA_KMS
    const ProjectorSettings& projector = show.devices.projector;
    const KmsSettings settings{projector.connector, projector.mode, projector.card, KmsMemoryKind::kDumb};
    return std::make_unique<KmsDisplay>(clock, settings, size.width, size.height);
#else
    throw Failure("play: this program was built without KMS");
#endif
  }
  if (kind == "auto" && !has_desktop()) {
    throw Failure(
        "play: there is no desktop and no projector; expected --display file with --out DIR, or --display "
        "fake");
  }
#ifdef CUPOLA_WINDOW
  auto window = std::make_unique<WindowDisplay>(clock, "Cupola: " + show.name, size.width, size.height);
  window->on_key([&commands](char key) {
    if (const std::optional<PlayerCommand> command = command_of_key(key)) commands.push(*command);
  });
  return window;
#else
  throw Failure("play: this program was built without windows");
#endif
}

}  // namespace cupola
