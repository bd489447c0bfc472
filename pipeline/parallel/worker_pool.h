// A fixed set of threads that share out numbered tasks; the results never depend on how many there are.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cupola {

class WorkerPool {
 public:
  // `threads` counts the calling thread too: 1 starts none. 0 takes one a core.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls task(0) ... task(count - 1), each once, on the pool and the calling thread; returns when all are
  // done. One run at a time, no run within a run. Does not allocate. The first exception a task throws is
  // thrown again here once every worker has stopped; tasks not begun by then are left out.
  template <class Task>
  void run(int count, Task&& task) {
    run_erased(count, &task, [](void* context, int index) {
      (*static_cast<std::remove_reference_t<Task>*>(context))(index);
    });
  }

 private:
  using Call = void (*)(void* context, int index);
  void run_erased(int count, void* context, Call call);
  void take_tasks() noexcept;
  void serve();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable begin_;
  std::condition_variable end_;
  std::uint64_t round_ = 0;  // rises once a run
  int busy_ = 0;             // workers still in the round
  bool stopping_ = false;
  std::exception_ptr error_;
  std::atomic<int> next_{0};
  int count_ = 0;
  void* context_ = nullptr;
  Call call_ = nullptr;
};

}  // namespace cupola
