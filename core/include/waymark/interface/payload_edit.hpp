// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/payload_field.hpp"

/// Sets the registered fields of a payload, the inverse of `visit_fields`: for formats that read payloads.
namespace waymark {

/// Place of an enum's value.
struct WordSlot {
  void* value;
  void (*assign)(void* value, int number);  ///< `number` is an index of `FieldInfo::words`
};

/// Place of a field's value, of the same kind as `FieldValue`.
using FieldSlot = std::variant<std::span<double>, int*, bool*, WordSlot, std::vector<float>*,
                               std::vector<Eigen::Vector3f>*, std::vector<std::uint8_t>*>;

/// Sets the fields of any payload, also of one defined by a plugin, in the order in which they are registered. A field
/// that it leaves alone keeps its value. Slots are valid during the call.
class WAYMARK_TYPE FieldEditor {
 public:
  virtual ~FieldEditor() = default;
  virtual void field(const FieldInfo& info, const FieldSlot& slot) = 0;
  /// Returns the size that a list of elements with fields of their own gets. For each element follow `element`, then
  /// its fields.
  virtual std::size_t list(const FieldInfo& info) = 0;
  virtual void element(std::size_t /*index*/) {}
};

template <HasFields T>
void edit_fields(T& object, FieldEditor& editor);

namespace field_detail {

inline void edit(double& value, const FieldInfo& info, FieldEditor& editor) {
  editor.field(info, std::span<double>(&value, 1));
}
inline void edit(int& value, const FieldInfo& info, FieldEditor& editor) { editor.field(info, &value); }
inline void edit(bool& value, const FieldInfo& info, FieldEditor& editor) { editor.field(info, &value); }
template <class Enum>
requires std::is_enum_v<Enum>
void edit(Enum& value, const FieldInfo& info, FieldEditor& editor) {
  const auto assign = [](void* enum_value, int number) { *static_cast<Enum*>(enum_value) = static_cast<Enum>(number); };
  editor.field(info, WordSlot{&value, assign});
}
inline void edit(Eigen::Vector3d& value, const FieldInfo& info, FieldEditor& editor) {
  editor.field(info, std::span<double>(value.data(), 3));
}
inline void edit(Eigen::Quaterniond& q, const FieldInfo& info, FieldEditor& editor) {
  std::array<double, 4> value{q.w(), q.x(), q.y(), q.z()};
  editor.field(info, std::span<double>(value));
  q = Eigen::Quaterniond(value[0], value[1], value[2], value[3]);
}
template <class T>
void edit(std::vector<T>& values, const FieldInfo& info, FieldEditor& editor) {
  if constexpr (HasFields<T>) {
    values.resize(editor.list(info));
    for (std::size_t i = 0; i < values.size(); ++i) {
      editor.element(i);
      edit_fields(values[i], editor);
    }
  } else {
    editor.field(info, &values);
  }
}

}  // namespace field_detail

/// Passes the places of all fields of `object` to `editor`, in the order in which they are registered.
template <HasFields T>
void edit_fields(T& object, FieldEditor& editor) {
  T::fields([&](auto member, const FieldInfo& info) { field_detail::edit(object.*member, info, editor); });
}

}  // namespace waymark
