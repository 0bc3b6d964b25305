// SPDX-License-Identifier: Apache-2.0
#include "row_writers.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "image_files.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::log_sink {
namespace {

/// The shortest text that reads back to the same number; one that is unknown, or infinite, is an empty field.
void append_number(double value, std::string& out) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(out), "{}", value);
}

/// The same for a float that is read as a double and then rounded.
void append_float(float value, std::string& out) {
  const std::size_t begin = out.size();
  fmt::format_to(std::back_inserter(out), "{}", value);
  double read = 0.0;
  std::from_chars(out.data() + begin, out.data() + out.size(), read);
  if (static_cast<float>(read) == value || std::isnan(value)) return;
  out.resize(begin);
  fmt::format_to(std::back_inserter(out), "{}", static_cast<double>(value));
}

/// The number in a column, or NaN for an empty field; what is not known is such a one.
double column_value(const FieldInfo& info, const FieldValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    const bool unknown = !info.unknown.empty() && *integer < 0;
    return unknown ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(*integer);
  }
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? 1.0 : 0.0;
  if (const auto* word = std::get_if<FieldWord>(&value)) return word->number;
  return std::numeric_limits<double>::quiet_NaN();
}

/// Calls `column(info, name, value)` for every column of the fields that are visited.
template <class Column>
class EachColumn final : public FieldVisitor {
 public:
  explicit EachColumn(Column column) : column_(std::move(column)) {}

  void field(const FieldInfo& info, const FieldValue& value) override {
    if (const auto* numbers = std::get_if<std::span<const double>>(&value)) {
      for (std::size_t i = 0; i < numbers->size(); ++i) column_(info, info.names[i], (*numbers)[i]);
    } else {
      column_(info, info.name(), column_value(info, value));
    }
  }

 private:
  Column column_;
};

/// "type: { column: type, map: { 0: none, 1: single } }" for an enum, else "x_m: x_m".
std::string column_yaml(const FieldInfo& info, std::string_view name) {
  if (info.words.empty()) return fmt::format("{}: {}", name, name);
  std::string map;
  for (std::size_t i = 0; i < info.words.size(); ++i)
    map += fmt::format("{}{}: {}", map.empty() ? "" : ", ", i, info.words[i]);
  return fmt::format("{}: {{ column: {}, map: {{ {} }} }}", name, name, map);
}

/// Payloads whose registered fields are a handful of numbers: a column for each.
class FieldsWriter final : public RowWriter {
 public:
  explicit FieldsWriter(const Payload& first) {
    EachColumn visitor([this](const FieldInfo& info, std::string_view name, double) {
      header_ += ',' + std::string(name);
      columns_.push_back(column_yaml(info, name));
      some_unknown_ = some_unknown_ || !info.unknown.empty();
    });
    first.visit(visitor);
  }

  std::string header() const override { return header_; }

  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    out += times;
    EachColumn visitor([&out](const FieldInfo&, std::string_view, double value) {
      out += ',';
      append_number(value, out);
    });
    measurement.payload->visit(visitor);
    out += '\n';
  }

  std::string yaml(std::string_view indent) const override {
    std::string text;
    if (some_unknown_) text += fmt::format("{}empty_is_unknown: true\n", indent);
    text += fmt::format("{}columns:\n", indent);
    for (const std::string& column : columns_) text += fmt::format("{}  {}\n", indent, column);
    return text;
  }

 private:
  std::string header_;
  std::vector<std::string> columns_;  // of YAML
  bool some_unknown_ = false;
};

/// One scan in a row. Beams that lie otherwise need a table of their own.
class ScanWriter final : public RowWriter {
 public:
  explicit ScanWriter(const LaserScan& first)
      : start_rad_(first.start_rad),
        step_rad_(first.step_rad),
        beam_interval_s_(first.beam_interval_s),
        ranges_(first.ranges_m.size()),
        intensities_(first.intensities.size()) {
    if (ranges_ == 0) throw Error("a scan without beams cannot be a row");
    if (intensities_ != 0 && intensities_ != ranges_)
      throw Error(fmt::format("a scan has {} ranges, but {} intensities", ranges_, intensities_));
  }

  bool fits(const Measurement& measurement) const override {
    const auto& scan = measurement.as<LaserScan>();
    return scan.start_rad == start_rad_ && scan.step_rad == step_rad_ && scan.beam_interval_s == beam_interval_s_ &&
           scan.ranges_m.size() == ranges_ && scan.intensities.size() == intensities_;
  }

  std::string header() const override {
    std::string text;
    for (std::size_t k = 0; k < ranges_; ++k) text += fmt::format(",r{}", k);
    for (std::size_t k = 0; k < intensities_; ++k) text += fmt::format(",i{}", k);
    return text;
  }

  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    const auto& scan = measurement.as<LaserScan>();
    out += times;
    for (const std::vector<float>* values : {&scan.ranges_m, &scan.intensities}) {
      for (const float value : *values) {
        out += ',';
        append_float(value, out);
      }
    }
    out += '\n';
  }

  std::string yaml(std::string_view indent) const override {
    std::string text =
        fmt::format("{}scan: {{ start_rad: {}, step_rad: {}, beam_interval_s: {}, allow_non_finite: true }}\n", indent,
                    start_rad_, step_rad_, beam_interval_s_);
    text += fmt::format("{}columns:\n{}  ranges_m: {{ first: r0, count: {} }}\n", indent, indent, ranges_);
    if (intensities_ > 0) text += fmt::format("{}  intensities: {{ first: i0, count: {} }}\n", indent, intensities_);
    return text;
  }

 private:
  double start_rad_;
  double step_rad_;
  double beam_interval_s_;
  std::size_t ranges_;
  std::size_t intensities_;
};

/// The path of an image's own file.
class ImageWriter final : public RowWriter {
 public:
  ImageWriter(std::filesystem::path folder, int png_compression) : files_(std::move(folder), png_compression) {}

  std::string header() const override { return ",file"; }
  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    out += fmt::format("{},{}\n", times, files_.add(measurement.as<Image>()));
  }
  std::string yaml(std::string_view indent) const override {
    return fmt::format("{}columns: {{ file: file }}\n", indent);
  }

 private:
  ImageFiles files_;
};

/// One element of a set in a row; rows of equal stamp are one set. An empty set is a row of empty fields.
template <class T, auto list>
class SetWriter final : public RowWriter {
 public:
  /// Two sets of equal stamp would be read as one.
  bool fits(const Measurement& measurement) const override { return measurement.stamp != last_; }

  std::string header() const override {
    std::string text;
    for_each_name([&](std::string_view name) { text += ',' + std::string(name); });
    return text;
  }

  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    last_ = measurement.stamp;
    const auto& set = measurement.as<T>().*list;
    EachColumn visitor([&out](const FieldInfo&, std::string_view, double value) {
      out += ',';
      append_number(value, out);
    });
    if (set.empty()) {
      out += times;
      for_each_name([&](std::string_view) { out += ','; });
      out += '\n';
    }
    for (const typename T::One& one : set) {
      out += times;
      visit_fields(one, visitor);
      out += '\n';
    }
  }

  std::string yaml(std::string_view indent) const override {
    std::string columns;
    for_each_name(
        [&](std::string_view name) { columns += fmt::format("{}{}: {}", columns.empty() ? "" : ", ", name, name); });
    return fmt::format("{0}empty_is_unknown: true\n{0}group_by_time: true\n{0}columns: {{ {1} }}\n", indent, columns);
  }

 private:
  template <class Name>
  static void for_each_name(Name name) {
    T::One::fields([&](auto, const FieldInfo& info) { name(info.name()); });
  }

  std::optional<Time> last_;
};

/// Those of core's payloads that the csv source reads out of one row of numbers.
bool is_row_of_numbers(std::string_view type) {
  const auto any = [type](const auto&... one) { return ((type == one) || ...); };
  return any(WheelSpeeds::kType, WheelSteering::kType, BodyTwist::kType, PoseIncrement::kType, GnssFix::kType,
             ImuSample::kType, CompassHeading::kType, MagneticField::kType, Height::kType);
}

}  // namespace

std::unique_ptr<RowWriter> make_row_writer(const Measurement& first, std::filesystem::path image_folder,
                                           int png_compression) {
  const std::string_view type = first.payload->type();
  if (is_row_of_numbers(type)) return std::make_unique<FieldsWriter>(*first.payload);
  if (type == LaserScan::kType) return std::make_unique<ScanWriter>(first.as<LaserScan>());
  if (type == Image::kType) return std::make_unique<ImageWriter>(std::move(image_folder), png_compression);
  if (type == LandmarkObservations::kType) {
    return std::make_unique<SetWriter<LandmarkObservations, &LandmarkObservations::landmarks>>();
  }
  if (type == Ranges::kType) return std::make_unique<SetWriter<Ranges, &Ranges::ranges>>();
  if (type == RadarTargets::kType) return std::make_unique<SetWriter<RadarTargets, &RadarTargets::targets>>();
  throw Error(fmt::format("{} has no form that the csv source could read", type));
}

}  // namespace waymark::log_sink
