// Connector, CRTC and primary plane, and the numbers of their properties.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <initializer_list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>

#include <drm_fourcc.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "hal/display/kms_device.h"

namespace cupola {
namespace {

struct Free {
  void operator()(drmModeRes* resources) const { drmModeFreeResources(resources); }
  void operator()(drmModeConnector* connector) const { drmModeFreeConnector(connector); }
  void operator()(drmModeEncoder* encoder) const { drmModeFreeEncoder(encoder); }
  void operator()(drmModePlane* plane) const { drmModeFreePlane(plane); }
  void operator()(drmModePlaneRes* planes) const { drmModeFreePlaneResources(planes); }
  void operator()(drmModeObjectProperties* properties) const { drmModeFreeObjectProperties(properties); }
  void operator()(drmModePropertyRes* property) const { drmModeFreeProperty(property); }
};
template <class Type>
using Owned = std::unique_ptr<Type, Free>;

struct Property {
  std::uint32_t id;
  std::uint64_t value;
};

std::optional<Property> find_property(int card, std::uint32_t object, std::uint32_t type,
                                      std::string_view name) {
  const Owned<drmModeObjectProperties> all(drmModeObjectGetProperties(card, object, type));
  for (std::uint32_t i = 0; all && i < all->count_props; ++i) {
    const Owned<drmModePropertyRes> property(drmModeGetProperty(card, all->props[i]));
    if (property && property->name == name) return Property{property->prop_id, all->prop_values[i]};
  }
  return {};
}

std::uint32_t needed_property(int card, std::uint32_t object, std::uint32_t type, const char* name) {
  const std::optional<Property> property = find_property(card, object, type, name);
  if (!property) throw std::runtime_error(std::string("kms: the driver has no property ") + name);
  return property->id;
}

std::uint64_t value_of(int card, std::uint32_t object, std::uint32_t type, const char* name) {
  const std::optional<Property> property = find_property(card, object, type, name);
  return property ? property->value : 0;
}

bool takes(const drmModePlane& plane, std::uint32_t format) {
  const std::uint32_t* const begin = plane.formats;
  const std::uint32_t* const end = begin + plane.count_formats;
  return std::find(begin, end, format) != end;
}

bool is_primary_for(int card, std::uint32_t id, int crtc_index) {
  const Owned<drmModePlane> plane(drmModeGetPlane(card, id));
  return plane && (plane->possible_crtcs >> crtc_index & 1U) != 0 &&
         value_of(card, id, DRM_MODE_OBJECT_PLANE, "type") == DRM_PLANE_TYPE_PRIMARY &&
         takes(*plane, DRM_FORMAT_XRGB8888);
}

// The plane's property `name` and its value that is called `meaning`; {0, 0} without that property, none
// where it has no such value.
std::optional<Property> find_choice(int card, std::uint32_t plane, std::string_view name,
                                    std::string_view meaning) {
  const std::optional<Property> found = find_property(card, plane, DRM_MODE_OBJECT_PLANE, name);
  if (!found) return Property{};
  const Owned<drmModePropertyRes> property(drmModeGetProperty(card, found->id));
  for (int i = 0; property && i < property->count_enums; ++i) {
    if (property->enums[i].name == meaning) return Property{found->id, property->enums[i].value};
  }
  return {};
}

std::uint32_t primary_plane(int card, int crtc_index) {
  const Owned<drmModePlaneRes> planes(drmModeGetPlaneResources(card));
  for (std::uint32_t i = 0; planes && i < planes->count_planes; ++i) {
    if (is_primary_for(card, planes->planes[i], crtc_index)) return planes->planes[i];
  }
  return 0;
}

std::uint32_t possible_crtcs(int card, std::uint32_t connector) {
  std::uint32_t possible = 0;
  const Owned<drmModeConnector> from(drmModeGetConnectorCurrent(card, connector));
  for (int i = 0; from && i < from->count_encoders; ++i) {
    const Owned<drmModeEncoder> encoder(drmModeGetEncoder(card, from->encoders[i]));
    if (encoder) possible |= encoder->possible_crtcs;
  }
  return possible;
}

void find_properties(int card, KmsPipe& pipe) {
  const auto connector = [&](const char* name) {
    return needed_property(card, pipe.connector, DRM_MODE_OBJECT_CONNECTOR, name);
  };
  const auto crtc = [&](const char* name) {
    return needed_property(card, pipe.crtc, DRM_MODE_OBJECT_CRTC, name);
  };
  const auto plane = [&](const char* name) {
    return needed_property(card, pipe.plane, DRM_MODE_OBJECT_PLANE, name);
  };
  const auto link = find_property(card, pipe.connector, DRM_MODE_OBJECT_CONNECTOR, "link-status");
  pipe.connector_property = {connector("CRTC_ID"), link ? link->id : 0};
  pipe.crtc_property = {crtc("MODE_ID"), crtc("ACTIVE")};
  pipe.plane_property = {plane("FB_ID"), plane("CRTC_ID"), plane("SRC_X"),  plane("SRC_Y"),  plane("SRC_W"),
                         plane("SRC_H"), plane("CRTC_X"),  plane("CRTC_Y"), plane("CRTC_W"), plane("CRTC_H")};
}

}  // namespace

bool choose_nv12(const KmsFile& card, KmsPipe& pipe, ScanoutColour colour) {
  const Owned<drmModePlane> plane(drmModeGetPlane(card.get(), pipe.plane));
  if (!plane || !takes(*plane, DRM_FORMAT_NV12)) return false;
  const auto encoding = find_choice(card.get(), pipe.plane, "COLOR_ENCODING",
                                    colour.bt709 ? "ITU-R BT.709 YCbCr" : "ITU-R BT.601 YCbCr");
  const auto range = find_choice(card.get(), pipe.plane, "COLOR_RANGE",
                                 colour.full_range ? "YCbCr full range" : "YCbCr limited range");
  if (!encoding || !range) return false;
  if ((encoding->id == 0 && colour.bt709) || (range->id == 0 && colour.full_range)) return false;
  pipe.nv12_colour = {encoding->id, range->id, encoding->value, range->value};
  return true;
}

KmsPipe find_kms_pipe(const KmsFile& card, const KmsConnector& connector) {
  const int file = card.get();
  KmsPipe pipe;
  pipe.connector = connector.id;
  const Owned<drmModeRes> resources(drmModeGetResources(file));
  const std::uint32_t possible = possible_crtcs(file, connector.id);
  // The CRTC that feeds the connector already, if any: nothing else has to move.
  const std::uint64_t present = value_of(file, connector.id, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID");
  for (const bool any : {false, true}) {
    for (int i = 0; resources && i < resources->count_crtcs && pipe.plane == 0; ++i) {
      if ((possible >> i & 1U) == 0 || (!any && resources->crtcs[i] != present)) continue;
      pipe.crtc = resources->crtcs[i];
      pipe.plane = primary_plane(file, i);
    }
  }
  if (pipe.plane == 0) throw std::runtime_error("kms: " + connector.name + ": no CRTC with a primary plane");
  find_properties(file, pipe);
  for (int i = 0; i < resources->count_connectors; ++i) {
    const std::uint32_t other = resources->connectors[i];
    if (other != connector.id && value_of(file, other, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID") == pipe.crtc) {
      pipe.neighbours.push_back(other);
    }
  }
  return pipe;
}

}  // namespace cupola
