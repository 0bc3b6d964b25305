// SPDX-License-Identifier: Apache-2.0
#include "payload_builders.hpp"

#include <array>
#include <cassert>
#include <limits>
#include <numbers>
#include <vector>

#include "field_columns.hpp"
#include "image_builder.hpp"
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

/// Payloads of which one row holds all fields.
template <class T>
class FieldsBuilder final : public PayloadBuilder {
 public:
  /// `per_second`: every field is something per second, so that a log may hold its total instead.
  FieldsBuilder(const Config& columns, ColumnFinder& finder, bool per_second = false)
      : fields_(columns, short_type_name(T::kType), finder), per_second_(per_second) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto payload = std::make_shared<T>();
    fields_.read(row, *payload);
    return payload;
  }

  Totals totals() const override { return per_second_ ? Totals::speed : Totals::none; }

  std::shared_ptr<Payload> growth(const Payload& before, const Payload& after, double seconds,
                                  double wraps_at) const override {
    auto payload = std::make_shared<T>();
    fields_.growth(static_cast<const T&>(before), static_cast<const T&>(after), seconds, wraps_at, *payload);
    return payload;
  }

 private:
  FieldColumns<T> fields_;
  bool per_second_;
};

void require_position(const Config& columns) {
  FieldColumns<GnssFix>::check_names(columns, short_type_name(GnssFix::kType));
  const bool local = columns.has("east_m") && columns.has("north_m");
  const bool geodetic = columns.has("latitude_deg") && columns.has("longitude_deg");
  if (!local && !geodetic) {
    columns.fail("GnssFix needs the columns \"east_m\" and \"north_m\", or \"latitude_deg\" and \"longitude_deg\"");
  }
}

class ScanBuilder final : public PayloadBuilder {
 public:
  ScanBuilder(const Config& entry, const Config& columns, ColumnFinder& finder) {
    check_fields(columns, {"ranges_m", "intensities"}, {"ranges_m"}, "LaserScan");
    ranges_.emplace(columns, Config::Key("ranges_m", "m", "a range of columns: one for each beam"), finder);
    if (columns.has("intensities")) {
      intensities_.emplace(columns, Config::Key("intensities", "", "a range of columns, as many as ranges", "none"),
                           finder);
      if (intensities_->count() != ranges_->count()) {
        columns.fail("intensities", std::to_string(intensities_->count()) + " columns for " +
                                        std::to_string(ranges_->count()) + " ranges; as many are expected");
      }
    }
    const Config scan = entry.child({"scan", "of `LaserScan`: where its beams point"});
    start_rad_ = read_angle(scan, {"start_deg", "°", "first beam, counter-clockwise from the sensor's x axis"},
                            {"start_rad", "rad", "the same, instead of `start_deg`"});
    step_rad_ = read_angle(scan, {"step_deg", "°", "from beam to beam: beam k points at start + k · step"},
                           {"step_rad", "rad", "the same, instead of `step_deg`"});
    if (step_rad_ == 0.0) {
      scan.fail(scan.has("step_rad") ? "step_rad" : "step_deg",
                "0 lets all beams point the same way; a number other than 0 is expected");
    }
    beam_interval_s_ =
        scan.number_in({"beam_interval_s", "s",
                        "time from one beam to the next, if the scanner turns and beam 0 is measured at the stamp: "
                        "maps then see the scan as from one place; negative: the later beams are the older ones"},
                       -1.0, 1.0, 0.0);
    allow_non_finite_ = scan.boolean(
        {"allow_non_finite",
         "a range of NaN or infinity is not a return (+infinity), and such an intensity 0; otherwise the row is bad"},
        false);
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
  static double read_angle(const Config& scan, const Config::Key& degrees, const Config::Key& radians) {
    if (!scan.has(radians.name)) return scan.number_in(degrees, -360.0, 360.0) * kRadPerDeg;
    if (scan.has(degrees.name)) scan.fail(radians.name, "give it in degrees or in radians, not both");
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
      : fields_(columns, short_type_name(LandmarkObservations::kType), finder),
        sets_may_be_empty_(finder.allows_empty()) {}

  std::shared_ptr<Payload> build(Row row) const override {
    auto set = std::make_shared<LandmarkObservations>();
    append(row, *set);
    return set;
  }

  void append(Row row, Payload& payload) const override {
    if (sets_may_be_empty_ && fields_.required_are_empty(row)) return;
    LandmarkObservations::One one;
    fields_.read(row, one);
    static_cast<LandmarkObservations&>(payload).landmarks.push_back(one);
  }

  bool can_append() const override { return true; }

 private:
  FieldColumns<LandmarkObservations::One> fields_;
  bool sets_may_be_empty_;
};

/// A truth value, or a mapping for totals that begin anew.
Config::Key cumulative_key() {
  return {"cumulative",
          "the columns hold totals since the start, of `PoseIncrement`, `WheelSpeeds` or `BodyTwist`; `{ wraps_at: "
          "65536 }`: raw totals begin anew there"};
}

}  // namespace

void PayloadBuilder::append(Row, Payload&) const { assert(false && "only a builder with can_append() forms sets"); }

std::shared_ptr<Payload> PayloadBuilder::growth(const Payload&, const Payload&, double, double) const {
  assert(false && "only for a builder that has totals()");
  return nullptr;
}

std::string_view payload_type(const Config& entry) {
  std::vector<std::string_view> names;
  std::string meaning = "what the rows hold: ";
  for (const std::string_view type : kTypes) {
    meaning.append(names.empty() ? "`" : ", `").append(short_type_name(type)).append("`");
    names.push_back(short_type_name(type));
  }
  const std::string name = entry.text({"payload", meaning});
  for (const std::string_view type : kTypes) {
    if (name == type || name == short_type_name(type)) return type;
  }
  entry.fail("payload", "there is no payload " + in_quotes(name) + suggestion(name, names));
}

bool holds_totals(const Config& entry) {
  return entry.is_mapping("cumulative") || entry.boolean(cumulative_key(), false);
}

double totals_wrap_at(const Config& entry) {
  if (!entry.is_mapping("cumulative")) return 0.0;
  return entry.child(cumulative_key()).positive({"wraps_at", "raw totals begin anew there"});
}

std::unique_ptr<PayloadBuilder> make_payload_builder(std::string_view type, const Config& entry, ColumnFinder& finder) {
  const Config columns = entry.child({"columns",
                                      "which column goes to which field of the payload: a number, counted from 0, or a "
                                      "name from the header; or `{ column, scale, offset }`"});
  if (type == WheelSpeeds::kType) return std::make_unique<FieldsBuilder<WheelSpeeds>>(columns, finder, true);
  if (type == WheelSteering::kType) return std::make_unique<FieldsBuilder<WheelSteering>>(columns, finder);
  if (type == BodyTwist::kType) return std::make_unique<FieldsBuilder<BodyTwist>>(columns, finder, true);
  if (type == PoseIncrement::kType) {
    if (holds_totals(entry)) return std::make_unique<MotionBuilder>(entry, columns, finder);
    return std::make_unique<FieldsBuilder<PoseIncrement>>(columns, finder);
  }
  if (type == GnssFix::kType) {
    require_position(columns);
    return std::make_unique<FieldsBuilder<GnssFix>>(columns, finder);
  }
  if (type == LaserScan::kType) return std::make_unique<ScanBuilder>(entry, columns, finder);
  if (type == ImuSample::kType) return std::make_unique<FieldsBuilder<ImuSample>>(columns, finder);
  if (type == CompassHeading::kType) return std::make_unique<FieldsBuilder<CompassHeading>>(columns, finder);
  if (type == MagneticField::kType) return std::make_unique<FieldsBuilder<MagneticField>>(columns, finder);
  if (type == Height::kType) return std::make_unique<FieldsBuilder<Height>>(columns, finder);
  if (type == Image::kType) {
    return std::make_unique<ImageBuilder>(columns, readable_file(entry, "path").parent_path(), finder);
  }
  return std::make_unique<LandmarksBuilder>(columns, finder);
}

}  // namespace waymark::csv
