// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeindex>
#include <utility>
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

/// An enum with enumerators from 0 to the one that `last_of`, found beside the enum, returns:
///
///     enum class Colour { red, green };
///     constexpr Colour last_of(Colour) { return Colour::green; }
template <class T>
concept BoundedEnum = std::is_enum_v<T> && requires(T value) {
  { last_of(value) } -> std::same_as<T>;
};

/// What is written as its bytes: each value has one representation, without padding.
template <class T>
concept PlainValue = std::is_arithmetic_v<T> ||
    (std::is_trivially_copyable_v<T>&& std::has_unique_object_representations_v<T>);

/// A versioned binary stream for checkpoints, little endian. Shared objects are written once and are shared again after
/// loading. Equal objects give equal bytes.
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
  requires std::is_arithmetic_v<T> || BoundedEnum<T>
  void value(const T& v) { bytes(&v, sizeof v); }
  /// A number that `InArchive::within` reads.
  template <class T>
  requires std::is_arithmetic_v<T>
  void within(const T& v, std::type_identity_t<T> /*low*/, std::type_identity_t<T> /*high*/) { value(v); }
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
  template <PlainValue T>
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

/// The reading side of `OutArchive`. What it reads may be damaged: every call throws DataError if the stream ends
/// early, a section does not fit, a truth value is neither 0 nor 1, an enum or a number lies outside of its range, a
/// number is not finite, or a rotation has not length 1. No length takes more memory than the stream has content.
class WAYMARK_API InArchive {
 public:
  static constexpr bool kReads = true;

  explicit InArchive(std::istream& stream);

  /// Reads all fields, as `OutArchive` wrote them.
  template <class... Fields>
  void operator()(Fields&... fields) {
    (field(fields), ...);
  }

  /// As `OutArchive::each`.
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
  requires std::is_integral_v<T>
  void value(T& v) { bytes(&v, sizeof v); }
  template <class T>
  requires std::is_floating_point_v<T>
  void value(T& v) {
    bytes(&v, sizeof v);
    if (!std::isfinite(v)) fail("a number is not finite");
  }
  template <BoundedEnum T>
  void value(T& v) {
    using Number = std::underlying_type_t<T>;
    Number number{};
    bytes(&number, sizeof number);
    if (std::cmp_less(number, 0) || number > static_cast<Number>(last_of(T{}))) fail("an enum has no such value");
    v = static_cast<T>(number);
  }
  void value(bool& v) {
    std::uint8_t byte = 0;
    value(byte);
    if (byte > 1) fail("a truth value is neither 0 nor 1");
    v = byte == 1;
  }
  /// A number in [low, high], for counts and indices.
  template <class T>
  requires std::is_arithmetic_v<T>
  void within(T& v, std::type_identity_t<T> low, std::type_identity_t<T> high) {
    value(v);
    if (v < low || v > high) fail("a number lies outside of its range");
  }
  void value(std::string& text) { elements(text); }
  void value(Time& time) { time = Time{duration()}; }
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
    const std::uint64_t size = static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(cols);
    if (R == Eigen::Dynamic || C == Eigen::Dynamic) require_left(size, sizeof(T));
    m.resize(rows, cols);
    bytes(m.data(), sizeof(T) * size);
    if (!m.allFinite()) fail("a matrix is not finite");
  }
  template <PlainValue T>
  void values(std::vector<T>& v) {
    elements(v);
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::ranges::all_of(v, [](T number) { return std::isfinite(number); })) fail("a number is not finite");
    }
  }

  /// Reads the number of a shared object into `number` and returns the object, or null if it is not loaded yet: its
  /// content follows, and `remember` must be called with it. Throws DataError if that object is of another type, or is
  /// still being read, and so would be a part of itself.
  template <class T>
  std::shared_ptr<T> shared(std::uint64_t& number) {
    return std::static_pointer_cast<T>(shared_of(typeid(T), number));
  }
  template <class T>
  void remember(std::uint64_t number, std::shared_ptr<T> object) {
    objects_.at(static_cast<std::size_t>(number)) = {typeid(T), std::move(object)};
  }

 private:
  /// Differences of stamps within this are not overflow: 146 years.
  static constexpr std::int64_t kMostNanoseconds = std::int64_t{1} << 62;
  static constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();

  struct Object {
    std::type_index type = typeid(void);
    std::shared_ptr<void> object;
  };

  Duration duration() {
    Duration::rep count = 0;
    value(count);
    if (count < -kMostNanoseconds || count > kMostNanoseconds) fail("a time lies outside of the range of stamps");
    return Duration{count};
  }
  /// A count and so many elements as bytes, piece by piece, since not every stream knows its length.
  template <class Elements>
  void elements(Elements& v) {
    using T = typename Elements::value_type;
    constexpr std::size_t kPiece = std::max<std::size_t>(1, (std::size_t{1} << 16) / sizeof(T));
    std::size_t rest = count(sizeof(T));
    v.clear();
    while (rest > 0) {
      const std::size_t piece = std::min(rest, kPiece);
      v.resize(v.size() + piece);
      bytes(v.data() + (v.size() - piece), sizeof(T) * piece);
      rest -= piece;
    }
  }
  std::shared_ptr<void> shared_of(std::type_index type, std::uint64_t& number);
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
  void field(Duration& given) { given = duration(); }
  void field(std::optional<Time>& time) { value(time); }
  void field(Eigen::Quaterniond& q) {
    value(q.coeffs());
    if (!(std::abs(q.squaredNorm() - 1.0) < 1e-4)) fail("a rotation has not length 1");
  }
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
  /// The number of elements that follow, each of `element_size` bytes or more.
  std::size_t count(std::size_t element_size);
  void require_left(std::uint64_t elements, std::size_t element_size) const;

  std::istream& stream_;
  std::uint64_t left_ = kUnknown;  // bytes of the stream, if it has an end
  std::vector<Object> objects_;    // by number
};

}  // namespace waymark
