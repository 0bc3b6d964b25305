// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/interface/source.hpp"

namespace waymark::host {

/// Several logs as one, in order of arrival; of equal arrivals, the earlier source of the YAML first.
class MergedSource final : public Source {
 public:
  explicit MergedSource(std::vector<std::shared_ptr<Source>> sources);

  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override;
  double progress() const override;
  const std::vector<BadRecord>& bad_records() const override;
  std::vector<std::string> notices() const override;
  std::shared_ptr<const Reference> reference() const override;

 private:
  struct Input {
    std::shared_ptr<Source> source;
    std::uint32_t first_channel;
    std::optional<Measurement> head;
    bool read = false;  // `head` is the source's next, or its end
  };
  std::vector<Input> inputs_;
  std::vector<Channel> channels_;
  mutable std::vector<BadRecord> bad_;
  std::uint64_t sequence_ = 0;
};

}  // namespace waymark::host
