// A camera's pictures and its neighbour's of the same instants, matched.
// SPDX-License-Identifier: MIT
#include "firmware/seam_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/calibrate/seam_match.h"

namespace cupola {
namespace {

using std::chrono::nanoseconds;

constexpr double kMostApart = 2.0;  // texels
constexpr nanoseconds kBetweenLooks =
    std::chrono::milliseconds(250);  // of the two kept of a look one will do

struct Neighbour {
  std::size_t view = 0;
  const std::vector<TrialPicture>* pictures = nullptr;
};

// Matches pictures that are near enough in time; false where there are none.
bool look(SeamMatch& match, const Rig& rig, const Neighbour& one, const Neighbour& other,
          nanoseconds tolerance) {
  bool any = false;
  nanoseconds next = nanoseconds::min();
  for (const TrialPicture& picture : *one.pictures) {
    if (picture.at < next || picture.grey.size != rig.views[one.view].size) continue;
    for (const TrialPicture& beside : *other.pictures) {
      if (std::chrono::abs(beside.at - picture.at) > tolerance ||
          beside.grey.size != rig.views[other.view].size)
        continue;
      match.look(picture.grey, beside.grey);
      any = true;
      next = picture.at + kBetweenLooks;
      break;
    }
  }
  return any;
}

// "0.3 right, 0.2 down"; empty where it is neither.
std::string sides(const Vec2& shift) {
  std::string text;
  const auto add = [&](double length, const char* less, const char* more) {
    if (std::abs(length) < 0.05) return;
    text +=
        fmt::format("{}{:.1f} {}", text.empty() ? "" : ", ", std::abs(length), length < 0.0 ? less : more);
  };
  add(shift.x, "left", "right");
  add(shift.y, "up", "down");
  return text;
}

std::string describe(const SeamMeasure& measure) {
  if (!measure.tells()) {
    return fmt::format(
        "cannot be told: of {} places {} have too little texture, {} look the same again within {} texels, "
        "{} have nothing alike there, {} agree",
        measure.places(), measure.plain, measure.repeating, SeamMatch::kReach, measure.unlike,
        measure.shifts.size());
  }
  std::string text = fmt::format("{:.2f} texels apart (median of {} places, 95 % within {:.2f})",
                                 measure.median, measure.shifts.size() - measure.strays, measure.most);
  const std::string mostly = sides(measure.mostly);
  if (!mostly.empty()) text += ", mostly " + mostly;
  if (measure.strays > 0) text += fmt::format("; {} stray{}", measure.strays, measure.strays > 1 ? "s" : "");
  return text;
}

// Where seams close, in words.
std::string meeting(const Rig& rig) {
  return std::isinf(rig.seams.distance_m) ? "far away" : fmt::format("{:.4g} m away", rig.seams.distance_m);
}

std::string complaint(const SeamMeasure& measure, const Rig& rig) {
  if (measure.tells() && measure.median > kMostApart) {
    return fmt::format("{:.2f} texels apart, expected {:g} at most of things {}: see cupola calibrate",
                       measure.median, kMostApart, meeting(rig));
  }
  // Most places with texture show other things.
  if (!measure.tells() && measure.unlike >= 2 * SeamMeasure::kLeast &&
      2 * measure.unlike > measure.places() - measure.plain) {
    return fmt::format(
        "nothing alike within {} texels at {} of {} places, expected pictures of the same things {}: see "
        "cupola "
        "calibrate",
        SeamMatch::kReach, measure.unlike, measure.places(), meeting(rig));
  }
  return {};
}

// Views that have pictures, and their sizes.
std::vector<Neighbour> neighbours_of(Rig& rig, std::span<const OpenCamera> cameras,
                                     std::span<const TrialResult> results, std::vector<std::string>& wrong) {
  std::vector<Neighbour> neighbours;
  for (std::size_t v = 0; v < rig.views.size(); ++v) {
    View& view = rig.views[v];
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const OpenCamera& of) { return of.settings.view == view.name; });
    if (camera == cameras.end()) continue;
    const TrialResult& result = results[static_cast<std::size_t>(camera - cameras.begin())];
    if (!result.mode) continue;
    const CameraMode whole = camera->whole.value_or(*result.mode);
    const Size sent{whole.width, whole.height};
    if (view.size != Size{} && view.size != sent) {
      wrong.push_back(fmt::format("camera {}: sends {} x {} texels, expected {} x {} as the view has",
                                  view.name, sent.width, sent.height, view.size.width, view.size.height));
      continue;
    }
    view.size = sent;
    if (!result.pictures.empty()) neighbours.push_back({v, &result.pictures});
  }
  return neighbours;
}

}  // namespace

std::vector<std::string> try_seams(const Rig& rig, std::span<const OpenCamera> cameras,
                                   std::span<const TrialResult> results, nanoseconds tolerance) {
  std::vector<std::string> wrong;
  Rig sized = rig;
  const std::vector<Neighbour> neighbours = neighbours_of(sized, cameras, results, wrong);
  bool told = false;
  for (std::size_t a = 0; a < neighbours.size(); ++a) {
    for (std::size_t b = a + 1; b < neighbours.size(); ++b) {
      const Neighbour& one = neighbours[a];
      const Neighbour& other = neighbours[b];
      SeamMatch match(sized, one.view, other.view);
      if (!match.overlap()) continue;
      const std::string seam =
          fmt::format("seam {}, {}", sized.views[one.view].name, sized.views[other.view].name);
      if (!look(match, sized, one, other, tolerance)) {
        fmt::print("{}: cannot be told: no whole pictures of both within {:g} ms\n", seam,
                   std::chrono::duration<double, std::milli>(tolerance).count());
        continue;
      }
      const SeamMeasure measure = match.measure();
      fmt::print("{}: {}\n", seam, describe(measure));
      if (const std::string words = complaint(measure, sized); !words.empty())
        wrong.push_back(fmt::format("{}: {}", seam, words));
      told = told || measure.tells();
    }
  }
  if (told) {
    fmt::print("seams: of things {}; what is nearer{} is apart by parallax\n", meeting(rig),
               std::isinf(rig.seams.distance_m) ? "" : " or farther");
  }
  return wrong;
}

}  // namespace cupola
