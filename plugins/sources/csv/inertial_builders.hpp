// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "payload_builders.hpp"

namespace waymark::csv {

/// Samples of an IMU: rates, and what else it has.
class ImuBuilder final : public PayloadBuilder {
 public:
  /// Throws ConfigError.
  ImuBuilder(const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;

 private:
  std::vector<NumberColumn> w_;
  std::vector<NumberColumn> f_;  // all axes, or none
  std::vector<NumberColumn> m_;
  std::vector<NumberColumn> q_;  // w, x, y, z
};

/// Headings of a compass.
class HeadingBuilder final : public PayloadBuilder {
 public:
  /// Throws ConfigError.
  HeadingBuilder(const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;

 private:
  NumberColumn heading_;
  std::optional<NumberColumn> sigma_;
  bool always_true_north_ = false;
  std::optional<NumberColumn> true_north_;
};

/// Vectors of the magnetic field.
class FieldBuilder final : public PayloadBuilder {
 public:
  /// Throws ConfigError.
  FieldBuilder(const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;

 private:
  std::vector<NumberColumn> m_;
};

}  // namespace waymark::csv
