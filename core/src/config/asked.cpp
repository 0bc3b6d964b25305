// SPDX-License-Identifier: Apache-2.0
// What was asked of a configuration: the declarations of its keys.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/node.hpp"

namespace waymark {
namespace {

using Asked = Config::Asked;
using Node = Config::Node;

std::string range(const Asked& asked) {
  const bool has_low = std::isfinite(asked.low);
  const bool has_high = std::isfinite(asked.high);
  if (has_low && has_high) return fmt::format(" in [{}, {}]", asked.low, asked.high);
  if (has_low) return fmt::format(" {} {}", asked.excludes_low ? ">" : ">=", asked.low);
  return has_high ? fmt::format(" <= {}", asked.high) : "";
}

void collect(const Node& node, const std::string& above, std::vector<Asked>& out);

void collect_below(const Node& child, const std::string& path, std::vector<Asked>& out) {
  if (child.kind == Node::Kind::mapping) collect(child, path + '.', out);
  if (child.kind != Node::Kind::list) return;
  for (const auto& element : child.children) collect_below(*element, path + "[]", out);
}

void collect(const Node& node, const std::string& above, std::vector<Asked>& out) {
  for (const Asked& asked : node.asked) {
    const std::string path = above + asked.path;  // not the copy's: `out` grows below
    out.emplace_back(asked).path = path;
    if (const Node* child = node.find(asked.path); child != nullptr) collect_below(*child, path, out);
  }
}

}  // namespace

std::string Config::Asked::expectation() const {
  switch (type) {
    case Type::none:
      return {};
    case Type::number:
      return "number" + range(*this);
    case Type::integer:
      return "whole number" + range(*this);
    case Type::boolean:
      return "true or false";
    case Type::text:
      return "text";
    case Type::choice:
      return fmt::format("one of: {}", fmt::join(words, ", "));
    case Type::numbers:
      return count < 0 ? "list of numbers" : fmt::format("list of {} numbers", count);
    case Type::texts:
      return "list of words";
    case Type::mapping:
      return "mapping";
    case Type::items:
      return "list of mappings";
  }
  return {};
}

Asked& Config::Node::note_asked(const Key& declared) {
  auto known =
      std::find_if(asked.begin(), asked.end(), [&declared](const Asked& a) { return a.path == declared.name; });
  if (known == asked.end()) {
    asked.emplace_back().path = declared.name;
    known = asked.end() - 1;
  }
  if (known->unit.empty()) known->unit = declared.unit;
  if (known->meaning.empty()) known->meaning = declared.meaning;
  if (!known->fallback && !declared.fallback.empty()) known->fallback = declared.fallback;
  return *known;
}

std::vector<std::string> Config::Node::asked_names() const {
  std::vector<std::string> names;
  for (const Asked& each : asked) names.push_back(each.path);
  return names;
}

std::vector<Config::Asked> Config::asked() const {
  std::vector<Asked> keys;
  collect(*node_, "", keys);
  return keys;
}

}  // namespace waymark
