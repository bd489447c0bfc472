// A bell that is waited for.
// SPDX-License-Identifier: MIT
#include "firmware/side_work.h"

#include <sys/resource.h>

namespace cupola {

SideWork::SideWork(std::function<void()> work, bool lowest) : work_(std::move(work)) {
  thread_ = std::thread([this, lowest] {
    if (lowest) setpriority(PRIO_PROCESS, 0, 19);  // on Linux: this thread's alone
    for (int heard = 0; !stopping();) {
      bell_.wait(heard);
      heard = bell_.load();
      if (!stopping()) work_();
    }
  });
}

void SideWork::finish() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  ring();
  thread_.join();
}

void SideWork::ring() noexcept {
  bell_.fetch_add(1);
  bell_.notify_one();
}

}  // namespace cupola
