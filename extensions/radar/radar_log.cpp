// SPDX-License-Identifier: Apache-2.0
// A source: recorded targets of the radars of a vehicle (targets_file.hpp).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytes_file.hpp"
#include "targets_file.hpp"
#include "text_table.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::radar {
namespace {

class RadarLog final : public Source {
 public:
  RadarLog(const Config& config, const Rig& rig)
      : file_(
            TargetsFile::open(readable_file(config, {"file", "the recording, plain or gzip; relative to the YAML"}))) {
    for (const Config& entry : config.items({"radars", "which radar of the recording feeds which sensor"})) {
      const auto number =
          static_cast<int>(entry.integer_in({"number", "of the radar in the recording"}, 0, UINT16_MAX, 0));
      Channel channel = channel_to_sensor(entry, rig, RadarTargets::kType);
      if (std::ranges::find(channels_, channel.sensor, &Channel::sensor) != channels_.end())
        entry.fail("sensor", "sensor \"" + channel.sensor + "\" is given twice");
      if (!channel_of_.emplace(number, static_cast<std::uint32_t>(channels_.size())).second)
        entry.fail("number", "radar " + std::to_string(number) + " is given twice");
      channels_.push_back(std::move(channel));
      entry.reject_unread();
    }
    if (config.has("extrinsics")) {
      read_mountings(readable_file(
          config, {"extrinsics",
                   "table with the mountings of the radars, for sensors with `base_T_sensor: from_tf`: columns "
                   "`sensor` (the number), `tx_m`, `ty_m`, `tz_m`, `qw`, `qx`, `qy`, `qz`"}));
    }
    if (channels_.empty()) config.fail("radars", "an empty list; at least one radar is expected");
  }

  const std::vector<Channel>& channels() const override { return channels_; }
  double progress() const override { return file_->progress(); }
  std::vector<std::string> notices() const override {
    std::vector<std::string> notices;
    notices.reserve(passed_over_.size());
    for (const auto& [number, scans] : passed_over_) {
      notices.push_back("radar " + std::to_string(number) + " is not in the list of radars: " + std::to_string(scans) +
                        " scans passed over");
    }
    return notices;
  }

  std::optional<Pose> T_base_sensor(std::string_view sensor) override {
    const auto found = mountings_.find(sensor);
    return found == mountings_.end() ? std::nullopt : std::optional(found->second);
  }

  std::optional<Measurement> next() override {
    while (std::optional<Scan> scan = file_->next()) {
      const auto found = channel_of_.find(scan->radar);
      if (found == channel_of_.end()) {
        ++passed_over_[scan->radar];
        continue;
      }
      auto payload = std::make_shared<RadarTargets>();
      payload->targets = std::move(scan->targets);
      Measurement m;
      m.stamp = m.arrival = scan->stamp;
      m.sensor = found->second;
      m.sequence = sequence_++;
      m.payload = std::move(payload);
      return m;
    }
    return std::nullopt;
  }

 private:
  void read_mountings(const std::filesystem::path& file) {
    TextTable table(std::make_unique<BytesFile>(file), {"sensor", "tx_m", "ty_m", "tz_m", "qw", "qx", "qy", "qz"});
    while (table.next()) {
      const Eigen::Quaterniond q(table.number(4), table.number(5), table.number(6), table.number(7));
      if (std::abs(q.norm() - 1.0) > 1e-3) throw DataError(table.place() + ": qw, qx, qy, qz are no unit quaternion");
      for (const auto& [number, channel] : channel_of_) {
        if (table.number(0) != number) continue;
        mountings_[channels_[channel].sensor] = {q.normalized(), {table.number(1), table.number(2), table.number(3)}};
      }
    }
  }

  std::unique_ptr<TargetsFile> file_;
  std::vector<Channel> channels_;
  std::map<int, std::uint32_t> channel_of_;
  std::map<std::string, Pose, std::less<>> mountings_;
  std::map<int, std::uint64_t> passed_over_;
  std::uint64_t sequence_ = 0;
};

}  // namespace
}  // namespace waymark::radar

WAYMARK_PLUGIN(waymark::Source, waymark::radar::RadarLog, "radar_log", "1.0.0")
