// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "config/node.hpp"

namespace waymark {
namespace {

using Node = Config::Node;
using Kind = Node::Kind;

[[noreturn]] void refuse_unknown(const Node& node, const Node& parent) {
  const std::vector<std::string> known = parent.asked_names();
  const std::string near = config::nearest_key(node.key, known);
  std::string hint = fmt::format("did you mean \"{}\"?", near);
  if (near.empty()) hint = known.empty() ? "no keys are known here" : "known here: " + config::join(known);
  throw config::config_error(fmt::format("{}: {}: unknown key; {}", node.key_place(), node.path(), hint));
}

void check(const Node& node) {
  if (node.ignored) return;
  for (const auto& child : node.children) {
    if (child->is_default) continue;
    if (node.kind == Kind::mapping && !child->was_read) refuse_unknown(*child, node);
    check(*child);
  }
}

void ignore_all(Node& node) {
  node.was_read = true;
  node.ignored = true;
  for (const auto& child : node.children) ignore_all(*child);
}

}  // namespace

void Config::fail(std::string_view key, std::string_view message) const {
  const Node* child = node_->find(key);
  if (child != nullptr) config::fail_at(*child, message);
  const std::string above = path();
  throw config::config_error(fmt::format("{}: {}{}{}: {}", place(), above, above.empty() ? "" : ".", key, message));
}

void Config::fail(std::string_view message) const { config::fail_at(*node_, message); }

std::string Config::place() const { return node_->place(); }

std::string Config::path() const { return node_->path(); }

std::filesystem::path Config::file() const {
  std::filesystem::path file = *root_->origin;
  const Node* base = root_->find("base_folder");
  if (base == nullptr || base->kind != Node::Kind::scalar || base->is_default) return file;
  return file.parent_path() / base->text / file.filename();
}

void Config::reject_unread() const { check(*node_); }

void Config::ignore() const { ignore_all(*node_); }

}  // namespace waymark
