// TOML files read strictly: every value is asked for by name and checked, every other key is an error.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cupola {

class SettingsErrors;

// One table of a settings file. All members throw InputError: "file:line: key: what was expected". The
// outermost table, the one that load_settings returned, must outlive the tables within.
//
// Where errors are gathered nothing is thrown: a wrong value is noted and read as its fallback, or else as
// the least one, 0, an empty text, or a list of the least length. Of each key one thing is said only, and
// nothing of tables that are missing or are none, so that no error follows from another one.
class SettingsTable {
 public:
  SettingsTable(SettingsTable&&) noexcept;
  SettingsTable& operator=(SettingsTable&&) noexcept;
  ~SettingsTable();

  bool has(std::string_view key) const;
  // All keys of this table, for tables whose keys are somebody else's names; in the order of the alphabet.
  std::vector<std::string> keys() const;

  // With a fallback the key may be missing; without, it must be there. Numbers are finite.
  double number(std::string_view key, double least, double most, std::optional<double> fallback = {});
  std::int64_t integer(std::string_view key, std::int64_t least, std::int64_t most,
                       std::optional<std::int64_t> fallback = {});
  bool flag(std::string_view key, std::optional<bool> fallback = {});
  std::string text(std::string_view key, std::optional<std::string> fallback = {});
  // The index of the value among `names`.
  std::size_t choice(std::string_view key, std::span<const std::string_view> names,
                     std::optional<std::size_t> fallback = {});
  // `least` to `most` numbers in brackets.
  std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most);
  std::vector<std::string> texts(std::string_view key, std::size_t least, std::size_t most);
  // [key]; empty when missing.
  SettingsTable table(std::string_view key);
  // [[key]]; none when missing.
  std::vector<SettingsTable> tables(std::string_view key);

  // Keys that might have been asked for, had what decides about it been right.
  void may_have(std::initializer_list<std::string_view> keys);
  // To be called when everything was asked for: a key that nobody asked for is refused, with the nearest
  // known one (all of them, where errors are gathered; a key that is missing by its misspelling is then no
  // error of its own); has() alone does not ask. Tables within are finished by whoever read them.
  void finish() const;

  // Refuses the value of `key` (or the table itself when empty): "file:line: key: message". Returns where
  // errors are gathered.
  void refuse(std::string_view key, std::string_view message) const;
  // Whether that was said of `key`, or of any key when empty; only where errors are gathered.
  bool refused(std::string_view key) const;
  // Does what `key` asks for; where errors are gathered an InputError out of it is one of this line.
  void attempt(std::string_view key, const std::function<void()>& read) const;
  SettingsErrors* errors() const;  // where they are gathered; null: nowhere

 private:
  friend SettingsTable load_settings(const std::filesystem::path&, std::span<const std::string>,
                                     SettingsErrors*);
  struct State;
  explicit SettingsTable(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Parses `file` and lays the overrides over it: "key=value", "table.key=value" or "tables.2.key=value"
// (counted from 0), the value as TOML has it; a bare word that is no TOML value is taken as text. Messages
// about them begin with "--set key=value". With `errors`, which must outlive the tables, all but a file that
// cannot be parsed is gathered there.
SettingsTable load_settings(const std::filesystem::path& file, std::span<const std::string> overrides = {},
                            SettingsErrors* errors = nullptr);

// The one of `names` most like `word` (fewest edits), for messages; empty when none is near.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> names);

}  // namespace cupola
