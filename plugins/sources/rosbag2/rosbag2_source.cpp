// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bag_folder.hpp"
#include "db3_log.hpp"
#include "merged_log.hpp"
#include "plugins/shared/mcap/mcap_log.hpp"
#include "plugins/shared/message_log/topic_source.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::rosbag2 {
namespace {

bool is_mcap(const std::filesystem::path& file) { return file.filename().string().find(".mcap") != std::string::npos; }

std::unique_ptr<message_log::MessageLog> open(const std::vector<std::filesystem::path>& bags) {
  std::vector<MergedLog::Part> parts;
  for (const std::filesystem::path& bag : bags) {
    const BagParts found = find_parts(bag);
    for (const std::filesystem::path& file : found.files) {
      std::unique_ptr<message_log::MessageLog> log;
      if (is_mcap(file)) {
        log = std::make_unique<mcap::McapLog>(std::vector{file});
      } else {
        log = std::make_unique<Db3Log>(file);
      }
      parts.push_back({std::move(log), found.compressed_messages});
    }
  }
  return std::make_unique<MergedLog>(std::move(parts));
}

/// Bags of ROS 2.
class Rosbag2Source final : public message_log::TopicSource {
 public:
  Rosbag2Source(const Config& config, const Rig& rig)
      : TopicSource(
            config, rig,
            {.one = "the bag",
             .file_key = "a bag (the folder with its metadata.yaml, or one .db3 or .mcap of it), or a list of "
                         "bags that are read as one; relative to the YAML",
             .bad_record = "bad messages, damaged chunks and missing ends that are skipped before the run stops",
             .open = open}) {}
};

}  // namespace
}  // namespace waymark::rosbag2

WAYMARK_PLUGIN(waymark::Source, waymark::rosbag2::Rosbag2Source, "rosbag2", "1.0.0")
