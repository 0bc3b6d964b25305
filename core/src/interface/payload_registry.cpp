// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/payload_registry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <tuple>

#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark {
namespace {

struct Registered {
  std::mutex mutex;
  std::map<std::string_view, KnownPayload> by_type;
};

// Never destroyed: a plugin's objects may outlive what is static here.
Registered& registered() {
  static auto& payloads = *new Registered;
  return payloads;
}

bool is_versioned_name(std::string_view type) {
  const auto slash = type.find('/');
  const auto at = type.find('@');
  return slash > 0 && slash != std::string_view::npos && at != std::string_view::npos && at > slash + 1 &&
         at + 1 < type.size();
}

std::string names_and_kinds(const KnownPayload& payload) {
  std::string text;
  for (const FieldDescription& field : payload.describe())
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", field.name, field.kind);
  return text;
}

}  // namespace

bool is_of_core(std::string_view payload_type) {
  return std::apply([&]<class... P>(const P&...) { return ((payload_type == P::kType) || ...); }, CorePayloads());
}

void register_payload(const KnownPayload& payload) {
  if (!is_versioned_name(payload.type))
    throw Error(fmt::format("\"{}\" is no name of a payload; \"vendor/Name@1\" is expected", payload.type));
  if (is_of_core(payload.type))
    throw Error(fmt::format("{} is a payload of core; a plugin's own has another vendor", payload.type));
  Registered& all = registered();
  const std::lock_guard lock(all.mutex);
  const auto [known, is_new] = all.by_type.emplace(payload.type, payload);
  if (is_new) return;
  const std::string before = names_and_kinds(known->second);
  const std::string now = names_and_kinds(payload);
  if (before != now) {
    throw Error(
        fmt::format("{} is registered with the fields {}, and again with {}; a payload whose fields change is "
                    "another version",
                    payload.type, before, now));
  }
}

std::vector<KnownPayload> known_payloads() {
  std::vector<KnownPayload> all;
  std::apply(
      [&]<class... P>(const P&...) {
        (all.push_back(
             {P::kType, []() -> std::shared_ptr<Payload> { return std::make_shared<P>(); }, &describe_fields<P>}),
         ...);
      },
      CorePayloads());
  Registered& own = registered();
  const std::lock_guard lock(own.mutex);
  for (const auto& [type, payload] : own.by_type) all.push_back(payload);
  return all;
}

std::string_view find_payload_type(std::string_view name) {
  const std::vector<KnownPayload> all = known_payloads();
  const auto is_named = [&](const KnownPayload& payload) { return payload.type == name; };
  const auto is_short = [&](const KnownPayload& payload) { return short_type_name(payload.type) == name; };
  auto found = std::ranges::find_if(all, is_named);
  if (found == all.end()) found = std::ranges::find_if(all, is_short);
  return found == all.end() ? std::string_view() : found->type;
}

std::shared_ptr<Payload> make_payload(std::string_view type) {
  std::shared_ptr<Payload> made;
  const auto make_if_named = [&]<class T>(const T&) {
    if (type == T::kType) made = std::make_shared<T>();
  };
  std::apply([&](const auto&... payload) { (make_if_named(payload), ...); }, CorePayloads());
  if (made) return made;
  Registered& own = registered();
  const std::lock_guard lock(own.mutex);
  const auto found = own.by_type.find(type);
  return found == own.by_type.end() ? nullptr : found->second.make();
}

}  // namespace waymark
