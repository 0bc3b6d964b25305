// SPDX-License-Identifier: Apache-2.0
#include "config/scalar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace waymark::config {
namespace {

// Variances are squares, and filters multiply these.
constexpr double kLargest = 1e50;
constexpr double kLeast = 1e-50;
constexpr double kLargestExactInteger = 9007199254740992.0;  // 2^53

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return text;
}

/// from_chars accepts no leading plus.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

bool is_not_finite(const std::string& text) {
  std::string word = lower(text);
  if (!word.empty() && (word[0] == '+' || word[0] == '-')) word.erase(0, 1);
  if (!word.empty() && word[0] == '.') word.erase(0, 1);
  return word == "inf" || word == "infinity" || word == "nan";
}

std::optional<bool> boolean_of(const std::string& text) {
  const std::string word = lower(text);
  if (word == "true" || word == "yes" || word == "on") return true;
  if (word == "false" || word == "no" || word == "off") return false;
  return std::nullopt;
}

void require_scalar(const Node& node, const char* expected) {
  if (node.kind == Node::Kind::null) fail_at(node, fmt::format("has no value; {} is expected", expected));
  if (node.kind != Node::Kind::scalar) fail_at(node, fmt::format("{} is not {}", node.description(), expected));
}

/// Parses the whole text or throws.
template <class T>
T parse(const Node& node, const char* expected) {
  const std::string_view text = without_plus(node.text);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
    fail_at(node, fmt::format("\"{}\" is not {}", node.text, expected));
  }
  if (error != std::errc{}) fail_at(node, fmt::format("{} is too large or too small for {}", node.text, expected));
  if (node.quoted) fail_at(node, fmt::format("\"{}\" is text, write it without quotes", node.text));
  return value;
}

}  // namespace

double to_number(Node& node) {
  require_scalar(node, "a number");
  if (is_not_finite(node.text)) fail_at(node, fmt::format("{} must be finite", node.text));
  const auto value = parse<double>(node, "a number");
  const double size = std::abs(value);
  if (size > kLargest || (size < kLeast && size > 0.0))
    fail_at(node,
            fmt::format("{} is too large or too small to compute with; 0 or 1e-50 to 1e50 is expected", node.text));
  node.shown = shortest(value);
  return value;
}

std::int64_t to_integer(Node& node) {
  require_scalar(node, "a whole number");
  const bool digits_only = node.text.find_first_not_of("+-0123456789") == std::string::npos;
  if (digits_only) {
    const auto value = parse<std::int64_t>(node, "a whole number");
    node.shown = std::to_string(value);
    return value;
  }
  if (is_not_finite(node.text)) fail_at(node, fmt::format("{} must be finite", node.text));
  const auto value = parse<double>(node, "a whole number");
  if (value != std::floor(value)) fail_at(node, fmt::format("{} is not a whole number", node.text));
  if (std::abs(value) > kLargestExactInteger)
    fail_at(node, fmt::format("{} is too large; write all its digits", node.text));
  node.shown = std::to_string(static_cast<std::int64_t>(value));
  return static_cast<std::int64_t>(value);
}

bool to_boolean(Node& node) {
  require_scalar(node, "true or false");
  const std::optional<bool> value = boolean_of(node.text);
  if (!value) fail_at(node, fmt::format("{} is not true or false", node.description()));
  if (node.quoted) fail_at(node, fmt::format("\"{}\" is text, write it without quotes", node.text));
  node.shown = *value ? "true" : "false";
  return *value;
}

std::string to_text(const Node& node) {
  require_scalar(node, "a text");
  return node.text;
}

}  // namespace waymark::config
