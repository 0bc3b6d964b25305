// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "targets_file.hpp"
#include "text_table.hpp"

namespace waymark::radar {

/// Targets as rows of text, in Cartesian coordinates; rows of equal time are one scan.
class PointsText final : public TargetsFile {
 public:
  /// Throws DataError if a column is missing.
  explicit PointsText(std::unique_ptr<BytesFile> file)
      : table_(std::move(file), {"t_s", "x_m", "y_m", "z_m", "doppler_mps"}) {}

  double progress() const override { return table_.progress(); }

 protected:
  std::optional<Scan> read() override;
  std::string place() const override { return table_.place(); }

 private:
  struct Point {
    Time stamp;
    std::optional<RadarTargets::One> target;  ///< nothing: at the radar itself
  };
  std::optional<Point> next_point();

  TextTable table_;
  std::optional<Point> ahead_;
};

}  // namespace waymark::radar
