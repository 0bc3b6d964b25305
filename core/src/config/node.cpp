// SPDX-License-Identifier: Apache-2.0
#include "config/node.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace waymark {
namespace {

std::string place_of(const std::string& origin, int line, int column) {
  return line > 0 ? fmt::format("{}:{}:{}", origin, line, column) : origin;
}

}  // namespace

Config::Node* Config::Node::find(std::string_view name) const {
  if (kind != Kind::mapping) return nullptr;
  for (const auto& child : children) {
    if (child->key == name) return child.get();
  }
  return nullptr;
}

Config::Node& Config::Node::add(std::unique_ptr<Node> child) {
  child->parent = this;
  return *children.emplace_back(std::move(child));
}

std::string Config::Node::place() const {
  const Node* given = this;
  while (given->is_default && given->parent != nullptr) given = given->parent;
  return place_of(*given->origin, given->line, given->column);
}

std::string Config::Node::key_place() const { return key_line > 0 ? place_of(*origin, key_line, key_column) : place(); }

std::string Config::Node::path() const {
  if (parent == nullptr) return {};
  const std::string above = parent->path();
  if (parent->kind == Kind::mapping) return above.empty() ? key : above + '.' + key;
  for (const char* label : {"name", "plugin"}) {
    const Node* child = find(label);
    if (child != nullptr && child->kind == Kind::scalar && !child->text.empty()) return above + '.' + child->text;
  }
  const auto& siblings = parent->children;
  const auto self =
      std::find_if(siblings.begin(), siblings.end(), [this](const auto& node) { return node.get() == this; });
  return fmt::format("{}[{}]", above, self - siblings.begin());
}

void Config::Node::assign(const Node& other) {
  kind = other.kind;
  text = other.text;
  quoted = false;
  children.clear();
  for (const auto& child : other.children) {
    auto copy = std::make_unique<Node>();
    copy->origin = child->origin;
    copy->line = child->line;
    copy->column = child->column;
    copy->key_line = child->key_line;
    copy->key_column = child->key_column;
    copy->key = child->key;
    copy->assign(*child);
    add(std::move(copy));
  }
}

std::string Config::Node::description() const {
  switch (kind) {
    case Kind::null:
      return "nothing";
    case Kind::list:
      return "a list";
    case Kind::mapping:
      return "a mapping";
    case Kind::scalar:
      break;
  }
  const bool looks_numeric = !quoted && text.find_first_of("0123456789") != std::string::npos &&
                             text.find_first_not_of("0123456789+-.eE") == std::string::npos;
  if (looks_numeric) return text;
  // A whole table that was taken for a YAML is one long scalar.
  constexpr std::size_t kLongestValue = 80;
  const std::size_t end = std::min({text.find('\n'), text.size(), kLongestValue});
  return '"' + text.substr(0, end) + (end < text.size() ? "…\"" : "\"");
}

namespace config {

ConfigError config_error(std::string message) {
  constexpr std::size_t kLongestMessage = 2000;
  if (message.size() > kLongestMessage) {
    std::size_t end = kLongestMessage;
    while (end > 0 && (static_cast<unsigned char>(message[end]) & 0xc0U) == 0x80U) --end;  // within a character
    message.replace(end, std::string::npos, "…");
  }
  for (std::size_t at = message.find_first_of("\n\r"); at != std::string::npos; at = message.find_first_of("\n\r", at))
    message.replace(at, 1, message[at] == '\n' ? "\\n" : "\\r");
  return ConfigError(message);
}

void fail_at(const Node& node, std::string_view message) {
  const std::string path = node.path();
  throw config_error(fmt::format("{}: {}{}{}", node.place(), path, path.empty() ? "" : ": ", message));
}

std::string join(const std::vector<std::string>& words) {
  return words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", "));
}

std::string shortest(double value) { return fmt::format("{}", value); }

}  // namespace config
}  // namespace waymark
