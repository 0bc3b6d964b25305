// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/payload_field.hpp"

namespace waymark {

/// What a measurement carries. A payload is a plain struct that derives from `PayloadOf<Itself>` and has a versioned
/// name `static constexpr std::string_view kType = "vendor/Name@1"`. It registers its fields with `fields`
/// (payload_field.hpp); one that does not is opaque to checks and formats. A rule that several fields obey together is
/// a member `std::string_view contradiction() const`: what is wrong, or empty. A plugin may bring its own.
class WAYMARK_TYPE Payload {
 public:
  virtual ~Payload() = default;
  virtual std::string_view type() const = 0;
  /// Gives all registered fields to `visitor`; false if none are registered.
  virtual bool visit(FieldVisitor& visitor) const = 0;
  /// What is wrong with its values, for people; empty: nothing. Checks every field by what is registered of it (finite,
  /// or unknown where it may be, and within its limit), then the payload's own rule.
  WAYMARK_API std::string problem() const;

 protected:
  virtual std::string_view broken_rule() const = 0;
};

template <class T>
struct PayloadOf : Payload {
  std::string_view type() const final { return T::kType; }
  bool visit(FieldVisitor& visitor) const final {
    if constexpr (HasFields<T>) visit_fields(static_cast<const T&>(*this), visitor);
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

/// One reading of one sensor.
struct WAYMARK_API Measurement {
  Time stamp{};                ///< when it was true
  Time arrival{};              ///< when it became known; "now" is the newest arrival, never a clock
  std::uint32_t sensor = 0;    ///< a source fills in its channel; the host puts the sensor's index in the rig
  std::uint64_t sequence = 0;  ///< counts the measurements of the source; breaks ties of equal stamps
  std::shared_ptr<const Payload> payload;  ///< never null

  /// The payload as T. Throws DataError that names what is there and what was asked for.
  template <class T>
  const T& as() const {
    if (payload->type() != T::kType) throw_wrong_type(T::kType);
    return static_cast<const T&>(*payload);
  }

 private:
  [[noreturn]] void throw_wrong_type(std::string_view asked) const;
};

}  // namespace waymark
