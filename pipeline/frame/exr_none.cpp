// Where this build has no OpenEXR, its files are refused by name.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {

StillInfo probe_exr(std::span<const std::byte>, const std::string& name) {
  throw InputError(name + ": an EXR; this build reads none (CUPOLA_EXR=OFF); expected PNG, JPEG or TIFF");
}

int read_exr(std::span<const std::byte> file, const std::string& name, const MutableImage&, RowRange) {
  probe_exr(file, name);
  return 0;
}

void write_exr(const std::filesystem::path& path, const Image&) {
  throw InputError(path.string() + ": an EXR; this build writes none (CUPOLA_EXR=OFF); expected PNG");
}

}  // namespace cupola
