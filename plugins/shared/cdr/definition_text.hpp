// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/message.hpp"

/// Definitions of messages as MCAP's encoding `ros2msg` has them: the fields of the message, then, behind lines of 80
/// `=`, those of each type used in it.
namespace waymark::ros {

/// Types with the lines of their fields, the outermost first.
using DefinitionParts = std::vector<std::pair<std::string, std::string>>;

/// "geometry_msgs/Pose" of "geometry_msgs/msg/Pose", as definitions name it.
std::string short_message_name(std::string_view type);

/// The parts as one text.
std::string join_definition(const DefinitionParts& parts);

namespace detail {

template <class T>
std::string field_type() {
  if constexpr (std::is_same_v<T, bool>) {
    return "bool";
  } else if constexpr (std::is_same_v<T, std::byte>) {
    return "byte";
  } else if constexpr (std::is_floating_point_v<T>) {
    return "float" + std::to_string(8 * sizeof(T));
  } else if constexpr (std::is_integral_v<T>) {
    return (std::is_signed_v<T> ? "int" : "uint") + std::to_string(8 * sizeof(T));
  } else if constexpr (std::is_same_v<T, std::string>) {
    return "string";
  } else if constexpr (IsArray<T>::value) {
    return field_type<typename T::value_type>() + "[" + std::to_string(std::tuple_size_v<T>) + "]";
  } else if constexpr (IsVector<T>::value) {
    return field_type<typename T::value_type>() + "[]";
  } else {
    static_assert(Message<T>);
    return short_message_name(T::kType);
  }
}

template <class T>
void add_definition(DefinitionParts& parts) {
  if constexpr (IsArray<T>::value || IsVector<T>::value) {
    add_definition<typename T::value_type>(parts);
  } else if constexpr (Message<T>) {
    std::string name = short_message_name(T::kType);
    if (std::ranges::find(parts, name, &DefinitionParts::value_type::first) != parts.end()) return;
    std::string lines;
    const T message;
    T::list_fields(message, [&](std::string_view field, const auto& value) {
      lines += field_type<std::remove_cvref_t<decltype(value)>>() + " " + std::string(field) + "\n";
    });
    parts.emplace_back(std::move(name), std::move(lines));
    T::list_fields(message, [&](std::string_view, const auto& value) {
      add_definition<std::remove_cvref_t<decltype(value)>>(parts);
    });
  }
}

}  // namespace detail

/// The definition of a message.
template <Message T>
std::string definition_text() {
  DefinitionParts parts;
  detail::add_definition<T>(parts);
  return join_definition(parts);
}

}  // namespace waymark::ros
