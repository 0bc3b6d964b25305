// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/node.hpp"
#include "config/scalar.hpp"

namespace waymark {
namespace {

using Node = Config::Node;
using Kind = Node::Kind;

void note_asked(Node& node, std::string_view key) {
  if (std::find(node.asked.begin(), node.asked.end(), key) == node.asked.end()) node.asked.emplace_back(key);
}

/// The child that the user gave; a filled-in one does not count.
Node* given(const Node& node, std::string_view key) {
  Node* child = node.find(key);
  return child != nullptr && !child->is_default ? child : nullptr;
}

/// Asks for a key and marks it as read.
Node* ask(Node& node, std::string_view key) {
  note_asked(node, key);
  Node* child = given(node, key);
  if (child != nullptr) child->was_read = true;
  return child;
}

Node& need(Node& node, std::string_view key) {
  if (Node* child = ask(node, key); child != nullptr) return *child;
  std::vector<std::string> unread;
  for (const auto& child : node.children) {
    if (!child->was_read && !child->is_default) unread.push_back(child->key);
  }
  const std::string near = config::nearest_key(key, unread);
  config::fail_at(node,
                  fmt::format("{} is missing{}", key, near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

std::unique_ptr<Node> filled_in(Kind kind, std::string text = {}) {
  auto node = std::make_unique<Node>();
  node->kind = kind;
  node->text = std::move(text);
  node->is_default = true;
  return node;
}

/// Notes the value that a fallback filled in.
Node& note_default(Node& node, std::string_view key, std::unique_ptr<Node> value) {
  value->key = key;
  value->origin = node.origin;
  std::erase_if(node.children, [key](const auto& child) { return child->is_default && child->key == key; });
  return node.add(std::move(value));
}

void note_number(Node& node, std::string_view key, double value) {
  // YAML could not give an infinite default back: it is shown, but not as a value.
  note_default(node, key, filled_in(std::isfinite(value) ? Kind::scalar : Kind::null, config::shortest(value)));
}

double checked(const Node& node, double value, bool fits, std::string_view expectation) {
  if (!fits) config::fail_at(node, fmt::format("{} {}", config::shortest(value), expectation));
  return value;
}

double as_positive(Node& node) {
  const double value = config::to_number(node);
  return checked(node, value, value > 0.0, "must be > 0");
}

double as_non_negative(Node& node) {
  const double value = config::to_number(node);
  return checked(node, value, value >= 0.0, "must be >= 0");
}

double as_number_in(Node& node, double low, double high) {
  const double value = config::to_number(node);
  return checked(node, value, low <= value && value <= high, fmt::format("must lie in [{}, {}]", low, high));
}

std::string as_choice(const Node& node, std::initializer_list<std::string_view> words) {
  std::string word = config::to_text(node);
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  config::fail_at(node, fmt::format("\"{}\" is not one of: {}", word, fmt::join(words, ", ")));
}

std::vector<double> as_numbers(Node& node, int count) {
  const std::string expected = count < 0 ? "a list of numbers" : fmt::format("a list of {} numbers", count);
  if (node.kind != Kind::list) config::fail_at(node, fmt::format("{} is not {}", node.description(), expected));
  if (count >= 0 && node.children.size() != static_cast<std::size_t>(count)) {
    config::fail_at(node, fmt::format("has {} elements; {} is expected", node.children.size(), expected));
  }
  std::vector<double> values;
  for (const auto& child : node.children) values.push_back(config::to_number(*child));
  return values;
}

std::vector<std::string> as_texts(const Node& node) {
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

const Config::Node& Config::read(std::string_view key) const { return need(*node_, key); }
const Config::Node* Config::read_if(std::string_view key) const { return ask(*node_, key); }

double Config::number(std::string_view key) const { return config::to_number(need(*node_, key)); }
double Config::number(std::string_view key, double fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return config::to_number(*node);
  note_number(*node_, key, fallback);
  return fallback;
}

double Config::positive(std::string_view key) const { return as_positive(need(*node_, key)); }
double Config::positive(std::string_view key, double fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return as_positive(*node);
  note_number(*node_, key, fallback);
  return fallback;
}

double Config::non_negative(std::string_view key) const { return as_non_negative(need(*node_, key)); }
double Config::non_negative(std::string_view key, double fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return as_non_negative(*node);
  note_number(*node_, key, fallback);
  return fallback;
}

double Config::number_in(std::string_view key, double low, double high) const {
  return as_number_in(need(*node_, key), low, high);
}
double Config::number_in(std::string_view key, double low, double high, double fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return as_number_in(*node, low, high);
  note_number(*node_, key, fallback);
  return fallback;
}

std::int64_t Config::integer(std::string_view key) const { return config::to_integer(need(*node_, key)); }
std::int64_t Config::integer(std::string_view key, std::int64_t fallback) const {
  constexpr auto kLowest = std::numeric_limits<std::int64_t>::min();
  constexpr auto kHighest = std::numeric_limits<std::int64_t>::max();
  return integer_in(key, kLowest, kHighest, fallback);
}
std::int64_t Config::integer_in(std::string_view key, std::int64_t low, std::int64_t high,
                                std::int64_t fallback) const {
  Node* node = ask(*node_, key);
  if (node == nullptr) {
    note_default(*node_, key, filled_in(Kind::scalar, std::to_string(fallback)));
    return fallback;
  }
  const std::int64_t value = config::to_integer(*node);
  if (value >= low && value <= high) return value;
  const bool bounded = high != std::numeric_limits<std::int64_t>::max();
  config::fail_at(*node, bounded ? fmt::format("{} must lie in [{}, {}]", value, low, high)
                                 : fmt::format("{} must be >= {}", value, low));
}

bool Config::boolean(std::string_view key) const { return config::to_boolean(need(*node_, key)); }
bool Config::boolean(std::string_view key, bool fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return config::to_boolean(*node);
  note_default(*node_, key, filled_in(Kind::scalar, fallback ? "true" : "false"));
  return fallback;
}

std::string Config::text(std::string_view key) const { return config::to_text(need(*node_, key)); }
std::string Config::text(std::string_view key, std::string_view fallback) const {
  if (const Node* node = ask(*node_, key); node != nullptr) return config::to_text(*node);
  note_default(*node_, key, filled_in(Kind::scalar, std::string(fallback)));
  return std::string(fallback);
}

std::string Config::choice(std::string_view key, std::initializer_list<std::string_view> words) const {
  return as_choice(need(*node_, key), words);
}
std::string Config::choice(std::string_view key, std::initializer_list<std::string_view> words,
                           std::string_view fallback) const {
  if (const Node* node = ask(*node_, key); node != nullptr) return as_choice(*node, words);
  note_default(*node_, key, filled_in(Kind::scalar, std::string(fallback)));
  return std::string(fallback);
}

std::vector<double> Config::numbers(std::string_view key, int count) const {
  return as_numbers(need(*node_, key), count);
}
std::vector<double> Config::numbers(std::string_view key, int count, const std::vector<double>& fallback) const {
  if (Node* node = ask(*node_, key); node != nullptr) return as_numbers(*node, count);
  Node& list = note_default(*node_, key, filled_in(Kind::list));
  for (const double value : fallback) list.add(filled_in(Kind::scalar, config::shortest(value)));
  return fallback;
}

std::vector<std::string> Config::texts(std::string_view key) const { return as_texts(need(*node_, key)); }
std::vector<std::string> Config::texts(std::string_view key, const std::vector<std::string>& fallback) const {
  if (const Node* node = ask(*node_, key); node != nullptr) return as_texts(*node);
  Node& list = note_default(*node_, key, filled_in(Kind::list));
  for (const std::string& value : fallback) list.add(filled_in(Kind::scalar, value));
  return fallback;
}

bool Config::has(std::string_view key) const {
  note_asked(*node_, key);
  return given(*node_, key) != nullptr;
}

Config Config::child(std::string_view key) const {
  Node& node = need(*node_, key);
  require_kind(node, Kind::mapping, "a mapping");
  return {root_, &node};
}

Config Config::child_or_empty(std::string_view key) const {
  if (ask(*node_, key) != nullptr) return child(key);
  Node* known = node_->find(key);
  if (known == nullptr || known->kind != Kind::mapping) known = &note_default(*node_, key, filled_in(Kind::mapping));
  return {root_, known};
}

std::vector<Config> Config::items(std::string_view key) const {
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

std::vector<Config> Config::items_or_empty(std::string_view key) const {
  if (ask(*node_, key) != nullptr) return items(key);
  note_default(*node_, key, filled_in(Kind::list));
  return {};
}

std::vector<std::string> Config::keys() const {
  std::vector<std::string> keys;
  for (const auto& child : node_->children) {
    if (!child->is_default) keys.push_back(child->key);
  }
  return keys;
}

bool Config::is_mapping(std::string_view key) const {
  const Node* node = given(*node_, key);
  return node != nullptr && node->kind == Kind::mapping;
}

bool Config::is_list(std::string_view key) const {
  const Node* node = given(*node_, key);
  return node != nullptr && node->kind == Kind::list;
}

}  // namespace waymark
