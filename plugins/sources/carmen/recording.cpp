// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <algorithm>
#include <string_view>

#include "log_lines.hpp"

namespace waymark::carmen {
namespace {

/// False for what a message is not called: a picture that somebody took for a log.
bool is_name(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  return word.size() <= kLongest && std::ranges::all_of(word, [](char c) { return c > ' ' && c <= '~'; });
}

/// Takes one message after the other into a recording.
class Reader {
 public:
  Reader(const Wanted& wanted, Recording& out) : wanted_(wanted), out_(out) {}

  /// Throws Unusable.
  void take(const Fields& fields, const LogLines& lines) {
    if (fields.name() == "PARAM") {
      const std::string_view name = fields.text(1, "a name");
      out_.parameters.insert_or_assign(std::string(name),
                                       Recording::Parameter{std::string(fields.text(2, "a value")), lines.place()});
      return;
    }
    ++messages_;
    if (fields.name() == "ODOM" && wanted_.poses != Wanted::Poses::none) return take_odom(fields, lines);
    if (is_laser(fields.name())) {
      const auto laser = std::ranges::find(wanted_.lasers, fields.name(), &Wanted::Laser::message);
      if (laser != wanted_.lasers.end())
        return take_laser(fields, static_cast<std::size_t>(laser - wanted_.lasers.begin()), lines);
    }
    if (fields.name() == "NMEAGGA" && wanted_.fixes) {
      auto fix = read_fix(fields);
      out_.fixes.push_back({stamp(fields), std::move(fix)});
      return;
    }
    const std::string_view name = is_name(fields.name()) ? fields.name() : "lines that are not messages";
    const auto known = out_.passed_over.find(name);
    if (known != out_.passed_over.end()) {
      ++known->second;
    } else {
      out_.passed_over.emplace(name, 1);
    }
  }

 private:
  Time stamp(const Fields& fields) {
    if (wanted_.clock == Wanted::Clock::lines) {
      const auto counted = stamp_after(messages_, wanted_.line_interval);
      if (!counted) throw Unusable("the number of the message times line_interval_s is more than 146 years");
      return *counted;
    }
    const Times times = read_times(fields);
    const Time stamp = wanted_.clock == Wanted::Clock::ipc ? times.ipc : times.logger;
    // Of its own kind only: many loggers write every scan behind the odometry that came after it.
    const auto [newest, first] = newest_.try_emplace(std::string(fields.name()), stamp);
    if (!first && stamp < newest->second) {
      ++out_.steps_back[newest->first];
      out_.longest_step_back = std::max(out_.longest_step_back, newest->second - stamp);
    }
    newest->second = stamp;
    return stamp;
  }

  void take_odom(const Fields& fields, const LogLines& lines) {
    const Odom odom = read_odom(fields);
    const Time at = stamp(fields);
    out_.speeds.push_back({at, odom.tv_mps});
    if (wanted_.poses != Wanted::Poses::scans) out_.poses.push_back({at, odom.T_odom_base, lines.place()});
  }

  void take_laser(const Fields& fields, std::size_t laser, const LogLines& lines) {
    LaserMessage message = read_laser(fields, wanted_.lasers[laser].beams);
    const Time at = stamp(fields);
    out_.scans.push_back({at, laser, std::move(message.scan)});
    const bool has_pose = wanted_.poses == Wanted::Poses::scans || wanted_.poses == Wanted::Poses::all;
    if (has_pose && laser == 0) out_.poses.push_back({at, message.T_odom_base, lines.place()});
  }

  const Wanted& wanted_;
  Recording& out_;
  std::map<std::string, Time, std::less<>> newest_;  // stamp of each kind of message
  std::uint64_t messages_ = 0;
};

}  // namespace

Recording read_recording(const std::filesystem::path& file, const Wanted& wanted, BadRecordList& bad) {
  Recording recording;
  Reader reader(wanted, recording);
  try {
    LogLines lines(file);
    Fields fields;
    for (std::string_view line; lines.next(line);) {
      fields.split(line);
      if (fields.empty() || fields.name().starts_with('#')) continue;
      try {
        reader.take(fields, lines);
      } catch (const Unusable& unusable) {
        bad.add(lines.place(), unusable.what());
      }
    }
  } catch (const DataError&) {
    recording.failure = std::current_exception();
  }
  std::ranges::stable_sort(recording.scans, {}, &Recording::Scan::stamp);
  std::ranges::stable_sort(recording.fixes, {}, &Recording::Fix::stamp);
  std::ranges::stable_sort(recording.poses, {}, &OdometryPose::stamp);
  std::ranges::stable_sort(recording.speeds, {}, &OdometrySpeed::stamp);
  return recording;
}

}  // namespace waymark::carmen
