// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "recording.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/plugin/descriptor.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::recorder {
namespace {

/// Everything that the filter gets, as it arrived.
class Recorder final : public Sink {
 public:
  explicit Recorder(const Config& config)
      : file_name_(config.output({"file", "name of the record; an older one is kept under a number"}, "flight.mcap")),
        config_file_(std::filesystem::absolute(config.file())) {
    options_.profile = "waymark";
    options_.library = "waymark " WAYMARK_VERSION;
    const std::string compression =
        config.choice({"compression", "of the chunks: zstd is smaller, lz4 faster"}, {"zstd", "lz4", "none"}, "zstd");
    using Compression = mcap::WriterOptions::Compression;
    options_.compression = compression == "zstd"  ? Compression::zstd
                           : compression == "lz4" ? Compression::lz4
                                                  : Compression::none;
    flush_ = from_seconds(config.number_in(
        {"flush_s", "s", "what arrived longer ago is in the file: as much a crash loses at most"}, 0.01, 60.0, 1.0));
    queue_bytes_ = static_cast<std::size_t>(config.integer_in(
                       {"queue_mb", "MB", "memory for what waits to be written; more end the record"}, 1, 65536, 64))
                   << 20U;
    with_maps_ = config.boolean({"maps", "the maps' files at the end of the run are attached"}, true);
  }

  void start(const RunInfo& info) override {
    std::vector<std::string> sensors;
    for (const Mounting& mounting : info.rig->mountings()) sensors.push_back(mounting.name);
    FlightEncoder encoder(options_, std::move(sensors), flush_);
    encoder.add_metadata("waymark", {{"version", WAYMARK_VERSION},
                                     {"plugin_abi", std::to_string(kPluginAbi)},
                                     {"config_file", config_file_.string()}});
    encoder.add_attachment(std::string(kEffectiveConfigFile), "application/yaml", info.config);
    recording_ = std::make_unique<Recording>(info.out_dir / file_name_, std::move(encoder), queue_bytes_);
  }

  void arrived(const Measurement& measurement) override { recording_->add(Delivered{measurement, false}); }
  void dropped(const Measurement& measurement) override { recording_->add(Delivered{measurement, true}); }
  void commanded(Time arrival, std::string_view command) override {
    recording_->add(Commanded{arrival, std::string(command)});
  }
  /// Only a running robot has one; there, nothing may wait for what follows.
  void front(const Belief&) override { recording_->flush_when_idle(); }
  std::vector<std::string> take_events() override { return recording_->take_events(); }
  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    if (last != nullptr && last->started() && with_maps_) {
      FileStems stems({});
      for (MapDescription& map : last->best_maps(MapDetail::with_files)) {
        const std::string stem = stems.of(map.module);
        for (MapFile& file : map.files)
          recording_->add(
              Attached{"maps/" + stem + file.extension, "application/octet-stream", std::move(file.content)});
      }
    }
    recording_->finish();
    // Of a log's replay nobody asks for events.
    const std::vector<std::string> events = recording_->take_events();
    if (!events.empty()) throw Error(fmt::format("{}", fmt::join(events, "; ")));
  }

 private:
  std::string file_name_;
  std::filesystem::path config_file_;
  mcap::WriterOptions options_;
  Duration flush_{};
  std::size_t queue_bytes_ = 0;
  bool with_maps_ = true;
  std::unique_ptr<Recording> recording_;
};

}  // namespace
}  // namespace waymark::recorder

WAYMARK_PLUGIN(waymark::Sink, waymark::recorder::Recorder, "recorder", "1.0.0")
