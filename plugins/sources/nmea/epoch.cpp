// SPDX-License-Identifier: Apache-2.0
#include "epoch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace waymark::nmea {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kMpsPerKnot = 1852.0 / 3600.0;
constexpr double kMpsPerKmh = 1.0 / 3.6;

constexpr std::array<std::string_view, 7> kTypes = {"GGA", "RMC", "GLL", "GST", "VTG", "ZDA", "HDT"};

double radians(std::optional<double> degrees) {
  return degrees ? *degrees * kRadPerDeg : std::numeric_limits<double>::quiet_NaN();
}

GnssFix::Type type_of_quality(int quality) {
  using enum GnssFix::Type;
  switch (quality) {
    case 1:
    case 3:  // the military service, by itself
      return single;
    case 2:
      return differential;
    case 4:
      return rtk_fixed;
    case 5:
      return rtk_float;
    case 0:
    case 6:  // dead reckoning
    case 7:  // typed in by hand
      return none;
    default:
      return unknown;
  }
}

GnssFix::Type type_of_mode(char mode) {
  using enum GnssFix::Type;
  switch (mode) {
    case 'A':
    case 'P':
      return single;
    case 'D':
      return differential;
    case 'R':
      return rtk_fixed;
    case 'F':
      return rtk_float;
    case 'N':
    case 'E':
    case 'M':
      return none;
    default:
      return unknown;
  }
}

double root_mean_square(double a, double b) { return std::sqrt(0.5 * (a * a + b * b)); }

}  // namespace

bool Epoch::reads(const Sentence& sentence) { return std::ranges::find(kTypes, sentence.type) != kTypes.end(); }

std::optional<Duration> Epoch::time_of(const Sentence& sentence) {
  constexpr std::size_t kTimeOfGll = 4;
  if (sentence.type == "VTG" || sentence.type == "HDT") return std::nullopt;
  return sentence.time_of_day(sentence.type == "GLL" ? kTimeOfGll : 0);
}

void Epoch::add(const Sentence& sentence) {
  if (sentence.type == "GGA") add_gga(sentence);
  if (sentence.type == "RMC") add_rmc(sentence);
  if (sentence.type == "GLL") add_gll(sentence);
  if (sentence.type == "GST") add_gst(sentence);
  if (sentence.type == "VTG") add_vtg(sentence);
  if (sentence.type == "ZDA") add_zda(sentence);
}

std::optional<Epoch::Position> Epoch::position(const Sentence& sentence, std::size_t index) {
  const auto latitude = sentence.angle(index, 'N', 'S', 90.0);
  const auto longitude = sentence.angle(index + 2, 'E', 'W', 180.0);
  if (!latitude || !longitude) return std::nullopt;
  return Position{*latitude, *longitude};
}

void Epoch::add_gga(const Sentence& sentence) {
  Gga gga;
  gga.quality = sentence.whole_number(5).value_or(0);
  if (type_of_quality(gga.quality) != GnssFix::Type::none) gga.position = position(sentence, 1);
  gga.satellites = sentence.whole_number(6).value_or(-1);
  gga.hdop = sentence.number(7).value_or(kUnknown);
  const auto above_geoid = sentence.number(8);
  const auto separation = sentence.number(10);
  if (above_geoid && separation) gga.height_m = *above_geoid + *separation;
  // Some receivers report one fix once for each satellite system: the first one that is a fix counts.
  if (!gga_ || (gga_->quality == 0 && gga.quality != 0)) gga_ = gga;
}

void Epoch::add_rmc(const Sentence& sentence) {
  constexpr std::size_t kMode = 11;
  Minimum rmc;
  const bool valid = sentence.field(1) == "A";
  const std::string_view mode = sentence.field(kMode);
  rmc.mode = !valid ? 'N' : mode.empty() ? '?' : mode[0];
  Motion motion;
  if (valid) {
    rmc.position = position(sentence, 2);
    motion.speed_mps = sentence.number(6).value_or(kUnknown) * kMpsPerKnot;
    motion.course_rad = radians(sentence.number(7));
  }
  const auto day = sentence.date(8);
  if (day) date = day;
  if (!rmc_ || !rmc_->position) rmc_ = rmc;
  if (valid && !rmc_motion_) rmc_motion_ = motion;
}

void Epoch::add_gll(const Sentence& sentence) {
  Minimum gll;
  const bool valid = sentence.field(5) == "A";
  const std::string_view mode = sentence.field(6);
  gll.mode = !valid ? 'N' : mode.empty() ? '?' : mode[0];
  if (valid) gll.position = position(sentence, 0);
  if (!gll_) gll_ = gll;
}

void Epoch::add_gst(const Sentence& sentence) {
  Sigmas sigmas;
  const auto north = sentence.number(5);
  const auto east = sentence.number(6);
  const auto major = sentence.number(2);
  const auto minor = sentence.number(3);
  if (north && east) {
    sigmas.horizontal_m = root_mean_square(*north, *east);
  } else if (major && minor) {
    sigmas.horizontal_m = root_mean_square(*major, *minor);
  }
  sigmas.vertical_m = sentence.number(7).value_or(kUnknown);
  if (std::isnan(sigmas_.horizontal_m)) sigmas_ = sigmas;
}

void Epoch::add_vtg(const Sentence& sentence) {
  constexpr std::size_t kMode = 8;
  if (sentence.field(kMode) == "N") return;
  Motion motion;
  motion.course_rad = radians(sentence.number(0));
  const auto knots = sentence.number(4);
  const auto kmh = sentence.number(6);
  motion.speed_mps = knots ? *knots * kMpsPerKnot : kmh ? *kmh * kMpsPerKmh : kUnknown;
  if (!vtg_motion_) vtg_motion_ = motion;
}

void Epoch::add_zda(const Sentence& sentence) {
  const auto day = sentence.whole_number(1);
  const auto month = sentence.whole_number(2);
  const auto year = sentence.whole_number(3);
  if (!day || !month || !year) return;
  const bool in_range = *day > 0 && *day < 32 && *month > 0 && *month < 13 && *year >= 1980 && *year < 2200;
  const std::chrono::year_month_day read(std::chrono::year(in_range ? *year : 0),
                                         std::chrono::month(in_range ? static_cast<unsigned>(*month) : 0),
                                         std::chrono::day(in_range ? static_cast<unsigned>(*day) : 0));
  if (!in_range || !read.ok()) throw Unusable(fmt::format("ZDA: {}-{}-{} is not a date", *year, *month, *day));
  date = std::chrono::sys_days(read);
}

bool Epoch::has_fix() const {
  if (gga_) return type_of_quality(gga_->quality) != GnssFix::Type::none;
  return (rmc_ && rmc_->position && rmc_->mode != 'N') || (gll_ && gll_->position && gll_->mode != 'N');
}

std::shared_ptr<GnssFix> Epoch::fix() const {
  if (!gga_ && !rmc_ && !gll_) return nullptr;
  auto fix = std::make_shared<GnssFix>();
  fix->type = gga_ ? type_of_quality(gga_->quality) : rmc_ ? type_of_mode(rmc_->mode) : type_of_mode(gll_->mode);
  if (fix->type == GnssFix::Type::none) return fix;
  std::optional<Position> found = gga_ ? gga_->position : std::nullopt;
  if (!found && rmc_) found = rmc_->position;
  if (!found && gll_) found = gll_->position;
  if (!found) throw Unusable("the receiver reports a fix, but not where");
  fix->latitude_deg = found->latitude_deg;
  fix->longitude_deg = found->longitude_deg;
  if (gga_) {
    fix->height_m = gga_->height_m;
    fix->hdop = gga_->hdop;
    fix->satellites = gga_->satellites;
  }
  fix->sigma_horizontal_m = sigmas_.horizontal_m;
  fix->sigma_vertical_m = sigmas_.vertical_m;
  for (const std::optional<Motion>* motion : {&rmc_motion_, &vtg_motion_}) {
    if (!*motion) continue;
    if (std::isnan(fix->speed_mps)) fix->speed_mps = (*motion)->speed_mps;
    if (std::isnan(fix->course_rad)) fix->course_rad = (*motion)->course_rad;
  }
  return fix;
}

std::shared_ptr<CompassHeading> Epoch::heading() const {
  if (!heading_deg_) return nullptr;
  auto heading = std::make_shared<CompassHeading>();
  heading->heading_rad = *heading_deg_ * kRadPerDeg;
  heading->from_true_north = true;
  return heading;
}

}  // namespace waymark::nmea
