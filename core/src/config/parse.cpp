// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "config/node.hpp"
#include "config/yaml_bounds.hpp"

namespace waymark {
namespace config {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 26;  // of a file: a log that was given by mistake is larger
constexpr std::size_t kFilePieceBytes = std::size_t{1} << 20;

/// Turns yaml-cpp's nodes into ours.
class Converter {
 public:
  Converter(std::shared_ptr<const std::string> origin, bool in_lines)
      : origin_(std::move(origin)), in_lines_(in_lines) {}

  std::unique_ptr<Node> convert(const YAML::Node& yaml) {
    auto root = std::make_unique<Node>();
    fill(yaml, *root, 0);
    return root;
  }

 private:
  /// Fills a node that already hangs in its tree, so that errors can name its path.
  void fill(const YAML::Node& yaml, Node& node, int depth) {
    node.origin = origin_;
    // A value that is not there has no place of its own: it stands where its key stands.
    const bool placed = in_lines_ && !yaml.Mark().is_null() && !yaml.IsNull();
    node.line = placed ? yaml.Mark().line + 1 : node.key_line;
    node.column = placed ? yaml.Mark().column + 1 : node.key_column;
    if (node.line == 0 && node.parent != nullptr) {
      node.line = node.parent->line;
      node.column = node.parent->column;
    }
    if (depth > kMaxDepth || ++count_ > kMaxNodes) fail_at(node, "is nested too deeply or without end");
    switch (yaml.Type()) {
      case YAML::NodeType::Undefined:
      case YAML::NodeType::Null:
        break;
      case YAML::NodeType::Scalar:
        node.kind = Node::Kind::scalar;
        node.text = yaml.Scalar();
        node.quoted = yaml.Tag() == "!" || yaml.Tag() == "tag:yaml.org,2002:str";
        break;
      case YAML::NodeType::Sequence:
        node.kind = Node::Kind::list;
        for (const YAML::Node& element : yaml) fill(element, node.add(std::make_unique<Node>()), depth + 1);
        break;
      case YAML::NodeType::Map:
        node.kind = Node::Kind::mapping;
        add_entries(yaml, node, depth);
        break;
    }
  }

  void add_entries(const YAML::Node& yaml, Node& node, int depth) {
    std::map<std::string, std::string> places;
    for (const auto& entry : yaml) {
      if (!entry.first.IsScalar()) fail_at(node, "has a key that is not a word");
      Node& child = node.add(std::make_unique<Node>());
      child.key = entry.first.Scalar();
      if (in_lines_) {
        child.key_line = entry.first.Mark().line + 1;
        child.key_column = entry.first.Mark().column + 1;
      }
      child.origin = origin_;
      if (child.key.size() > kMaxKeyBytes) {
        throw config_error(fmt::format("{}: a key of {} bytes begins with \"{}\"; it may have {}", child.key_place(),
                                       child.key.size(), child.key.substr(0, 40), kMaxKeyBytes));
      }
      const auto [first, is_new] = places.try_emplace(child.key, child.key_place());
      if (!is_new) {
        throw config_error(fmt::format("{}: {}: the key is given twice; the first is at {}", child.key_place(),
                                       child.path(), first->second));
      }
      fill(entry.second, child, depth + 1);
    }
  }

  std::shared_ptr<const std::string> origin_;
  bool in_lines_;
  std::size_t count_ = 0;
};

std::string line_of(const std::string& text, int line) {
  std::istringstream stream(text);
  std::string found;
  for (int i = 0; i <= line && std::getline(stream, found); ++i) continue;
  return found;
}

/// What a typing error was that yaml-cpp explains in words of its own; empty if that is not known.
std::string explanation(const std::string& text, const YAML::Exception& error) {
  if (error.mark.is_null()) return {};
  const std::string line = line_of(text, error.mark.line);
  // In flow style the braces of a variable are YAML's own.
  if (line.find("${") != std::string::npos) return "between { } or [ ] a variable needs quotes: \"${name}\"";
  if (line.substr(0, line.find_first_not_of(" \t")).find('\t') != std::string::npos)
    return "there is a tab in the indentation; YAML wants blanks";
  if (error.msg == YAML::ErrorMsg::END_OF_MAP_FLOW) return "before this place a { has no }, or a comma is missing";
  if (error.msg == YAML::ErrorMsg::END_OF_SEQ_FLOW) return "before this place a [ has no ], or a comma is missing";
  // The line with "-name: gps" is a text, so that the error may be in the one that follows.
  for (int k = error.mark.line; k >= std::max(0, error.mark.line - 1); --k) {
    const std::string candidate = line_of(text, k);
    const std::size_t at = candidate.find_first_not_of(' ');
    const bool has_letter = at != std::string::npos && at + 1 < candidate.size() && candidate[at] == '-' &&
                            std::isalpha(static_cast<unsigned char>(candidate[at + 1])) != 0;
    if (has_letter && candidate.find(':', at) != std::string::npos)
      return fmt::format("line {} needs a blank after its \"-\"", k + 1);
  }
  return {};
}

}  // namespace

std::unique_ptr<Node> parse_yaml(const std::string& text, std::shared_ptr<const std::string> origin, bool in_lines) {
  YAML::Node document;
  try {
    check_yaml_bounds(text);
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    const bool placed = in_lines && !error.mark.is_null();
    const std::string meaning = explanation(text, error);
    throw config_error(fmt::format("{}{}: {}{}{}", *origin,
                                   placed ? fmt::format(":{}:{}", error.mark.line + 1, error.mark.column + 1) : "",
                                   error.msg, meaning.empty() ? "" : "; ", meaning));
  }
  return Converter(std::move(origin), in_lines).convert(document);
}

namespace {

std::unique_ptr<Node> load_tree(const std::string& text, const std::string& name,
                                const std::vector<Config::Override>& overrides) {
  auto root = parse_yaml(text, std::make_shared<const std::string>(name), true);
  if (root->kind == Node::Kind::null) {
    root->kind = Node::Kind::mapping;
    root->line = root->column = 1;
  }
  if (root->kind != Node::Kind::mapping) fail_at(*root, root->description() + " is not a mapping of keys to values");
  for (const Config::Override& text_of_override : overrides) apply_override(*root, text_of_override);
  substitute_variables(*root);
  return root;
}

/// Throws ConfigError if there is a byte from `begin` on that no text has.
void check_is_text(const std::string& content, std::size_t begin, const std::filesystem::path& file) {
  const auto is_binary = [](char c) {
    return (c >= '\0' && c < ' ' && c != '\n' && c != '\r' && c != '\t') || c == '\x7f';
  };
  const auto at = std::find_if(content.begin() + static_cast<std::ptrdiff_t>(begin), content.end(), is_binary);
  if (at == content.end()) return;
  throw config_error(fmt::format("{}:{}: is not text (byte {:#04x}), a YAML file is expected", file.string(),
                                 std::count(content.begin(), at, '\n') + 1, static_cast<unsigned char>(*at)));
}

std::string read_whole(const std::filesystem::path& file) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(file, error);
  if (is_folder) throw config_error(file.string() + ": is a folder, a YAML file is expected");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw config_error(fmt::format("{}: cannot be read: {}", file.string(), std::generic_category().message(errno)));
  std::string content;
  do {
    const std::size_t before = content.size();
    content.resize(before + kFilePieceBytes);
    stream.read(content.data() + before, static_cast<std::streamsize>(kFilePieceBytes));
    content.resize(before + static_cast<std::size_t>(stream.gcount()));
    check_is_text(content, before, file);
  } while (stream && content.size() <= kMaxFileBytes);
  if (stream.bad()) throw config_error(fmt::format("{}: reading failed", file.string()));
  if (content.size() > kMaxFileBytes) {
    throw config_error(
        fmt::format("{}: is longer than {} MiB, a YAML file is expected", file.string(), kMaxFileBytes >> 20));
  }
  return content;
}

}  // namespace
}  // namespace config

Config Config::load(const std::filesystem::path& file, const std::vector<Override>& overrides) {
  std::shared_ptr<Node> root = config::load_tree(config::read_whole(file), file.string(), overrides);
  return {root, root.get()};
}

Config Config::parse(std::string_view yaml, std::string_view name, const std::vector<Override>& overrides) {
  std::shared_ptr<Node> root = config::load_tree(std::string(yaml), std::string(name), overrides);
  return {root, root.get()};
}

}  // namespace waymark
