// SPDX-License-Identifier: Apache-2.0
#include "source_list.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace waymark::host {

SourceList::SourceList(std::vector<std::shared_ptr<Source>> sources) : sources_(std::move(sources)) {
  for (const std::shared_ptr<Source>& source : sources_) {
    first_channel_.push_back(static_cast<std::uint32_t>(channels_.size()));
    channels_.insert(channels_.end(), source->channels().begin(), source->channels().end());
  }
}

const std::vector<BadRecord>& SourceList::bad_records() const {
  bad_.clear();
  for (const std::shared_ptr<Source>& source : sources_) {
    const std::vector<BadRecord>& own = source->bad_records();
    bad_.insert(bad_.end(), own.begin(), own.end());
  }
  return bad_;
}

std::vector<std::string> SourceList::notices() const {
  std::vector<std::string> all;
  for (const std::shared_ptr<Source>& source : sources_) std::ranges::move(source->notices(), std::back_inserter(all));
  return all;
}

}  // namespace waymark::host
