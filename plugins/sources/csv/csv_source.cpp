// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "csv_file.hpp"
#include "number_text.hpp"
#include "reference.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/plugin/source.hpp"

namespace waymark::csv {

/// Delimited text files, merged by time of arrival; equal times in the order of the YAML.
class CsvSource final : public Source {
 public:
  CsvSource(const Config& config, const Rig& rig);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override;
  const std::vector<BadRecord>& bad_records() const override { return bad_rows_.records(); }
  std::shared_ptr<const Reference> reference() const override {
    if (reference_failure_) std::rethrow_exception(reference_failure_);
    return reference_;
  }

 private:
  /// A file, and its next measurement or why there is none.
  struct Input {
    CsvFile file;
    std::uint32_t channel = 0;
    std::optional<Measurement> pending;
    std::exception_ptr failure;

    bool done() const { return !pending && !failure; }
    Time due() const { return pending ? pending->arrival : file.newest_arrival(); }
  };

  void add_input(const Config& entry, const Rig& rig, Duration max_time_jump, Duration max_ahead);
  void fetch(Input& input);

  std::vector<Channel> channels_;
  std::vector<Input> inputs_;
  BadRecordList bad_rows_;
  std::shared_ptr<const Reference> reference_;
  std::exception_ptr reference_failure_;
  std::uint64_t sequence_ = 0;
  bool started_ = false;
};

CsvSource::CsvSource(const Config& config, const Rig& rig)
    : bad_rows_(static_cast<std::uint64_t>(config.integer_in(
                    {"max_bad_rows", "rows, over all files, that may be skipped before the run stops with an error"}, 0,
                    std::numeric_limits<std::int64_t>::max(), 0)),
                {"row", "max_bad_rows", "skips such rows"}) {
  const double jump_s =
      config.positive({"max_time_jump_s", "s", "a larger step forward within a file makes the row a bad row"}, 3600.0);
  const Duration max_ahead = from_seconds(config.number_in(
      {"max_ahead_s", "s",
       "a stamp may lie this long after its `arrival`; the host has its own opinion about such ones (`clock`)"},
      0.0, 9e9, 0.0));
  const std::vector<Config> entries = config.items(
      {"files", "text files; rows of equal time come in the order of this list; `[]` with a `reference` alone"});
  if (entries.empty() && !config.has("reference"))
    config.fail("files", "the list is empty; at least one file is expected, or a reference");
  for (const Config& entry : entries) add_input(entry, rig, from_seconds(jump_s), max_ahead);
  if (config.has("reference")) {
    const Config reference = config.child(
        {"reference",
         "truth for pictures and scores, never seen by a filter; with a bad row there is none: the run goes on and "
         "ends with an error"});
    try {
      reference_ = read_reference(reference, rig);
    } catch (const DataError&) {
      // The measurements do not need it: who asks for it gets the error.
      reference_failure_ = std::current_exception();
      reference.ignore();
    }
  }
}

void CsvSource::add_input(const Config& entry, const Rig& rig, Duration max_time_jump, Duration max_ahead) {
  Input input{.file = CsvFile(entry, max_time_jump, max_ahead), .channel = 0, .pending = {}, .failure = {}};
  const Channel wanted = channel_to_sensor(entry, rig, input.file.payload_type(), "this file");
  for (const Input& other : inputs_) {
    std::error_code error;
    if (std::filesystem::equivalent(other.file.reader().file(), input.file.reader().file(), error) &&
        other.file.signature() == input.file.signature()) {
      entry.fail("sensor", "two sensors on one input: " + in_quotes(other.file.sensor()) + " and " +
                               in_quotes(wanted.sensor) + " get the same columns of " +
                               input.file.reader().file().string());
    }
  }

  const auto is_ours = [&](const Channel& channel) {
    return channel.sensor == wanted.sensor && channel.payload_type == wanted.payload_type;
  };
  const auto channel = std::ranges::find_if(channels_, is_ours);
  input.channel = static_cast<std::uint32_t>(channel - channels_.begin());
  if (channel == channels_.end()) channels_.push_back(wanted);
  inputs_.push_back(std::move(input));
}

void CsvSource::fetch(Input& input) {
  try {
    input.pending = input.file.next(bad_rows_);
  } catch (const DataError&) {
    // Thrown when it is this file's turn, so what the others have until then is still delivered.
    input.pending.reset();
    input.failure = std::current_exception();
  }
}

std::optional<Measurement> CsvSource::next() {
  if (!std::exchange(started_, true)) {
    for (Input& input : inputs_) fetch(input);
  }
  Input* first = nullptr;
  for (Input& input : inputs_) {
    if (input.done()) continue;
    const bool earlier = first == nullptr || input.due() < first->due() ||
                         (input.due() == first->due() && first->failure && !input.failure);
    if (earlier) first = &input;
  }
  if (first == nullptr) return std::nullopt;
  if (first->failure) std::rethrow_exception(first->failure);

  std::optional<Measurement> measurement = std::exchange(first->pending, std::nullopt);
  measurement->sensor = first->channel;
  measurement->sequence = sequence_++;
  fetch(*first);
  return measurement;
}

double CsvSource::progress() const {
  if (inputs_.empty()) return 1.0;
  double consumed = 0.0;
  double total = 0.0;
  for (const Input& input : inputs_) {
    consumed += input.file.reader().used_bytes();
    total += static_cast<double>(input.file.reader().file_size());
  }
  return std::min(consumed / total, 1.0);
}

}  // namespace waymark::csv

WAYMARK_PLUGIN(waymark::Source, waymark::csv::CsvSource, "csv", "1.0.0")
