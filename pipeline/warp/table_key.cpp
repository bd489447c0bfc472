// Takes the rig apart member by member. The structured bindings are there to fail when a member is added: say
// then whether it bears on the table.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <concepts>

#include "pipeline/frame/checksum.h"

namespace cupola {
namespace {

class KeyWriter {
 public:
  void add(double value) { key_.push_back(std::bit_cast<std::uint64_t>(value)); }
  void add(std::integral auto value) { key_.push_back(static_cast<std::uint64_t>(value)); }
  template <class Name>
  requires std::is_enum_v<Name>
  void add(Name value) { key_.push_back(static_cast<std::uint64_t>(value)); }

  void add(const Vec2& v) { add_all(v.x, v.y); }
  void add(const Vec3& v) { add_all(v.x, v.y, v.z); }
  void add(const Size& size) { add_all(size.width, size.height); }

  void add(const Lens& lens) {
    const auto& [model, half_fov, coefficients, name] = lens;
    add_all(model, half_fov, coefficients.size());
    for (const double coefficient : coefficients) add(coefficient);
  }

  void add(const View& view) {
    const auto& [name, forward, right, up, size, focal, principal, distortion, coefficients, limit, rec_v,
                 position_m, shift] = view;
    add_all(forward, right, up, size, focal, principal, distortion, limit, rec_v);
    for (const double coefficient : coefficients) add(coefficient);
  }

  void add(const std::vector<View>& views) {
    add(views.size());
    for (const View& view : views) add(view);
  }

  void add(const FrameGeometry& frame) {
    const auto& [model, size, center, radius, crop, lens, fov, columns, faces] = frame;
    add_all(model, size, center, radius, crop, lens, fov, columns, faces);
  }

  void add(const FilterSettings& filter) {
    const auto& [kernel, alpha, radius, rec, table, noise] = filter;
    add_all(kernel, alpha, radius, rec, table, noise);
  }

  void add(const Rig& rig) {
    const auto& [file, frame, views, filter, samples, seams, budget_ms, tilt_deg, world_from_lens] = rig;
    add_all(frame, views, filter);
    if (seams.feather_deg > 0.0) add(seams.feather_deg);
    // Where there is none the key is what it was before there were any; three numbers a view tell them from
    // the feather.
    if (std::any_of(views.begin(), views.end(), is_shifted)) {
      for (const View& view : views) add(view.shift);
    }
  }

  TableKey take() { return std::move(key_); }

 private:
  template <class... Value>
  void add_all(const Value&... values) {
    (add(values), ...);
  }

  TableKey key_;
};

}  // namespace

TableKey table_key(const Rig& rig) {
  KeyWriter writer;
  writer.add(rig);
  return writer.take();
}

std::string hash_of(const TableKey& key) {
  return fmt::format("{:016x}", checksum(std::as_bytes(std::span(key))));
}

}  // namespace cupola
