// What is wrong with settings files, gathered in one pass instead of thrown at the first.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cupola {

class SettingsErrors {
 public:
  // Where a message belongs: files in the order in which they were begun, then lines; 0 is the file as such.
  struct Place {
    std::size_t file = 0;
    std::uint32_t line = 0;
  };

  // The place of a file, the same one for the same name.
  std::size_t begin_file(const std::string& name);
  // Returns what withdraw() takes.
  std::size_t add(Place place, std::string message);
  void withdraw(std::size_t index) { entries_[index].withdrawn = true; }

  // How many were added so far, those withdrawn too.
  std::size_t count() const { return entries_.size(); }
  // All, in the order of their places, none twice.
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    Place place;
    std::string message;
    bool withdrawn = false;
  };
  std::vector<std::string> files_;
  std::vector<Entry> entries_;
};

}  // namespace cupola
