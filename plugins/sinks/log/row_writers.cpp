// SPDX-License-Identifier: Apache-2.0
#include "row_writers.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
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

/// One column of a payload that is a handful of numbers.
template <class T>
struct NumberField {
  std::string_view name;
  double (*value)(const T&);
};

/// Payloads that are a handful of numbers.
template <class T>
class NumbersWriter : public RowWriter {
 public:
  explicit NumbersWriter(std::vector<NumberField<T>> fields, bool some_unknown = false)
      : fields_(std::move(fields)), some_unknown_(some_unknown) {}

  std::string header() const override {
    std::string text;
    for (const NumberField<T>& field : fields_) text += ',' + std::string(field.name);
    return text;
  }

  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    const T& payload = measurement.as<T>();
    out += times;
    for (const NumberField<T>& field : fields_) {
      out += ',';
      const double value = field.value(payload);
      append_number(value, out);
      has_holes_ = has_holes_ || !std::isfinite(value);
    }
    out += '\n';
  }

  std::string yaml(std::string_view indent) const override {
    std::string text;
    if (has_holes_ && some_required()) text += fmt::format("{}required_may_be_empty: true\n", indent);
    if (some_unknown_) text += fmt::format("{}empty_is_unknown: true\n", indent);
    text += fmt::format("{}columns:\n", indent);
    for (const NumberField<T>& field : fields_) text += fmt::format("{}  {}\n", indent, column(field.name));
    return text;
  }

 protected:
  virtual std::string column(std::string_view name) const { return fmt::format("{}: {}", name, name); }
  virtual bool some_required() const { return true; }

 private:
  std::vector<NumberField<T>> fields_;
  bool some_unknown_;
  bool has_holes_ = false;
};

/// Which word of the csv source each number of `GnssFix::Type` is.
class FixWriter final : public NumbersWriter<GnssFix> {
 public:
  using NumbersWriter::NumbersWriter;

 private:
  std::string column(std::string_view name) const override {
    if (name != "type") return NumbersWriter::column(name);
    return "type: { column: type, map: { 0: none, 1: single, 2: differential, 3: rtk_float, 4: rtk_fixed, 5: unknown } "
           "}";
  }
  bool some_required() const override { return false; }
};

double type_number(GnssFix::Type type) {
  switch (type) {
    case GnssFix::Type::none:
      return 0.0;
    case GnssFix::Type::single:
      return 1.0;
    case GnssFix::Type::differential:
      return 2.0;
    case GnssFix::Type::rtk_float:
      return 3.0;
    case GnssFix::Type::rtk_fixed:
      return 4.0;
    case GnssFix::Type::unknown:
      break;
  }
  return 5.0;
}

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

/// One landmark in a row; rows of equal stamp are one set. A set without landmarks is a row of empty fields.
class LandmarkSetWriter final : public RowWriter {
 public:
  /// Two sets of equal stamp would be read as one.
  bool fits(const Measurement& measurement) const override { return measurement.stamp != last_; }

  std::string header() const override { return ",range_m,bearing_rad,radius_m,identity"; }

  void append(const Measurement& measurement, std::string_view times, std::string& out) override {
    last_ = measurement.stamp;
    const auto& set = measurement.as<LandmarkObservations>();
    if (set.landmarks.empty()) out += fmt::format("{},,,,\n", times);
    for (const LandmarkObservations::One& one : set.landmarks) {
      out += times;
      for (const double value : {one.range_m, one.bearing_rad, one.radius_m}) {
        out += ',';
        append_number(value, out);
      }
      out += fmt::format(",{}\n", one.identity);
    }
  }

  std::string yaml(std::string_view indent) const override {
    return fmt::format(
        "{0}empty_is_unknown: true\n{0}group_by_time: true\n"
        "{0}columns: {{ range_m: range_m, bearing_rad: bearing_rad, radius_m: radius_m, identity: identity }}\n",
        indent);
  }

 private:
  std::optional<Time> last_;
};

std::unique_ptr<RowWriter> make_fix_writer() {
  constexpr auto kUnknown = GnssFix::kUnknown;
  return std::make_unique<FixWriter>(
      std::vector<NumberField<GnssFix>>{
          {"east_m", [](const GnssFix& f) { return f.p_map_antenna.x(); }},
          {"north_m", [](const GnssFix& f) { return f.p_map_antenna.y(); }},
          {"up_m", [](const GnssFix& f) { return f.p_map_antenna.z(); }},
          {"latitude_deg", [](const GnssFix& f) { return f.latitude_deg; }},
          {"longitude_deg", [](const GnssFix& f) { return f.longitude_deg; }},
          {"height_m", [](const GnssFix& f) { return f.height_m; }},
          {"sigma_horizontal_m", [](const GnssFix& f) { return f.sigma_horizontal_m; }},
          {"sigma_vertical_m", [](const GnssFix& f) { return f.sigma_vertical_m; }},
          {"hdop", [](const GnssFix& f) { return f.hdop; }},
          {"satellites", [](const GnssFix& f) { return f.satellites < 0 ? kUnknown : f.satellites; }},
          {"type", [](const GnssFix& f) { return type_number(f.type); }},
          {"speed_mps", [](const GnssFix& f) { return f.speed_mps; }},
          {"course_rad", [](const GnssFix& f) { return f.course_rad; }}},
      true);
}

std::unique_ptr<RowWriter> make_imu_writer() {
  return std::make_unique<NumbersWriter<ImuSample>>(
      std::vector<NumberField<ImuSample>>{{"w_x_radps", [](const ImuSample& s) { return s.w_sensor.x(); }},
                                          {"w_y_radps", [](const ImuSample& s) { return s.w_sensor.y(); }},
                                          {"w_z_radps", [](const ImuSample& s) { return s.w_sensor.z(); }},
                                          {"f_x_mps2", [](const ImuSample& s) { return s.f_sensor.x(); }},
                                          {"f_y_mps2", [](const ImuSample& s) { return s.f_sensor.y(); }},
                                          {"f_z_mps2", [](const ImuSample& s) { return s.f_sensor.z(); }},
                                          {"m_x_t", [](const ImuSample& s) { return s.m_sensor.x(); }},
                                          {"m_y_t", [](const ImuSample& s) { return s.m_sensor.y(); }},
                                          {"m_z_t", [](const ImuSample& s) { return s.m_sensor.z(); }},
                                          {"q_w", [](const ImuSample& s) { return s.q_enu_sensor.w(); }},
                                          {"q_x", [](const ImuSample& s) { return s.q_enu_sensor.x(); }},
                                          {"q_y", [](const ImuSample& s) { return s.q_enu_sensor.y(); }},
                                          {"q_z", [](const ImuSample& s) { return s.q_enu_sensor.z(); }}},
      true);
}

std::unique_ptr<RowWriter> make_heading_writer() {
  return std::make_unique<NumbersWriter<CompassHeading>>(
      std::vector<NumberField<CompassHeading>>{
          {"heading_rad", [](const CompassHeading& c) { return c.heading_rad; }},
          {"sigma_rad", [](const CompassHeading& c) { return c.sigma_rad; }},
          {"from_true_north", [](const CompassHeading& c) { return c.from_true_north ? 1.0 : 0.0; }}},
      true);
}

}  // namespace

std::string_view short_name(std::string_view payload_type) {
  payload_type.remove_prefix(payload_type.find('/') + 1);
  return payload_type.substr(0, payload_type.find('@'));
}

std::unique_ptr<RowWriter> make_row_writer(const Measurement& first, std::filesystem::path image_folder,
                                           int png_compression) {
  const std::string_view type = first.payload->type();
  if (type == WheelSpeeds::kType) {
    return std::make_unique<NumbersWriter<WheelSpeeds>>(
        std::vector<NumberField<WheelSpeeds>>{{"left_mps", [](const WheelSpeeds& w) { return w.left_mps; }},
                                              {"right_mps", [](const WheelSpeeds& w) { return w.right_mps; }}});
  }
  if (type == WheelSteering::kType) {
    return std::make_unique<NumbersWriter<WheelSteering>>(std::vector<NumberField<WheelSteering>>{
        {"speed_mps", [](const WheelSteering& w) { return w.speed_mps; }},
        {"steering_rad", [](const WheelSteering& w) { return w.steering_rad; }}});
  }
  if (type == BodyTwist::kType) {
    return std::make_unique<NumbersWriter<BodyTwist>>(
        std::vector<NumberField<BodyTwist>>{{"v_x_mps", [](const BodyTwist& t) { return t.v_x_mps; }},
                                            {"v_y_mps", [](const BodyTwist& t) { return t.v_y_mps; }},
                                            {"w_z_radps", [](const BodyTwist& t) { return t.w_z_radps; }}});
  }
  if (type == PoseIncrement::kType) {
    return std::make_unique<NumbersWriter<PoseIncrement>>(
        std::vector<NumberField<PoseIncrement>>{{"interval_s", [](const PoseIncrement& i) { return i.interval_s; }},
                                                {"x_m", [](const PoseIncrement& i) { return i.x_m; }},
                                                {"y_m", [](const PoseIncrement& i) { return i.y_m; }},
                                                {"yaw_rad", [](const PoseIncrement& i) { return i.yaw_rad; }}});
  }
  if (type == CompassHeading::kType) return make_heading_writer();
  if (type == MagneticField::kType) {
    return std::make_unique<NumbersWriter<MagneticField>>(
        std::vector<NumberField<MagneticField>>{{"m_x_t", [](const MagneticField& m) { return m.m_sensor.x(); }},
                                                {"m_y_t", [](const MagneticField& m) { return m.m_sensor.y(); }},
                                                {"m_z_t", [](const MagneticField& m) { return m.m_sensor.z(); }}});
  }
  if (type == Height::kType) {
    return std::make_unique<NumbersWriter<Height>>(
        std::vector<NumberField<Height>>{{"height_m", [](const Height& h) { return h.height_m; }},
                                         {"sigma_m", [](const Height& h) { return h.sigma_m; }}},
        true);
  }
  if (type == GnssFix::kType) return make_fix_writer();
  if (type == ImuSample::kType) return make_imu_writer();
  if (type == LaserScan::kType) return std::make_unique<ScanWriter>(first.as<LaserScan>());
  if (type == Image::kType) return std::make_unique<ImageWriter>(std::move(image_folder), png_compression);
  if (type == LandmarkObservations::kType) return std::make_unique<LandmarkSetWriter>();
  throw Error(fmt::format("{} has no form that the csv source could read", type));
}

}  // namespace waymark::log_sink
