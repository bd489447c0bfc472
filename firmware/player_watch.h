// Beside the frame loop: keeps the show's position in a file and tells systemd that frames are presented.
// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "firmware/control_answers.h"
#include "firmware/control_link.h"
#include "firmware/service_notice.h"
#include "firmware/show_position.h"

namespace cupola {

// Has a thread of its own, which looks at the link's status a few times a second.
class PlayerWatch {
 public:
  // `link` and `notice` are borrowed for the watch's life. An empty `file`: no position is kept.
  PlayerWatch(ControlLink& link, ServiceNotice& notice, ShowFacts facts, std::filesystem::path file);
  ~PlayerWatch();

 private:
  void run();
  // What is new in `status`; systemd hears of frames that the loop made, though the display may be away.
  void look(const PlayerStatus& status);
  void keep(const PlayerStatus& status);

  ControlLink& link_;
  ServiceNotice& notice_;
  ShowFacts facts_;
  std::filesystem::path file_;
  bool ready_ = false;
  std::int64_t frames_ = 0;              // presented when systemd was told last
  PlayerStatus kept_;                    // what the file says
  bool keeps_ = false;                   // ... once it says something
  bool failed_ = false;                  // and could not be written last
  std::chrono::nanoseconds written_{0};  // of the boot's clock: when
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace cupola
