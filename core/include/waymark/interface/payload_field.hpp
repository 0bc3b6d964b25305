// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "waymark/base/api.hpp"

/// The fields of a payload, registered once in the struct, for checks, reference pages and text formats.
///
///     template <class Visitor>
///     static void fields(Visitor&& field) {
///       field(&Height::height_m, {.names = {"height_m"}, .unit = "m", .meaning = "height above the ground"});
///       field(&Height::sigma_m, {.names = {"sigma_m"}, .unit = "m", .meaning = "its σ", .required = false, .unknown =
///       "NaN"});
///     }
namespace waymark {

/// Properties of one field: a number, vector, quaternion, enum, flag, or a list.
struct FieldInfo {
  /// Names in text formats: one, or one for each number of a vector (x, y, z) or quaternion (w, x, y, z).
  std::array<std::string_view, 4> names;
  std::string_view unit = {};     ///< "m/s"; empty: none
  std::string_view meaning = {};  ///< for reference pages
  bool required = true;           ///< text formats must contain it; otherwise it may keep its default
  /// The value that means "not known", for reference pages: "NaN", "-1". Empty: the value is always known, and finite.
  std::string_view unknown = {};
  bool separable = false;                        ///< of a vector: some of its numbers may be known without the others
  double limit = 0.0;                            ///< > 0: largest valid magnitude
  std::span<const std::string_view> words = {};  ///< of an enum, in the order of its values 0, 1, …

  std::string_view name() const { return names.front(); }
};

/// A value of an enum.
struct FieldWord {
  int number;
  std::string_view word;
};

/// Value of a field. Numbers, vectors and quaternions are lists of numbers, in the order of their names.
using FieldValue = std::variant<std::span<const double>, std::int64_t, bool, FieldWord, std::span<const float>,
                                std::span<const Eigen::Vector3f>, std::span<const std::uint8_t>>;

/// Visits the fields of any payload, also of one defined by a plugin. Spans are valid during the call.
class WAYMARK_TYPE FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;
  /// One field with its value.
  virtual void field(const FieldInfo& info, const FieldValue& value) = 0;
  /// A list of `size` elements with fields of their own. They follow: for each element `element`, then its fields.
  virtual void list(const FieldInfo&, std::size_t /*size*/) {}
  virtual void element(std::size_t /*index*/) {}
};

namespace field_detail {

struct AnyVisitor {
  template <class Member>
  void operator()(Member member, const FieldInfo& info) const;
};

}  // namespace field_detail

/// True if T registers fields.
template <class T>
concept HasFields = requires(field_detail::AnyVisitor visitor) {
  T::fields(visitor);
};

template <HasFields T>
void visit_fields(const T& object, FieldVisitor& visitor);

namespace field_detail {

inline void visit(double value, const FieldInfo& info, FieldVisitor& visitor) {
  visitor.field(info, std::span<const double>(&value, 1));
}
inline void visit(int value, const FieldInfo& info, FieldVisitor& visitor) { visitor.field(info, std::int64_t{value}); }
inline void visit(bool value, const FieldInfo& info, FieldVisitor& visitor) { visitor.field(info, value); }
template <class Enum>
requires std::is_enum_v<Enum>
void visit(Enum value, const FieldInfo& info, FieldVisitor& visitor) {
  const auto number = static_cast<std::size_t>(value);
  const bool known = number < info.words.size();
  visitor.field(info, FieldWord{static_cast<int>(value), known ? info.words[number] : std::string_view()});
}
inline void visit(const Eigen::Vector3d& value, const FieldInfo& info, FieldVisitor& visitor) {
  visitor.field(info, std::span<const double>(value.data(), 3));
}
inline void visit(const Eigen::Quaterniond& q, const FieldInfo& info, FieldVisitor& visitor) {
  const std::array<double, 4> value{q.w(), q.x(), q.y(), q.z()};
  visitor.field(info, std::span<const double>(value));
}
template <class T>
void visit(const std::vector<T>& values, const FieldInfo& info, FieldVisitor& visitor) {
  if constexpr (HasFields<T>) {
    visitor.list(info, values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      visitor.element(i);
      visit_fields(values[i], visitor);
    }
  } else {
    visitor.field(info, std::span<const T>(values));
  }
}

}  // namespace field_detail

/// Passes all fields of `object` to `visitor`, in the order in which they are registered.
template <HasFields T>
void visit_fields(const T& object, FieldVisitor& visitor) {
  T::fields([&](auto member, const FieldInfo& info) { field_detail::visit(object.*member, info, visitor); });
}

}  // namespace waymark
