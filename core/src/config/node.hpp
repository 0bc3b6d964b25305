// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/config/config.hpp"

namespace waymark {

/// One node of a configuration's tree: its value, where it stands, and what was read of it.
struct Config::Node {
  enum class Kind { null, scalar, list, mapping };

  Kind kind = Kind::null;
  std::string text;     ///< of a scalar
  bool quoted = false;  ///< a scalar that the user marked as text
  std::string shown;    ///< canonical form of a scalar that was read as a number or a truth value; else empty

  std::shared_ptr<const std::string> origin;  ///< the file, or `--set key=value`
  int line = 0;                               ///< of the value, from 1; 0 if the origin has no lines
  int column = 0;
  int key_line = 0;  ///< of the key in front of the value
  int key_column = 0;

  Node* parent = nullptr;
  std::string key;  ///< if the parent is a mapping
  std::vector<std::unique_ptr<Node>> children;

  /// Of the root: the files that the readers write, each with the node and the key that names it.
  struct Output {
    std::string file;
    const Node* node;
    std::string key;
  };
  std::vector<Output> outputs;
  bool permits_outside = false;  ///< of the root: outputs may lie anywhere

  bool is_default = false;   ///< not given, but filled in by a read with a fallback
  bool was_read = false;     ///< something asked for it
  bool ignored = false;      ///< nothing below needs to be read
  std::vector<Asked> asked;  ///< keys that were asked for, found or not

  /// What is noted of a key; unit and meaning are those of the first read that gave them. `path` is the name here.
  Asked& note_asked(const Key& declared);
  std::vector<std::string> asked_names() const;
  /// The child under a key, also a filled-in one; null if there is none.
  Node* find(std::string_view name) const;
  /// Appends a child and returns it.
  Node& add(std::unique_ptr<Node> child);
  /// "file:line:col" of the value, or of the nearest node above that was given.
  std::string place() const;
  /// "file:line:col" of the key.
  std::string key_place() const;
  /// "sensors.gps.sigma_m"
  std::string path() const;
  /// Takes over value and children of another node, but keeps its own place.
  void assign(const Node& other);
  /// What it is, for messages: "a list", "a mapping", "\"abc\"", "5".
  std::string description() const;
};

namespace config {

using Node = Config::Node;

/// The error with this message, on one line of at most 2000 bytes whatever text of a YAML is in it.
ConfigError config_error(std::string message);

/// Throws ConfigError `place: path: message`.
[[noreturn]] void fail_at(const Node& node, std::string_view message);

/// The tree of a YAML text. Throws ConfigError with `origin:line:col` for wrong syntax and duplicate keys. `in_lines`
/// is false for texts whose lines mean nothing to the user.
std::unique_ptr<Node> parse_yaml(const std::string& text, std::shared_ptr<const std::string> origin, bool in_lines);

/// Applies one `key=value`. Throws ConfigError that starts with `--set key=value:`.
void apply_override(Node& root, const Config::Override& override_text);

/// Replaces every `${name}` and takes the block `variables:` out of the tree.
void substitute_variables(Node& root);

/// The word that differs only in its unit suffix (sigma_cm and sigma_m), else `nearest_name`.
std::string nearest_key(std::string_view key, const std::vector<std::string>& keys);

/// "a, b, c", or "none".
std::string join(const std::vector<std::string>& words);

/// A number in the shortest form that reads back to the same value.
std::string shortest(double value);

}  // namespace config
}  // namespace waymark
