// SPDX-License-Identifier: Apache-2.0
#include "payload_builders.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "image_builder.hpp"
#include "inertial_builders.hpp"
#include "motion_builder.hpp"
#include "number_text.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::csv {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

constexpr std::array<std::string_view, 12> kTypes = {
    WheelSpeeds::kType,    WheelSteering::kType, BodyTwist::kType, PoseIncrement::kType,
    GnssFix::kType,        LaserScan::kType,     Image::kType,     ImuSample::kType,
    CompassHeading::kType, MagneticField::kType, Height::kType,    LandmarkObservations::kType};

std::string_view short_name(std::string_view type) {
  type.remove_prefix(type.find('/') + 1);
  return type.substr(0, type.find('@'));
}

/// A field of a payload that is one number.
template <class T>
struct Field {
  std::string_view name;
  double T::*member;
  bool required = true;
};

/// Payloads that consist of numbers only.
template <class T>
class NumbersBuilder final : public PayloadBuilder {
 public:
  /// `per_second`: every field is something per second, so that a log may hold its total instead.
  NumbersBuilder(const Config& columns, std::initializer_list<Field<T>> fields, ColumnFinder& finder,
                 bool per_second = false)
      : per_second_(per_second) {
    std::vector<std::string_view> valid;
    std::vector<std::string_view> required;
    for (const Field<T>& field : fields) {
      valid.push_back(field.name);
      if (field.required) required.push_back(field.name);
    }
    check_fields(columns, valid, required, short_name(T::kType));
    for (const Field<T>& field : fields) {
      if (!columns.has(field.name)) continue;
      NumberColumn column(columns, field.name, finder);
      if (!field.required && finder.allows_empty()) column.allow_empty();
      columns_.push_back({std::move(column), field.member, field.required});
    }
  }

  std::shared_ptr<Payload> build(Row row) const override {
    auto payload = std::make_shared<T>();
    for (const auto& [column, member, required] : columns_) {
      if (required || !column.is_unknown(row)) (*payload).*member = column.read(row);
    }
    return payload;
  }

  Totals totals() const override { return per_second_ ? Totals::speed : Totals::none; }

  std::shared_ptr<Payload> growth(const Payload& before, const Payload& after, double seconds,
                                  double wraps_at) const override {
    auto payload = std::make_shared<T>();
    for (const auto& [column, member, required] : columns_) {
      const double first = static_cast<const T&>(before).*member;
      const double last = static_cast<const T&>(after).*member;
      (*payload).*member = column.growth(first, last, wraps_at) / seconds;
    }
    return payload;
  }

 private:
  struct Mapped {
    NumberColumn column;
    double T::*member;
    bool required;
  };
  std::vector<Mapped> columns_;
  bool per_second_;
};

class GnssBuilder final : public PayloadBuilder {
 public:
  GnssBuilder(const Config& columns, ColumnFinder& finder) {
    check_fields(columns,
                 {"east_m", "north_m", "up_m", "latitude_deg", "longitude_deg", "height_m", "sigma_horizontal_m",
                  "sigma_vertical_m", "hdop", "satellites", "type", "speed_mps", "course_rad"},
                 {}, "GnssFix");
    const bool local = columns.has("east_m") && columns.has("north_m");
    const bool geodetic = columns.has("latitude_deg") && columns.has("longitude_deg");
    if (!local && !geodetic) {
      columns.fail("GnssFix needs the columns \"east_m\" and \"north_m\", or \"latitude_deg\" and \"longitude_deg\"");
    }
    constexpr std::array<std::string_view, 3> kAxes = {"east_m", "north_m", "up_m"};
    for (std::size_t i = 0; i < kAxes.size(); ++i) local_[i] = optional_number_column(columns, kAxes[i], finder);
    latitude_ = optional_number_column(columns, "latitude_deg", finder);
    constexpr std::array<std::pair<std::string_view, double GnssFix::*>, 7> kOthers = {
        {{"longitude_deg", &GnssFix::longitude_deg},
         {"height_m", &GnssFix::height_m},
         {"sigma_horizontal_m", &GnssFix::sigma_horizontal_m},
         {"sigma_vertical_m", &GnssFix::sigma_vertical_m},
         {"hdop", &GnssFix::hdop},
         {"speed_mps", &GnssFix::speed_mps},
         {"course_rad", &GnssFix::course_rad}}};
    for (const auto& [name, member] : kOthers) {
      if (auto column = optional_number_column(columns, name, finder)) others_.emplace_back(std::move(*column), member);
    }
    satellites_ = optional_number_column(columns, "satellites", finder);
    if (columns.has("type")) read_type_map(columns, finder);
  }

  std::shared_ptr<Payload> build(Row row) const override {
    auto fix = std::make_shared<GnssFix>();
    for (std::size_t i = 0; i < local_.size(); ++i) {
      if (local_[i]) fix->p_map_antenna[static_cast<Eigen::Index>(i)] = local_[i]->read(row);
    }
    if (latitude_) {
      fix->latitude_deg = latitude_->read(row);
      if (std::abs(fix->latitude_deg) > 90.0) {
        throw BadRow(in_quotes(row[latitude_->column().index]) + " in " + latitude_->column().label +
                     " is no latitude (-90 to 90 deg)");
      }
    }
    for (const auto& [column, member] : others_) (*fix).*member = column.read(row);
    if (satellites_ && !satellites_->is_unknown(row)) fix->satellites = satellites_->read_integer(row);
    if (type_) {
      const int code = type_->read_integer(row);
      for (const auto& [number, type] : types_) {
        if (number == code) fix->type = type;
      }
    }
    return fix;
  }

 private:
  void read_type_map(const Config& columns, ColumnFinder& finder) {
    if (!columns.is_mapping("type")) columns.fail("type", "expected {column, map: {number: word}}");
    type_ = NumberColumn(columns, "type", finder);
    const Config map = columns.child("type").child("map");
    for (const std::string& key : map.keys()) {
      double code = 0.0;
      if (parse_number(key, code) != NumberText::ok || code != std::floor(code) || std::abs(code) > 1e6) {
        map.fail(key, in_quotes(key) + " is not a whole number");
      }
      const std::string word = map.choice(key, {"none", "single", "differential", "rtk_float", "rtk_fixed", "unknown"});
      using enum GnssFix::Type;
      const GnssFix::Type type = word == "none"           ? none
                                 : word == "single"       ? single
                                 : word == "differential" ? differential
                                 : word == "rtk_float"    ? rtk_float
                                 : word == "rtk_fixed"    ? rtk_fixed
                                                          : unknown;
      types_.emplace_back(static_cast<int>(code), type);
    }
  }

  std::array<std::optional<NumberColumn>, 3> local_;
  std::optional<NumberColumn> latitude_;
  std::vector<std::pair<NumberColumn, double GnssFix::*>> others_;
  std::optional<NumberColumn> satellites_;
  std::optional<NumberColumn> type_;
  std::vector<std::pair<int, GnssFix::Type>> types_;
};

class ScanBuilder final : public PayloadBuilder {
 public:
  ScanBuilder(const Config& entry, const Config& columns, ColumnFinder& finder) {
    check_fields(columns, {"ranges_m", "intensities"}, {"ranges_m"}, "LaserScan");
    ranges_.emplace(columns, "ranges_m", finder);
    if (columns.has("intensities")) {
      intensities_.emplace(columns, "intensities", finder);
      if (intensities_->count() != ranges_->count()) {
        columns.fail("intensities", std::to_string(intensities_->count()) + " columns for " +
                                        std::to_string(ranges_->count()) + " ranges; as many are expected");
      }
    }
    const Config scan = entry.child("scan");
    start_rad_ = read_angle(scan, "start_deg", "start_rad");
    step_rad_ = read_angle(scan, "step_deg", "step_rad");
    if (step_rad_ == 0.0) {
      scan.fail(scan.has("step_rad") ? "step_rad" : "step_deg",
                "0 lets all beams point the same way; a number other than 0 is expected");
    }
    beam_interval_s_ = scan.number_in("beam_interval_s", -1.0, 1.0, 0.0);
    allow_non_finite_ = scan.boolean("allow_non_finite", false);
  }

  std::shared_ptr<Payload> build(Row row) const override {
    auto scan = std::make_shared<LaserScan>();
    scan->start_rad = start_rad_;
    scan->step_rad = step_rad_;
    scan->beam_interval_s = beam_interval_s_;
    const auto instead = [this](float value) { return allow_non_finite_ ? std::optional<float>(value) : std::nullopt; };
    ranges_->read(row, scan->ranges_m, instead(std::numeric_limits<float>::infinity()));
    if (intensities_) intensities_->read(row, scan->intensities, instead(0.0F));
    return scan;
  }

  bool wants_equal_rows() const override { return true; }

 private:
  /// An angle in degrees, as people write it, or in radians, as it is used.
  static double read_angle(const Config& scan, std::string_view degrees, std::string_view radians) {
    if (!scan.has(radians)) return scan.number_in(degrees, -360.0, 360.0) * kRadPerDeg;
    if (scan.has(degrees)) scan.fail(radians, "give it in degrees or in radians, not both");
    return scan.number_in(radians, -360.0 * kRadPerDeg, 360.0 * kRadPerDeg);
  }

  std::optional<ColumnRange> ranges_;
  std::optional<ColumnRange> intensities_;
  double start_rad_ = 0.0;
  double step_rad_ = 0.0;
  double beam_interval_s_ = 0.0;
  bool allow_non_finite_ = false;
};

class LandmarksBuilder final : public PayloadBuilder {
 public:
  LandmarksBuilder(const Config& columns, ColumnFinder& finder)
      : range_((check_fields(columns, {"range_m", "bearing_rad", "radius_m", "identity"}, {"range_m", "bearing_rad"},
                             "LandmarkObservations"),
                columns),
               "range_m", finder),
        bearing_(columns, "bearing_rad", finder),
        radius_(optional_number_column(columns, "radius_m", finder)),
        identity_(optional_number_column(columns, "identity", finder)),
        sets_may_be_empty_(finder.allows_empty()) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto set = std::make_shared<LandmarkObservations>();
    append(row, *set);
    return set;
  }

  void append(Row row, Payload& payload) const override {
    if (sets_may_be_empty_ && row[range_.column().index].empty() && row[bearing_.column().index].empty()) return;
    static_cast<LandmarkObservations&>(payload).landmarks.push_back(read(row));
  }

  bool can_append() const override { return true; }

 private:
  LandmarkObservations::One read(Row row) const {
    LandmarkObservations::One one;
    one.range_m = range_.read(row);
    one.bearing_rad = bearing_.read(row);
    if (radius_) one.radius_m = radius_->read(row);
    if (identity_ && !identity_->is_unknown(row)) one.identity = identity_->read_integer(row);
    return one;
  }

  NumberColumn range_;
  NumberColumn bearing_;
  std::optional<NumberColumn> radius_;
  std::optional<NumberColumn> identity_;
  bool sets_may_be_empty_;
};

}  // namespace

void PayloadBuilder::append(Row, Payload&) const { assert(false && "only a builder with can_append() forms sets"); }

std::shared_ptr<Payload> PayloadBuilder::growth(const Payload&, const Payload&, double, double) const {
  assert(false && "only a builder that knows totals() is asked");
  return nullptr;
}

std::string_view payload_type(const Config& entry) {
  const std::string name = entry.text("payload");
  std::vector<std::string_view> names;
  for (const std::string_view type : kTypes) {
    if (name == type || name == short_name(type)) return type;
    names.push_back(short_name(type));
  }
  entry.fail("payload", "there is no payload " + in_quotes(name) + suggestion(name, names));
}

bool holds_totals(const Config& entry) { return entry.is_mapping("cumulative") || entry.boolean("cumulative", false); }

std::unique_ptr<PayloadBuilder> make_payload_builder(std::string_view type, const Config& entry, ColumnFinder& finder) {
  const Config columns = entry.child("columns");
  if (type == WheelSpeeds::kType) {
    return std::make_unique<NumbersBuilder<WheelSpeeds>>(
        columns,
        std::initializer_list<Field<WheelSpeeds>>{{"left_mps", &WheelSpeeds::left_mps},
                                                  {"right_mps", &WheelSpeeds::right_mps}},
        finder, true);
  }
  if (type == WheelSteering::kType) {
    return std::make_unique<NumbersBuilder<WheelSteering>>(
        columns,
        std::initializer_list<Field<WheelSteering>>{{"speed_mps", &WheelSteering::speed_mps},
                                                    {"steering_rad", &WheelSteering::steering_rad}},
        finder);
  }
  if (type == BodyTwist::kType) {
    return std::make_unique<NumbersBuilder<BodyTwist>>(
        columns,
        std::initializer_list<Field<BodyTwist>>{{"v_x_mps", &BodyTwist::v_x_mps},
                                                {"v_y_mps", &BodyTwist::v_y_mps, false},
                                                {"w_z_radps", &BodyTwist::w_z_radps}},
        finder, true);
  }
  if (type == PoseIncrement::kType) {
    if (holds_totals(entry)) return std::make_unique<MotionBuilder>(entry, columns, finder);
    return std::make_unique<NumbersBuilder<PoseIncrement>>(
        columns,
        std::initializer_list<Field<PoseIncrement>>{{"interval_s", &PoseIncrement::interval_s},
                                                    {"x_m", &PoseIncrement::x_m},
                                                    {"y_m", &PoseIncrement::y_m},
                                                    {"yaw_rad", &PoseIncrement::yaw_rad}},
        finder);
  }
  if (type == GnssFix::kType) return std::make_unique<GnssBuilder>(columns, finder);
  if (type == LaserScan::kType) return std::make_unique<ScanBuilder>(entry, columns, finder);
  if (type == ImuSample::kType) return std::make_unique<ImuBuilder>(columns, finder);
  if (type == CompassHeading::kType) return std::make_unique<HeadingBuilder>(columns, finder);
  if (type == MagneticField::kType) return std::make_unique<FieldBuilder>(columns, finder);
  if (type == Height::kType) {
    return std::make_unique<NumbersBuilder<Height>>(
        columns,
        std::initializer_list<Field<Height>>{{"height_m", &Height::height_m}, {"sigma_m", &Height::sigma_m, false}},
        finder);
  }
  if (type == Image::kType) {
    return std::make_unique<ImageBuilder>(columns, readable_file(entry, "path").parent_path(), finder);
  }
  return std::make_unique<LandmarksBuilder>(columns, finder);
}

}  // namespace waymark::csv
