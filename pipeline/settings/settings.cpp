// Strict reading of TOML: toml++ parses, this checks types, ranges and spelling.
// SPDX-License-Identifier: MIT
#include "pipeline/settings/settings.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <system_error>

#include <toml++/toml.h>

#include "pipeline/frame/error.h"
#include "pipeline/settings/settings_errors.h"

namespace cupola {
namespace {

constexpr std::size_t kLongestFile = 16U << 20U;  // bytes

template <class Number>
std::string written(Number value) {
  std::array<char, 40> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 60)) result += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  return result + (text.size() > 60 ? "...\"" : "\"");
}

// What a value is, for "not ...".
std::string described(const toml::node& node) {
  if (const auto* text = node.as_string()) return in_quotes(text->get());
  if (const auto* number = node.as_floating_point()) {
    if (std::isnan(number->get())) return "nan";
    return written(number->get());
  }
  if (const auto* integer = node.as_integer()) return written(integer->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (node.is_array_of_tables()) return "[[tables]]";
  if (node.is_array()) return "a list";
  if (node.is_table()) return "a table";
  return "a date or time";
}

std::string range(std::string_view what, const std::string& least, const std::string& most) {
  return "expected " + std::string(what) + " from " + least + " to " + most;
}

std::string count(std::size_t least, std::size_t most, std::string_view what) {
  return least == most ? written(least) + " " + std::string(what)
                       : written(least) + " to " + written(most) + " " + std::string(what);
}

std::string alternatives(std::span<const std::string_view> names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 == names.size() ? " or " : ", ";
    list += names[i];
  }
  return list;
}

std::string place(const toml::source_region& source, const std::string& otherwise) {
  if (!source.path) return otherwise;
  if (source.path->starts_with("--set ")) return *source.path;
  if (source.begin.line == 0) return *source.path;
  return *source.path + ":" + written(source.begin.line);
}

std::string contents(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": is a folder; expected a TOML file");
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw InputError(file.string() + ": cannot be opened: " + std::generic_category().message(errno));
  }
  std::string text;
  std::array<char, 65536> part{};
  while (stream.read(part.data(), part.size()), stream.gcount() > 0) {
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kLongestFile)
      throw InputError(file.string() + ": expected a TOML file of at most 16 MiB");
  }
  if (stream.bad()) {
    throw InputError(file.string() + ": cannot be read: " + std::generic_category().message(errno));
  }
  return text;
}

// "key = value" as a table, or the value as text where TOML has no such value.
toml::table parse_override(const std::string& line, const std::string& source) {
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos || equals == 0) throw InputError(source + ": expected key=value");
  if (line.find('\n') != std::string::npos) throw InputError(source + ": expected a single line");
  const std::string key = line.substr(0, equals);
  const std::string value = line.substr(equals + 1);
  try {
    return toml::parse(line, source);
  } catch (const toml::parse_error& error) {
    const bool bare =
        !value.empty() && std::string_view("\"'[{").find(value.front()) == std::string_view::npos;
    if (!bare || value.find("'''") != std::string::npos) {
      throw InputError(source + ": " + std::string(error.description()));
    }
  }
  try {
    return toml::parse(key + " = '''" + value + "'''", source);
  } catch (const toml::parse_error& error) {
    throw InputError(source + ": " + std::string(error.description()));
  }
}

void lay_over(toml::table& below, toml::table&& above, const std::string& source);

void lay_over(toml::node& below, toml::table&& above, const std::string& source) {
  if (toml::table* table = below.as_table()) return lay_over(*table, std::move(above), source);
  toml::array& array = *below.as_array();
  for (auto&& [key, node] : above) {
    std::size_t index = 0;
    const std::string_view digits = key.str();
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (error != std::errc() || end != digits.data() + digits.size() || index >= array.size()) {
      throw InputError(source + ": expected a place from 0 to " + written(array.size() - 1) + ", not " +
                       in_quotes(digits));
    }
    if (node.is_table() && array[index].is_table()) {
      lay_over(*array[index].as_table(), std::move(*node.as_table()), source);
    } else {
      std::move(node).visit([&](auto&& value) {
        array.replace(array.cbegin() + static_cast<std::ptrdiff_t>(index),
                      std::forward<decltype(value)>(value));
      });
    }
  }
}

void lay_over(toml::table& below, toml::table&& above, const std::string& source) {
  for (auto&& [key, node] : above) {
    const std::string_view name = key.str();
    toml::node* old = below.get(name);
    if (node.is_table() && !node.as_table()->is_inline() && old != nullptr &&
        (old->is_table() || (old->is_array() && !old->as_array()->empty()))) {
      lay_over(*old, std::move(*node.as_table()), source);
    } else {
      std::move(node).visit(
          [&](auto&& value) { below.insert_or_assign(name, std::forward<decltype(value)>(value)); });
    }
  }
}

}  // namespace

struct SettingsTable::State {
  std::unique_ptr<toml::table> document;  // the outermost table's only
  const toml::table* values = nullptr;    // null when the table is missing
  std::string prefix;                     // "frame." within [frame]
  std::string origin;                     // file:line of the table
  SettingsErrors* errors = nullptr;       // null: the first error is thrown
  SettingsErrors::Place at;               // of the table
  bool silent = false;                    // the table is missing where it must not, or is none
  std::set<std::string, std::less<>> asked;
  std::set<std::string, std::less<>> known;  // asked for, or whether it is there
  // Keys of which something was said, and for those that are not there its number among the errors.
  mutable std::map<std::string, std::optional<std::size_t>, std::less<>> wrong;

  const toml::node* find(std::string_view key) const { return values ? values->get(key) : nullptr; }
  const toml::node* ask(std::string_view key) {
    asked.emplace(key);
    known.emplace(key);
    return find(key);
  }
  std::string where(std::string_view key) const {
    const toml::node* node = find(key);
    return node ? place(node->source(), origin) : origin;
  }
  SettingsErrors::Place place_of(std::string_view key) const {
    const toml::node* node = find(key);
    if (!node || node->source().begin.line == 0) return at;
    const bool own = !node->source().path || !node->source().path->starts_with("--set ");
    return {at.file, own ? node->source().begin.line : std::uint32_t{0}};
  }
  void refuse(std::string_view key, std::string_view message) const {
    std::string name = prefix + std::string(key);
    if (key.empty() && !name.empty()) name.pop_back();
    std::string line = where(key) + ": " + (name.empty() ? "" : name + ": ") + std::string(message);
    if (!errors) throw InputError(line);
    if (silent || wrong.contains(key)) return;
    const std::size_t index = errors->add(place_of(key), std::move(line));
    wrong.emplace(key, find(key) || key.empty() ? std::nullopt : std::optional(index));
  }
  void refuse_value(std::string_view key, const toml::node* node, const std::string& expected) const {
    refuse(key, node ? expected + ", not " + described(*node) : "missing; " + expected);
  }
  // None where it was refused.
  std::vector<const toml::node*> list(std::string_view key, std::size_t least, std::size_t most,
                                      std::string_view what) {
    const toml::node* node = ask(key);
    const toml::array* array = node ? node->as_array() : nullptr;
    if (!array) {
      refuse_value(key, node, "expected a list of " + count(least, most, what));
      return {};
    }
    if (array->size() < least || array->size() > most) {
      refuse(key, "expected a list of " + count(least, most, what) + ", not of " + written(array->size()));
      return {};
    }
    std::vector<const toml::node*> nodes;
    for (const toml::node& element : *array) nodes.push_back(&element);
    return nodes;
  }
  std::unique_ptr<State> within(std::string_view key, const std::string& suffix) const {
    auto state = std::make_unique<State>();
    state->prefix = prefix + std::string(key) + suffix + ".";
    state->errors = errors;
    state->silent = silent;
    return state;
  }
};

SettingsTable::SettingsTable(std::unique_ptr<State> state) : state_(std::move(state)) {}
SettingsTable::SettingsTable(SettingsTable&&) noexcept = default;
SettingsTable& SettingsTable::operator=(SettingsTable&&) noexcept = default;
SettingsTable::~SettingsTable() = default;

bool SettingsTable::has(std::string_view key) const {
  state_->known.emplace(key);
  return state_->find(key) != nullptr;
}

std::vector<std::string> SettingsTable::keys() const {
  std::vector<std::string> names;
  if (state_->values) {
    for (auto&& [key, node] : *state_->values) names.emplace_back(key.str());
  }
  return names;
}

double SettingsTable::number(std::string_view key, double least, double most,
                             std::optional<double> fallback) {
  const toml::node* node = state_->ask(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_number()) {
    const double value = *node->value<double>();
    if (value >= least && value <= most && std::isfinite(value)) return value;
  }
  state_->refuse_value(key, node, range("a number", written(least), written(most)));
  return fallback.value_or(least);
}

std::int64_t SettingsTable::integer(std::string_view key, std::int64_t least, std::int64_t most,
                                    std::optional<std::int64_t> fallback) {
  const toml::node* node = state_->ask(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_integer()) {
    const std::int64_t value = node->as_integer()->get();
    if (value >= least && value <= most) return value;
  }
  state_->refuse_value(key, node, range("a whole number", written(least), written(most)));
  return fallback.value_or(least);
}

bool SettingsTable::flag(std::string_view key, std::optional<bool> fallback) {
  const toml::node* node = state_->ask(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_boolean()) return node->as_boolean()->get();
  state_->refuse_value(key, node, "expected true or false");
  return fallback.value_or(false);
}

std::string SettingsTable::text(std::string_view key, std::optional<std::string> fallback) {
  const toml::node* node = state_->ask(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_string()) return node->as_string()->get();
  state_->refuse_value(key, node, "expected a text in quotes");
  return fallback.value_or("");
}

std::size_t SettingsTable::choice(std::string_view key, std::span<const std::string_view> names,
                                  std::optional<std::size_t> fallback) {
  const toml::node* node = state_->ask(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_string()) {
    const auto found = std::find(names.begin(), names.end(), node->as_string()->get());
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    const std::string_view nearest = nearest_name(node->as_string()->get(), names);
    if (!nearest.empty()) {
      state_->refuse(key, "expected " + alternatives(names) + ", not " + described(*node) +
                              "; did you mean " + std::string(nearest) + "?");
    }
  }
  state_->refuse_value(key, node, "expected " + alternatives(names));
  return fallback.value_or(0);
}

std::vector<double> SettingsTable::numbers(std::string_view key, std::size_t least, std::size_t most) {
  std::vector<double> values;
  for (const toml::node* node : state_->list(key, least, most, "numbers")) {
    const double value = node->is_number() ? *node->value<double>() : std::nan("");
    if (!std::isfinite(value)) {
      state_->refuse(
          key, "expected finite numbers, not " + described(*node) + " at place " + written(values.size()));
      values.clear();
      break;
    }
    values.push_back(value);
  }
  if (values.size() < least) values.resize(least);
  return values;
}

std::vector<std::string> SettingsTable::texts(std::string_view key, std::size_t least, std::size_t most) {
  std::vector<std::string> values;
  for (const toml::node* node : state_->list(key, least, most, "texts")) {
    if (!node->is_string()) {
      state_->refuse(
          key, "expected texts in quotes, not " + described(*node) + " at place " + written(values.size()));
      values.clear();
      break;
    }
    values.push_back(node->as_string()->get());
  }
  if (values.size() < least) values.resize(least);
  return values;
}

SettingsTable SettingsTable::table(std::string_view key) {
  const toml::node* node = state_->ask(key);
  if (node && !node->is_table())
    state_->refuse_value(key, node, "expected the table [" + std::string(key) + "]");
  auto within = state_->within(key, "");
  within->values = node ? node->as_table() : nullptr;
  within->origin = state_->where(key);
  within->at = state_->place_of(key);
  within->silent = state_->silent || state_->wrong.contains(key);
  return SettingsTable(std::move(within));
}

std::vector<SettingsTable> SettingsTable::tables(std::string_view key) {
  std::vector<SettingsTable> result;
  const toml::node* node = state_->ask(key);
  if (!node) return result;
  const toml::array* array = node->as_array();
  if (!array || (!array->empty() && !array->is_array_of_tables())) {
    state_->refuse_value(key, node, "expected tables headed [[" + std::string(key) + "]]");
    return result;
  }
  for (const toml::node& element : *array) {
    auto within = state_->within(key, "." + written(result.size()));
    within->values = element.as_table();
    within->origin = place(element.source(), state_->origin);
    within->at = {state_->at.file, element.source().begin.line};
    result.push_back(SettingsTable(std::move(within)));
  }
  return result;
}

void SettingsTable::may_have(std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) state_->ask(key);
}

void SettingsTable::finish() const {
  if (!state_->values) return;
  std::vector<const toml::key*> strangers;
  for (auto&& [key, node] : *state_->values) {
    if (!state_->asked.contains(key.str())) strangers.push_back(&key);
  }
  std::stable_sort(strangers.begin(), strangers.end(), [](const toml::key* a, const toml::key* b) {
    return a->source().begin.line < b->source().begin.line;
  });
  const std::vector<std::string_view> names(state_->known.begin(), state_->known.end());
  for (const toml::key* key : strangers) {
    if (state_->known.contains(key->str())) {
      state_->refuse(key->str(), "has no meaning here");
      continue;
    }
    const std::string_view nearest = nearest_name(key->str(), names);
    state_->refuse(key->str(), names.empty()     ? "unknown key"
                               : nearest.empty() ? "unknown key; known are " + alternatives(names)
                                                 : "unknown key; did you mean " + std::string(nearest) + "?");
    const auto missed = state_->wrong.find(nearest);
    if (missed != state_->wrong.end() && missed->second) state_->errors->withdraw(*missed->second);
  }
}

void SettingsTable::refuse(std::string_view key, std::string_view message) const {
  state_->refuse(key, message);
}

bool SettingsTable::refused(std::string_view key) const {
  return key.empty() ? !state_->wrong.empty() : state_->wrong.contains(key);
}

void SettingsTable::attempt(std::string_view key, const std::function<void()>& read) const {
  try {
    read();
  } catch (const InputError& error) {
    if (!state_->errors) throw;
    if (state_->silent || !state_->wrong.emplace(key, std::nullopt).second) return;
    state_->errors->add(state_->place_of(key), error.what());
  }
}

SettingsErrors* SettingsTable::errors() const {
  return state_->errors;
}

SettingsTable load_settings(const std::filesystem::path& file, std::span<const std::string> overrides,
                            SettingsErrors* errors) {
  auto state = std::make_unique<SettingsTable::State>();
  state->errors = errors;
  if (errors) state->at = {errors->begin_file(file.string()), 0};
  try {
    state->document = std::make_unique<toml::table>(toml::parse(contents(file), file.string()));
  } catch (const toml::parse_error& error) {
    throw InputError(place(error.source(), file.string()) + ": " + std::string(error.description()));
  }
  for (const std::string& line : overrides) {
    const std::string source = "--set " + line;
    try {
      lay_over(*state->document, parse_override(line, source), source);
    } catch (const InputError& error) {
      if (!errors) throw;
      errors->add(state->at, error.what());
    }
  }
  state->values = state->document.get();
  state->origin = file.string();
  return SettingsTable(std::move(state));
}

}  // namespace cupola
