// SPDX-License-Identifier: Apache-2.0
#include "epoch_clock.hpp"

#include <fmt/format.h>

namespace waymark::nmea {
namespace {

constexpr Duration kHalfDay = std::chrono::hours(12);

std::string date_and_time(Time time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const auto within = time - day;
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(within);
  return fmt::format("{}-{:02}-{:02} {:02}:{:02}:{:06.3f}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), minutes.count() / 60,
                     minutes.count() % 60, to_seconds(within - minutes));
}

}  // namespace

/// True if the clock was set back, and this is the second time after it.
bool EpochClock::goes_on_after_step_back(Time stamp) {
  if (step_back_ == StepBack::is_left_out || !newest_ || stamp > *newest_) return false;
  return stepped_back_to_ && stamp > *stepped_back_to_ && stamp - *stepped_back_to_ <= max_jump_;
}

std::optional<Time> EpochClock::stamp(const Epoch& epoch, BadRecordList& bad) {
  if (!epoch.time_of_day) return std::nullopt;
  const Duration time_of_day = *epoch.time_of_day;
  if (epoch.date) {
    date_ = epoch.date;
  } else if (date_ && time_of_day_ && time_of_day < *time_of_day_ - kHalfDay) {
    date_ = *date_ + std::chrono::days(1);  // midnight has passed
  } else if (date_ && time_of_day_ && time_of_day > *time_of_day_ + kHalfDay) {
    date_ = *date_ - std::chrono::days(1);
  }
  time_of_day_ = time_of_day;
  if (!date_) {
    if (epoch.has_fix()) {
      bad.add(epoch.place,
              "a fix has no date: no RMC or ZDA came before it or with it; the key start_date would give it");
    }
    return std::nullopt;
  }
  const std::optional<Time> counted = stamp_on(*date_, time_of_day);
  if (!counted) {
    bad.add(epoch.place, fmt::format("the year {} is not a year of a stamp; 1824 to 2115 are",
                                     static_cast<int>(std::chrono::year_month_day(*date_).year())));
    return std::nullopt;
  }
  const Time stamp = *counted;
  const bool was_right = had_fix_;
  had_fix_ = had_fix_ || epoch.has_fix();
  if (goes_on_after_step_back(stamp)) newest_.reset();
  if (newest_ && (stamp <= *newest_ || stamp - *newest_ > max_jump_)) {
    const bool back = stamp <= *newest_;
    bad.add(epoch.place, fmt::format("time {} by {:.3f} s, from {} to {}{}", back ? "goes back" : "jumps forward",
                                     to_seconds(back ? *newest_ - stamp : stamp - *newest_), date_and_time(*newest_),
                                     date_and_time(stamp), was_right ? "" : ": the receiver's clock was not set yet"));
    // A step forward is believed if time goes on from there; a step back in a log is never, or order would be lost.
    if (back) stepped_back_to_ = stamp;
    if (!was_right || !back) newest_ = stamp;
    if (was_right) return std::nullopt;
  }
  newest_ = stamp;
  stepped_back_to_.reset();
  return had_fix_ ? std::optional(stamp) : std::nullopt;
}

}  // namespace waymark::nmea
