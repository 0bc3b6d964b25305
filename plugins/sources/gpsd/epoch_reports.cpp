// SPDX-License-Identifier: Apache-2.0
#include "epoch_reports.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

namespace waymark::gpsd {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// Reports this much older than the last complete time belong to it; others are a clock that was set back.
constexpr Duration kBelated = std::chrono::seconds(10);

double finite(double value) { return std::isfinite(value) ? value : kUnknown; }
double root_mean_square(double a, double b) { return std::sqrt(0.5 * (a * a + b * b)); }

/// Nothing if gpsd does not report the time, or one that is not a stamp.
std::optional<Time> time_of(const timespec_t& time) {
  if (time.tv_sec <= 0) return std::nullopt;
  const auto second = stamp_after(static_cast<std::uint64_t>(time.tv_sec), std::chrono::seconds(1));
  return second ? moved(*second, std::chrono::nanoseconds(time.tv_nsec)) : std::nullopt;
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

using Json = nlohmann::ordered_json;

/// What is needed of an object: numbers, truth values and short texts under the names that are listed.
Json known_of(const Json& object, std::span<const std::string_view> names) {
  constexpr std::size_t kLongestText = 30;
  Json known = Json::object();
  for (const std::string_view name : names) {
    const auto found = object.find(name);
    if (found == object.end()) continue;
    const bool is_short = found->is_string() && found->get_ref<const std::string&>().size() <= kLongestText;
    if (found->is_number() || found->is_boolean() || is_short) known[std::string(name)] = *found;
  }
  return known;
}

/// libgps 3.22 reads some lines without end: those of damaged JSON, and those with a key twice. So it gets reports that
/// are made anew of what is needed. Empty: the line is none of them.
std::string clean_report(const std::string& line) {
  static constexpr std::array<std::string_view, 20> kNames{
      "class", "time", "mode", "status", "lat",   "lon",   "altHAE",  "alt",         "speed",       "track",
      "hdop",  "nSat", "uSat", "rms",    "major", "minor", "release", "proto_major", "proto_minor", "rev"};
  static constexpr std::array<std::string_view, 5> kNamesOfSatellite{"PRN", "el", "az", "ss", "used"};
  static constexpr std::array<std::string_view, 4> kClasses{"TPV", "GST", "SKY", "VERSION"};
  constexpr std::size_t kMostSatellites = 100;
  const Json given = Json::parse(line, nullptr, false);
  if (!given.is_object()) return {};
  Json report = known_of(given, kNames);
  const auto kind = report.find("class");
  if (kind == report.end() || !kind->is_string()) return {};
  if (std::ranges::find(kClasses, kind->get<std::string>()) == kClasses.end()) return {};
  if (const auto list = given.find("satellites"); list != given.end() && list->is_array()) {
    Json satellites = Json::array();
    for (const Json& one : *list) {
      if (one.is_object() && satellites.size() < kMostSatellites)
        satellites.push_back(known_of(one, kNamesOfSatellite));
    }
    report["satellites"] = std::move(satellites);
  }
  return report.dump();
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
  const std::string report = clean_report(line);
  if (report.empty()) return std::nullopt;
  std::string text = report;  // libgps wants to write into it
  const bool is_position = report.starts_with(R"({"class":"TPV")");
  data_->set = 0;
  if (is_position) gps_clear_fix(&data_->fix);
  if (gps_unpack(text.data(), data_.get()) != 0) return std::nullopt;
  if ((data_->set & VERSION_SET) != 0) release_ = data_->version.release;
  if (report.starts_with(R"({"class":"SKY")") && data_->satellites_visible > 0) satellites_ = data_->satellites_used;
  if (is_position) {
    const auto stamp = time_of(data_->fix.time);
    if (!stamp) return std::nullopt;
    auto complete = begin(*stamp);
    if (current_ && current_->stamp == *stamp) current_->fix = data_->fix;
    return complete;
  }
  if (report.starts_with(R"({"class":"GST")")) {
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
