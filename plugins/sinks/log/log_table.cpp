// SPDX-License-Identifier: Apache-2.0
#include "log_table.hpp"

#include <fmt/format.h>

#include <utility>

#include "replay.hpp"
#include "waymark/base/error.hpp"

namespace waymark::log_sink {

LogTable::LogTable(const std::filesystem::path& file, std::string sensor, std::string_view payload_type,
                   std::unique_ptr<RowWriter> rows)
    : name_(file.filename().string()),
      sensor_(std::move(sensor)),
      payload_type_(payload_type),
      rows_(std::move(rows)),
      file_(file) {
  file_.write("t_ns,arrival_ns" + rows_->header() + '\n');
}

bool LogTable::takes(const Measurement& measurement) const {
  return measurement.payload->type() == payload_type_ && rows_->fits(measurement);
}

void LogTable::append(const Measurement& measurement) {
  if (newest_ && measurement.arrival < *newest_) {
    throw Error(fmt::format("sensor {}: arrivals go back from {} to {} s; the csv source could not read that", sensor_,
                            format_time(*newest_), format_time(measurement.arrival)));
  }
  newest_ = measurement.arrival;
  const std::string times = fmt::format("{},{}", measurement.stamp.time_since_epoch().count(),
                                        measurement.arrival.time_since_epoch().count());
  has_invalid_ = has_invalid_ || !measurement.payload->problem().empty();
  text_.clear();
  rows_->append(measurement, times, text_);
  file_.write(text_);
}

std::string LogTable::yaml(std::string_view indent) const {
  std::string text = fmt::format("{}- path: {}\n", indent, in_quotes(name_));
  const std::string deeper = std::string(indent) + "  ";
  text += fmt::format("{}sensor: {}\n", deeper, in_quotes(sensor_));
  text += fmt::format("{}payload: {}\n", deeper, short_type_name(payload_type_));
  text += fmt::format("{}time: {{ column: t_ns, scale: 1e-9 }}\n", deeper);
  text += fmt::format("{}arrival: {{ column: arrival_ns, scale: 1e-9 }}\n", deeper);
  if (has_invalid_) text += fmt::format("{}keep_invalid: true\n", deeper);
  return text + rows_->yaml(deeper);
}

}  // namespace waymark::log_sink
