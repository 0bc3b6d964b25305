// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "config/node.hpp"

namespace waymark {
namespace {

using Node = Config::Node;
using Kind = Node::Kind;

/// True if YAML reads the text back as the same plain scalar, also between brackets.
bool is_plain(std::string_view text) {
  const auto is_alphanumeric = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  if (text.empty() || text == "null" || text == "Null" || text == "NULL") return false;
  const std::string_view sign_less = text.front() == '-' || text.front() == '+' ? text.substr(1) : text;
  if (sign_less.empty() || sign_less.front() == '-' || sign_less == ".." || sign_less == "...") return false;
  return std::all_of(text.begin(), text.end(),
                     [&](char c) {
                       return is_alphanumeric(c) || std::string_view("_./+-@").find(c) != std::string_view::npos;
                     }) &&
         text.front() != '@';
}

/// In double quotes. Values may hold variables, keys do not.
std::string quote(std::string_view text, bool is_key = false) {
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (c == '\n') {
      result += "\\n";
    } else if (c == '\t') {
      result += "\\t";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else if (!is_key && c == '$' && text.substr(i, 2) == "${") {
      result += "$$";  // or it would be taken for a variable
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string scalar(const Node& node) {
  if (node.kind == Kind::null) return "~";
  if (!node.shown.empty()) return node.shown;
  return !node.quoted && is_plain(node.text) ? node.text : quote(node.text);
}

/// False for what was neither given nor filled in with a value that YAML can give back.
bool has_value(const Node& node) {
  if (!node.is_default) return true;
  if (node.kind != Kind::mapping) return node.kind != Kind::null;
  return std::any_of(node.children.begin(), node.children.end(), [](const auto& child) { return has_value(*child); });
}

bool is_empty(const Node& node) {
  return std::none_of(node.children.begin(), node.children.end(), [](const auto& child) { return has_value(*child); });
}

/// Lists without mappings stand on one line.
bool is_flat(const Node& node) {
  if (node.kind == Kind::mapping) return false;
  return std::all_of(node.children.begin(), node.children.end(), [](const auto& child) { return is_flat(*child); });
}

std::string one_line(const Node& node) {
  if (node.kind == Kind::mapping) return "{}";
  if (node.kind != Kind::list) return scalar(node);
  std::string result = "[";
  for (const auto& child : node.children) result += (result.size() > 1 ? ", " : "") + one_line(*child);
  return result + ']';
}

void write_entries(const Node& node, const std::string& indent, bool first_is_indented, std::string& out);

/// What stands behind `key:`, to the end of the line or below it.
void write_value(const Node& node, const std::string& indent, std::string& out) {
  if (is_flat(node) || is_empty(node)) {
    out += ' ' + one_line(node) + (node.is_default ? "  # default" : "") + '\n';
  } else if (node.kind == Kind::mapping) {
    out += '\n';
    write_entries(node, indent + "  ", false, out);
  } else {
    out += '\n';
    for (const auto& child : node.children) {
      out += indent + "  -";
      if (child->kind == Kind::mapping && !is_empty(*child)) {
        out += ' ';
        write_entries(*child, indent + "    ", true, out);
      } else {
        // A list within a list that holds mappings starts on a line of its own.
        write_value(*child, indent + "  ", out);
      }
    }
  }
}

void write_entries(const Node& node, const std::string& indent, bool first_is_indented, std::string& out) {
  for (const auto& child : node.children) {
    // An empty mapping that nobody gave would look as if it had been given.
    if (child->kind == Kind::mapping && !has_value(*child)) continue;
    if (!first_is_indented) out += indent;
    first_is_indented = false;
    const std::string key = is_plain(child->key) ? child->key : quote(child->key, true);
    if (child->is_default && child->kind == Kind::null) {
      out += fmt::format("# {}: {}  # default\n", key, child->text);
      continue;
    }
    out += key + ':';
    write_value(*child, indent, out);
  }
}

}  // namespace

std::string Config::effective() const {
  std::string out;
  write_entries(*node_, "", false, out);
  return out.empty() ? "{}\n" : out;
}

}  // namespace waymark
