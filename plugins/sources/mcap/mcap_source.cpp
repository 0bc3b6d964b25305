// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "flight_replay.hpp"
#include "plugins/shared/mcap/mcap_log.hpp"
#include "plugins/shared/message_log/topic_source.hpp"
#include "waymark/base/error.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::mcap_source {
namespace {

constexpr std::string_view kFileKey = "an MCAP file, or a list of files that are read as one; relative to the YAML";
constexpr std::string_view kBadRecordKey =
    "bad messages, damaged chunks and missing ends that are skipped before the run stops";

std::unique_ptr<Source> topics(const Config& config, const Rig& rig) {
  const auto open = [](const std::vector<std::filesystem::path>& files) {
    return std::make_unique<mcap::McapLog>(files);
  };
  return std::make_unique<message_log::TopicSource>(
      config, rig,
      message_log::LogFormat{.one = "the file", .file_key = kFileKey, .bad_record = kBadRecordKey, .open = open});
}

std::unique_ptr<Source> flight(const Config& config, const Rig& rig) {
  const auto max_bad_records = static_cast<std::uint64_t>(
      config.integer_in({"max_bad_records", kBadRecordKey}, 0, std::numeric_limits<std::int64_t>::max(), 0));
  std::vector<std::filesystem::path> files;
  for (const std::string& name : config.texts({"file", kFileKey})) files.push_back(config.file().parent_path() / name);
  if (files.empty()) config.fail("file", "the list is empty, at least one file is expected");
  std::unique_ptr<mcap::McapLog> log;
  try {
    log = std::make_unique<mcap::McapLog>(files);
  } catch (const DataError& error) {
    config.fail("file", error.what());
  }
  return std::make_unique<FlightReplay>(std::move(log), max_bad_records, config, rig);
}

/// Topics of ROS 2, or what waymark recorded itself.
class McapSource final : public Source {
 public:
  McapSource(const Config& config, const Rig& rig)
      : source_(config.has("channels") ? topics(config, rig) : flight(config, rig)) {}

  const std::vector<Channel>& channels() const override { return source_->channels(); }
  std::optional<Measurement> next() override { return source_->next(); }
  double progress() const override { return source_->progress(); }
  const std::vector<BadRecord>& bad_records() const override { return source_->bad_records(); }
  std::vector<std::string> notices() const override { return source_->notices(); }

 private:
  std::unique_ptr<Source> source_;
};

}  // namespace
}  // namespace waymark::mcap_source

WAYMARK_PLUGIN(waymark::Source, waymark::mcap_source::McapSource, "mcap", "1.0.0")
