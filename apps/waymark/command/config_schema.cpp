// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/config_schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

namespace waymark::command {

namespace {

using Json = nlohmann::ordered_json;
using Asked = Config::Asked;

/// A key with those below it: "files[]" is the element of the list `files`.
struct KeyNode {
  Asked asked;
  std::vector<std::pair<std::string, std::unique_ptr<KeyNode>>> below;

  KeyNode& at(const std::string& name) {
    const auto found = std::ranges::find(below, name, [](const auto& child) { return child.first; });
    if (found != below.end()) return *found->second;
    return *below.emplace_back(name, std::make_unique<KeyNode>()).second;
  }
  const KeyNode* find(std::string_view name) const {
    const auto found = std::ranges::find(below, name, [](const auto& child) { return child.first; });
    return found == below.end() ? nullptr : found->second.get();
  }
};

void add(KeyNode& root, const Asked& asked) {
  KeyNode* node = &root;
  std::string rest = asked.path;
  while (!rest.empty()) {
    const std::size_t dot = std::min(rest.find('.'), rest.size());
    std::string name = rest.substr(0, dot);
    rest.erase(0, dot + 1);
    const bool is_element = name.ends_with("[]");
    if (is_element) name.resize(name.size() - 2);
    node = &node->at(name);
    if (is_element) node = &node->at("[]");
  }
  node->asked = asked;
}

KeyNode tree_of(const std::vector<DescribedKey>& keys) {
  KeyNode root;
  root.asked.type = Asked::Type::mapping;
  for (const DescribedKey& key : keys) add(root, key.asked);
  return root;
}

Json variable() { return {{"type", "string"}, {"pattern", "\\$\\{"}}; }

Json number(const Asked& asked) {
  Json out{{"type", asked.type == Asked::Type::integer ? "integer" : "number"}};
  if (std::isfinite(asked.low)) out[asked.excludes_low ? "exclusiveMinimum" : "minimum"] = asked.low;
  if (std::isfinite(asked.high)) out["maximum"] = asked.high;
  return out;
}

Json any_of(std::vector<Json> choices) { return {{"anyOf", std::move(choices)}}; }

/// Instead of numbers, a mapping or a list a word may stand (`none`, `from_tf`). Which ones, only the reader decides.
Json or_word(Json value) { return any_of({std::move(value), {{"type", "string"}}}); }

Json object_of(const KeyNode& node);

Json value_of(const KeyNode& node) {
  const Asked& asked = node.asked;
  const Json scalar{{"type", {"string", "number", "boolean"}}};
  switch (asked.type) {
    case Asked::Type::number:
    case Asked::Type::integer:
      return any_of({number(asked), variable()});
    case Asked::Type::boolean:
      return any_of({{{"enum", {true, false, "yes", "no", "on", "off"}}}, variable()});
    case Asked::Type::choice:
      return any_of({{{"enum", asked.words}}, variable()});
    case Asked::Type::text:
      // A column of a table may also be a mapping: its name, and its unit or scale.
      return any_of({scalar, {{"type", "object"}}});
    case Asked::Type::numbers: {
      Json list{{"type", "array"}, {"items", any_of({{{"type", "number"}}, variable()})}};
      if (asked.count >= 0) list["minItems"] = list["maxItems"] = asked.count;
      return or_word(list);
    }
    case Asked::Type::texts:
      return any_of({scalar, {{"type", "array"}, {"items", scalar}}});
    case Asked::Type::items: {
      const KeyNode* element = node.find("[]");
      return or_word(
          {{"type", "array"}, {"items", element == nullptr ? Json{{"type", "object"}} : object_of(*element)}});
    }
    case Asked::Type::mapping:
      return or_word(object_of(node));
    case Asked::Type::none:
      break;
  }
  // Only looked for: what it is, another key of the same name decides.
  if (node.find("[]") != nullptr) return {{"type", "array"}, {"items", object_of(*node.find("[]"))}};
  return node.below.empty() ? Json::object() : object_of(node);
}

/// Its meaning, unit and default, as an editor shows them.
std::string description(const Asked& asked) {
  std::string text = asked.meaning;
  if (!asked.unit.empty()) text += fmt::format(" [{}]", asked.unit);
  if (asked.fallback) text += fmt::format(" (default: {})", *asked.fallback);
  return text;
}

Json properties_of(const KeyNode& node) {
  Json properties = Json::object();
  for (const auto& [name, child] : node.below) {
    properties[name] = value_of(*child);
    if (const std::string text = description(child->asked); !text.empty()) properties[name]["description"] = text;
  }
  return properties;
}

Json object_of(const KeyNode& node) {
  Json out{{"type", "object"}};
  if (node.below.empty()) return out;
  out["properties"] = properties_of(node);
  out["additionalProperties"] = false;
  return out;
}

/// An element of `sensors`, `maps`, … : the keys of the host and those of its plugin.
class PluginChoice {
 public:
  PluginChoice(std::string kind, const KeyNode* of_host) : kind_(std::move(kind)), of_host_(of_host) {}

  /// Adds the plugins' definitions. `needs_plugin`: false for sensors, which a map may use without one.
  Json element(const std::vector<PluginKeys>& plugins, bool needs_plugin, Json& definitions) const {
    Json names = Json::array();
    Json cases = Json::array();
    for (const PluginKeys& plugin : plugins) {
      if (plugin.kind != kind_) continue;
      names.push_back(plugin.name);
      const std::string name = fmt::format("{}.{}", kind_, plugin.name);
      definitions[name] = object(properties(plugin.keys));
      cases.push_back({{"if", {{"properties", {{"plugin", {{"const", plugin.name}}}}}, {"required", {"plugin"}}}},
                       {"then", {{"$ref", "#/definitions/" + name}}}});
    }
    Json out{{"type", "object"}};
    out["properties"] = {
        {"plugin",
         {{"anyOf", {{{"enum", names}}, variable()}}, {"description", "name of a plugin that is installed"}}}};
    if (needs_plugin) {
      out["required"] = {"plugin"};
    } else {
      cases.push_back({{"if", {{"not", {{"required", {"plugin"}}}}}}, {"then", object(properties({}))}});
    }
    out["allOf"] = cases;
    return out;
  }

  /// The keys of the host and of one plugin.
  Json properties(const std::vector<DescribedKey>& keys) const {
    Json all = of_host_ == nullptr ? Json::object() : properties_of(*of_host_);
    const Json of_plugin = properties_of(tree_of(keys));
    for (const auto& [name, value] : of_plugin.items()) {
      // What the plugin only looked for, the host has declared.
      if (!all.contains(name) || value.contains("description")) all[name] = value;
    }
    all["plugin"] = Json::object();
    return all;
  }

  static Json object(const Json& properties) {
    return {{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  }

 private:
  std::string kind_;
  const KeyNode* of_host_;
};

}  // namespace

std::string config_schema(const std::vector<DescribedKey>& robot, const std::vector<PluginKeys>& plugins) {
  const KeyNode root = tree_of(robot);
  Json out{{"$schema", "http://json-schema.org/draft-07/schema#"},
           {"title", "waymark configuration"},
           {"description", "Written by `waymark schema`."}};
  Json properties = properties_of(root);
  Json definitions = Json::object();
  const auto element_of = [&](const char* key) -> const KeyNode* {
    const KeyNode* list = root.find(key);
    return list == nullptr ? nullptr : list->find("[]");
  };
  const auto put = [&](const char* key, Json value) {
    const std::string text = properties.contains(key) ? properties[key].value("description", "") : "";
    properties[key] = std::move(value);
    if (!text.empty()) properties[key]["description"] = text;
  };
  const auto list_of = [](Json element) { return Json{{"type", "array"}, {"items", std::move(element)}}; };
  put("sensors", list_of(PluginChoice("sensor", element_of("sensors")).element(plugins, false, definitions)));
  put("maps", list_of(PluginChoice("map_module", element_of("maps")).element(plugins, true, definitions)));
  put("sinks", list_of(PluginChoice("sink", element_of("sinks")).element(plugins, true, definitions)));
  definitions["source"] = PluginChoice("source", root.find("source")).element(plugins, true, definitions);
  put("source", {{"$ref", "#/definitions/source"}});
  put("sources", list_of({{"$ref", "#/definitions/source"}}));
  for (const PluginKeys& plugin : plugins) {
    if (plugin.kind == "sink" && plugin.name == "recorder")
      put("record", PluginChoice::object(PluginChoice("sink", nullptr).properties(plugin.keys)));
  }
  properties["variables"] = {{"type", "object"},
                             {"description", "values that `${name}` stands for; --set variables.name=… changes one"}};
  out["type"] = "object";
  out["properties"] = properties;
  out["additionalProperties"] = false;
  out["definitions"] = definitions;
  return out.dump(1) + '\n';
}

}  // namespace waymark::command
