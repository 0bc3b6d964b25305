// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "waymark/interface/source.hpp"

namespace waymark::host {

/// Several sources with their channels in one list.
class SourceList {
 public:
  explicit SourceList(std::vector<std::shared_ptr<Source>> sources);

  std::size_t size() const { return sources_.size(); }
  auto begin() const { return sources_.begin(); }
  auto end() const { return sources_.end(); }
  Source& operator[](std::size_t source) const { return *sources_[source]; }

  /// Of all sources, in their order.
  const std::vector<Channel>& channels() const { return channels_; }
  /// Index in `channels` of a source's first one.
  std::uint32_t first_channel(std::size_t source) const { return first_channel_[source]; }
  /// Of all sources. The reference is valid until the next call.
  const std::vector<BadRecord>& bad_records() const;
  std::vector<std::string> notices() const;

 private:
  std::vector<std::shared_ptr<Source>> sources_;
  std::vector<std::uint32_t> first_channel_;
  std::vector<Channel> channels_;
  mutable std::vector<BadRecord> bad_;
};

}  // namespace waymark::host
