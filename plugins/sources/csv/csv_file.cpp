// SPDX-License-Identifier: Apache-2.0
#include "csv_file.hpp"

#include <initializer_list>
#include <utility>

#include "bad_row.hpp"

namespace waymark::csv {
namespace {

std::string seconds_text(Duration duration) {
  std::string text = format_time(Time{duration});
  text.erase(text.find_last_not_of('0') + 1);
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

ColumnFinder make_finder(const Config& entry, const std::vector<std::string>& header) {
  ColumnFinder finder(header);
  if (empty_is_unknown(entry)) finder.allow_empty();
  const Config::Key keep_invalid{
      "keep_invalid",
      "true: a row that breaks a rule of its payload (a negative range, an empty field of a required column) is no bad "
      "row; the measurement is delivered as it is, for the host to refuse, as the one in the log was"};
  const Config::Key old_name{"required_may_be_empty", "old name of `keep_invalid`"};
  const bool has_old_name = entry.has(old_name) && !entry.has(keep_invalid);
  if (entry.boolean(has_old_name ? old_name : keep_invalid, false)) finder.keep_invalid();
  return finder;
}

}  // namespace

CsvFile::CsvFile(const Config& entry, Duration max_time_jump, Duration max_ahead)
    : sensor_(entry.text(
          {"sensor",
           "a name under `sensors`; several files may feed one sensor, but two sensors may not share one input"})),
      type_(csv::payload_type(entry)),
      reader_(text_file(entry), read_format(entry)),
      finder_(make_finder(entry, reader_.header())),
      time_(
          entry,
          {"time", "s",
           "when the measurement was true: a column in seconds or of dates, or `{ column, unit or scale, offset_s }`"},
          finder_),
      filter_(entry, finder_),
      builder_(make_payload_builder(type_, entry, finder_)),
      group_by_time_(entry.boolean({"group_by_time",
                                    "rows of equal stamp form one set of `LandmarkObservations`, `Ranges` or "
                                    "`RadarTargets`, where otherwise each row is a set; or "
                                    "one `LaserScan` of which each row is a beam"},
                                   false)),
      max_time_jump_(max_time_jump),
      max_ahead_(max_ahead) {
  if (entry.has("arrival") || given_key(entry, {"arrival", "s"})) {
    const Config::Key key("arrival", "s",
                          "when it became known, same shape; it orders the file instead of `time`, and may not be "
                          "earlier than that by more than `max_ahead_s`",
                          "as time");
    arrival_.emplace(entry, key, finder_);
  }
  if (group_by_time_ && !builder_->can_append()) {
    entry.fail(
        "group_by_time",
        "rows of this payload form no set; only those of LandmarkObservations, Ranges and RadarTargets do, and of "
        "LaserScan with range_m and bearing_rad");
  }
  if (!group_by_time_ && builder_->wants_sets())
    entry.fail("group_by_time", "a row is one beam of a scan here: true is expected");
  min_step_ = from_seconds(entry.non_negative(
      {"min_step_s", "s",
       "thins out a file: a row whose stamp lies less than this after the last one taken is passed over"},
      0.0));
  const std::vector<std::string> names =
      entry.texts({"only_changes_of",
                   "column or list of columns: a row that has the same in them as the row before is passed over, as a "
                   "fast log repeats a slow receiver's last fix"},
                  std::vector<std::string>{});
  for (const std::string& name : names)
    changing_.push_back(finder_.find(entry, "only_changes_of", name, "only_changes_of"));
  if (group_by_time_ && !changing_.empty()) entry.fail("only_changes_of", "cannot be combined with group_by_time");
  if (group_by_time_ && min_step_ > Duration{}) entry.fail("min_step_s", "cannot be combined with group_by_time");
  is_cumulative_ = holds_totals(entry);
  if (is_cumulative_) wraps_at_ = totals_wrap_at(entry);
  if (is_cumulative_ && builder_->totals() == PayloadBuilder::Totals::none) {
    entry.fail("cumulative", "this payload has no totals; only WheelSpeeds, BodyTwist and PoseIncrement have");
  }
  ends_interval_ = csv::ends_interval(entry);
  if (ends_interval_) {
    if (!builder_->has_interval())
      entry.fail("end_of_interval",
                 "rows of this payload describe an instant; only speeds, rates, PoseIncrement and "
                 "LaserScan may describe an interval");
    for (const std::string_view key : {"cumulative", "min_step_s"}) {
      if (entry.has(key)) entry.fail("end_of_interval", "cannot be combined with " + std::string(key));
    }
  }
  entry.reject_unread();
}

std::string CsvFile::signature() const {
  return std::string(type_) + "|" + finder_.signature() + "|" + filter_.signature();
}

std::optional<Measurement> CsvFile::next(BadRecordList& bad_rows) {
  if (failure_) std::rethrow_exception(failure_);
  try {
    while (reader_.next()) {
      try {
        if (auto measurement = take_row()) return measurement;
      } catch (const BadRow& bad) {
        bad_rows.add(reader_.place(), bad.what());
      }
    }
  } catch (const DataError&) {
    if (!group_set_) throw;
    failure_ = std::current_exception();
  }
  return rest_of_group();
}

/// The set that waits for further rows, if there is one.
std::optional<Measurement> CsvFile::rest_of_group() {
  if (!group_set_) return std::nullopt;
  Measurement done = std::exchange(group_, {});
  const std::shared_ptr<Payload> set = std::exchange(group_set_, nullptr);
  if (ends_interval_) {
    const auto before = builder_->stamp_before_end(*set, std::nullopt);
    done.stamp = moved(done.stamp, -before.value_or(Duration{})).value_or(done.stamp);
  }
  return done;
}

std::optional<Measurement> CsvFile::take_row() {
  const Row row = reader_.row();
  if (!filter_.keeps(row)) return std::nullopt;
  if (fields_of_first_row_ == 0) fields_of_first_row_ = row.size();
  if (builder_->wants_equal_rows() && row.size() != fields_of_first_row_) {
    throw BadRow(std::to_string(row.size()) + " fields, but the first row of this file has " +
                 std::to_string(fields_of_first_row_));
  }
  if (row.size() < finder_.needed_fields()) {
    throw BadRow("too few columns: " + std::to_string(row.size()) + ", at least " +
                 std::to_string(finder_.needed_fields()) + " are expected");
  }

  Measurement read;
  read.stamp = time_.read(row);
  read.arrival = arrival_ ? arrival_->read(row) : read.stamp;
  check_order(read.stamp, read.arrival);
  std::string changing = changing_values(row);
  if (!changing_.empty() && changing == last_values_) {
    newest_ = read.arrival;
    return std::nullopt;
  }
  if (min_step_ > Duration{} && last_taken_ && read.stamp - *last_taken_ < min_step_) {
    newest_ = read.arrival;
    last_values_ = std::move(changing);
    return std::nullopt;
  }
  if (group_set_ && read.stamp == group_.stamp) {
    check_values(*builder_->build(row));
    builder_->append(row, *group_set_);
    group_.arrival = read.arrival;
    newest_ = read.arrival;
    return std::nullopt;
  }
  const std::optional<Time> last_end = std::exchange(last_end_, read.stamp);  // also of a bad row
  std::shared_ptr<Payload> payload = builder_->build(row);
  const bool is_placed = !ends_interval_ || group_by_time_ || place_interval(last_end, read, *payload);
  if (!is_cumulative_ && is_placed) check_values(*payload);
  newest_ = read.arrival;
  last_values_ = std::move(changing);  // not of a bad row: the next one may hold the same, and well
  last_taken_ = read.stamp;
  read.payload = payload;
  if (is_cumulative_) {
    if (!make_growth(read)) return std::nullopt;
    check_values(*read.payload);
  }
  if (!is_placed) return std::nullopt;
  if (!group_by_time_) return read;
  auto done = rest_of_group();
  group_ = std::move(read);
  group_set_ = std::move(payload);
  return done;
}

/// Throws BadRow if the values break a rule of the payload, unless the host is to refuse them.
void CsvFile::check_values(const Payload& payload) const {
  if (finder_.keeps_invalid()) return;
  const std::string problem = payload.problem();
  if (!problem.empty()) throw BadRow(problem);
}

/// Turns the totals of a row into what became of those of the row before, known at the end. False: there was no row
/// before.
bool CsvFile::make_growth(Measurement& read) {
  if (!total_.payload) {
    total_ = read;
    return false;
  }
  const Duration passed = read.stamp - total_.stamp;
  if (passed <= Duration{}) throw BadRow("no time has passed since the row before: nothing can grow in none");
  const Measurement before = std::exchange(total_, read);
  read.payload = builder_->growth(*before.payload, *total_.payload, to_seconds(passed), wraps_at_);
  read.stamp = builder_->totals() == PayloadBuilder::Totals::speed ? before.stamp + passed / 2 : before.stamp;
  return true;
}

/// Moves the stamp from the end of the row's interval to where its payload is true. False if that takes the row before,
/// which ended at `last_end`, and there is none.
bool CsvFile::place_interval(std::optional<Time> last_end, Measurement& read, Payload& payload) const {
  std::optional<Duration> since_last;
  if (last_end) since_last = read.stamp - *last_end;
  if (since_last && *since_last <= Duration{})
    throw BadRow("no time has passed since the row before: its interval has no length");
  const auto before = builder_->stamp_before_end(payload, since_last);
  if (!before) return false;
  const auto begin = moved(read.stamp, -*before);
  if (!begin) throw BadRow("its interval begins more than 146 years from the epoch");
  read.stamp = *begin;
  return true;
}

/// What the row holds in the columns of `only_changes_of`.
std::string CsvFile::changing_values(Row row) const {
  std::string values;
  for (const Column& column : changing_) (values += row[column.index]) += '\n';
  return values;
}

void CsvFile::check_order(Time stamp, Time arrival) const {
  if (arrival_ && stamp - arrival > max_ahead_) {
    throw BadRow("the stamp lies " + seconds_text(stamp - arrival) + " s after the arrival; max_ahead_s is " +
                 seconds_text(max_ahead_));
  }
  if (arrival_ && arrival - stamp > max_time_jump_) {
    throw BadRow("the stamp lies " + seconds_text(arrival - stamp) + " s before the arrival; max_time_jump_s is " +
                 seconds_text(max_time_jump_));
  }
  if (!newest_) return;
  if (arrival < *newest_) {
    throw BadRow("time goes back by " + seconds_text(*newest_ - arrival) + " s, from " + format_time(*newest_) +
                 " to " + format_time(arrival));
  }
  if (arrival - *newest_ > max_time_jump_) {
    throw BadRow("time jumps forward by " + seconds_text(arrival - *newest_) + " s; max_time_jump_s is " +
                 seconds_text(max_time_jump_));
  }
}

}  // namespace waymark::csv
