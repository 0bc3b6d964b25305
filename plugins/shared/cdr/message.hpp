// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"
#include "plugins/shared/cdr/wire_writer.hpp"

/// Messages of ROS as plain structs. Each lists its fields once, in the order of its definition, for reading, writing
/// and its definition's text:
///
///     struct Vector3 {
///       static constexpr std::string_view kType = "geometry_msgs/msg/Vector3";
///       double x = 0.0;
///       double y = 0.0;
///       double z = 0.0;
///
///       template <class Self, class Visitor>
///       static void list_fields(Self& self, Visitor&& field) {
///         field("x", self.x);
///         field("y", self.y);
///         field("z", self.z);
///       }
///     };
namespace waymark::ros {

namespace detail {

struct AnyFieldVisitor {
  template <class T>
  void operator()(std::string_view name, const T& value) const;
};

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};

template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};

}  // namespace detail

/// A struct with a name and fields.
template <class T>
concept Message = requires(const T& message, detail::AnyFieldVisitor visitor) {
  { T::kType } -> std::convertible_to<std::string_view>;
  T::list_fields(message, visitor);
};

/// Bytes that a T takes at least, however it is aligned.
template <class T>
std::size_t least_size() {
  if constexpr (std::is_same_v<T, bool>) {
    return 1;
  } else if constexpr (WireNumber<T>) {
    return sizeof(T);
  } else if constexpr (detail::IsArray<T>::value) {
    return std::tuple_size_v<T> * least_size<typename T::value_type>();
  } else if constexpr (Message<T>) {
    static const std::size_t size = [] {
      std::size_t sum = 0;
      const T message;
      T::list_fields(message, [&](std::string_view, const auto& field) {
        sum += least_size<std::remove_cvref_t<decltype(field)>>();
      });
      return sum;
    }();
    return size;
  } else {
    return sizeof(std::uint32_t);  // the count of a text or a list
  }
}

/// A header of ROS 1 begins with a number that ROS 2 does not have.
inline constexpr std::string_view kHeaderType = "std_msgs/msg/Header";

/// Reads a field or a whole message. Throws Unusable.
template <class T>
void read(WireReader& in, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = in.value<std::uint8_t>() != 0;
  } else if constexpr (WireNumber<T>) {
    value = in.value<T>();
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = in.text();
  } else if constexpr (detail::IsArray<T>::value) {
    if constexpr (WireNumber<typename T::value_type>) {
      in.values(std::span<typename T::value_type>(value));
    } else {
      for (auto& element : value) read(in, element);
    }
  } else if constexpr (detail::IsVector<T>::value) {
    value.resize(in.count(least_size<typename T::value_type>()));
    if constexpr (WireNumber<typename T::value_type>) {
      in.values(std::span<typename T::value_type>(value));
    } else {
      for (auto& element : value) read(in, element);
    }
  } else {
    static_assert(Message<T>);
    if constexpr (T::kType == kHeaderType) {
      if (!in.is_cdr()) in.value<std::uint32_t>();
    }
    T::list_fields(value, [&](std::string_view, auto& field) { read(in, field); });
  }
}

/// Writes a field or a whole message.
template <class T>
void write(WireWriter& out, const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    out.value(static_cast<std::uint8_t>(value));
  } else if constexpr (WireNumber<T>) {
    out.value(value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    out.text(value);
  } else if constexpr (detail::IsArray<T>::value || detail::IsVector<T>::value) {
    using Element = typename T::value_type;
    if constexpr (detail::IsVector<T>::value) out.count(value.size());
    if constexpr (WireNumber<Element>) {
      out.values(std::span<const Element>(value));
    } else {
      for (const auto& element : value) write(out, element);
    }
  } else {
    static_assert(Message<T>);
    T::list_fields(value, [&](std::string_view, const auto& field) { write(out, field); });
  }
}

/// Writers pad a message to a multiple of 4 bytes; more than that left over is another definition.
inline constexpr std::size_t kMostPadding = 3;

/// Throws Unusable if more is left than padding.
void require_end(const WireReader& in, std::string_view type);

/// A message as CDR with its encapsulation header, as DDS, MCAP and bags of ROS 2 carry it.
template <Message T>
std::vector<std::uint8_t> to_cdr(const T& message) {
  WireWriter out;
  write(out, message);
  return out.take();
}

/// Reads a message. Throws Unusable if the bytes are not exactly such a message.
template <Message T>
T from_cdr(Bytes bytes) {
  WireReader in = WireReader::cdr(bytes);
  T message;
  read(in, message);
  require_end(in, T::kType);
  return message;
}

/// The same for a message of ROS 1.
template <Message T>
T from_ros1(Bytes bytes) {
  WireReader in(bytes);
  T message;
  read(in, message);
  require_end(in, T::kType);
  return message;
}

}  // namespace waymark::ros
