// SPDX-License-Identifier: Apache-2.0
#include "merged_source.hpp"

#include <algorithm>
#include <utility>

namespace waymark::host {

MergedSource::MergedSource(std::vector<std::shared_ptr<Source>> sources) {
  for (std::shared_ptr<Source>& source : sources) {
    const auto first = static_cast<std::uint32_t>(channels_.size());
    channels_.insert(channels_.end(), source->channels().begin(), source->channels().end());
    inputs_.push_back({std::move(source), first, std::nullopt});
  }
}

std::optional<Measurement> MergedSource::next() {
  Input* earliest = nullptr;
  for (Input& input : inputs_) {
    if (!std::exchange(input.read, true)) input.head = input.source->next();
    if (input.head && (earliest == nullptr || input.head->arrival < earliest->head->arrival)) earliest = &input;
  }
  if (earliest == nullptr) return std::nullopt;
  earliest->read = false;
  std::optional<Measurement> measurement = std::exchange(earliest->head, std::nullopt);
  measurement->sensor += earliest->first_channel;
  measurement->sequence = sequence_++;
  return measurement;
}

double MergedSource::progress() const {
  double least = 1.0;
  for (const Input& input : inputs_) least = std::min(least, input.source->progress());
  return least;
}

const std::vector<BadRecord>& MergedSource::bad_records() const {
  bad_.clear();
  for (const Input& input : inputs_) {
    const std::vector<BadRecord>& own = input.source->bad_records();
    bad_.insert(bad_.end(), own.begin(), own.end());
  }
  return bad_;
}

std::vector<std::string> MergedSource::notices() const {
  std::vector<std::string> all;
  for (const Input& input : inputs_) std::ranges::move(input.source->notices(), std::back_inserter(all));
  return all;
}

std::shared_ptr<const Reference> MergedSource::reference() const {
  for (const Input& input : inputs_) {
    if (auto reference = input.source->reference()) return reference;
  }
  return nullptr;
}

}  // namespace waymark::host
