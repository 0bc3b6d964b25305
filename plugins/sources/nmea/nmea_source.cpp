// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <deque>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "epoch.hpp"
#include "epoch_clock.hpp"
#include "line_stream.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "sentence.hpp"
#include "serial_lines.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::nmea {
namespace {

/// A GNSS receiver's sentences of NMEA 0183: fixes, and headings of a compass that refers to true north.
class NmeaSource final : public Source {
 public:
  NmeaSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  bool is_live() const override { return is_live_; }
  void stop() override { lines_->stop(); }
  std::vector<std::string> take_events() override { return events_.take(); }
  double progress() const override { return lines_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  std::optional<std::uint32_t> add_channel(const Config& config, const Rig& rig, const Config::Key& key,
                                           std::string_view payload);
  std::unique_ptr<LineInput> make_input(const Config& config);
  void take(const std::string& line);
  void report_bad();
  void take_heading(const Sentence& sentence);
  void finish_epoch();
  void deliver(Time stamp, std::uint32_t channel, std::shared_ptr<const Payload> payload);

  std::vector<Channel> channels_;
  std::optional<std::uint32_t> gnss_;  // their channels
  std::optional<std::uint32_t> heading_;
  bool heading_of_next_ = false;
  bool is_live_;
  live::EventList events_;
  BadRecordList bad_;
  Duration delay_{};  // of a log
  std::unique_ptr<LineInput> lines_;
  bool needs_checksum_;
  EpochClock clock_;

  Epoch epoch_;
  std::optional<Duration> complete_;        // time of day of an epoch that a pause has ended
  std::size_t next_report_ = 1;             // of bad records
  std::optional<double> next_heading_deg_;  // of the epoch to come
  std::deque<Measurement> ready_;
  std::uint64_t delivered_ = 0;
  bool ended_ = false;
};

std::filesystem::path file_of(const Config& config) {
  if (config.text({"file", "a file, a FIFO, or `-`: the standard input; relative to the YAML"}) == "-") return "-";
  return readable_file(config, "file");
}

std::optional<std::chrono::sys_days> start_date_of(const Config& config) {
  const std::string text =
      config.text({"start_date", "date of the first sentence, as `2024-12-31`, where none has the date"}, "none");
  if (text == "none") return std::nullopt;
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  const char* const end = text.data() + text.size();
  const bool read = text.size() == 10 && text[4] == '-' && text[7] == '-' &&
                    std::from_chars(text.data(), end, year).ptr == text.data() + 4 &&
                    std::from_chars(text.data() + 5, end, month).ptr == text.data() + 7 &&
                    std::from_chars(text.data() + 8, end, day).ptr == end;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  if (!read || !date.ok() || !stamp_on(date, {}))
    config.fail("start_date", fmt::format("\"{}\" is not a date as 2024-12-31", text));
  return std::chrono::sys_days(date);
}

std::uint64_t bad_record_limit(const Config& config, bool is_live) {
  if (is_live) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(config.integer_in(
      {"max_bad_records",
       "lines and fixes of a `file` that are skipped before the run stops: a serial line loses a byte now and then"},
      0, std::numeric_limits<std::int64_t>::max(), 100));
}

NmeaSource::NmeaSource(const Config& config, const Rig& rig)
    : is_live_(config.has({"device", "serial port of a receiver, such as /dev/ttyUSB0; instead of `file`"})),
      bad_(bad_record_limit(config, is_live_), {"record", "max_bad_records", "goes on after such ones"}),
      lines_(make_input(config)),
      needs_checksum_(config.boolean(
          {"require_checksum", "false: a sentence without a checksum is taken; a wrong one never is"}, true)),
      clock_(start_date_of(config),
             from_seconds(
                 config.number_in({"max_time_jump_s", "s", "a larger step forward is a fault"}, 1e-3, 9e9, 3600.0)),
             is_live_ ? EpochClock::StepBack::is_believed_the_second_time : EpochClock::StepBack::is_left_out) {
  gnss_ = add_channel(config, rig, {"gnss", "its `sensor` gets the fixes; `gnss` or `heading` is required"},
                      GnssFix::kType);
  heading_ = add_channel(config, rig, {"heading", "its `sensor` gets the headings from true north of `HDT`"},
                         CompassHeading::kType);
  if (!gnss_ && !heading_) config.fail("neither gnss nor heading is given; at least one of them is expected");
  if (heading_) {
    heading_of_next_ = config.child("heading").choice(
                           {"time",
                            "`HDT` has no time: it is that of the sentence before it (`previous`) or of the `next` "
                            "one; look into the log; of several headings of one time the last one counts"},
                           {"previous", "next"}, "previous") == "next";
    config.child("heading").reject_unread();
  }
  if (gnss_) config.child("gnss").reject_unread();
}

std::unique_ptr<LineInput> NmeaSource::make_input(const Config& config) {
  if (!is_live_) {
    delay_ = from_seconds(config.number_in(
        {"delay_s", "s", "how long after its time a fix of a `file` becomes known; arrival = stamp + delay"}, 0.0,
        3600.0, 0.0));
    return std::make_unique<LineStream>(
        file_of(config),
        from_seconds(config.number_in(
            {"follow_s", "s", "how long at the end of a file that grows more lines are waited for"}, 0.0, 1e6, 0.0)));
  }
  const std::string device = config.text("device");
  constexpr std::array kRates = {1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600};
  const std::int64_t baud = config.integer({"baud", "bits per second of the `device`"}, 9600);
  if (std::ranges::find(kRates, baud) == kRates.end())
    config.fail("baud", fmt::format("{} is not one of: {}", baud, fmt::join(kRates, ", ")));
  const double quiet_s = config.number_in(
      {"quiet_s", "s", "a `device` that sends nothing for so long has sent all of one time"}, 0.01, 10.0, 0.1);
  return std::make_unique<SerialLines>(device, static_cast<unsigned>(baud),
                                       std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * quiet_s)), events_);
}

std::optional<std::uint32_t> NmeaSource::add_channel(const Config& config, const Rig& rig, const Config::Key& key,
                                                     std::string_view payload) {
  if (!config.has(key)) return std::nullopt;
  channels_.push_back(channel_to_sensor(config.child(key), rig, payload));
  return static_cast<std::uint32_t>(channels_.size() - 1);
}

void NmeaSource::deliver(Time stamp, std::uint32_t channel, std::shared_ptr<const Payload> payload) {
  Measurement measurement;
  measurement.stamp = stamp;
  measurement.arrival = stamp + delay_;
  measurement.sensor = channel;
  measurement.payload = std::move(payload);
  ready_.push_back(std::move(measurement));
}

/// Makes measurements of the sentences of one time.
void NmeaSource::finish_epoch() {
  const Epoch epoch = std::exchange(epoch_, {});
  const auto stamp = clock_.stamp(epoch, bad_);
  if (!stamp) return;
  try {
    if (gnss_) {
      if (auto fix = epoch.fix()) deliver(*stamp, *gnss_, std::move(fix));
    }
  } catch (const Unusable& unusable) {
    bad_.add(epoch.place, unusable.what());
  }
  if (heading_) {
    if (auto heading = epoch.heading()) deliver(*stamp, *heading_, std::move(heading));
  }
}

/// Headings carry no time of their own.
void NmeaSource::take_heading(const Sentence& sentence) {
  const auto degrees = sentence.number(0);
  if (!degrees) return;
  if (heading_of_next_) {
    next_heading_deg_ = degrees;
  } else if (epoch_.time_of_day) {
    epoch_.set_heading(*degrees);
  }
}

void NmeaSource::take(const std::string& line) {
  try {
    if (line.size() >= LineInput::kLongest)
      throw Unusable(fmt::format("a line of {} characters or more", LineInput::kLongest));
    const auto sentence = read_sentence(line, needs_checksum_);
    if (!sentence || !Epoch::reads(*sentence)) return;
    if (sentence->type == "HDT") return take_heading(*sentence);
    const auto time = Epoch::time_of(*sentence);
    // Without a time a receiver has no fix either; VTG has none of its own.
    if (!time && !(sentence->type == "VTG" && epoch_.time_of_day)) return;
    if (time && time == complete_) return;
    if (time && epoch_.time_of_day != time) {
      complete_.reset();
      if (epoch_.time_of_day) finish_epoch();
      epoch_.time_of_day = time;
      epoch_.place = lines_->place();
      if (next_heading_deg_) epoch_.set_heading(*std::exchange(next_heading_deg_, {}));
    }
    epoch_.add(*sentence);
  } catch (const Unusable& unusable) {
    bad_.add(lines_->place(), unusable.what());
  }
}

/// Reports the first bad record of a running robot, then the 10th, the 100th, …
void NmeaSource::report_bad() {
  constexpr std::size_t kStep = 10;
  const std::vector<BadRecord>& records = bad_.records();
  if (records.size() < next_report_) return;
  events_.add(fmt::format("{} bad record{} so far; {}: {}", records.size(), records.size() == 1 ? "" : "s",
                          records.back().place, records.back().reason));
  while (next_report_ <= records.size()) next_report_ *= kStep;
}

std::optional<Measurement> NmeaSource::next() {
  std::string line;
  while (ready_.empty()) {
    if (ended_) return std::nullopt;
    switch (lines_->read(line)) {
      case LineInput::Got::line:
        take(line);
        break;
      case LineInput::Got::pause:
        if (epoch_.time_of_day) complete_ = epoch_.time_of_day;
        finish_epoch();
        break;
      case LineInput::Got::end:
        ended_ = true;
        if (!is_live_) finish_epoch();
    }
    if (is_live_) report_bad();
  }
  Measurement measurement = std::move(ready_.front());
  ready_.pop_front();
  measurement.sequence = delivered_++;
  return measurement;
}

}  // namespace
}  // namespace waymark::nmea

WAYMARK_PLUGIN(waymark::Source, waymark::nmea::NmeaSource, "nmea", "1.0.0")
