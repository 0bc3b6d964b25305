// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "recording.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::carmen {
namespace {

constexpr std::string_view kFrontLaser = "FLASER";
constexpr std::string_view kFrontOffset = "robot_frontlaser_offset";
constexpr double kOffsetTolerance = 0.005;  // [m]

/// "2 SYNC, 1 TRUEPOS", a few of them.
std::string counts(const std::map<std::string, std::size_t, std::less<>>& by_name) {
  constexpr std::size_t kShown = 8;
  std::string list;
  std::size_t shown = 0;
  for (const auto& [name, count] : by_name) {
    if (shown++ == kShown) return list + fmt::format(" and {} other kinds", by_name.size() - kShown);
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", count, name);
  }
  return list;
}

/// A text log of CARMEN: scans, odometry, fixes.
class CarmenSource final : public Source {
 public:
  CarmenSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override {
    return measurements_.empty() ? 0.0 : static_cast<double>(next_) / static_cast<double>(measurements_.size());
  }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }
  std::vector<std::string> notices() const override { return notices_; }

 private:
  std::uint32_t add_channel(const Config& entry, const Rig& rig, std::string_view payload);
  void add_laser(const Config& entry, const Rig& rig);
  void read();
  void report(const Recording& recording, const OdometrySteps& odometry);
  void compare_offset(const Recording& recording);

  std::filesystem::path file_;
  BadRecordList bad_;
  Wanted wanted_;
  StepOptions step_options_;
  std::vector<Channel> channels_;
  std::vector<std::uint32_t> lasers_;  // their channels
  std::optional<std::uint32_t> wheels_;
  std::optional<std::uint32_t> gnss_;
  std::optional<Pose> T_base_front_;  // of the sensor that gets FLASER
  std::string front_sensor_;

  bool read_ = false;
  std::vector<Measurement> measurements_;  // in order of arrival
  std::size_t next_ = 0;
  std::exception_ptr failure_;  // thrown when all before it is delivered
  std::vector<std::string> notices_;
};

CarmenSource::CarmenSource(const Config& config, const Rig& rig)
    : file_(readable_file(config, {"file", "the log, plain or gzip; relative to the YAML"})),
      bad_(static_cast<std::uint64_t>(
               config.integer_in({"max_bad_records", "lines and steps that may be bad before the run stops"}, 0,
                                 std::numeric_limits<std::int64_t>::max(), 0)),
           {"record", "max_bad_records", "skips such ones"}) {
  const std::string times =
      config.choice({"times",
                     "which time of a message is its stamp: `ipc`: when it was made; `logger`: when it was written; "
                     "`lines`: none, message n is at n times `line_interval_s`"},
                    {"ipc", "logger", "lines"}, "ipc");
  wanted_.clock = times == "ipc"      ? Wanted::Clock::ipc
                  : times == "logger" ? Wanted::Clock::logger
                                      : Wanted::Clock::lines;
  wanted_.line_interval = from_seconds(
      config.number_in({"line_interval_s", "s", "time from message to message, of `times: lines`"}, 1e-6, 3600.0, 0.1));
  const std::vector<Config> lasers =
      config.items_or_empty({"lasers", "scanners; one of `lasers`, `wheels` and `gnss` is required"});
  for (const Config& entry : lasers) add_laser(entry, rig);
  if (config.has("wheels")) {
    const Config wheels = config.child(
        {"wheels", "its `sensor`, of the plugin `odometry` with `model: increment`, gets the steps of odometry"});
    wheels_ = add_channel(wheels, rig, PoseIncrement::kType);
    const std::string poses = wheels.choice(
        {"poses", "whose poses: `scans`: of the first entry of `lasers`; `odom`: of `ODOM`; `all`: of both"},
        {"scans", "odom", "all"}, "scans");
    wanted_.poses = poses == "scans"  ? Wanted::Poses::scans
                    : poses == "odom" ? Wanted::Poses::odom
                                      : Wanted::Poses::all;
    if (lasers_.empty() && wanted_.poses != Wanted::Poses::odom)
      wheels.fail("poses", "\"" + poses + "\" needs an entry of lasers, whose messages hold the poses; or: odom");
    step_options_.repair_reversals = wheels.choice({"reversals",
                                                    "`repair`: steps that go forward while `tv` of `ODOM` is negative "
                                                    "are turned round; `as_logged`: nothing is changed"},
                                                   {"repair", "as_logged"}, "repair") == "repair";
    step_options_.max_speed_mps = wheels.positive({"max_speed_mps", "m/s",
                                                   "a faster step is a jump (odometry was set anew) and is left out as "
                                                   "a bad record; intervals below 0.1 s count as 0.1 s"},
                                                  20.0);
    wheels.reject_unread();
  }
  if (config.has("gnss")) {
    gnss_ = add_channel(config.child({"gnss", "its `sensor` gets `NMEAGGA`"}), rig, GnssFix::kType);
    config.child("gnss").reject_unread();
    wanted_.fixes = true;
  }
  if (channels_.empty()) config.fail("none of lasers, wheels and gnss is given; at least one of them is expected");
}

std::uint32_t CarmenSource::add_channel(const Config& entry, const Rig& rig, std::string_view payload) {
  Channel channel = channel_to_sensor(entry, rig, payload);
  if (std::ranges::find(channels_, channel.sensor, &Channel::sensor) != channels_.end())
    entry.fail("sensor", fmt::format("sensor \"{}\" is given twice", channel.sensor));
  channels_.push_back(std::move(channel));
  return static_cast<std::uint32_t>(channels_.size() - 1);
}

void CarmenSource::add_laser(const Config& entry, const Rig& rig) {
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  Wanted::Laser laser;
  laser.message =
      entry.choice({"message", "which messages are the scans"}, {"FLASER", "RLASER", "ROBOTLASER1", "ROBOTLASER2"});
  if (std::ranges::find(wanted_.lasers, laser.message, &Wanted::Laser::message) != wanted_.lasers.end())
    entry.fail("message", laser.message + " is given twice");
  if (entry.has("start_deg") || entry.has("step_deg")) {
    const double start_deg = entry.number(
        {"start_deg", "°", "first beam, counter-clockwise; with `step_deg`, instead of that of the message",
         "from the message"});
    const double step_deg =
        entry.number({"step_deg", "°", "from beam to beam, counter-clockwise; with `start_deg`", "from the message"});
    laser.beams = BeamRule{kRadPerDeg * start_deg, kRadPerDeg * step_deg};
    if (laser.beams->step_rad == 0.0) entry.fail("step_deg", "0 is not a step");
  }
  lasers_.push_back(add_channel(entry, rig, LaserScan::kType));
  if (laser.message == kFrontLaser) {
    front_sensor_ = channels_.back().sensor;
    T_base_front_ = rig.mountings()[static_cast<std::size_t>(rig.find(front_sensor_))].T_base_sensor;
  }
  wanted_.lasers.push_back(std::move(laser));
  entry.reject_unread();
}

void CarmenSource::read() {
  read_ = true;
  Recording recording = read_recording(file_, wanted_, bad_);
  failure_ = recording.failure;
  OdometrySteps odometry;
  if (wheels_) odometry = make_steps(recording.poses, recording.speeds, step_options_, bad_);
  if (odometry.failure) {
    // It ends where its last step does: what comes later in the file is behind the record that was one too many.
    failure_ = odometry.failure;
    const Time end = odometry.steps.empty() ? Time::min() : odometry.steps.back().end;
    std::erase_if(recording.scans, [&](const Recording::Scan& scan) { return scan.stamp > end; });
    std::erase_if(recording.fixes, [&](const Recording::Fix& fix) { return fix.stamp > end; });
  }
  report(recording, odometry);

  measurements_.reserve(odometry.steps.size() + recording.scans.size() + recording.fixes.size());
  const auto add = [&](Time stamp, Time arrival, std::uint32_t channel, std::shared_ptr<const Payload> payload) {
    Measurement& m = measurements_.emplace_back();
    m.stamp = stamp;
    m.arrival = arrival;
    m.sensor = channel;
    m.payload = std::move(payload);
  };
  // A step is known at its end, where the next scan is, too; the scan at its begin has been taken in by then. One
  // nanosecond later than that scan the step is not late, whichever of the two sensors the YAML names first.
  for (std::size_t i = 0; i < odometry.steps.size(); ++i) {
    OdometryStep& step = odometry.steps[i];
    add(step.begin + Duration(i == 0 ? 0 : 1), step.end, *wheels_, std::move(step.increment));
  }
  for (Recording::Scan& scan : recording.scans) add(scan.stamp, scan.stamp, lasers_[scan.laser], std::move(scan.scan));
  for (Recording::Fix& fix : recording.fixes) add(fix.stamp, fix.stamp, *gnss_, std::move(fix.fix));
  std::ranges::stable_sort(measurements_, {}, &Measurement::arrival);
  for (std::size_t i = 0; i < measurements_.size(); ++i) measurements_[i].sequence = i;
}

void CarmenSource::report(const Recording& recording, const OdometrySteps& odometry) {
  const std::string file = file_.filename().string();
  if (!recording.steps_back.empty()) {
    notices_.push_back(fmt::format("{}: stamps step back, by up to {:.3f} s: {}; put in order", file,
                                   to_seconds(recording.longest_step_back), counts(recording.steps_back)));
  }
  if (odometry.turned > 0) {
    notices_.push_back(
        fmt::format("{}: odometry goes forward while the robot reverses in {} steps ({} stretches, {:.1f} m in all): "
                    "turned round (reversals: as_logged leaves them)",
                    file, odometry.turned, odometry.stretches, odometry.turned_m));
  }
  if (!recording.passed_over.empty()) {
    notices_.push_back(fmt::format("{}: messages passed over: {}", file, counts(recording.passed_over)));
  }
  compare_offset(recording);
}

/// Reports it if the log and the YAML differ on where the front laser is.
void CarmenSource::compare_offset(const Recording& recording) {
  const auto found = recording.parameters.find(kFrontOffset);
  if (found == recording.parameters.end() || front_sensor_.empty()) return;
  const auto& [value, place] = found->second;
  double offset = 0.0;
  if (std::from_chars(value.data(), value.data() + value.size(), offset).ec != std::errc{}) return;
  const double ours = T_base_front_ ? T_base_front_->p.x() : 0.0;
  if (std::abs(ours - offset) <= kOffsetTolerance) return;
  notices_.push_back(fmt::format("{}: {} is {} m, but base_T_sensor of sensors.{} {}", place, kFrontOffset, offset,
                                 front_sensor_,
                                 T_base_front_ ? fmt::format("has x {:.3f} m", ours) : std::string("is not given")));
}

std::optional<Measurement> CarmenSource::next() {
  if (!read_) read();
  if (next_ == measurements_.size()) {
    if (failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  return measurements_[next_++];
}

}  // namespace
}  // namespace waymark::carmen

WAYMARK_PLUGIN(waymark::Source, waymark::carmen::CarmenSource, "carmen", "1.0.0")
