// Lenses as data: the [lens] table of a rig, or a file of its own.
// SPDX-License-Identifier: MIT
#include <array>

#include "pipeline/optics/config_path.h"
#include "pipeline/optics/lens.h"
#include "pipeline/portable/portable_math.h"
#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

constexpr std::array<std::string_view, 7> kModelNames = {"omnimax-c430",  "equidistant",  "equisolid",
                                                         "stereographic", "orthographic", "polynomial",
                                                         "opencv-fisheye"};

double half_fov(SettingsTable& table, double most_degrees) {
  return portable::radians(table.number("fov_deg", 1.0, most_degrees, std::min(180.0, most_degrees)) / 2);
}

Lens read_model(SettingsTable& table) {
  const std::size_t model = table.choice("model", kModelNames);
  if (table.refused("model")) {
    half_fov(table, 360.0);
    if (table.has("coefficients")) table.numbers("coefficients", 1, 16);
    return omnimax_c430();
  }
  Lens lens;
  switch (model) {
    case 0:
      return omnimax_c430();
    case 1:
      lens = {LensModel::kEquidistant, half_fov(table, 360.0), {}, {}};
      break;
    case 2:
      lens = {LensModel::kEquisolid, half_fov(table, 360.0), {}, {}};
      break;
    case 3:
      lens = {LensModel::kStereographic, half_fov(table, 350.0), {}, {}};
      break;
    case 4:
      lens = {LensModel::kOrthographic, half_fov(table, 180.0), {}, {}};
      break;
    case 5:
      lens = {LensModel::kPolynomial, 0.0, table.numbers("coefficients", 2, 16), {}};
      break;
    default:
      lens = {LensModel::kOpencvFisheye, half_fov(table, 360.0), table.numbers("coefficients", 1, 4), {}};
  }
  lens.name = kModelNames[model];
  return lens;
}

}  // namespace

Lens read_lens(SettingsTable& table, const std::filesystem::path& directory) {
  if (table.has("file")) {
    const std::string name = table.text("file");
    const std::filesystem::path file = name.empty() ? "" : find_config(name, directory, "lenses");
    if (file.empty()) table.refuse("file", "expected a lens file beside the rig or in config/lenses");
    table.finish();
    Lens lens = omnimax_c430();
    if (file.empty()) return lens;
    table.attempt("file", [&] {
      SettingsTable own = load_settings(file, {}, table.errors());
      if (own.has("file")) {
        own.refuse("file", "expected a lens with a model, not another file");
      } else {
        lens = read_lens(own, file.parent_path());
      }
    });
    return lens;
  }
  Lens lens = read_model(table);
  const std::string wrong = table.refused("") ? "" : fault(lens);
  if (!wrong.empty()) table.refuse(table.has("coefficients") ? "coefficients" : "model", wrong);
  table.finish();
  return lens;
}

}  // namespace cupola
