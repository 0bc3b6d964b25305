// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "bag_log.hpp"
#include "plugins/shared/message_log/topic_source.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::rosbag1 {
namespace {

/// Bags of ROS 1.
class Rosbag1Source final : public message_log::TopicSource {
 public:
  Rosbag1Source(const Config& config, const Rig& rig)
      : TopicSource(
            config, rig,
            {.one = "the bag",
             .file_key =
                 "a bag, or a list of bags that are read as one (`rosbag record --split`); relative to the YAML",
             .bad_record = "bad messages, damaged chunks and missing ends that are skipped before the run stops",
             .open = [](const auto& files) { return std::make_unique<BagLog>(files); }}) {}
};

}  // namespace
}  // namespace waymark::rosbag1

WAYMARK_PLUGIN(waymark::Source, waymark::rosbag1::Rosbag1Source, "rosbag1", "1.1.0")
