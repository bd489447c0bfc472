// One function a kind of device.
// SPDX-License-Identifier: MIT
#include "firmware/rig_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "firmware/camera_trial.h"
#include "firmware/open_cameras.h"
#include "firmware/seam_trial.h"
#include "hal/gpio/gpiod_lines.h"
#ifdef CUPOLA_KMS
#include "hal/display/kms_device.h"
#endif

namespace cupola {
namespace {

using namespace std::chrono_literals;
using Complaints = std::vector<std::string>;

void print(const RigCamera& camera, const TrialResult& result) {
  fmt::print("camera {}: {}", camera.view, camera.setup.device);
  if (result.mode) {
    fmt::print(": {} {} x {}, {} frames, {:.2f} a second, jitter {:.2f} ms, longest gap {:.1f} ms",
               name_of(result.mode->format), result.mode->width, result.mode->height, result.counts.frames,
               result.rate, result.jitter_ms, result.worst_gap_ms);
  }
  if (result.offset_ms) {
    fmt::print(", {:+.2f} ms off the first camera (within {:.2f})", *result.offset_ms,
               result.offset_spread_ms);
  }
  if (result.counts.dropped > 0) fmt::print(", {} dropped", result.counts.dropped);
  fmt::print("\n");
  if (!result.picture) return;
  fmt::print("camera {}: brightness {:.0f} %, {:.1f} % of it white, ", camera.view,
             100.0 * result.picture->mean, 100.0 * result.picture->white_share);
  if (result.picture->edge_texels > 0.0) {
    fmt::print("sharpest edges {:.1f} texels wide\n", result.picture->edge_texels);
  } else {
    fmt::print("too few edges to tell the focus\n");
  }
}

// What fake cameras send is of no world, and has no seams; recordings go by the fake clock too.
void try_the_cameras(const Rig& rig, const RigDevices& devices, const std::filesystem::path& recording,
                     Complaints& wrong) {
  const std::vector<RigCamera>& settings = devices.cameras;
  if (settings.empty()) return;
  const bool fakes =
      recording.empty() && std::all_of(settings.begin(), settings.end(), [](const RigCamera& camera) {
        return camera.driver == CameraDriver::kFake;
      });
  MonotonicClock real;
  FakeClock fake;
  const bool real_time = recording.empty() && !fakes;
  Clock& clock = real_time ? static_cast<Clock&>(real) : static_cast<Clock&>(fake);
  CameraRecordings recordings;
  recordings.replay = recording;
  recordings.from_first_frame = true;
  CameraDrivers drivers;
  const std::vector<OpenCamera> cameras =
      drivers.open(settings, clock, real_time ? nullptr : &fake, recordings);
  std::vector<CameraWatch*> watches;
  for (const OpenCamera& camera : cameras) watches.push_back(camera.watch.get());
  const std::vector<TrialResult> results = try_cameras(watches, clock, 2s);
  for (std::size_t c = 0; c < results.size(); ++c) {
    print(settings[c], results[c]);
    for (const std::string& complaint : complaints(results[c], settings[c].setup.rate)) {
      wrong.push_back(
          fmt::format("camera {}: {}: {}", settings[c].view, settings[c].setup.device, complaint));
    }
  }
  if (fakes) return;
  for (std::string& complaint : try_seams(rig, cameras, results, devices.live.sync.tolerance))
    wrong.push_back(std::move(complaint));
}

void try_the_lines(const GpioSettings& settings, Complaints& wrong) {
  if (settings.empty()) return;
  std::vector<GpioLine> lines;
  for (const PanelInput& input : settings.inputs) lines.push_back(input.line);
  for (const PanelOutput& output : settings.outputs) lines.push_back(output.line);
  MonotonicClock clock;
  const std::unique_ptr<Gpio> gpio = make_gpiod_lines(clock);
  const auto started = gpio->start(lines);
  if (const GpioTrouble* trouble = std::get_if<GpioTrouble>(&started)) {
    wrong.push_back("gpio: " + describe(*trouble, lines));
    return;
  }
  const GpioLevels& levels = *std::get_if<GpioLevels>(&started);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    fmt::print("gpio {}: {}\n", describe(lines[i]),
               lines[i].output ? "an output"
               : levels[i]     ? "an input, active"
                               : "an input, not active");
  }
  gpio->stop();
}

#ifdef CUPOLA_KMS
// Of the colour that most cameras have.
bool takes_nv12(const KmsCard& card, const KmsConnector& connector) {
  const KmsFile file = open_kms_card(card.path);
  KmsPipe pipe = find_kms_pipe(file, connector);
  return choose_nv12(file, pipe, {});
}
#endif

void try_the_projector([[maybe_unused]] const ProjectorSettings& settings, [[maybe_unused]] Size frame,
                       [[maybe_unused]] Complaints& wrong) {
#ifdef CUPOLA_KMS
  if (settings.connector.empty() && settings.mode.width == 0) return;  // it may be a window
  for (const KmsCard& card : list_kms_cards()) {
    if (!settings.card.empty() && card.path != settings.card) continue;
    const auto place = choose_kms_connector(card.connectors, settings.connector);
    if (!place) continue;
    const KmsConnector& connector = card.connectors[*place];
    if (!connector.connected) {
      wrong.push_back(fmt::format("display {}: nothing plugged in", connector.name));
      return;
    }
    const KmsModeChoice choice = choose_kms_mode(connector.modes, settings.mode, frame.width, frame.height);
    if (choice.trouble != KmsModeTrouble::kNone) {
      wrong.push_back("display: " + describe(choice, connector, settings.mode, frame.width, frame.height));
      return;
    }
    fmt::print("display {}: {} on {}\n", connector.name, name_of(connector.modes[choice.index]),
               card.path.string());
    if (settings.nv12 && !takes_nv12(card, connector)) {
      wrong.push_back(fmt::format("display {}: takes no NV12: frames will be XRGB8888", connector.name));
    }
    return;
  }
  wrong.push_back(fmt::format("display: no connector {}; see cupola devices",
                              settings.connector.empty() ? "with a projector" : settings.connector));
#endif
}

}  // namespace

std::vector<std::string> try_rig(const Rig& rig, const RigDevices& devices) {
  Complaints wrong;
  try_the_cameras(rig, devices, {}, wrong);
  try_the_lines(devices.gpio, wrong);
  try_the_projector(devices.projector, rig.frame.size, wrong);
  return wrong;
}

std::vector<std::string> try_recording(const Rig& rig, const RigDevices& devices,
                                       const std::filesystem::path& folder) {
  Complaints wrong;
  try_the_cameras(rig, devices, folder, wrong);
  return wrong;
}

}  // namespace cupola
