// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::command {

/// A text whose numbers are left out, so that reports of the same thing are equal: "gps: # measurements in a row
/// rejected". A digit within a word ("gps2") is part of the word.
inline std::string without_numbers(std::string_view text) {
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const bool is_number = is_digit(text[i]) && (i == 0 || !is_word(text[i - 1]));
    if (!is_number) {
      out += text[i++];
      continue;
    }
    if (!out.empty() && out.back() == '-') out.pop_back();
    out += '#';
    while (i < text.size() &&
           (is_digit(text[i]) || text[i] == 'e' ||
            ((text[i] == '.' || text[i] == '-' || text[i] == '+') && i + 1 < text.size() && is_digit(text[i + 1])))) {
      ++i;
    }
  }
  return out;
}

/// Events that report the same thing, with other numbers.
struct FoldedEvents {
  Event first;
  Event last;
  std::uint64_t count = 1;

  /// One line, or two if there were several: the first one, then how many, and the last one.
  std::vector<std::string> lines() const {
    std::vector<std::string> out{fmt::format("at {} s: {}", format_time(first.stamp, 3), first.text)};
    if (count > 1) {
      out.push_back(fmt::format("  {} times until {} s{}", count, format_time(last.stamp, 3),
                                last.text == first.text ? "" : "; the last: " + last.text));
    }
    return out;
  }
};

/// Folds events, in the order of the first of each kind.
inline std::vector<FoldedEvents> fold(std::span<const Event> events) {
  std::vector<FoldedEvents> out;
  std::map<std::string, std::size_t> place;
  for (const Event& event : events) {
    const auto [found, is_new] = place.try_emplace(without_numbers(event.text), out.size());
    if (is_new) {
      out.push_back({event, event, 1});
    } else {
      out[found->second].last = event;
      ++out[found->second].count;
    }
  }
  return out;
}

/// Counts the events of a run that goes on, so that not each of many equal ones is printed.
class RepeatedEvents {
 public:
  /// True if there was one of its kind, so that it was printed.
  bool has_shown(const Event& event) const { return counts_.contains(without_numbers(event.text)); }
  /// True for the first three of a kind, then for the tenth, the hundredth and so on. `count`: how many there were.
  bool shows(const Event& event, std::uint64_t& count) {
    // A run of months has more kinds than one wants to keep.
    if (counts_.size() >= kMostKinds) counts_.clear();
    count = ++counts_[without_numbers(event.text)];
    if (count <= kShown) return true;
    std::uint64_t power = 10;
    while (power < count) power *= 10;
    return power == count;
  }

 private:
  static constexpr std::size_t kMostKinds = 2000;
  static constexpr std::uint64_t kShown = 3;
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace waymark::command
