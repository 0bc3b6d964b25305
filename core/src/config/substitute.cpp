// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <set>

#include "config/node.hpp"
#include "config/yaml_bounds.hpp"
#include "waymark/config/nearest_name.hpp"

namespace waymark::config {
namespace {

using Kind = Node::Kind;

std::vector<std::string> keys_of(const Node& mapping) {
  std::vector<std::string> keys;
  for (const auto& child : mapping.children) keys.push_back(child->key);
  return keys;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& words) {
  const std::string near = nearest_name(word, words);
  return near.empty() ? "; there are: " + join(words) : fmt::format("; did you mean \"{}\"?", near);
}

// --- overrides
// ---------------------------------------------------------------------------------------------------------

/// The element of a list that a word means: its `name`, its `plugin` or its index. Null if there is none.
Node* find_element(const Node& list, const std::string& word) {
  for (const char* label : {"name", "plugin"}) {
    for (const auto& element : list.children) {
      const Node* child = element->find(label);
      if (child != nullptr && child->kind == Kind::scalar && child->text == word) return element.get();
    }
  }
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  const bool is_index = error == std::errc{} && end == word.data() + word.size() && index < list.children.size();
  return is_index ? list.children[index].get() : nullptr;
}

std::vector<std::string> element_names(const Node& list) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.children.size(); ++i) {
    const Node& element = *list.children[i];
    const Node* label = element.find("name");
    if (label == nullptr) label = element.find("plugin");
    names.push_back(label != nullptr && label->kind == Kind::scalar ? label->text : std::to_string(i));
  }
  return names;
}

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> words(1);
  for (const char c : path) {
    if (c == '.') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

/// One step down the tree; makes what a mapping lacks.
Node& step(Node& node, const std::string& word, const std::shared_ptr<const std::string>& origin) {
  if (node.kind == Kind::null) node.kind = Kind::mapping;
  if (node.kind == Kind::list) {
    if (Node* element = find_element(node, word); element != nullptr) return *element;
    throw config_error(fmt::format("{}: {} has no element \"{}\"; there are: {}", *origin, node.path(), word,
                                   join(element_names(node))));
  }
  if (node.kind != Kind::mapping) {
    throw config_error(fmt::format("{}: {} is {}, not a mapping or a list", *origin, node.path(), node.description()));
  }
  if (Node* child = node.find(word); child != nullptr) return *child;
  if (node.parent != nullptr && node.parent->parent == nullptr && node.key == "variables") {
    throw config_error(
        fmt::format("{}: there is no variable \"{}\"{}", *origin, word, suggestion(word, keys_of(node))));
  }
  auto child = std::make_unique<Node>();
  child->key = word;
  child->origin = origin;
  return node.add(std::move(child));
}

// --- variables
// ---------------------------------------------------------------------------------------------------------

bool is_name(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

constexpr std::size_t kMaxTextBytes = std::size_t{1} << 20;      // of one value
constexpr std::size_t kMaxExpandedBytes = std::size_t{1} << 24;  // of all
constexpr std::size_t kMaxChain = 64;                            // variables in variables

/// What a tree takes.
struct Size {
  std::size_t bytes = 0;
  std::size_t nodes = 0;
  int depth = 0;  ///< of lists and mappings in each other
};

void add_size_of(const Node& node, int depth, Size& size) {
  size.bytes += node.text.size() + node.key.size();
  ++size.nodes;
  if (node.kind == Kind::list || node.kind == Kind::mapping) size.depth = std::max(size.depth, ++depth);
  for (const auto& child : node.children) add_size_of(*child, depth, size);
}

int depth_of(const Node& node) {
  int depth = 0;
  for (const Node* above = node.parent; above != nullptr; above = above->parent) ++depth;
  return depth;
}

bool is_in_capitals(std::string_view name) {
  return std::none_of(name.begin(), name.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

/// Replaces variables; each is resolved when it is first used. Bounded: variables of variables multiply.
class Substitution {
 public:
  explicit Substitution(Node* variables) : variables_(variables) {}

  void apply(Node& node) {
    if (node.kind == Kind::scalar) {
      apply_to_scalar(node);
      return;
    }
    for (const auto& child : node.children) {
      if (child.get() != variables_) apply(*child);
    }
  }

  /// After `apply`: throws if variables that nothing uses refer to one another in a circle.
  void check_unused() {
    if (variables_ == nullptr) return;
    for (const auto& variable : variables_->children) follow(*variable);
  }

 private:
  void follow(const Node& variable) {
    if (done_.contains(&variable)) return;
    open_.insert(&variable);
    follow_references_in(variable);
    open_.erase(&variable);
    done_.insert(&variable);
  }

  void follow_references_in(const Node& node) {
    for (const auto& child : node.children) follow_references_in(*child);
    if (node.kind != Kind::scalar) return;
    const std::string& text = node.text;
    for (std::size_t at = text.find("${"); at != std::string::npos; at = text.find("${", at + 2)) {
      const std::size_t end = text.find('}', at);
      if (end == std::string::npos) return;
      if (at > 0 && text[at - 1] == '$') continue;  // a literal ${
      const std::string name = text.substr(at + 2, end - at - 2);
      const Node* variable = variables_->find(name);
      if (variable == nullptr) continue;
      if (open_.contains(variable)) throw_circle(name, node);
      if (open_.size() > kMaxChain) throw_chain(name, node);
      follow(*variable);
    }
  }

  void apply_to_scalar(Node& node) {
    const std::string text = node.text;
    if (text.find("${") == std::string::npos) return;
    if (text.front() == '$' && text[1] == '{' && text.find('}') == text.size() - 1) {
      node.assign(value(text.substr(2, text.size() - 3), node));
      return;
    }
    std::string result;
    bool replaced = false;
    for (std::size_t at = 0; at < text.size();) {
      if (text.compare(at, 3, "$${") == 0) {  // the way to write a literal ${
        result += "${";
        at += 3;
      } else if (text.compare(at, 2, "${") == 0) {
        const std::size_t end = text.find('}', at);
        if (end == std::string::npos) throw_at(node, fmt::format("\"{}\": a ${{ has no }}", text));
        const std::string name = text.substr(at + 2, end - at - 2);
        const Node found = copy(value(name, node));
        if (found.kind != Kind::scalar && found.kind != Kind::null) {
          throw_at(node, fmt::format("${{{}}}: is {} and cannot stand inside a text", name, found.description()));
        }
        result += found.text;
        if (result.size() > kMaxTextBytes) {
          throw_at(node, fmt::format("${{{}}}: the text becomes longer than {} MiB", name, kMaxTextBytes >> 20));
        }
        replaced = true;
        at = end + 1;
      } else {
        result += text[at++];
      }
    }
    node.text = result;
    if (replaced) node.quoted = false;
  }

  static Node copy(const Node& node) {
    Node result;
    result.assign(node);
    return result;
  }

  /// The value of a variable, itself already substituted.
  Node value(const std::string& name, const Node& user) {
    if (!is_name(name)) throw_at(user, fmt::format("${{{}}}: a variable's name has letters, digits and _ only", name));
    Node* variable = variables_ == nullptr ? nullptr : variables_->find(name);
    if (variable == nullptr) return from_environment(name, user);
    if (!done_.contains(variable)) {
      if (!open_.insert(variable).second) throw_circle(name, user);
      if (open_.size() > kMaxChain) throw_chain(name, user);
      apply(*variable);
      open_.erase(variable);
      done_.insert(variable);
    }
    spend(*variable, name, user);
    return copy(*variable);
  }

  /// Before a value is copied to its user: is there room for it?
  void spend(const Node& variable, const std::string& name, const Node& user) {
    Size size;
    add_size_of(variable, 0, size);
    if (depth_of(user) + size.depth > kMaxDepth)
      throw_at(user, fmt::format("${{{}}}: nested too deeply: at most {} levels are expected", name, kMaxDepth));
    nodes_ += size.nodes;
    bytes_ += size.bytes;
    if (nodes_ > kMaxNodes)
      throw_at(user, fmt::format("${{{}}}: the variables of this file hold more than {} values", name, kMaxNodes));
    if (bytes_ > kMaxExpandedBytes) {
      throw_at(user, fmt::format("${{{}}}: the variables of this file expand to more than {} MiB", name,
                                 kMaxExpandedBytes >> 20));
    }
  }

  Node from_environment(const std::string& name, const Node& user) const {
    if (!is_in_capitals(name)) {
      const std::vector<std::string> names = variables_ == nullptr ? std::vector<std::string>{} : keys_of(*variables_);
      throw_at(user, fmt::format("${{{}}}: variables: has no such name{}", name, suggestion(name, names)));
    }
    const char* text = std::getenv(name.c_str());
    if (text == nullptr || *text == '\0') {
      throw_at(user, fmt::format(
                         "${{{}}}: the environment variable {} is not set; set it, or define {} under variables:", name,
                         name, name));
    }
    Node result;
    result.kind = Kind::scalar;
    result.text = text;
    return result;
  }

  [[noreturn]] static void throw_circle(const std::string& name, const Node& user) {
    throw_at(user, fmt::format("${{{}}}: the variable refers to itself", name));
  }
  [[noreturn]] static void throw_chain(const std::string& name, const Node& user) {
    throw_at(user, fmt::format("${{{}}}: variables refer to one another over more than {} levels", name, kMaxChain));
  }
  [[noreturn]] static void throw_at(const Node& node, const std::string& message) {
    throw config_error(node.place() + ": " + message);
  }

  Node* variables_;
  std::set<const Node*> open_;
  std::set<const Node*> done_;
  std::size_t nodes_ = 0;  // copied so far
  std::size_t bytes_ = 0;
};

}  // namespace

void apply_override(Node& root, const Config::Override& override_text) {
  const auto origin = std::make_shared<const std::string>("--set " + override_text);
  const std::size_t equals = override_text.find('=');
  if (equals == std::string::npos || equals == 0) throw config_error(*origin + ": key=value is expected");
  const std::vector<std::string> words = split(std::string_view(override_text).substr(0, equals));
  if (words.size() > static_cast<std::size_t>(kMaxDepth))
    throw config_error(fmt::format("{}: the key has more than {} parts", *origin, kMaxDepth));
  auto value = parse_yaml(override_text.substr(equals + 1), origin, false);
  Node* node = &root;
  for (const std::string& word : words) {
    if (word.empty()) throw config_error(*origin + ": the key has an empty part");
    if (word.size() > kMaxKeyBytes)
      throw config_error(fmt::format("{}: a part of the key has more than {} bytes", *origin, kMaxKeyBytes));
    node = &step(*node, word, origin);
  }
  // `assign` drops the quotes: a shell leaves none of the user's intent.
  node->assign(*value);
  node->origin = origin;
  node->line = node->column = node->key_line = node->key_column = 0;
}

void substitute_variables(Node& root) {
  Node* variables = root.find("variables");
  if (variables != nullptr && variables->kind != Kind::mapping && variables->kind != Kind::null) {
    fail_at(*variables, variables->description() + " is not a mapping of names to values");
  }
  Substitution substitution(variables);
  substitution.apply(root);
  substitution.check_unused();
  std::erase_if(root.children, [variables](const auto& child) { return child.get() == variables; });
}

}  // namespace waymark::config
