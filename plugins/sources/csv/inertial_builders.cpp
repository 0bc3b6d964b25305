// SPDX-License-Identifier: Apache-2.0
#include "inertial_builders.hpp"

#include <cmath>
#include <initializer_list>
#include <string_view>

#include "number_text.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

using Names = std::initializer_list<std::string_view>;

std::vector<NumberColumn> all_columns(const Config& columns, Names names, ColumnFinder& finder) {
  std::vector<NumberColumn> found;
  for (const std::string_view name : names) found.emplace_back(columns, name, finder);
  return found;
}

std::vector<NumberColumn> all_or_none(const Config& columns, Names names, ColumnFinder& finder) {
  std::vector<NumberColumn> found;
  for (const std::string_view name : names) {
    if (auto column = optional_number_column(columns, name, finder)) found.push_back(std::move(*column));
  }
  if (found.empty() || found.size() == names.size()) return found;
  std::string list;
  std::size_t count = 0;
  for (const std::string_view name : names) {
    const bool last = ++count == names.size();
    list += (list.empty() ? "" : last ? " and " : ", ") + in_quotes(name);
  }
  columns.fail("ImuSample needs " + list + ", or none of them");
}

void read_vector(Row row, const std::vector<NumberColumn>& axes, Eigen::Vector3d& vector) {
  for (std::size_t i = 0; i < axes.size(); ++i) vector[static_cast<Eigen::Index>(i)] = axes[i].read(row);
}

}  // namespace

ImuBuilder::ImuBuilder(const Config& columns, ColumnFinder& finder) {
  check_fields(columns,
               {"w_x_radps", "w_y_radps", "w_z_radps", "f_x_mps2", "f_y_mps2", "f_z_mps2", "m_x_t", "m_y_t", "m_z_t",
                "q_w", "q_x", "q_y", "q_z"},
               {"w_x_radps", "w_y_radps", "w_z_radps"}, "ImuSample");
  w_ = all_columns(columns, {"w_x_radps", "w_y_radps", "w_z_radps"}, finder);
  f_ = all_or_none(columns, {"f_x_mps2", "f_y_mps2", "f_z_mps2"}, finder);
  m_ = all_or_none(columns, {"m_x_t", "m_y_t", "m_z_t"}, finder);
  q_ = all_or_none(columns, {"q_w", "q_x", "q_y", "q_z"}, finder);
}

std::shared_ptr<Payload> ImuBuilder::build(Row row) const {
  auto sample = std::make_shared<ImuSample>();
  read_vector(row, w_, sample->w_sensor);
  read_vector(row, f_, sample->f_sensor);
  read_vector(row, m_, sample->m_sensor);
  if (q_.empty()) return sample;
  const Eigen::Quaterniond q(q_[0].read(row), q_[1].read(row), q_[2].read(row), q_[3].read(row));
  const double norm = q.norm();
  if (norm == 0.0 || q.coeffs().array().isNaN().all()) return sample;
  constexpr double kLoose = 0.01;
  constexpr double kTight = 1e-9;  // what was normalised once stays as it is, bit by bit
  if (!(std::abs(norm - 1.0) < kLoose)) {
    throw BadRow("q_w to q_z are no unit quaternion: their norm is " + std::to_string(norm));
  }
  sample->q_enu_sensor = std::abs(norm - 1.0) < kTight ? q : q.normalized();
  return sample;
}

HeadingBuilder::HeadingBuilder(const Config& columns, ColumnFinder& finder)
    : heading_(
          (check_fields(columns, {"heading_rad", "sigma_rad", "from_true_north"}, {"heading_rad"}, "CompassHeading"),
           columns),
          "heading_rad", finder),
      sigma_(optional_number_column(columns, "sigma_rad", finder)) {
  if (!columns.has("from_true_north")) return;
  const std::string word = columns.is_mapping("from_true_north") ? "" : columns.text("from_true_north");
  if (word == "true" || word == "false") {
    always_true_north_ = word == "true";
  } else {
    true_north_.emplace(columns, "from_true_north", finder);
  }
}

std::shared_ptr<Payload> HeadingBuilder::build(Row row) const {
  auto heading = std::make_shared<CompassHeading>();
  heading->heading_rad = heading_.read(row);
  if (sigma_) heading->sigma_rad = sigma_->read(row);
  heading->from_true_north = always_true_north_;
  if (true_north_) {
    const double value = true_north_->read(row);
    if (value != 0.0 && value != 1.0) {
      const Column& column = true_north_->column();
      throw BadRow(in_quotes(row[column.index]) + " in " + column.label + " is neither 0 nor 1");
    }
    heading->from_true_north = value == 1.0;
  }
  return heading;
}

FieldBuilder::FieldBuilder(const Config& columns, ColumnFinder& finder) {
  check_fields(columns, {"m_x_t", "m_y_t", "m_z_t"}, {"m_x_t", "m_y_t", "m_z_t"}, "MagneticField");
  m_ = all_columns(columns, {"m_x_t", "m_y_t", "m_z_t"}, finder);
}

std::shared_ptr<Payload> FieldBuilder::build(Row row) const {
  auto field = std::make_shared<MagneticField>();
  read_vector(row, m_, field->m_sensor);
  return field;
}

}  // namespace waymark::csv
