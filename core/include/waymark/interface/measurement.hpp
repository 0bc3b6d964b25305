// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/payload_edit.hpp"
#include "waymark/interface/payload_field.hpp"

namespace waymark {

/// Content of a measurement: a plain struct that derives from `PayloadOf<Itself>`, with a versioned name `static
/// constexpr std::string_view kType = "vendor/Name@1"`. It registers its fields with `fields` (payload_field.hpp);
/// without them it is opaque to checks and formats. A rule over several fields is a member `std::string_view
/// contradiction() const`, which returns the violation, or an empty text. A plugin may define its own payloads.
class WAYMARK_TYPE Payload {
 public:
  virtual ~Payload() = default;
  /// The versioned name, "waymark/LaserScan@1".
  virtual std::string_view type() const = 0;
  /// Passes all registered fields to `visitor`; false if none are registered.
  virtual bool visit(FieldVisitor& visitor) const = 0;
  /// Passes the places of all registered fields to `editor`; false if none are registered. What was set should be
  /// checked with `problem`.
  virtual bool edit(FieldEditor& editor) = 0;
  /// The first invalid value, as a text for users; empty if there is none. Checks every registered field (finite, or
  /// unknown where allowed, and within its limit), then the rule over several fields.
  WAYMARK_API std::string problem() const;

 protected:
  /// The violated rule over several fields, as a text for users; empty if there is none. `PayloadOf` implements it with
  /// `contradiction`.
  virtual std::string_view broken_rule() const = 0;
};

/// Base class of payload T. Implements `Payload` with `T::kType`, `T::fields` and `T::contradiction`.
template <class T>
struct PayloadOf : Payload {
  std::string_view type() const final { return T::kType; }
  bool visit(FieldVisitor& visitor) const final {
    if constexpr (HasFields<T>) visit_fields(static_cast<const T&>(*this), visitor);
    return HasFields<T>;
  }
  bool edit(FieldEditor& editor) final {
    if constexpr (HasFields<T>) edit_fields(static_cast<T&>(*this), editor);
    return HasFields<T>;
  }

 protected:
  std::string_view broken_rule() const final {
    if constexpr (requires(const T& payload) { payload.contradiction(); }) {
      return static_cast<const T&>(*this).contradiction();
    }
    return {};
  }
};

/// "LaserScan" of "waymark/LaserScan@1".
constexpr std::string_view short_type_name(std::string_view payload_type) {
  payload_type.remove_prefix(payload_type.find('/') + 1);
  return payload_type.substr(0, payload_type.find('@'));
}

/// Stamp of a live measurement whose sensor reports no time: the host replaces it by the arrival.
inline constexpr Time kUnknownStamp = Time::min();

/// One reading of one sensor.
struct WAYMARK_API Measurement {
  Time stamp{};                ///< time at which it was valid
  Time arrival{};              ///< time at which it became available; "now" is the newest arrival, never a clock
  std::uint32_t sensor = 0;    ///< index of the source's channel; in the host: of the sensor in the rig
  std::uint64_t sequence = 0;  ///< counts the measurements of the source; breaks ties of equal stamps
  std::shared_ptr<const Payload> payload;  ///< never null

  /// The payload as T. Throws DataError naming both types if it is not a T.
  template <class T>
  const T& as() const {
    if (payload->type() != T::kType) throw_wrong_type(T::kType);
    return static_cast<const T&>(*payload);
  }

 private:
  [[noreturn]] void throw_wrong_type(std::string_view expected) const;
};

}  // namespace waymark
