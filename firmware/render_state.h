// What a render has written so far, kept beside its files, so that it goes on after it was killed.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

namespace cupola {

// A file of lines: the key of the render, then, added as frames are done, "frame NUMBER BYTES" or "process
// NUMBER". It is there only while the render is not whole. Everything throws Failure.
class RenderState {
 public:
  // Takes over what is in `file` where that was written with the same `key`; else begins it anew. Temporary
  // files of the processes that were killed are removed from its folder. Only one process at a time may have
  // the file.
  RenderState(std::filesystem::path file, const std::string& key);
  ~RenderState();
  RenderState(const RenderState&) = delete;
  RenderState& operator=(const RenderState&) = delete;

  // The frame was written by this render, and its file `written` is still as long as it was.
  bool done(std::int64_t frame, const std::filesystem::path& written) const;
  void add(std::int64_t frame, const std::filesystem::path& written);
  void finish();  // the render is whole: removes the file

 private:
  void read_lines(const std::string& key);
  void append(const std::string& line);
  [[noreturn]] void fail(int error) const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::map<std::int64_t, std::uintmax_t> bytes_;  // of the frames that are done
};

// Sixteen digits that stand for everything that bears on the pixels: a text and numbers.
std::string render_key(const std::string& text, std::span<const std::uint64_t> numbers);

}  // namespace cupola
