// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::magnetic_model {

/// The instrument behind a magnetic heading: one reading must not count twice.
inline constexpr SensorTraits::Instrument kMagnetometer{"a magnetometer", "set own_magnetometer: true"};

/// The Earth's magnetic field as far as the YAML or the model gives it.
struct Field {
  double declination = 0.0;            ///< east positive [rad]
  std::optional<double> strength_t{};  ///< of the model only
  std::optional<double> dip{};         ///< below the horizon positive [rad]
};

/// Declination, and with the model strength and dip, at the place of the map and the time of a measurement.
class EarthField {
 public:
  /// Reads `declination`, `declination_deg` and `magnetic_model`. With a `fallback` [deg] all may be absent, else one
  /// of the first two must be there. Throws ConfigError.
  explicit EarthField(const Config& config, std::optional<double> fallback = std::nullopt);

  /// The field there and then. The stamp is taken as UTC, and the field as constant over that day. Throws DataError
  /// without datum or outside of the model's time, if the model is asked.
  const Field& at(Time stamp, const Datum* datum);
  /// The same without keeping it for the next call.
  Field at(Time stamp, const Datum* datum) const;

  bool uses_model() const { return model_ != nullptr; }
  /// The headings count from true north, so no magnetometer makes them.
  bool from_true_north() const { return from_true_north_; }

  class Model;

 private:
  std::shared_ptr<const Model> model_;  // null: the declination is given
  bool from_true_north_ = false;
  Field field_;
  std::optional<Time> day_;  // for which field_ holds
  Datum place_;
};

/// The year with its fraction: 2025.5 is the middle of 2025.
double decimal_year(Time utc);

}  // namespace waymark::magnetic_model
