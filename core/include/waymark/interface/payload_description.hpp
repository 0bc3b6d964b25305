// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "waymark/interface/payload_field.hpp"

namespace waymark {

/// Description of a field, for reference pages and schemas.
struct FieldDescription {
  std::string name;  ///< as text formats write it; of an element of a list, "landmarks[].range_m"
  std::string kind;  ///< "number", "integer", "true or false", "list of numbers", the words of an enum, …
  FieldInfo info;
};

namespace field_detail {

template <class Owner, class Member>
Member member_type(Member Owner::*);

template <class T>
std::string kind_of(const FieldInfo& info) {
  if constexpr (std::is_same_v<T, bool>) return "true or false";
  if constexpr (std::is_same_v<T, std::vector<float>>) return "list of numbers";
  if constexpr (std::is_same_v<T, std::vector<Eigen::Vector3f>>) return "list of points";
  if constexpr (std::is_same_v<T, std::vector<std::uint8_t>>) return "bytes";
  if constexpr (std::is_enum_v<T>) {
    std::string words;
    for (const std::string_view word : info.words) words += (words.empty() ? "" : ", ") + std::string(word);
    return words;
  }
  return std::is_integral_v<T> ? "integer" : "number";
}

template <class T>
constexpr bool kIsListOfFields = false;
template <HasFields T>
constexpr bool kIsListOfFields<std::vector<T>> = true;

}  // namespace field_detail

/// All fields of T, one for each name, in the order in which they are registered.
template <HasFields T>
std::vector<FieldDescription> describe_fields() {
  std::vector<FieldDescription> all;
  T::fields([&all](auto member, const FieldInfo& info) {
    using Member = decltype(field_detail::member_type(member));
    if constexpr (field_detail::kIsListOfFields<Member>) {
      all.push_back({std::string(info.name()), "list", info});
      for (FieldDescription& of_element : describe_fields<typename Member::value_type>()) {
        of_element.name = std::string(info.name()) + "[]." + of_element.name;
        all.push_back(std::move(of_element));
      }
    } else {
      for (const std::string_view name : info.names) {
        if (!name.empty()) all.push_back({std::string(name), field_detail::kind_of<Member>(info), info});
      }
    }
  });
  return all;
}

}  // namespace waymark
