// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <istream>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"

namespace waymark {

/// A class that lists its fields once, for writing and for reading:
///
///     template <class Archive>
///     void serialize(Archive& archive) {
///       archive.section("inflation", 1);
///       archive(last_, usual_s_, left_);
///     }
///
/// `Archive::kReads` is the direction, if reading must check or convert. Writing must not change the object.
template <class T, class Archive>
concept Serializable = requires(T& object, Archive& archive) {
  object.serialize(archive);
};

/// A versioned binary stream for checkpoints, little endian. Shared objects are written once and are shared again after
/// loading.
class WAYMARK_API OutArchive {
 public:
  static constexpr bool kReads = false;

  explicit OutArchive(std::ostream& stream) : stream_(stream) {}

  /// Writes all fields in order: numbers, enums, times, texts, matrices, quaternions, `std::optional`, `std::vector`
  /// and `std::array` of these, and objects that have `serialize`, or `save` and `load`.
  template <class... Fields>
  void operator()(const Fields&... fields) {
    (field(fields), ...);
  }

  /// A list whose elements `fields(archive, element)` lists, for both directions.
  template <class Objects, class Fields>
  void each(Objects& objects, const Fields& fields) {
    value(static_cast<std::uint64_t>(objects.size()));
    for (auto& object : objects) fields(*this, object);
  }

  /// Opens a section: what follows belongs to `name` in this version, which is returned.
  std::uint32_t section(std::string_view name, std::uint32_t version);
  void bytes(const void* data, std::size_t size);

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void value(const T& v) { bytes(&v, sizeof v); }
  void value(std::string_view text) {
    value(static_cast<std::uint64_t>(text.size()));
    bytes(text.data(), text.size());
  }
  void value(Time time) { value(time.time_since_epoch().count()); }
  void value(const std::optional<Time>& time) {
    value(time.has_value());
    value(time.value_or(Time{}));
  }
  template <class T, int R, int C, int O, int MR, int MC>
  void value(const Eigen::Matrix<T, R, C, O, MR, MC>& m) {
    value(static_cast<std::int32_t>(m.rows()));
    value(static_cast<std::int32_t>(m.cols()));
    bytes(m.data(), sizeof(T) * static_cast<std::size_t>(m.size()));
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void values(const std::vector<T>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    bytes(v.data(), sizeof(T) * v.size());
  }

  /// Writes the number of `object`. True at its first call for this object: its content must follow.
  bool first_sight(const void* object);

 private:
  template <class T>
  void field(const T& object) {
    if constexpr (Serializable<T, OutArchive>) {
      // One list for both directions; writing changes nothing.
      const_cast<T&>(object).serialize(*this);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    } else if constexpr (requires { object.save(*this); }) {
      object.save(*this);
    } else {
      value(object);
    }
  }
  void field(Duration duration) { value(duration.count()); }
  void field(const std::optional<Time>& time) { value(time); }
  void field(const Eigen::Quaterniond& q) { value(q.coeffs()); }
  template <class T>
  void field(const std::optional<T>& object) {
    value(object.has_value());
    if (object) field(*object);
  }
  template <class T>
  void field(const std::vector<T>& objects) {
    if constexpr (std::is_arithmetic_v<T>) {
      values(objects);
    } else {
      value(static_cast<std::uint64_t>(objects.size()));
      for (const T& object : objects) field(object);
    }
  }
  template <class T, std::size_t N>
  void field(const std::array<T, N>& objects) {
    for (const T& object : objects) field(object);
  }

  std::ostream& stream_;
  std::map<const void*, std::uint64_t> seen_;
};

/// The reading side of `OutArchive`. Every call throws DataError if the stream ends early or a section does not fit.
class WAYMARK_API InArchive {
 public:
  static constexpr bool kReads = true;

  explicit InArchive(std::istream& stream) : stream_(stream) {}

  /// Reads all fields, as `OutArchive` wrote them.
  template <class... Fields>
  void operator()(Fields&... fields) {
    (field(fields), ...);
  }

  /// As `OutArchive::each`. Element by element, so that a damaged count takes no more memory than the stream has
  /// content.
  template <class Objects, class Fields>
  void each(Objects& objects, const Fields& fields) {
    const std::size_t size = count(1);
    objects.clear();
    for (std::size_t i = 0; i < size; ++i) fields(*this, objects.emplace_back());
  }

  /// Checks the section's name and returns its version; throws if the version is newer than `newest`.
  std::uint32_t section(std::string_view name, std::uint32_t newest);
  void bytes(void* data, std::size_t size);

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void value(T& v) { bytes(&v, sizeof v); }
  void value(std::string& text) {
    text.resize(count(1));
    bytes(text.data(), text.size());
  }
  void value(Time& time) {
    Duration::rep count = 0;
    value(count);
    time = Time{Duration{count}};
  }
  void value(std::optional<Time>& time) {
    bool known = false;
    Time stamp{};
    value(known);
    value(stamp);
    time = known ? std::optional(stamp) : std::nullopt;
  }
  template <class T, int R, int C, int O, int MR, int MC>
  void value(Eigen::Matrix<T, R, C, O, MR, MC>& m) {
    std::int32_t rows = 0;
    std::int32_t cols = 0;
    value(rows);
    value(cols);
    const bool fits = rows >= 0 && cols >= 0 &&
                      (R == Eigen::Dynamic ? (MR == Eigen::Dynamic || rows <= MR) : rows == R) &&
                      (C == Eigen::Dynamic ? (MC == Eigen::Dynamic || cols <= MC) : cols == C);
    if (!fits) fail("a matrix has another shape");
    m.resize(rows, cols);
    bytes(m.data(), sizeof(T) * static_cast<std::size_t>(m.size()));
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void values(std::vector<T>& v) {
    v.resize(count(sizeof(T)));
    bytes(v.data(), sizeof(T) * v.size());
  }

  /// Reads the number of a shared object into `number` and returns the object, or null if it is not loaded yet: its
  /// content follows, and `remember` must be called with it.
  std::shared_ptr<void> shared(std::uint64_t& number);
  void remember(std::uint64_t number, std::shared_ptr<void> object) { objects_[number] = std::move(object); }

 private:
  template <class T>
  void field(T& object) {
    if constexpr (Serializable<T, InArchive>) {
      object.serialize(*this);
    } else if constexpr (requires { object.load(*this); }) {
      object.load(*this);
    } else {
      value(object);
    }
  }
  void field(Duration& duration) {
    Duration::rep count = 0;
    value(count);
    duration = Duration{count};
  }
  void field(std::optional<Time>& time) { value(time); }
  void field(Eigen::Quaterniond& q) { value(q.coeffs()); }
  template <class T>
  void field(std::optional<T>& object) {
    bool known = false;
    value(known);
    object.reset();
    if (known) field(object.emplace());
  }
  template <class T>
  void field(std::vector<T>& objects) {
    if constexpr (std::is_arithmetic_v<T>) {
      values(objects);
    } else {
      // Element by element, so that a damaged count takes no more memory than the stream has content.
      const std::size_t size = count(1);
      objects.clear();
      for (std::size_t i = 0; i < size; ++i) field(objects.emplace_back());
    }
  }
  template <class T, std::size_t N>
  void field(std::array<T, N>& objects) {
    for (T& object : objects) field(object);
  }

  [[noreturn]] void fail(std::string_view what) const;
  std::size_t count(std::size_t element_size);

  std::istream& stream_;
  std::map<std::uint64_t, std::shared_ptr<void>> objects_;
};

}  // namespace waymark
