// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "calibration.hpp"
#include "planar_cut.hpp"
#include "recording.hpp"
#include "unusable.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/io/bad_record_list.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::kitti {
namespace {

/// A raw recording of KITTI: clouds, as they are or each cut to a planar scan, and the images of one camera.
class KittiSource final : public Source {
 public:
  KittiSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override { return static_cast<double>(position_) / static_cast<double>(entries_.size()); }
  const std::vector<BadRecord>& bad_records() const override { return bad_.records(); }

 private:
  const Mounting& add_channel(const Config& config, const Rig& rig, std::string_view payload);
  std::shared_ptr<const Payload> read(const Entry& entry);
  std::shared_ptr<const Payload> read_scan(const Entry& entry);
  const Mounting& add_lidar(const Config& lidar, const Rig& rig);

  std::vector<Channel> channels_;
  std::vector<bool> is_lidar_;    // of each channel
  std::optional<PlanarCut> cut_;  // nothing: clouds are delivered as they are
  std::size_t every_ = 1;         // of a cloud
  std::vector<Entry> entries_;
  std::uint64_t position_ = 0;  // the next entry
  std::uint64_t sequence_ = 0;
  BadRecordList bad_;
  std::vector<float> points_;  // of one scan, kept for its storage
};

Duration period_of(const Config& config) {
  const double period_s =
      config.positive({"frame_period_s", "s", "frame N is at N times this where there is no `timestamps.txt`"}, 0.1);
  if (period_s < 1e-6 || period_s > 3600.0) config.fail("frame_period_s", "1e-6 to 3600 s are expected");
  return from_seconds(period_s);
}

void require_folder(const Config& config, const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) config.fail("folder", folder.string() + " is not a folder");
}

Stream open_stream(const Config& config, const std::filesystem::path& folder, const std::vector<std::string>& endings) {
  try {
    return Stream(folder, endings);
  } catch (const DataError& error) {
    config.fail("folder", error.what());
  }
}

Config::Key declared_calibration() {
  return {"calibration", "",
          "folder with `calib_cam_to_cam.txt` and `calib_velo_to_cam.txt`; `auto`: `calib` in `folder`, "
          "`folder` or the one above; `none`: the camera is not checked",
          "auto"};
}

/// The folder with the calibration that the key names; nothing if it is not to be checked.
std::optional<std::filesystem::path> calibration_of(const Config& config, const std::string& given,
                                                    const std::filesystem::path& folder) {
  if (given == "none") return std::nullopt;
  if (given != "auto") return config.file().parent_path() / given;
  // As in the excerpt, and as KITTI's archives unpack: in the folder of the day.
  for (const auto& candidate : {folder / "calib", folder, folder / ".."}) {
    std::error_code ignored;
    if (std::filesystem::exists(candidate / "calib_velo_to_cam.txt", ignored)) return candidate;
  }
  config.fail(
      "calibration",
      fmt::format("there is no calib_velo_to_cam.txt in {0}/calib, {0} or the folder above; give the folder, or "
                  "none if the camera is not to be checked",
                  folder.string()));
}

KittiSource::KittiSource(const Config& config, const Rig& rig)
    : bad_(static_cast<std::uint64_t>(
               config.integer_in({"max_bad_records", "files that may be bad before the run stops"}, 0,
                                 std::numeric_limits<std::int64_t>::max(), 0)),
           {"record", "max_bad_records", "goes on after such ones"}) {
  const std::filesystem::path folder =
      config.file().parent_path() / config.text({"folder", "folder of one drive; relative to the YAML"});
  const Duration period = period_of(config);
  const Config lidar = config.child({"lidar", "the scanner; its `sensor` needs `base_T_sensor`"});
  if (!config.has("camera")) {
    if (config.has("calibration")) {
      const std::string given = config.text(declared_calibration(), "auto");
      if (given != "none" && given != "auto")
        config.fail("calibration", "is for the camera, and there is no `camera`; leave it out, or write none");
    }
    add_lidar(lidar, rig);
    require_folder(config, folder);
    const Stream clouds = open_stream(config, folder / "velodyne_points", {".bin", ".bin.gz"});
    entries_ = schedule({{&clouds, &clouds}}, period);
    return;
  }

  // The camera comes first: an image belongs to the scan of the same stamp.
  const Config camera =
      config.child({"camera", "without it there are no images; its `sensor` needs `base_T_sensor` and `intrinsics`"});
  const Mounting& eye = add_channel(camera, rig, Image::kType);
  const Pose& T_base_lidar = rig.T_base_sensor(add_lidar(lidar, rig).name);
  const int number = static_cast<int>(camera.integer_in({"number", "N of the folder `image_0N`"}, 0, 3, 2));
  const bool own = camera.choice({"stamp", "`scan`: that of the scan of the same frame; `own`: its own"},
                                 {"scan", "own"}, "scan") == "own";
  const std::string calibration_key = config.text(declared_calibration(), "auto");

  require_folder(config, folder);
  const Stream clouds = open_stream(config, folder / "velodyne_points", {".bin", ".bin.gz"});
  const Stream images = open_stream(config, folder / fmt::format("image_{:02}", number), {".png", ".jpg"});
  if (const auto calibration = calibration_of(config, calibration_key, folder)) {
    try {
      check_calibration(read_calibration(*calibration, number), T_base_lidar, eye, camera);
    } catch (const DataError& error) {
      config.fail("calibration", error.what());
    }
  }
  if (own && images.has_stamps() != clouds.has_stamps()) {
    camera.fail("stamp", "own needs a timestamps.txt in both folders, or in none");
  }
  entries_ = schedule({{&images, own ? &images : &clouds}, {&clouds, &clouds}}, period);
}

const Mounting& KittiSource::add_channel(const Config& config, const Rig& rig, std::string_view payload) {
  Channel channel = channel_to_sensor(config, rig, payload);
  if (std::ranges::any_of(channels_, [&](const Channel& other) { return other.sensor == channel.sensor; }))
    config.fail("sensor", fmt::format("sensor \"{}\" cannot be both scanner and camera", channel.sensor));
  const Mounting& mounting = rig.mountings()[static_cast<std::size_t>(rig.find(channel.sensor))];
  channels_.push_back(std::move(channel));
  is_lidar_.push_back(payload != Image::kType);
  return mounting;
}

const Mounting& KittiSource::add_lidar(const Config& lidar, const Rig& rig) {
  const bool is_cloud =
      lidar.choice({"payload", "what becomes of a cloud: `LaserScan`: a planar cut; `PointCloud`: the cloud itself"},
                   {"LaserScan", "PointCloud"}, "LaserScan") == "PointCloud";
  const Mounting& scanner = add_channel(lidar, rig, is_cloud ? PointCloud::kType : LaserScan::kType);
  const Pose& T_base_sensor = rig.T_base_sensor(scanner.name);
  if (is_cloud) {
    constexpr std::int64_t kMost = 1 << 24;
    every_ = static_cast<std::size_t>(lidar.integer_in(
        {"every_nth_point", "of a `PointCloud`: thins it out to one point of so many, in their order"}, 1, kMost, 1));
  } else {
    cut_.emplace(lidar, T_base_sensor);
  }
  return scanner;
}

std::shared_ptr<const Payload> KittiSource::read_scan(const Entry& entry) {
  read_points(entry.file, points_);
  const auto left_out = [&](std::size_t not_finite) {
    if (not_finite == 0) return;
    bad_.add(entry.file.string(),
             fmt::format("{} of {} points are not finite and were left out", not_finite, points_.size() / 4));
  };
  if (!cut_) {
    auto cloud = std::make_shared<PointCloud>();
    left_out(take_points(points_, every_, *cloud));
    return cloud;
  }
  PlanarCut::Result result = (*cut_)(points_);
  left_out(result.not_finite);
  return std::move(result.scan);
}

std::shared_ptr<const Payload> KittiSource::read(const Entry& entry) {
  if (!entry.problem.empty()) throw Unusable(entry.file.string(), entry.problem);
  if (is_lidar_[entry.stream]) return read_scan(entry);
  auto image = std::make_shared<Image>();
  image->encoding = Image::Encoding::compressed;
  image->data = read_bytes(entry.file);
  return image;
}

std::optional<Measurement> KittiSource::next() {
  while (position_ < entries_.size()) {
    const Entry& entry = entries_[position_++];
    try {
      Measurement measurement;
      measurement.stamp = measurement.arrival = entry.stamp;
      measurement.sensor = entry.stream;
      measurement.payload = read(entry);
      measurement.sequence = sequence_++;
      return measurement;
    } catch (const Unusable& bad) {
      bad_.add(bad.place(), bad.what());
    }
  }
  return std::nullopt;
}

}  // namespace
}  // namespace waymark::kitti

WAYMARK_PLUGIN(waymark::Source, waymark::kitti::KittiSource, "kitti", "1.0.0")
