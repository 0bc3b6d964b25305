// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

/// One node of the YAML, and what was read of it. Every read marks the key; `reject_unread` then finds the typos. Reads
/// with a fallback note the effective value, so the effective configuration can be shown. Cheap to copy (a handle). All
/// reads throw ConfigError: `file:line:col: sensors.gps.sigma_m: "abc" is not a number`.
class WAYMARK_API Config {
 public:
  /// A key of the YAML, declared where it is read: the reference pages, `waymark plugins NAME` and messages are made of
  /// these (key_reference.hpp). The name alone is enough to read a key that is declared elsewhere.
  ///
  ///     config.positive({"sigma_m", "m", "noise per axis"})
  ///     config.boolean({"merge", "landmarks that came together become one"}, false)
  struct Key {
    std::string_view name;
    std::string_view unit;      ///< "m", "m/s"; empty: none
    std::string_view meaning;   ///< one clause
    std::string_view fallback;  ///< in words, if the default is computed: "2 × sigma_m"; empty: the value itself

    Key(std::string_view key) : name(key) {}    // NOLINT(google-explicit-constructor): reads take a name as well
    Key(const char* key) : name(key) {}         // NOLINT(google-explicit-constructor)
    Key(const std::string& key) : name(key) {}  // NOLINT(google-explicit-constructor)
    Key(std::string_view key, std::string_view what) : name(key), meaning(what) {}
    Key(std::string_view key, std::string_view in, std::string_view what, std::string_view otherwise = {})
        : name(key), unit(in), meaning(what), fallback(otherwise) {}
  };

  /// What reads asked for under one key: its declaration, as far as it was given.
  struct Asked {
    enum class Type { none, number, integer, boolean, text, choice, numbers, texts, mapping, items };

    std::string path;  ///< below the node that was asked: "extraction.range_max_m", "files[].file"
    std::string unit, meaning;
    Type type = Type::none;                                 ///< none: only looked for
    double low = -std::numeric_limits<double>::infinity();  ///< of numbers and integers
    double high = std::numeric_limits<double>::infinity();  ///< the same
    bool excludes_low = false;                              ///< > low, not >= low
    int count = -1;                                         ///< of numbers; any if negative
    std::vector<std::string> words;                         ///< of a choice
    std::optional<std::string> fallback;                    ///< as YAML, or in words
    bool is_required = false;

    /// "number > 0", "one of: keep, match, drop"; empty if it was only looked for.
    std::string expectation() const;
  };

  /// `key=value` with a dotted path: `filter.particles=100`, `sensors.gps.sigma_m=0.1`, `sinks.0.plugin=tum`. An
  /// element of a list is named by its index, or by its `name`, or by its `plugin`. The value is YAML, so `[1, 2]` is a
  /// list.
  using Override = std::string;

  /// Reads a file. `${name}` is replaced from the block `variables:` (whose values an override may set) or, for names
  /// in capitals, from the environment. Duplicate keys are refused. Throws ConfigError.
  static Config load(const std::filesystem::path& file, const std::vector<Override>& overrides = {});
  /// The same for text, under a name for messages.
  static Config parse(std::string_view yaml, std::string_view name = "text",
                      const std::vector<Override>& overrides = {});

  // --- scalars of a mapping ------------------------------------------------------------------------------------------
  double number(const Key& key) const;  ///< finite
  double number(const Key& key, double fallback) const;
  double positive(const Key& key) const;  ///< finite and > 0
  double positive(const Key& key, double fallback) const;
  double non_negative(const Key& key) const;
  double non_negative(const Key& key, double fallback) const;
  double number_in(const Key& key, double low, double high) const;  ///< low <= value <= high
  double number_in(const Key& key, double low, double high, double fallback) const;
  std::int64_t integer(const Key& key) const;
  std::int64_t integer(const Key& key, std::int64_t fallback) const;
  std::int64_t integer_in(const Key& key, std::int64_t low, std::int64_t high, std::int64_t fallback) const;
  bool boolean(const Key& key) const;  ///< true/false, yes/no, on/off
  bool boolean(const Key& key, bool fallback) const;
  std::string text(const Key& key) const;
  std::string text(const Key& key, std::string_view fallback) const;
  /// One of the words; the error lists them.
  std::string choice(const Key& key, std::initializer_list<std::string_view> words) const;
  std::string choice(const Key& key, std::initializer_list<std::string_view> words, std::string_view fallback) const;
  /// A list of exactly `count` numbers (any count if negative).
  std::vector<double> numbers(const Key& key, int count = -1) const;
  std::vector<double> numbers(const Key& key, int count, const std::vector<double>& fallback) const;
  std::vector<std::string> texts(const Key& key) const;  ///< a list of words, or one word
  std::vector<std::string> texts(const Key& key, const std::vector<std::string>& fallback) const;

  // --- files that are written ----------------------------------------------------------------------------------------
  /// Name of a file or folder that the reader writes, below the run's output folder. Throws ConfigError if it leads out
  /// of that folder (an absolute path, "..") without `permit_outside`, or if another key names the same file.
  std::string output(const Key& key, std::string_view fallback) const;
  /// Outputs of this configuration may lie anywhere, from here on.
  void permit_outside() const;

  // --- structure -----------------------------------------------------------------------------------------------------
  bool has(const Key& key) const;                   ///< does not count as a read
  Config child(const Key& key) const;               ///< a mapping that must be there
  Config child_or_empty(const Key& key) const;      ///< a mapping, or an empty one if the key is absent
  std::vector<Config> items(const Key& key) const;  ///< a list of mappings that must be there
  std::vector<Config> items_or_empty(const Key& key) const;
  std::vector<std::string> keys() const;  ///< in the order of the file; does not count as a read
  bool is_mapping(const Key& key) const;  ///< does not count as a read
  bool is_list(const Key& key) const;     ///< does not count as a read
  /// True if a scalar with this text is given. Does not count as a read.
  bool is_word(const Key& key, std::string_view word) const;
  /// Puts a value (YAML) in the place of the one that was given for a key: what a word stands for, once that is known.
  /// The effective configuration has it. Throws ConfigError for wrong syntax.
  void replace(const Key& key, std::string_view value) const;

  // --- errors and reports --------------------------------------------------------------------------------------------
  /// Throws ConfigError at the key's place (or at this node's, if the key is absent).
  [[noreturn]] void fail(std::string_view key, std::string_view message) const;
  /// Throws ConfigError at this node's place.
  [[noreturn]] void fail(std::string_view message) const;
  std::string place() const;           ///< "file:line:col"
  std::string path() const;            ///< "sensors.gps"
  std::filesystem::path file() const;  ///< of the YAML; relative paths in it count from its folder (or `base_folder`)

  /// Throws ConfigError for the first key below this node that nothing has read, with the nearest key that was asked
  /// for.
  void reject_unread() const;
  /// Marks this node and all below as read: for what a disabled part does not need.
  void ignore() const;
  /// The keys that were asked for at this node and below, in the order of the reads.
  std::vector<Asked> asked() const;
  /// The effective configuration as YAML: what was given and, behind `# default`, what was filled in.
  std::string effective() const;

  struct Node;  ///< private to the implementation

 private:
  Config(std::shared_ptr<Node> root, Node* node) : root_(std::move(root)), node_(node) {}
  std::shared_ptr<Node> root_;  // keeps the tree
  Node* node_;
};

}  // namespace waymark
