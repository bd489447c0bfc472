// The bar and the count.
// SPDX-License-Identifier: MIT
#include "firmware/progress.h"

#include <unistd.h>

#include <cstdio>

namespace cupola {

Progress::Progress(std::string what, std::int64_t total)
    : what_(std::move(what)), total_(total), on_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (on_terminal_) std::fputs("\r\033[K", stderr);
}

void Progress::show(std::int64_t done) {
  const std::chrono::nanoseconds now = clock_.now();
  if (!on_terminal_ || now < next_) return;
  next_ = now + std::chrono::milliseconds(200);
  constexpr int kWidth = 30;
  const int full = total_ > 0 ? static_cast<int>(kWidth * done / total_) : 0;
  std::string bar(static_cast<std::size_t>(full), '#');
  bar.resize(kWidth, '.');
  std::fprintf(stderr, "\r%s [%s] %lld of %lld\033[K", what_.c_str(), bar.c_str(),
               static_cast<long long>(done), static_cast<long long>(total_));
  std::fflush(stderr);
}

}  // namespace cupola
