// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "column_map.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::csv {

/// Turns rows into payloads of one type.
class PayloadBuilder {
 public:
  virtual ~PayloadBuilder() = default;

  /// A payload out of one row. Throws BadRow.
  virtual std::shared_ptr<Payload> build(Row row) const = 0;
  /// Adds one row to what `build` made, if rows can form a set. Throws BadRow, and leaves the payload alone then.
  virtual void append(Row row, Payload& payload) const;
  virtual bool can_append() const { return false; }
  /// True if a row alone is no measurement.
  virtual bool wants_sets() const { return false; }

  /// What rows of totals give: nothing; a speed, true in the middle between two rows; a motion, from the first of two
  /// on.
  enum class Totals { none, speed, motion };
  virtual Totals totals() const { return Totals::none; }
  /// What became of the totals `before`, which `build` made, in `seconds` > 0. A total that starts over at `wraps_at`
  /// (raw, before scale; 0: none does) grew by less than half of that. Throws BadRow.
  virtual std::shared_ptr<Payload> growth(const Payload& before, const Payload& after, double seconds,
                                          double wraps_at) const;
  /// True if a row may describe an interval, not an instant.
  virtual bool has_interval() const { return false; }
  /// How long before the end of that interval the payload's stamp lies. `since_last` > 0: the time since the row
  /// before, if there is one; the payload may get its length from it. Nothing: that row is needed.
  virtual std::optional<Duration> stamp_before_end(Payload& payload, std::optional<Duration> since_last) const;
  /// True if every row must have as many fields as the file's first.
  virtual bool wants_equal_rows() const { return false; }
};

/// The full type of a name in the YAML: "LaserScan" or "waymark/LaserScan@1". Throws ConfigError at `payload` of the
/// entry.
std::string_view payload_type(const Config& entry);

/// The key `cumulative`: its columns hold totals. Throws ConfigError.
bool holds_totals(const Config& entry);
/// Its key `wraps_at`: where raw totals begin anew; 0: they do not. Throws ConfigError.
double totals_wrap_at(const Config& entry);

/// The key `end_of_interval`: stamps are the ends of intervals. Throws ConfigError.
bool ends_interval(const Config& entry);

/// The builder for that type from `columns` (and `scan`) of the entry. Throws ConfigError.
std::unique_ptr<PayloadBuilder> make_payload_builder(std::string_view type, const Config& entry, ColumnFinder& finder);

}  // namespace waymark::csv
