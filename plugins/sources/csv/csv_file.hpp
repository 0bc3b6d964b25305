// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "column_map.hpp"
#include "delimited_reader.hpp"
#include "payload_builders.hpp"
#include "row_filter.hpp"
#include "time_column.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::csv {

/// One entry of `files`: the measurements of one sensor out of one file, in the order of the file.
class CsvFile {
 public:
  /// Throws ConfigError or, if the file has no data row, DataError.
  CsvFile(const Config& entry, Duration max_time_jump, Duration max_ahead);

  /// The next measurement, without channel and sequence; nothing at the end. Rows that cannot be used go to `bad_rows`.
  /// Throws DataError if the file is damaged or `bad_rows` is full.
  std::optional<Measurement> next(BadRecordList& bad_rows);

  /// The last arrival that was read; the order of the merge where a file cannot be read on.
  Time newest_arrival() const { return newest_.value_or(Time::min()); }

  const std::string& sensor() const { return sensor_; }
  std::string_view payload_type() const { return type_; }
  const DelimitedReader& reader() const { return reader_; }
  /// Equal for two entries that read the same columns and rows into the same payload.
  std::string signature() const;

 private:
  std::optional<Measurement> take_row();
  void check_order(Time stamp, Time arrival) const;
  std::optional<Measurement> rest_of_group();
  std::string changing_values(Row row) const;
  void check_values(const Payload& payload) const;
  bool make_growth(Measurement& read);
  bool place_interval(std::optional<Time> last_end, Measurement& read, Payload& payload) const;

  std::string sensor_;
  std::string_view type_;
  DelimitedReader reader_;
  ColumnFinder finder_;
  TimeColumn time_;
  std::optional<TimeColumn> arrival_;
  RowFilter filter_;
  std::unique_ptr<PayloadBuilder> builder_;
  bool group_by_time_ = false;
  Duration max_time_jump_;
  Duration max_ahead_;
  Duration min_step_{};
  std::vector<Column> changing_;  // of `only_changes_of`

  std::optional<Time> newest_;
  std::optional<Time> last_taken_;  // stamp of the last measurement, for min_step_
  std::string last_values_;         // of the changing columns
  std::size_t fields_of_first_row_ = 0;
  bool ends_interval_ = false;
  std::optional<Time> last_end_;  // of the interval of the row before
  bool is_cumulative_ = false;
  double wraps_at_ = 0.0;
  Measurement total_;                   // of `cumulative`, the row before; no payload: none
  Measurement group_;                   // the set that rows are added to; no payload: none
  std::shared_ptr<Payload> group_set_;  // its payload, writable
  std::exception_ptr failure_;          // thrown when the set before it is delivered
};

}  // namespace waymark::csv
