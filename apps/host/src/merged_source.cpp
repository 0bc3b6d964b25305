// SPDX-License-Identifier: Apache-2.0
#include "merged_source.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace waymark::host {

MergedSource::MergedSource(std::vector<std::shared_ptr<Source>> sources)
    : sources_(std::move(sources)), heads_(sources_.size()) {}

std::optional<Measurement> MergedSource::next() {
  std::optional<std::size_t> earliest;
  for (std::size_t i = 0; i < heads_.size(); ++i) {
    if (!std::exchange(heads_[i].is_read, true)) heads_[i].measurement = sources_[i].next();
    if (!heads_[i].measurement) continue;
    if (!earliest || heads_[i].measurement->arrival < heads_[*earliest].measurement->arrival) earliest = i;
  }
  if (!earliest) return std::nullopt;
  std::optional<Measurement> measurement = std::exchange(heads_[*earliest], {}).measurement;
  measurement->sensor += sources_.first_channel(*earliest);
  measurement->sequence = sequence_++;
  return measurement;
}

double MergedSource::progress() const {
  double least = 1.0;
  for (const std::shared_ptr<Source>& source : sources_) least = std::min(least, source->progress());
  return least;
}

std::shared_ptr<const Reference> MergedSource::reference() const {
  for (const std::shared_ptr<Source>& source : sources_) {
    if (auto reference = source->reference()) return reference;
  }
  return nullptr;
}

}  // namespace waymark::host
