// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "sentence.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::nmea {

/// All that the sentences of one time of day report.
class Epoch {
 public:
  /// The time of day that the sentence carries. Throws Unusable.
  static std::optional<Duration> time_of(const Sentence& sentence);
  /// True for the types that are read here.
  static bool reads(const Sentence& sentence);

  /// Takes what the sentence reports. Throws Unusable, and takes nothing of it then.
  void add(const Sentence& sentence);
  void set_heading(double degrees) { heading_deg_ = degrees; }

  std::optional<Duration> time_of_day;
  std::string place;                          ///< of the first sentence, "file:line"
  std::optional<std::chrono::sys_days> date;  ///< if one of the sentences has it

  /// True if the receiver reports that it has a fix.
  bool has_fix() const;
  /// The fix; null if no sentence has one. Throws Unusable if it has no position.
  std::shared_ptr<GnssFix> fix() const;
  /// The heading, or null.
  std::shared_ptr<CompassHeading> heading() const;

 private:
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  struct Position {
    double latitude_deg = kUnknown;
    double longitude_deg = kUnknown;
  };
  struct Gga {
    int quality = 0;
    std::optional<Position> position;
    double height_m = kUnknown;
    double hdop = kUnknown;
    int satellites = -1;
  };
  struct Motion {
    double speed_mps = kUnknown;
    double course_rad = kUnknown;
  };
  /// RMC and GLL: a position with the letter of the receiver's mode.
  struct Minimum {
    std::optional<Position> position;
    char mode = 0;
  };
  struct Sigmas {
    double horizontal_m = kUnknown;
    double vertical_m = kUnknown;
  };

  static std::optional<Position> position(const Sentence& sentence, std::size_t index);
  void add_gga(const Sentence& sentence);
  void add_rmc(const Sentence& sentence);
  void add_gll(const Sentence& sentence);
  void add_gst(const Sentence& sentence);
  void add_vtg(const Sentence& sentence);
  void add_zda(const Sentence& sentence);

  std::optional<Gga> gga_;
  std::optional<Minimum> rmc_;
  std::optional<Minimum> gll_;
  std::optional<Motion> rmc_motion_;
  std::optional<Motion> vtg_motion_;
  Sigmas sigmas_;
  std::optional<double> heading_deg_;
};

}  // namespace waymark::nmea
