// SPDX-License-Identifier: Apache-2.0
#include "epoch_reports.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace waymark::gpsd {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// Reports this much older than the last complete time belong to it; others are a clock that was set back.
constexpr Duration kBelated = std::chrono::seconds(10);

double finite(double value) { return std::isfinite(value) ? value : kUnknown; }
double root_mean_square(double a, double b) { return std::sqrt(0.5 * (a * a + b * b)); }

/// Nothing if gpsd does not report the time.
std::optional<Time> time_of(const timespec_t& time) {
  constexpr std::int64_t kLastSecond = 9'000'000'000;  // fits into nanoseconds
  if (time.tv_sec <= 0 || time.tv_sec > kLastSecond) return std::nullopt;
  return Time(std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec));
}

/// The numbers are those of gpsd's JSON (gpsd_json(5)); the names of the constants change.
GnssFix::Type type_of(const gps_fix_t& fix) {
  using enum GnssFix::Type;
  if (fix.mode < MODE_2D) return none;
  switch (fix.status) {
    case 0:  // left out for a plain fix
    case 1:
    case 6:  // with dead reckoning between the satellites
    case 9:  // the military service
      return single;
    case 2:
      return differential;
    case 3:
      return rtk_fixed;
    case 4:
      return rtk_float;
    case 5:  // dead reckoning
    case 7:  // typed in by hand
      return none;
    default:
      return unknown;
  }
}

}  // namespace

EpochReports::EpochReports() : data_(std::make_unique<gps_data_t>()) { data_->dop.hdop = kUnknown; }

EpochReports::Sigmas EpochReports::read_sigmas() const {
  const gst_t& gst = data_->gst;
  double horizontal = root_mean_square(gst.lat_err_deviation, gst.lon_err_deviation);
  if (!std::isfinite(horizontal)) horizontal = root_mean_square(gst.smajor_deviation, gst.sminor_deviation);
  return {finite(horizontal), finite(gst.alt_err_deviation)};
}

std::optional<TimedFix> EpochReports::begin(Time stamp) {
  if (current_ && current_->stamp == stamp) return std::nullopt;
  std::optional<TimedFix> complete = finish();
  const bool is_belated = finished_ && stamp <= *finished_ && *finished_ - stamp < kBelated;
  if (!is_belated) current_ = Epoch{stamp, {}, {}};
  return complete;
}

std::optional<TimedFix> EpochReports::take(const std::string& line) {
  std::string text = line;  // libgps wants to write into it
  const bool is_position = line.starts_with(R"({"class":"TPV")");
  data_->set = 0;
  if (is_position) gps_clear_fix(&data_->fix);
  if (gps_unpack(text.data(), data_.get()) != 0) return std::nullopt;
  if ((data_->set & VERSION_SET) != 0) release_ = data_->version.release;
  if (line.starts_with(R"({"class":"SKY")") && data_->satellites_visible > 0) satellites_ = data_->satellites_used;
  if (is_position) {
    const auto stamp = time_of(data_->fix.time);
    if (!stamp) return std::nullopt;
    auto complete = begin(*stamp);
    if (current_ && current_->stamp == *stamp) current_->fix = data_->fix;
    return complete;
  }
  if (line.starts_with(R"({"class":"GST")")) {
    const auto stamp = time_of(data_->gst.utctime);
    if (!stamp) return std::nullopt;
    auto complete = begin(*stamp);
    if (current_ && current_->stamp == *stamp) current_->sigmas = read_sigmas();
    return complete;
  }
  return std::nullopt;
}

std::optional<TimedFix> EpochReports::finish() {
  const std::optional<Epoch> epoch = std::exchange(current_, std::nullopt);
  if (!epoch) return std::nullopt;
  finished_ = epoch->stamp;
  if (!epoch->fix) return std::nullopt;
  auto fix = fix_of(*epoch);
  if (!fix->problem().empty()) return std::nullopt;
  return TimedFix{epoch->stamp, std::move(fix)};
}

std::shared_ptr<const GnssFix> EpochReports::fix_of(const Epoch& epoch) const {
  const gps_fix_t& report = *epoch.fix;
  auto fix = std::make_shared<GnssFix>();
  fix->type = type_of(report);
  if (fix->type == GnssFix::Type::none) return fix;
  fix->latitude_deg = finite(report.latitude);
  fix->longitude_deg = finite(report.longitude);
  if (report.mode >= MODE_3D) fix->height_m = finite(report.altHAE);
  fix->speed_mps = finite(report.speed);
  fix->course_rad = finite(report.track) * kRadPerDeg;
  fix->hdop = finite(data_->dop.hdop);
  fix->satellites = satellites_;
  if (epoch.sigmas) {
    fix->sigma_horizontal_m = epoch.sigmas->horizontal_m;
    fix->sigma_vertical_m = epoch.sigmas->vertical_m;
  }
  return fix;
}

}  // namespace waymark::gpsd
