// Patterns of numbered files.
// SPDX-License-Identifier: MIT
#include "pipeline/source/numbered_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, char>, 6> kLetters = {
    {{"front", 'f'}, {"left", 'l'}, {"right", 'r'}, {"top", 't'}, {"bottom", 'd'}, {"back", 'b'}}};

char letter_of(std::string_view view) {
  for (const auto& [name, letter] : kLetters) {
    if (name == view) return letter;
  }
  return '\0';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool parse_number(std::string_view digits, std::int64_t& number) {
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && end == digits.data() + digits.size();
}

// A pattern cut at its number.
struct Cut {
  std::string_view before;
  std::string_view after;
  int digits = 1;  // at least
};

Cut cut_pattern(std::string_view pattern) {
  const auto refuse = [&] {
    throw InputError(fmt::format("{}: expected one number such as %06d in the file's name", pattern));
  };
  const std::size_t at = pattern.find('%');
  if (at == std::string_view::npos) refuse();
  Cut cut{pattern.substr(0, at), pattern.substr(at + 1), 1};
  std::size_t width = 0;
  while (width < cut.after.size() && is_digit(cut.after[width])) ++width;
  if (width > 0) {
    std::int64_t digits = 0;
    if (cut.after[0] != '0' || !parse_number(cut.after.substr(0, width), digits) || digits > 18) refuse();
    cut.digits = std::max(1, static_cast<int>(digits));
  }
  if (width >= cut.after.size() || cut.after[width] != 'd') refuse();
  cut.after.remove_prefix(width + 1);
  if (cut.after.find_first_of("%/") != std::string_view::npos) refuse();
  return cut;
}

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
}

// The numbers of the files that a view's pattern matches.
std::set<std::int64_t> numbers_there(const std::string& pattern) {
  const Cut cut = cut_pattern(pattern);
  const fs::path folder = fs::path(pattern).parent_path();
  const std::string before = fs::path(cut.before).filename().string();
  std::set<std::int64_t> numbers;
  std::error_code error;
  fs::directory_iterator entries(folder.empty() ? fs::path(".") : folder, error);
  if (error) throw InputError(fmt::format("{}: {}; expected a folder", folder.string(), error.message()));
  for (const fs::directory_entry& entry : entries) {
    const std::string name = entry.path().filename().string();
    if (name.size() <= before.size() + cut.after.size() || !name.starts_with(before) ||
        !name.ends_with(cut.after))
      continue;
    const std::string digits = name.substr(before.size(), name.size() - before.size() - cut.after.size());
    std::int64_t number = 0;
    if (!std::ranges::all_of(digits, is_digit) || !parse_number(digits, number)) continue;
    if (fmt::format("{:0{}}", number, cut.digits) == digits) numbers.insert(number);
  }
  return numbers;
}

bool is_picture_name(std::string_view ending) {
  std::string lower(ending);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower == ".png" || lower == ".jpg" || lower == ".jpeg" || lower == ".tif" || lower == ".tiff" ||
         lower == ".exr";
}

// The patterns, numbers cut to %0Nd, of the pictures in a folder.
std::set<std::string> patterns_in(const fs::path& folder) {
  std::map<std::pair<std::string, std::string>, std::size_t> fewest;  // digits, for what is before and after
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string stem = entry.path().stem().string();
    const std::string ending = entry.path().extension().string();
    const std::size_t before = stem.find_last_not_of("0123456789") + 1;  // 0 when all are digits
    const std::size_t digits = stem.size() - before;
    if (digits == 0 || digits > 18 || !is_picture_name(ending) || stem.find('%') != std::string::npos)
      continue;
    const auto [place, is_new] = fewest.try_emplace({stem.substr(0, before), ending}, digits);
    if (!is_new) place->second = std::min(place->second, digits);
  }
  std::set<std::string> patterns;
  for (const auto& [around, digits] : fewest) {
    patterns.insert(around.first + (digits == 1 ? "%d" : fmt::format("%0{}d", digits)) + around.second);
  }
  return patterns;
}

// `name` with each word `word` in it, one at a time, replaced by `by`; a word ends where letters end.
std::vector<std::string> with_word_replaced(const std::string& name, std::string_view word,
                                            std::string_view by) {
  std::vector<std::string> results;
  for (std::size_t at = 0; (at = name.find(word, at)) != std::string::npos; ++at) {
    const std::size_t end = at + word.size();
    if (at > 0 && (is_letter(name[at - 1]) || name[at - 1] == '%' || is_digit(name[at - 1]))) continue;
    if (end < name.size() && is_letter(name[end])) continue;
    if (name.find('.', end) == std::string::npos) continue;  // not the ending
    results.push_back(std::string(name).replace(at, word.size(), by));
  }
  return results;
}

bool holds_all(const std::string& pattern, std::span<const std::string> views) {
  return std::ranges::all_of(views, [&](const std::string& view) {
    if (pattern.find("{letter}") != std::string::npos && letter_of(view) == '\0') return false;
    const std::string of_view = pattern_of_view(pattern, view);
    std::error_code error;
    const fs::path folder = fs::path(of_view).parent_path();
    return fs::is_directory(folder, error) && !numbers_there(of_view).empty();
  });
}

// "4, 7 to 9", what `range` has and `numbers` has not; the first few gaps.
std::string gaps(const std::set<std::int64_t>& numbers, NumberRange range) {
  constexpr int kMost = 8;
  std::string text;
  int count = 0;
  const auto gap = [&](std::int64_t first, std::int64_t last) {
    if (first > last || ++count > kMost) return;
    text += (text.empty() ? "" : ", ") +
            (first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last));
  };
  std::int64_t next = range.first;
  for (auto at = numbers.lower_bound(range.first); at != numbers.end() && *at <= range.last; ++at) {
    gap(next, *at - 1);
    next = *at + 1;
  }
  gap(next, range.last);
  return count > kMost ? fmt::format("{} and {} more gaps", text, count - kMost) : text;
}

}  // namespace

bool has_view(std::string_view pattern) {
  for (const std::string_view mark : {"{view}", "{letter}", "%c"}) {
    if (pattern.find(mark) != std::string_view::npos) return true;
  }
  return false;
}

std::string pattern_of_view(std::string_view pattern, std::string_view view) {
  std::string result(pattern);
  replace_all(result, "%c", "{letter}");
  if (result.find("{letter}") != std::string::npos) {
    const char letter = letter_of(view);
    if (letter == '\0') {
      throw InputError(
          fmt::format("{}: view {} has no letter; expected front, left, right, top, bottom or back, or "
                      "a pattern with {{view}}",
                      pattern, view));
    }
    replace_all(result, "{letter}", std::string(1, letter));
  }
  replace_all(result, "{view}", view);
  return result;
}

std::string numbered_file(std::string_view pattern, std::int64_t number) {
  const Cut cut = cut_pattern(pattern);
  return fmt::format("{}{:0{}}{}", cut.before, number, cut.digits, cut.after);
}

NumberRange find_numbers(std::span<const std::string> patterns, std::optional<std::int64_t> in,
                         std::optional<std::int64_t> out) {
  std::vector<std::set<std::int64_t>> numbers;
  std::set<std::int64_t> all;
  for (const std::string& pattern : patterns) {
    numbers.push_back(numbers_there(pattern));
    if (numbers.back().empty()) {
      throw InputError(fmt::format("{}: no such files; expected for instance {}", pattern,
                                   numbered_file(pattern, in.value_or(1))));
    }
    all.insert(numbers.back().begin(), numbers.back().end());
  }
  const NumberRange range{in.value_or(*all.begin()), out.value_or(*all.rbegin())};
  if (range.first > range.last) {
    throw InputError(fmt::format("{}: in is {} and out is {}; expected in to be at most out",
                                 patterns.front(), range.first, range.last));
  }
  for (std::int64_t number = range.first; number <= range.last; ++number) {  // ends at the first gap
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      if (numbers[i].contains(number)) continue;
      std::string all_gaps;
      for (std::size_t j = 0; j < patterns.size(); ++j) {
        const std::string of_pattern = gaps(numbers[j], range);
        if (!of_pattern.empty()) all_gaps += fmt::format("; {} lacks {}", patterns[j], of_pattern);
      }
      throw InputError(
          fmt::format("{}: missing; expected all files from number {} to {} ({}); in and out choose a part{}",
                      numbered_file(patterns[i], number), range.first, range.last,
                      in && out ? "in to out" : "what the folder holds", all_gaps));
    }
  }
  return range;
}

std::string find_pattern(const fs::path& folder, std::span<const std::string> views) {
  if (views.empty()) throw InputError("expected at least one view");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(fmt::format("{}: expected a folder of numbered pictures", folder.string()));
  }
  const std::string& view = views.front();
  const char letter = letter_of(view);
  std::set<std::string> candidates;
  const auto add = [&](const std::string& name, std::string_view word, const std::string& mark) {
    for (const std::string& candidate : with_word_replaced(name, word, mark))
      candidates.insert((folder / candidate).string());
  };
  for (const std::string& name : patterns_in(folder)) {
    add(name, view, "{view}");
    if (letter != '\0') add(name, std::string_view(&letter, 1), "{letter}");
  }
  for (const auto& [word, mark] :
       {std::pair(view, std::string("{view}")),
        std::pair(std::string(letter == '\0' ? 0 : 1, letter), std::string("{letter}"))}) {
    if (word.empty() || !fs::is_directory(folder / word, error)) continue;
    for (const std::string& name : patterns_in(folder / word)) {
      candidates.insert((folder / mark / name).string());
      for (const std::string& both : with_word_replaced(name, word, mark))  // front/name_front_0001.png
        candidates.insert((folder / mark / both).string());
    }
  }
  std::vector<std::string> found;
  for (const std::string& candidate : candidates) {
    if (holds_all(candidate, views)) found.push_back(candidate);
  }
  if (found.empty()) {
    throw InputError(
        fmt::format("{}: no numbered pictures of {}; expected for instance {}/000001.png, "
                    "name_{}_000001.png or frame_{}_0001.png",
                    folder.string(), fmt::join(views, ", "), view, view, letter == '\0' ? 'f' : letter));
  }
  if (found.size() > 1) {
    throw InputError(fmt::format("{}: holds several sequences: {}; expected one of them as the pattern",
                                 folder.string(), fmt::join(found, " and ")));
  }
  return found.front();
}

}  // namespace cupola
