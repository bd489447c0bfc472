// Whose turn it is: which of a screen's buffers is drawn next, and how old what it holds is.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace cupola {

// Three buffers: on the screen, on its way there, and free. While every flip comes in time two take turns;
// the third is for the frames after one that is stuck.
class ScanoutTurns {
 public:
  static constexpr int kBuffers = 3;

  int back() const { return back_; }  // to be drawn
  int last() const { return last_; }  // presented last, seen or not; -1: none
  // How many presents ago what the back buffer holds was presented; 0: it holds anything.
  int age() const;
  bool in_flight() const { return in_flight_ >= 0; }

  // The back buffer is finished: another becomes the back buffer.
  void presented();
  // The last one was handed to the screen; it got there; the screen was switched off.
  void committed() { in_flight_ = last_; }
  void flipped();
  void switched_off();
  // What was presented so far does not count: the next present() is the first.
  void forget();
  // New buffers: they hold nothing but the frame presented last, copied into the first of them.
  void replaced();

 private:
  void choose_back();

  std::array<std::int64_t, kBuffers> presented_{};  // number of the present that the buffer holds; 0: none
  std::int64_t presents_ = 0;
  int back_ = 0;
  int last_ = -1;
  int in_flight_ = -1;
  int screen_ = -1;
};

}  // namespace cupola
