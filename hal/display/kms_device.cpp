// Finding cards, connectors and modes.
// SPDX-License-Identifier: MIT
#include "hal/display/kms_device.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

namespace cupola {
namespace {

struct Free {
  void operator()(drmModeRes* resources) const { drmModeFreeResources(resources); }
  void operator()(drmModeConnector* connector) const { drmModeFreeConnector(connector); }
  void operator()(drmVersion* version) const { drmFreeVersion(version); }
};

std::string connector_name(const drmModeConnector& connector) {
  const char* type = drmModeGetConnectorTypeName(connector.connector_type);
  return std::string(type ? type : "Unknown") + "-" + std::to_string(connector.connector_type_id);
}

// The N of "cardN".
int card_number(const std::filesystem::path& path) {
  const std::string name = path.filename();
  constexpr std::string_view kCard = "card";
  if (!name.starts_with(kCard)) return -1;
  int number = -1;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + kCard.size(), end, number);
  return read.ec == std::errc() && read.ptr == end ? number : -1;
}

}  // namespace

KmsFile& KmsFile::operator=(KmsFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}
KmsFile::~KmsFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

KmsFile open_kms_card(const std::filesystem::path& path) {
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error("kms: " + path.string() + ": " + why);
  };
  KmsFile card(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
  if (!card) fail(std::strerror(errno));
  std::uint64_t able = 0;
  const std::unique_ptr<drmModeRes, Free> resources(drmModeGetResources(card.get()));
  if (!resources || resources->count_crtcs == 0) fail("it drives no screens");
  if (drmSetClientCap(card.get(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1) != 0 ||
      drmSetClientCap(card.get(), DRM_CLIENT_CAP_ATOMIC, 1) != 0) {
    fail("its driver has no atomic mode setting");
  }
  if (drmGetCap(card.get(), DRM_CAP_TIMESTAMP_MONOTONIC, &able) != 0 || able == 0) {
    fail("its driver does not stamp flips with the monotonic clock");
  }
  return card;
}

KmsMode mode_of(const _drmModeConnector& connector, int index) {
  const drmModeModeInfo& from = connector.modes[index];
  KmsMode mode;
  mode.width = from.hdisplay;
  mode.height = from.vdisplay;
  const std::uint64_t pixels = std::uint64_t{from.htotal} * from.vtotal;  // clock: kHz
  mode.period = std::chrono::nanoseconds(from.clock == 0 ? 0 : pixels * 1'000'000U / from.clock);
  mode.preferred = (from.type & DRM_MODE_TYPE_PREFERRED) != 0;
  mode.progressive = (from.flags & (DRM_MODE_FLAG_INTERLACE | DRM_MODE_FLAG_DBLSCAN)) == 0 &&
                     mode.period > std::chrono::nanoseconds(0);
  return mode;
}

std::vector<KmsConnector> connectors_of(const KmsFile& card) {
  std::vector<KmsConnector> connectors;
  const std::unique_ptr<drmModeRes, Free> resources(drmModeGetResources(card.get()));
  for (int i = 0; resources && i < resources->count_connectors; ++i) {
    const std::unique_ptr<drmModeConnector, Free> from(
        drmModeGetConnector(card.get(), resources->connectors[i]));
    if (!from || from->connector_type == DRM_MODE_CONNECTOR_WRITEBACK) continue;
    KmsConnector connector{
        connector_name(*from), from->connector_id, from->connection == DRM_MODE_CONNECTED, {}};
    for (int mode = 0; mode < from->count_modes; ++mode) connector.modes.push_back(mode_of(*from, mode));
    connectors.push_back(std::move(connector));
  }
  return connectors;
}

std::vector<KmsCard> list_kms_cards(const std::filesystem::path& folder) {
  std::vector<KmsCard> cards;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (card_number(entry.path()) < 0) continue;
    KmsCard card{entry.path(), {}, {}, {}};
    try {
      const KmsFile file = open_kms_card(card.path);
      const std::unique_ptr<drmVersion, Free> version(drmGetVersion(file.get()));
      if (version) card.driver = version->name;
      card.connectors = connectors_of(file);
    } catch (const std::runtime_error& trouble) {
      card.trouble = trouble.what();
    }
    cards.push_back(std::move(card));
  }
  std::sort(cards.begin(), cards.end(),
            [](const KmsCard& a, const KmsCard& b) { return card_number(a.path) < card_number(b.path); });
  return cards;
}

KmsPlug::KmsPlug(const std::filesystem::path& card, const std::string& connector) {
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(card, error);
  const std::string path = "/sys/class/drm/" + real.filename().string() + "-" + connector + "/status";
  status_ = KmsFile(open(path.c_str(), O_RDONLY | O_CLOEXEC));
}

bool KmsPlug::in() const noexcept {
  if (!status_) return true;
  char text[16] = {};
  const ssize_t size = pread(status_.get(), text, sizeof text - 1, 0);
  return size < 0 || std::string_view(text) != "disconnected\n";
}

}  // namespace cupola
