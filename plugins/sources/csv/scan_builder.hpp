// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "payload_builders.hpp"

namespace waymark::csv {

/// Where the beams of a scan point: the key `scan` of an entry.
struct ScanShape {
  double start_rad = 0.0;
  double step_rad = 0.0;
  double beam_interval_s = 0.0;
  bool allow_non_finite = false;
};

/// Throws ConfigError.
ScanShape read_scan_shape(const Config& entry);

/// Scans of which a row holds all beams.
class ScanBuilder final : public PayloadBuilder {
 public:
  /// Columns `ranges_m` and `intensities`. Throws ConfigError.
  ScanBuilder(const Config& entry, const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;
  bool wants_equal_rows() const override { return true; }
  bool has_interval() const override { return true; }
  std::optional<Duration> stamp_before_end(Payload& payload, std::optional<Duration> since_last) const override;

 private:
  ColumnRange ranges_;
  std::optional<ColumnRange> intensities_;
  ScanShape shape_;
};

/// Scans of which a row holds one beam.
class BeamBuilder final : public PayloadBuilder {
 public:
  /// True if `columns` are those of one beam.
  static bool is_meant(const Config& columns);

  /// Columns `range_m`, `bearing_rad` and `intensity`. Throws ConfigError.
  BeamBuilder(const Config& entry, const Config& columns, ColumnFinder& finder);

  /// A scan of one beam. Those before it are not returns.
  std::shared_ptr<Payload> build(Row row) const override;
  void append(Row row, Payload& payload) const override;
  bool can_append() const override { return true; }
  bool wants_sets() const override { return true; }
  bool has_interval() const override { return true; }
  std::optional<Duration> stamp_before_end(Payload& payload, std::optional<Duration> since_last) const override;

 private:
  std::size_t beam_at(double bearing_rad, Row row) const;

  NumberColumn range_;
  NumberColumn bearing_;
  std::optional<NumberColumn> intensity_;
  ScanShape shape_;
};

}  // namespace waymark::csv
