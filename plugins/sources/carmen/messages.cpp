// SPDX-License-Identifier: Apache-2.0
#include "messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "waymark/base/error.hpp"

namespace waymark::carmen {
namespace {

constexpr std::size_t kTimes = 3;  // ipc_timestamp ipc_hostname logger_timestamp
constexpr std::size_t kMostValues = 1'000'000;

std::string quoted(std::string_view text) {
  std::string shown(text.substr(0, 40));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return '"' + shown + '"';
}

PlanarPose read_pose(const Fields& fields, std::size_t at) {
  return {fields.number(at, "x"), fields.number(at + 1, "y"), fields.number(at + 2, "theta")};
}

/// Ranges and remissions are finite numbers; what is not a return, the YAML of the module that takes them defines.
std::vector<float> read_values(const Fields& fields, std::size_t first, std::size_t count, std::string_view what) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(fields.number(first + i, what));
  return values;
}

/// The number of ranges; a scan has at least one.
std::size_t read_beams(const Fields& fields, std::size_t at) {
  const std::size_t beams = fields.count(at, "num_readings");
  if (beams == 0) throw Unusable("num_readings is 0; a scan has at least one range");
  return beams;
}

BeamRule half_circle(std::size_t beams) {
  constexpr std::array<std::size_t, 6> kKnown = {180, 181, 360, 361, 720, 721};
  if (std::ranges::find(kKnown, beams) == kKnown.end())
    throw Unusable(fmt::format("{} beams; give start_deg and step_deg of this laser in the YAML", beams));
  return {-0.5 * std::numbers::pi, std::numbers::pi / static_cast<double>(beams - beams % 2)};
}

/// FLASER n r_1 … r_n x y theta odom_x odom_y odom_theta, then the times.
LaserMessage read_old_laser(const Fields& fields, const std::optional<BeamRule>& given) {
  const std::size_t beams = read_beams(fields, 1);
  fields.expect(2 + beams + 6 + kTimes);
  const BeamRule rule = given ? *given : half_circle(beams);
  LaserMessage message{std::make_shared<LaserScan>(), read_pose(fields, 2 + beams + 3)};
  message.scan->start_rad = rule.start_rad;
  message.scan->step_rad = rule.step_rad;
  message.scan->ranges_m = read_values(fields, 2, beams, "a range");
  return message;
}

/// ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode n r_1 …
/// r_n m remission_1 … remission_m laser_x laser_y laser_theta x y theta tv rv forward_safety side_safety turn_axis,
/// then the times.
LaserMessage read_new_laser(const Fields& fields, const std::optional<BeamRule>& given) {
  constexpr std::size_t kHead = 8;  // the name, laser_type … remission_mode
  const std::size_t beams = read_beams(fields, kHead);
  const std::size_t remissions = fields.count(kHead + 1 + beams, "num_remissions");
  const std::size_t pose = kHead + 2 + beams + remissions;
  fields.expect(pose + 6 + 5 + kTimes);
  if (remissions != 0 && remissions != beams)
    throw Unusable(fmt::format("{} ranges but {} remissions; as many or none are expected", beams, remissions));
  const BeamRule rule =
      given ? *given : BeamRule{fields.number(2, "start_angle"), fields.number(4, "angular_resolution")};
  if (rule.step_rad == 0.0 && beams > 1) throw Unusable("angular_resolution is 0");
  LaserMessage message{std::make_shared<LaserScan>(), read_pose(fields, pose + 3)};
  message.scan->start_rad = rule.start_rad;
  message.scan->step_rad = rule.step_rad;
  message.scan->ranges_m = read_values(fields, kHead + 1, beams, "a range");
  message.scan->intensities = read_values(fields, kHead + 2 + beams, remissions, "a remission");
  return message;
}

/// Degrees and minutes in one number, 4900.1234 for 49° 0.1234', and a letter for its side.
double read_angle(const Fields& fields, std::size_t at, std::string_view what, char positive, char negative,
                  double limit) {
  const double value = fields.number(at, what);
  const std::string_view side = fields.text(at + 1, what);
  const double whole = std::floor(value / 100.0);
  const double minutes = value - 100.0 * whole;
  const double degrees = whole + minutes / 60.0;
  const bool known_side = side.size() == 1 && (side[0] == positive || side[0] == negative);
  if (!known_side || value < 0.0 || minutes >= 60.0 || degrees > limit)
    throw Unusable(fmt::format("{} is {} {}, degrees and minutes as 4900.1234 {} are expected", what,
                               quoted(fields.text(at, what)), quoted(side), positive));
  return side[0] == positive ? degrees : -degrees;
}

GnssFix::Type fix_type(double quality) {
  using enum GnssFix::Type;
  constexpr std::array kTypes = {none, single, differential, single, rtk_fixed, rtk_float, none, none};
  return quality >= 0.0 && quality < double{kTypes.size()} ? kTypes[static_cast<std::size_t>(quality)] : unknown;
}

}  // namespace

void Fields::split(std::string_view line) {
  words_.clear();
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  const char* at = line.data();
  const char* const end = at + line.size();
  for (;;) {
    while (at != end && blank(*at)) ++at;
    if (at == end) return;
    const char* const begin = at;
    while (at != end && !blank(*at)) ++at;
    words_.emplace_back(begin, static_cast<std::size_t>(at - begin));
  }
}

std::string_view Fields::text(std::size_t index, std::string_view what) const {
  if (index >= words_.size())
    throw Unusable(fmt::format("{} has {} words, {} is expected as word {}", name(), words_.size(), what, index + 1));
  return words_[index];
}

double Fields::number(std::size_t index, std::string_view what) const {
  const std::string_view word = text(index, what);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
    throw Unusable(fmt::format("{}: {} (word {}) is {}, a number is expected", name(), what, index + 1, quoted(word)));
  return value;
}

std::size_t Fields::count(std::size_t index, std::string_view what) const {
  const std::string_view word = text(index, what);
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || value > kMostValues)
    throw Unusable(fmt::format("{}: {} (word {}) is {}, a whole number up to {} is expected", name(), what, index + 1,
                               quoted(word), kMostValues));
  return value;
}

Time Fields::time(std::size_t index, std::string_view what) const {
  const std::string_view word = text(index, what);
  try {
    return parse_time(word);
  } catch (const DataError&) {
    throw Unusable(fmt::format("{}: {} (word {}) is {}, seconds are expected", name(), what, index + 1, quoted(word)));
  }
}

void Fields::expect(std::size_t size) const {
  if (words_.size() != size)
    throw Unusable(fmt::format("{} has {} words, {} are expected", name(), words_.size(), size));
}

bool is_laser(std::string_view name) {
  return name == "FLASER" || name == "RLASER" || name == "ROBOTLASER1" || name == "ROBOTLASER2";
}

Odom read_odom(const Fields& fields) {
  fields.expect(7 + kTimes);
  return {read_pose(fields, 1), fields.number(4, "tv")};
}

LaserMessage read_laser(const Fields& fields, const std::optional<BeamRule>& rule) {
  return fields.name().starts_with("ROBOT") ? read_new_laser(fields, rule) : read_old_laser(fields, rule);
}

std::shared_ptr<GnssFix> read_fix(const Fields& fields) {
  fields.expect(15 + kTimes);
  auto fix = std::make_shared<GnssFix>();
  fix->type = fix_type(fields.number(7, "gps_quality"));
  if (fix->type != GnssFix::Type::none) {
    fix->latitude_deg = read_angle(fields, 3, "latitude", 'N', 'S', 90.0);
    fix->longitude_deg = read_angle(fields, 5, "longitude", 'E', 'W', 180.0);
    fix->hdop = fields.number(9, "hdop");
  }
  fix->satellites = static_cast<int>(fields.count(8, "num_satellites"));
  return fix;
}

Times read_times(const Fields& fields) {
  if (fields.size() < 1 + kTimes)
    throw Unusable(fmt::format("{} has {} words, its times are missing", fields.name(), fields.size()));
  return {fields.time(fields.size() - 3, "ipc_timestamp"), fields.time(fields.size() - 1, "logger_timestamp")};
}

}  // namespace waymark::carmen
