// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"

namespace waymark {

/// What a measurement carries. A payload is a plain struct that derives from `PayloadOf<Itself>` and has a versioned
/// name `static constexpr std::string_view kType = "vendor/Name@1"`. A plugin may bring its own.
class WAYMARK_TYPE Payload {
 public:
  virtual ~Payload() = default;
  virtual std::string_view type() const = 0;
};

template <class T>
struct PayloadOf : Payload {
  std::string_view type() const final { return T::kType; }
};

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
