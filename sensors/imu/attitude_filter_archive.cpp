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

void pass(const auto& part, OutArchive& archive) { part.save(archive); }
void pass(auto& part, InArchive& archive) { part.load(archive); }

}  // namespace

template <class Archive, class Filter>
void AttitudeFilter::each_state(Archive& archive, Filter& filter) {
  archive.value(filter.q_.coeffs());
  archive.value(filter.bias_);
  archive.value(filter.w_);
  archive.value(filter.last_rate_);
  archive.value(filter.P_);
  archive.value(filter.last_stamp_);
  archive.value(filter.levelled_);
  archive.value(filter.knows_tilt_);
  archive.value(filter.knows_heading_);
  archive.value(filter.q_map_level_.coeffs());
  archive.value(filter.q_level_sensor_.coeffs());
  archive.value(filter.force_sum_);
  archive.value(filter.field_sum_);
  archive.value(filter.force_count_);
  archive.value(filter.field_count_);
  archive.value(filter.levelling_s_);
  archive.value(filter.levelling_force_);
  pass(filter.force_, archive);
  pass(filter.attitude_, archive);
  pass(filter.motion_, archive);
  archive.value(filter.since_restart_s_);
  archive.value(filter.since_force_s_);
  archive.value(filter.since_field_s_);
  pass(filter.field_, archive);
  pass(filter.rest_, archive);
  archive.value(filter.surprise_s_);
  pass(filter.saturation_, archive);
  each_count(archive, filter.counts_);
}

void AttitudeFilter::save(OutArchive& out) const {
  out.section("attitude_filter", 1);
  each_state(out, *this);
}

void AttitudeFilter::load(InArchive& in) {
  in.section("attitude_filter", 1);
  each_state(in, *this);
}

}  // namespace waymark::imu
