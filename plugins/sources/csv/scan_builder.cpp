// SPDX-License-Identifier: Apache-2.0
#include "scan_builder.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "bad_row.hpp"
#include "number_text.hpp"
#include "units.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

constexpr float kNoReturn = std::numeric_limits<float>::infinity();

/// An angle in degrees, as people write it, or in radians, as it is used.
double read_angle(const Config& scan, const Config::Key& degrees, const Config::Key& radians) {
  if (!scan.has(radians.name)) return scan.number_in(degrees, -360.0, 360.0) * kRadPerDeg;
  if (scan.has(degrees.name)) scan.fail(radians.name, "give it in degrees or in radians, not both");
  return scan.number_in(radians, -360.0 * kRadPerDeg, 360.0 * kRadPerDeg);
}

std::string rounded(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6).ptr;
  return {text.data(), end};
}

/// Throws ConfigError for a step with which the beams would go around more than once, as in another unit.
void check_turn(const Config& entry, const ScanShape& shape, std::size_t beams) {
  constexpr double kMostDegrees = 1.01 * 360.0;  // steps are rounded
  const double step = std::abs(shape.step_rad) / kRadPerDeg;
  const double turn = step * (static_cast<double>(beams) - 1.0);
  if (turn <= kMostDegrees) return;
  const Config scan = entry.child("scan");
  scan.fail(scan.has("step_rad") ? "step_rad" : "step_deg", std::to_string(beams) + " beams of " + rounded(step) +
                                                                " deg cover " + rounded(turn) +
                                                                " deg; at most 360 are possible");
}

ColumnRange read_ranges(const Config& columns, ColumnFinder& finder) {
  check_fields(columns, {{"ranges_m", "m"}, {"intensities", ""}}, {"ranges_m"}, "LaserScan");
  return {columns, Config::Key("ranges_m", "m", "a range of columns: one for each beam"), finder};
}

NumberColumn read_beam_range(const Config& columns, ColumnFinder& finder) {
  check_fields(columns, {{"range_m", "m"}, {"bearing_rad", "rad"}, {"intensity", ""}}, {"range_m", "bearing_rad"},
               "a beam of LaserScan");
  return {columns, Config::Key("range_m", "m", "of scans with one beam a row: its range"), finder};
}

std::shared_ptr<LaserScan> empty_scan(const ScanShape& shape) {
  auto scan = std::make_shared<LaserScan>();
  scan->start_rad = shape.start_rad;
  scan->step_rad = shape.step_rad;
  scan->beam_interval_s = shape.beam_interval_s;
  return scan;
}

/// Of a scan whose last beam is measured at the end of the sweep.
Duration sweep_time(const Payload& payload) {
  const auto& scan = static_cast<const LaserScan&>(payload);
  const auto steps = static_cast<double>(scan.ranges_m.size()) - 1.0;
  return from_seconds(std::max(0.0, steps * scan.beam_interval_s));
}

}  // namespace

ScanShape read_scan_shape(const Config& entry) {
  ScanShape shape;
  const Config scan = entry.child({"scan", "of `LaserScan`: where its beams point"});
  shape.start_rad = read_angle(scan, {"start_deg", "°", "first beam, counter-clockwise from the sensor's x axis"},
                               {"start_rad", "rad", "the same, instead of `start_deg`"});
  shape.step_rad = read_angle(scan, {"step_deg", "°", "from beam to beam: beam k points at start + k · step"},
                              {"step_rad", "rad", "the same, instead of `step_deg`"});
  if (shape.step_rad == 0.0) {
    scan.fail(scan.has("step_rad") ? "step_rad" : "step_deg",
              "0 lets all beams point the same way; a number other than 0 is expected");
  }
  shape.beam_interval_s =
      scan.number_in({"beam_interval_s", "s",
                      "time from one beam to the next, if the scanner turns and beam 0 is measured at the stamp: "
                      "maps then see the scan as from one place; negative: the later beams are the older ones"},
                     -1.0, 1.0, 0.0);
  shape.allow_non_finite = scan.boolean(
      {"allow_non_finite",
       "a range of NaN or infinity is not a return (+infinity), and such an intensity 0; otherwise the row is bad"},
      false);
  return shape;
}

ScanBuilder::ScanBuilder(const Config& entry, const Config& columns, ColumnFinder& finder)
    : ranges_(read_ranges(columns, finder)) {
  if (columns.has("intensities")) {
    intensities_.emplace(columns, Config::Key("intensities", "", "a range of columns, as many as ranges", "none"),
                         finder);
    if (intensities_->count() != ranges_.count()) {
      columns.fail("intensities", std::to_string(intensities_->count()) + " columns for " +
                                      std::to_string(ranges_.count()) + " ranges; as many are expected");
    }
  }
  shape_ = read_scan_shape(entry);
  check_turn(entry, shape_, ranges_.count());
}

std::shared_ptr<Payload> ScanBuilder::build(Row row) const {
  auto scan = empty_scan(shape_);
  const auto instead = [this](float value) {
    return shape_.allow_non_finite ? std::optional<float>(value) : std::nullopt;
  };
  ranges_.read(row, scan->ranges_m, instead(kNoReturn));
  if (intensities_) intensities_->read(row, scan->intensities, instead(0.0F));
  return scan;
}

std::optional<Duration> ScanBuilder::stamp_before_end(Payload& payload, std::optional<Duration>) const {
  return sweep_time(payload);
}

bool BeamBuilder::is_meant(const Config& columns) {
  return !given_key(columns, {"ranges_m", "m"}) && given_key(columns, {"range_m", "m"});
}

BeamBuilder::BeamBuilder(const Config& entry, const Config& columns, ColumnFinder& finder)
    : range_(read_beam_range(columns, finder)),
      bearing_(columns, {"bearing_rad", "rad", "its direction, counter-clockwise from the sensor's x axis"}, finder),
      intensity_(optional_number_column(columns, {"intensity", "", "its intensity", "none"}, finder)),
      shape_(read_scan_shape(entry)) {}

/// The beam that points there, or nearest.
std::size_t BeamBuilder::beam_at(double bearing_rad, Row row) const {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double turn = kTurn / std::abs(shape_.step_rad);  // in beams
  double beam = (bearing_rad - shape_.start_rad) / shape_.step_rad;
  if (beam <= -0.5) {
    beam += turn;
  } else if (beam >= turn - 0.5) {
    beam -= turn;
  }
  if (!(beam > -0.5 && beam < turn - 0.5)) {
    throw BadRow(bearing_.text(row) + " in " + bearing_.label() +
                 " lies a turn or more from scan.start; is its unit right?");
  }
  return static_cast<std::size_t>(std::lround(std::max(beam, 0.0)));
}

std::shared_ptr<Payload> BeamBuilder::build(Row row) const {
  auto scan = empty_scan(shape_);
  append(row, *scan);
  return scan;
}

void BeamBuilder::append(Row row, Payload& payload) const {
  auto& scan = static_cast<LaserScan&>(payload);
  const std::size_t beam = beam_at(bearing_.read(row), row);
  const double raw = range_.read_any(row);
  if (!std::isfinite(raw) && !shape_.allow_non_finite) {
    throw BadRow(range_.text(row) + " in " + range_.label() +
                 " is not finite; if it means no return, set scan.allow_non_finite");
  }
  const float range = std::isfinite(raw) ? static_cast<float>(raw) : kNoReturn;
  const float intensity = intensity_ ? static_cast<float>(intensity_->read(row)) : 0.0F;
  if (beam >= scan.ranges_m.size()) {
    scan.ranges_m.resize(beam + 1, kNoReturn);
    if (intensity_) scan.intensities.resize(beam + 1, 0.0F);
  }
  if (range >= scan.ranges_m[beam]) return;  // of two at one beam the nearer is in the way
  scan.ranges_m[beam] = range;
  if (intensity_) scan.intensities[beam] = intensity;
}

std::optional<Duration> BeamBuilder::stamp_before_end(Payload& payload, std::optional<Duration>) const {
  return sweep_time(payload);
}

}  // namespace waymark::csv
