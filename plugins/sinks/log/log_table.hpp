// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "row_writers.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::log_sink {

/// One CSV file: measurements of one sensor with payloads of one type and layout, in order of arrival.
class LogTable {
 public:
  /// Throws Error if the file cannot be created.
  LogTable(const std::filesystem::path& file, std::string sensor, std::string_view payload_type,
           std::unique_ptr<RowWriter> rows);

  /// True if the measurement, of the same sensor, can be a row here.
  bool takes(const Measurement& measurement) const;
  /// Throws Error if arrivals go back, or for what cannot be written.
  void append(const Measurement& measurement);
  /// Throws Error.
  void commit() { file_.commit(); }

  /// The entry of the csv source that reads this table: an element of a list, in lines of YAML.
  std::string yaml(std::string_view indent) const;

 private:
  std::string name_;
  std::string sensor_;
  std::string payload_type_;
  std::unique_ptr<RowWriter> rows_;
  OutputFile file_;
  std::optional<Time> newest_;
  bool has_invalid_ = false;  // the host refuses some measurement
  std::string text_;          // of one measurement; kept for its memory
};

}  // namespace waymark::log_sink
