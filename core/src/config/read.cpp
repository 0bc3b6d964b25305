// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/node.hpp"
#include "config/scalar.hpp"

namespace waymark {
namespace {

using Asked = Config::Asked;
using Key = Config::Key;
using Kind = Config::Node::Kind;
using Node = Config::Node;
using Type = Asked::Type;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What numbers may be.
struct Range {
  double low = -kInfinity;
  double high = kInfinity;
  bool excludes_low = false;
};
constexpr Range kPositive{0.0, kInfinity, true};
constexpr Range kNonNegative{0.0, kInfinity, false};

/// The child that the user gave; a filled-in one does not count.
Node* given(const Node& node, std::string_view key) {
  Node* child = node.find(key);
  return child != nullptr && !child->is_default ? child : nullptr;
}

Asked& note(Node& node, const Key& key, Type type) {
  Asked& asked = node.note_asked(key);
  asked.type = type;
  return asked;
}

Asked& note_range(Node& node, const Key& key, Type type, const Range& range) {
  Asked& asked = note(node, key, type);
  asked.low = range.low;
  asked.high = range.high;
  asked.excludes_low = range.excludes_low;
  return asked;
}

void note_words(Node& node, const Key& key, std::initializer_list<std::string_view> words) {
  note(node, key, Type::choice).words.assign(words.begin(), words.end());
}

/// The value under a key, which then counts as read.
Node* find(Node& node, const Key& key) {
  Node* child = given(node, key.name);
  if (child != nullptr) child->was_read = true;
  return child;
}

Node& need(Node& node, const Key& key) {
  node.note_asked(key).is_required = true;
  if (Node* child = find(node, key); child != nullptr) return *child;
  std::vector<std::string> unread;
  for (const auto& child : node.children) {
    // One that was asked for is spelt as it should be.
    const bool is_valid = std::ranges::any_of(node.asked, [&](const Asked& asked) { return asked.path == child->key; });
    if (!child->was_read && !child->is_default && !is_valid) unread.push_back(child->key);
  }
  const std::string near = config::nearest_key(key.name, unread);
  config::fail_at(
      node, fmt::format("{} is missing{}", key.name,
                        near.empty() ? "" : fmt::format("; \"{}\" is given: did you mean \"{}\"?", near, key.name)));
}

std::unique_ptr<Node> filled_in(Kind kind, std::string text = {}) {
  auto node = std::make_unique<Node>();
  node->kind = kind;
  node->text = std::move(text);
  node->is_default = true;
  return node;
}

/// Fills in the value of a fallback.
Node& fill_in(Node& node, const Key& key, std::unique_ptr<Node> value) {
  value->key = key.name;
  value->origin = node.origin;
  std::erase_if(node.children, [&key](const auto& child) { return child->is_default && child->key == key.name; });
  return node.add(std::move(value));
}

void fill_in_scalar(Node& node, const Key& key, std::string text, Kind kind = Kind::scalar) {
  Asked& asked = node.note_asked(key);
  if (!asked.fallback) asked.fallback = text;
  fill_in(node, key, filled_in(kind, std::move(text)));
}

void fill_in_number(Node& node, const Key& key, double value) {
  // YAML could not give an infinite default back: it is shown, but not as a value.
  fill_in_scalar(node, key, config::shortest(value), std::isfinite(value) ? Kind::scalar : Kind::null);
}

void fill_in_list(Node& node, const Key& key, const std::vector<std::string>& values) {
  Asked& asked = node.note_asked(key);
  if (!asked.fallback) asked.fallback = fmt::format("[{}]", fmt::join(values, ", "));
  Node& list = fill_in(node, key, filled_in(Kind::list));
  for (const std::string& value : values) list.add(filled_in(Kind::scalar, value));
}

double to_number_in(Node& node, const Range& range) {
  const double value = config::to_number(node);
  const bool fits = (range.excludes_low ? value > range.low : value >= range.low) && value <= range.high;
  if (fits) return value;
  const std::string expected = std::isfinite(range.high) ? fmt::format("must lie in [{}, {}]", range.low, range.high)
                                                         : fmt::format("must be {} 0", range.excludes_low ? ">" : ">=");
  config::fail_at(node, fmt::format("{} {}", config::shortest(value), expected));
}

double read_number(Node& node, const Key& key, const Range& range) {
  note_range(node, key, Type::number, range);
  return to_number_in(need(node, key), range);
}
double read_number(Node& node, const Key& key, const Range& range, double fallback) {
  note_range(node, key, Type::number, range);
  if (Node* value = find(node, key); value != nullptr) return to_number_in(*value, range);
  fill_in_number(node, key, fallback);
  return fallback;
}

std::string to_choice(const Node& node, const Key& key, std::initializer_list<std::string_view> words) {
  std::string word = config::to_text(node);
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  if (words.size() == 1 && !key.meaning.empty()) {
    // The one word stands for a value of another kind, such as a list; only the meaning names that.
    std::string meaning(key.meaning);
    std::erase(meaning, '`');
    config::fail_at(node,
                    fmt::format("\"{}\" is not {}, nor what else is expected: {}", word, *words.begin(), meaning));
  }
  config::fail_at(node, fmt::format("\"{}\" is not one of: {}", word, fmt::join(words, ", ")));
}

std::vector<double> to_numbers(Node& node, int count) {
  const std::string expected = count < 0 ? "a list of numbers" : fmt::format("a list of {} numbers", count);
  if (node.kind != Kind::list) config::fail_at(node, fmt::format("{} is not {}", node.description(), expected));
  if (count >= 0 && node.children.size() != static_cast<std::size_t>(count)) {
    config::fail_at(node, fmt::format("has {} elements; {} is expected", node.children.size(), expected));
  }
  std::vector<double> values;
  for (const auto& child : node.children) values.push_back(config::to_number(*child));
  return values;
}

std::vector<std::string> to_texts(const Node& node) {
  if (node.kind != Kind::list) return {config::to_text(node)};
  std::vector<std::string> values;
  for (const auto& child : node.children) values.push_back(config::to_text(*child));
  return values;
}

/// A key without a value is an empty mapping or list.
void require_kind(Node& node, Kind kind, const char* expected) {
  if (node.kind == Kind::null) node.kind = kind;
  if (node.kind != kind) config::fail_at(node, fmt::format("{} is not {}", node.description(), expected));
}

}  // namespace

double Config::number(const Key& key) const { return read_number(*node_, key, {}); }
double Config::number(const Key& key, double fallback) const { return read_number(*node_, key, {}, fallback); }
double Config::positive(const Key& key) const { return read_number(*node_, key, kPositive); }
double Config::positive(const Key& key, double fallback) const { return read_number(*node_, key, kPositive, fallback); }
double Config::non_negative(const Key& key) const { return read_number(*node_, key, kNonNegative); }
double Config::non_negative(const Key& key, double fallback) const {
  return read_number(*node_, key, kNonNegative, fallback);
}
double Config::number_in(const Key& key, double low, double high) const {
  return read_number(*node_, key, {low, high});
}
double Config::number_in(const Key& key, double low, double high, double fallback) const {
  return read_number(*node_, key, {low, high}, fallback);
}

std::int64_t Config::integer(const Key& key) const {
  note(*node_, key, Type::integer);
  return config::to_integer(need(*node_, key));
}
std::int64_t Config::integer(const Key& key, std::int64_t fallback) const {
  constexpr auto kLowest = std::numeric_limits<std::int64_t>::min();
  constexpr auto kHighest = std::numeric_limits<std::int64_t>::max();
  return integer_in(key, kLowest, kHighest, fallback);
}
std::int64_t Config::integer_in(const Key& key, std::int64_t low, std::int64_t high, std::int64_t fallback) const {
  using Limits = std::numeric_limits<std::int64_t>;
  note_range(*node_, key, Type::integer,
             {low == Limits::min() ? -kInfinity : static_cast<double>(low),
              high == Limits::max() ? kInfinity : static_cast<double>(high)});
  Node* node = find(*node_, key);
  if (node == nullptr) {
    fill_in_scalar(*node_, key, std::to_string(fallback));
    return fallback;
  }
  const std::int64_t value = config::to_integer(*node);
  if (value >= low && value <= high) return value;
  config::fail_at(*node, high != Limits::max() ? fmt::format("{} must lie in [{}, {}]", value, low, high)
                                               : fmt::format("{} must be >= {}", value, low));
}

bool Config::boolean(const Key& key) const {
  note(*node_, key, Type::boolean);
  return config::to_boolean(need(*node_, key));
}
bool Config::boolean(const Key& key, bool fallback) const {
  note(*node_, key, Type::boolean);
  if (Node* node = find(*node_, key); node != nullptr) return config::to_boolean(*node);
  fill_in_scalar(*node_, key, fallback ? "true" : "false");
  return fallback;
}

std::string Config::text(const Key& key) const {
  note(*node_, key, Type::text);
  return config::to_text(need(*node_, key));
}
std::string Config::text(const Key& key, std::string_view fallback) const {
  note(*node_, key, Type::text);
  if (const Node* node = find(*node_, key); node != nullptr) return config::to_text(*node);
  fill_in_scalar(*node_, key, std::string(fallback));
  return std::string(fallback);
}

std::string Config::choice(const Key& key, std::initializer_list<std::string_view> words) const {
  note_words(*node_, key, words);
  return to_choice(need(*node_, key), key, words);
}
std::string Config::choice(const Key& key, std::initializer_list<std::string_view> words,
                           std::string_view fallback) const {
  note_words(*node_, key, words);
  if (const Node* node = find(*node_, key); node != nullptr) return to_choice(*node, key, words);
  fill_in_scalar(*node_, key, std::string(fallback));
  return std::string(fallback);
}

std::vector<double> Config::numbers(const Key& key, int count) const {
  note(*node_, key, Type::numbers).count = count;
  return to_numbers(need(*node_, key), count);
}
std::vector<double> Config::numbers(const Key& key, int count, const std::vector<double>& fallback) const {
  note(*node_, key, Type::numbers).count = count;
  if (Node* node = find(*node_, key); node != nullptr) return to_numbers(*node, count);
  std::vector<std::string> values;
  values.reserve(fallback.size());
  for (const double value : fallback) values.push_back(config::shortest(value));
  fill_in_list(*node_, key, values);
  return fallback;
}

std::vector<std::string> Config::texts(const Key& key) const {
  note(*node_, key, Type::texts);
  return to_texts(need(*node_, key));
}
std::vector<std::string> Config::texts(const Key& key, const std::vector<std::string>& fallback) const {
  note(*node_, key, Type::texts);
  if (const Node* node = find(*node_, key); node != nullptr) return to_texts(*node);
  fill_in_list(*node_, key, fallback);
  return fallback;
}

bool Config::has(const Key& key) const {
  node_->note_asked(key);
  return given(*node_, key.name) != nullptr;
}

Config Config::child(const Key& key) const {
  note(*node_, key, Type::mapping);
  Node& node = need(*node_, key);
  require_kind(node, Kind::mapping, "a mapping");
  return {root_, &node};
}

Config Config::child_or_empty(const Key& key) const {
  note(*node_, key, Type::mapping);
  if (Node* node = find(*node_, key); node != nullptr) {
    require_kind(*node, Kind::mapping, "a mapping");
    return {root_, node};
  }
  Node* known = node_->find(key.name);
  if (known == nullptr || known->kind != Kind::mapping) known = &fill_in(*node_, key, filled_in(Kind::mapping));
  return {root_, known};
}

std::vector<Config> Config::items(const Key& key) const {
  note(*node_, key, Type::items);
  Node& node = need(*node_, key);
  require_kind(node, Kind::list, "a list");
  std::vector<Config> elements;
  for (const auto& child : node.children) {
    require_kind(*child, Kind::mapping, "a mapping");
    child->was_read = true;
    elements.push_back(Config(root_, child.get()));
  }
  return elements;
}

std::vector<Config> Config::items_or_empty(const Key& key) const {
  note(*node_, key, Type::items);
  if (given(*node_, key.name) != nullptr) return items(key);
  fill_in(*node_, key, filled_in(Kind::list));
  return {};
}

std::vector<std::string> Config::keys() const {
  std::vector<std::string> keys;
  for (const auto& child : node_->children) {
    if (!child->is_default) keys.push_back(child->key);
  }
  return keys;
}

bool Config::is_mapping(const Key& key) const {
  const Node* node = given(*node_, key.name);
  return node != nullptr && node->kind == Kind::mapping;
}

bool Config::is_word(const Key& key, std::string_view word) const {
  const Node* node = given(*node_, key.name);
  return node != nullptr && node->kind == Kind::scalar && node->text == word;
}

void Config::replace(const Key& key, std::string_view value) const {
  Node& node = need(*node_, key);
  node.assign(*config::parse_yaml(std::string(value), node.origin, false));
}

bool Config::is_list(const Key& key) const {
  const Node* node = given(*node_, key.name);
  return node != nullptr && node->kind == Kind::list;
}

}  // namespace waymark
