// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "plugins/shared/cloud_file/cloud_reader.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::clouds {
namespace {

using cloud_file::CloudReader;

/// A file of point clouds.
class CloudsSource final : public Source {
 public:
  CloudsSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override { return is_ended_ ? 1.0 : reader_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  BadRecordList bad_;
  std::optional<CloudReader> reader_;
  std::vector<Channel> channels_;
  cloud_file::Thinning thinning_;
  std::int64_t first_ = 0;  // cloud
  std::int64_t last_ = 0;
  Duration start_{};  // after the file's first stamp
  Duration end_{};
  std::optional<Time> origin_;  // that stamp
  std::optional<Time> newest_;
  std::uint64_t sequence_ = 0;
  bool is_ended_ = false;
};

CloudsSource::CloudsSource(const Config& config, const Rig& rig)
    : bad_(static_cast<std::uint64_t>(
               config.integer_in({"max_bad_records", "clouds that may be bad before the run stops"}, 0,
                                 std::numeric_limits<std::int64_t>::max(), 0)),
           {"record", "max_bad_records", "goes on after such ones"}) {
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();
  const auto file =
      readable_file(config, {"file", "the clouds, plain or gzip, recognised by content; relative to the YAML"});
  channels_.push_back(channel_to_sensor(config, rig, PointCloud::kType));
  thinning_.every = static_cast<std::uint32_t>(
      config.integer_in({"every_nth_point", "thins the clouds out: one point of so many, in their order"}, 1,
                        cloud_file::kMostPoints, 1));
  if (config.has("max_points")) {
    thinning_.at_most = static_cast<std::uint32_t>(config.integer_in(
        {"max_points", "", "thins a cloud of more points out to so many, evenly in their order", "no limit"}, 1,
        cloud_file::kMostPoints, cloud_file::kMostPoints));
  }
  first_ =
      config.integer_in({"first_cloud", "clouds before it are passed over; the file's first one is 0"}, 0, kMost, 0);
  last_ = config.has("last_cloud")
              ? config.integer_in({"last_cloud", "", "the log ends after it", "the file's last one"}, 0, kMost, kMost)
              : kMost;
  if (last_ < first_) config.fail("last_cloud", fmt::format("{} is before first_cloud, {}", last_, first_));
  start_ = from_seconds(
      config.non_negative({"start_s", "s", "clouds so long after the file's first one are the first taken"}, 0.0));
  end_ = config.has("end_s")
             ? from_seconds(config.non_negative(
                   {"end_s", "s", "the log ends so long after the file's first cloud", "the file's end"}))
             : kLongest;
  if (end_ < start_) config.fail("end_s", "is before start_s");
  try {
    reader_.emplace(file);
  } catch (const DataError& error) {
    config.fail("file", error.what());
  }
  if (first_ > 0 && first_ >= reader_->clouds())
    config.fail("first_cloud", fmt::format("{}: the file has {} clouds, counted from 0", first_, reader_->clouds()));
}

std::optional<Measurement> CloudsSource::next() {
  while (!is_ended_) {
    const std::optional<CloudReader::Head> head = reader_->next();
    if (!head || head->number > last_) break;
    if (head->stamp && !origin_) origin_ = head->stamp;
    if (head->number < first_) continue;
    if (!head->stamp) {
      bad_.add(reader_->place(), "its time is no stamp; the years 1824 to 2115 are");
      continue;
    }
    const Duration since = *head->stamp - *origin_;
    if (since > end_) break;
    if (since < start_) continue;
    if (newest_ && *head->stamp <= *newest_) {
      bad_.add(reader_->place(), fmt::format("its stamp, {}, is not later than that of the cloud before, {}",
                                             format_time(*head->stamp), format_time(*newest_)));
      continue;
    }
    auto cloud = std::make_shared<PointCloud>();
    const std::size_t not_finite = reader_->read(thinning_, *cloud);
    if (not_finite > 0) {
      bad_.add(reader_->place(),
               fmt::format("{} of {} points are not finite and were left out", not_finite, head->points));
    }
    newest_ = head->stamp;
    Measurement measurement;
    measurement.stamp = measurement.arrival = *head->stamp;
    measurement.sensor = 0;
    measurement.sequence = sequence_++;
    measurement.payload = std::move(cloud);
    return measurement;
  }
  is_ended_ = true;
  return std::nullopt;
}

}  // namespace
}  // namespace waymark::clouds

WAYMARK_PLUGIN(waymark::Source, waymark::clouds::CloudsSource, "clouds", "1.0.0")
