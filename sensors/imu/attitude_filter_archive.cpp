// SPDX-License-Identifier: Apache-2.0
#include "attitude_filter.hpp"

namespace waymark::imu {

namespace {

/// The same list for writing and reading.
template <class Archive, class Filter>
void each_count(Archive& archive, Filter& counts) {
  archive.value(counts.used);
  archive.value(counts.without_rate);
  archive.value(counts.out_of_order);
  archive.value(counts.without_force);
  archive.value(counts.without_field);
  archive.value(counts.disturbed);
  archive.value(counts.saturated);
  archive.value(counts.gaps);
}

}  // namespace

void AttitudeFilter::save(OutArchive& out) const {
  out.section("attitude_filter", 1);
  out.value(q_.coeffs());
  out.value(bias_);
  out.value(w_);
  out.value(last_rate_);
  out.value(P_);
  out.value(last_stamp_.has_value());
  out.value(last_stamp_.value_or(Time{}).time_since_epoch().count());
  out.value(levelled_);
  out.value(knows_tilt_);
  out.value(knows_heading_);
  out.value(q_map_level_.coeffs());
  out.value(q_level_sensor_.coeffs());
  out.value(force_sum_);
  out.value(field_sum_);
  out.value(force_count_);
  out.value(field_count_);
  out.value(levelling_s_);
  out.value(levelling_force_);
  force_.save(out);
  attitude_.save(out);
  motion_.save(out);
  out.value(since_restart_s_);
  out.value(since_force_s_);
  out.value(since_field_s_);
  field_.save(out);
  rest_.save(out);
  out.value(surprise_s_);
  saturation_.save(out);
  each_count(out, counts_);
}

void AttitudeFilter::load(InArchive& in) {
  in.section("attitude_filter", 1);
  in.value(q_.coeffs());
  in.value(bias_);
  in.value(w_);
  in.value(last_rate_);
  in.value(P_);
  bool known = false;
  std::int64_t stamp = 0;
  in.value(known);
  in.value(stamp);
  last_stamp_ = known ? std::optional(Time{Duration{stamp}}) : std::nullopt;
  in.value(levelled_);
  in.value(knows_tilt_);
  in.value(knows_heading_);
  in.value(q_map_level_.coeffs());
  in.value(q_level_sensor_.coeffs());
  in.value(force_sum_);
  in.value(field_sum_);
  in.value(force_count_);
  in.value(field_count_);
  in.value(levelling_s_);
  in.value(levelling_force_);
  force_.load(in);
  attitude_.load(in);
  motion_.load(in);
  in.value(since_restart_s_);
  in.value(since_force_s_);
  in.value(since_field_s_);
  field_.load(in);
  rest_.load(in);
  in.value(surprise_s_);
  saturation_.load(in);
  each_count(in, counts_);
}

}  // namespace waymark::imu
