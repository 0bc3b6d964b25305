// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "log_table.hpp"
#include "replay.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::log_sink {
namespace {

constexpr std::size_t kMostTables = 50;  // of one sensor; every one is an open file

/// What the source delivers, as text and images that the csv source reads back.
class Log final : public Sink {
 public:
  Log(const Config& config, const Rig& rig)
      : yaml_(std::filesystem::absolute(config.file())),
        folder_name_(config.output({"folder", "folder within the output folder"}, "log")),
        png_compression_(static_cast<int>(config.integer_in(
            {"png_compression", "compression of images that arrive as pixels, from fast to small"}, 0, 9, 1))) {
    for (const std::string& name :
         config.texts({"leave_out", "", "sensors that are not written, a camera for example", "none"},
                      std::vector<std::string>{})) {
      const int sensor = rig.find(name);
      if (sensor < 0) config.fail("leave_out", fmt::format("there is no sensor \"{}\"", name));
      left_out_.insert(static_cast<std::uint32_t>(sensor));
    }
  }

  void start(const RunInfo& info) override {
    folder_ = info.out_dir / folder_name_;
    create_folder(folder_);
    std::error_code error;
    // They describe an older log until `finish` writes them anew.
    for (const char* name : {"source.yaml", "replay.yaml"}) std::filesystem::remove(folder_ / name, error);
    config_ = info.config;
    for (const Mounting& mounting : info.rig->mountings()) sensors_.push_back(mounting.name);
    if (info.reference) reference_ = write_reference(*info.reference, folder_, "    ");
  }

  void arrived(const Measurement& measurement) override {
    if (left_out_.contains(measurement.sensor)) return;
    try {
      const std::size_t table = table_for(measurement);
      tables_[table].table->append(measurement);
      note_tie(table, measurement.arrival);
    } catch (...) {
      keep_what_there_is();
      throw;
    }
  }

  void write(const Snapshot&) override {}

  void finish(const Snapshot*, const RunReport&) override { close(); }

 private:
  struct Entry {
    std::uint32_t sensor;
    std::unique_ptr<LogTable> table;
    std::set<std::size_t> before;  ///< tables whose rows came after one of this with the same arrival
  };

  std::size_t table_for(const Measurement& measurement) {
    std::size_t of_sensor = 0;
    for (std::size_t i = 0; i < tables_.size(); ++i) {
      if (tables_[i].sensor != measurement.sensor) continue;
      if (tables_[i].table->takes(measurement)) return i;
      ++of_sensor;
    }
    const std::string& sensor = sensors_.at(measurement.sensor);
    if (of_sensor == kMostTables) {
      throw Error(
          fmt::format("sensor {}: its payloads have more than {} layouts (beams, angles); a log needs a file for each",
                      sensor, kMostTables));
    }
    const std::string stem = stems_.of(sensor);
    std::unique_ptr<RowWriter> rows;
    try {
      rows = make_row_writer(measurement, folder_ / stem, png_compression_);
    } catch (const Error& error) {
      throw Error(fmt::format("sensor {}: {}; leave_out: [{}] would write the others", sensor, error.what(), sensor));
    }
    tables_.push_back(
        {measurement.sensor,
         std::make_unique<LogTable>(folder_ / (stem + ".csv"), sensor, measurement.payload->type(), std::move(rows)),
         {}});
    return tables_.size() - 1;
  }

  /// The csv source takes rows of equal arrival in the order of its files.
  void note_tie(std::size_t table, Time arrival) {
    if (last_ && last_->second == arrival && last_->first != table) tables_[last_->first].before.insert(table);
    last_ = {table, arrival};
  }

  /// The tables in an order that keeps what came first of equal arrivals, as far as there is one.
  std::vector<std::size_t> in_order() const {
    std::vector<std::size_t> left(tables_.size());
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
    std::vector<std::size_t> order;
    while (!left.empty()) {
      auto next = std::ranges::find_if(left, [&](std::size_t table) {
        return std::ranges::none_of(left, [&](std::size_t other) { return tables_[other].before.contains(table); });
      });
      if (next == left.end()) next = left.begin();
      order.push_back(*next);
      left.erase(next);
    }
    return order;
  }

  /// Ends all files and writes how to read them. What one file could not take costs the others nothing; the first error
  /// is thrown at the end.
  void close() {
    std::exception_ptr first;
    const auto attempt = [&first](const auto& step) {
      try {
        step();
      } catch (...) {
        if (!first) first = std::current_exception();
      }
    };
    for (Entry& entry : tables_) attempt([&] { entry.table->commit(); });
    attempt([&] { describe(); });
    if (first) std::rethrow_exception(first);
  }

  /// After an error: the one that came first is the one to report.
  void keep_what_there_is() noexcept {
    try {
      close();
    } catch (...) {
      return;
    }
  }

  void describe() const {
    if (tables_.empty()) return;
    std::string source = "  plugin: csv\n  max_time_jump_s: 9e9\n  max_ahead_s: 9e9\n  files:\n";
    for (const std::size_t table : in_order()) source += tables_[table].table->yaml("    ");
    if (!reference_.empty()) source += "  reference:\n" + reference_;
    write_file(folder_ / "source.yaml",
               "# What a run's source delivered. Paths count from the folder of the YAML that "
               "this stands in.\nsource:\n" +
                   source);
    if (config_.empty()) return;
    std::vector<std::size_t> silent;
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      if (std::ranges::none_of(tables_, [i](const Entry& entry) { return entry.sensor == i; })) silent.push_back(i);
    }
    write_file(folder_ / "replay.yaml", "# The robot of a run with the log of that run as its source.\n" +
                                            replay_config(config_, source, yaml_.parent_path(), silent));
  }

  std::filesystem::path yaml_;
  std::string folder_name_;
  int png_compression_;
  std::set<std::uint32_t> left_out_;

  std::filesystem::path folder_;
  std::string config_;
  std::string reference_;             // YAML
  std::vector<std::string> sensors_;  // names by index in the rig
  FileStems stems_{{"reference_trajectory", "reference_landmarks"}};
  std::vector<Entry> tables_;
  std::optional<std::pair<std::size_t, Time>> last_;
};

}  // namespace
}  // namespace waymark::log_sink

WAYMARK_PLUGIN(waymark::Sink, waymark::log_sink::Log, "log", "1.0.0")
