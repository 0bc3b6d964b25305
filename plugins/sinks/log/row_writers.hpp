// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "waymark/interface/measurement.hpp"

namespace waymark::log_sink {

/// Turns payloads of one type and layout into rows, and describes to the csv source how to read them.
class RowWriter {
 public:
  virtual ~RowWriter() = default;

  /// True if the measurement can go into this table; another scan geometry needs another one.
  virtual bool fits(const Measurement&) const { return true; }
  /// Names of the columns behind the times, each with a comma before it.
  virtual std::string header() const = 0;
  /// Adds the measurement's rows, each of which begins with `times`. Throws Error.
  virtual void append(const Measurement& measurement, std::string_view times, std::string& out) = 0;
  /// What the entry of the csv source needs beside path, sensor, payload and times: lines of YAML, each behind
  /// `indent`.
  virtual std::string yaml(std::string_view indent) const = 0;
};

/// The writer for measurements like this one. `image_folder` is where images would go. Throws Error, which names the
/// payload type, if the csv source cannot read such a payload.
std::unique_ptr<RowWriter> make_row_writer(const Measurement& first, std::filesystem::path image_folder,
                                           int png_compression);

}  // namespace waymark::log_sink
