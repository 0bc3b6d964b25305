// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "source_list.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::host {

/// Several logs as one, in order of arrival; of equal arrivals, the earlier source of the YAML first.
class MergedSource final : public Source {
 public:
  explicit MergedSource(std::vector<std::shared_ptr<Source>> sources);

  const std::vector<Channel>& channels() const override { return sources_.channels(); }
  std::optional<Measurement> next() override;
  double progress() const override;
  const std::vector<BadRecord>& bad_records() const override { return sources_.bad_records(); }
  std::vector<std::string> notices() const override { return sources_.notices(); }
  std::shared_ptr<const Reference> reference() const override;

 private:
  struct Head {
    std::optional<Measurement> measurement;
    bool is_read = false;  // `measurement` is the source's next, or nothing at its end
  };
  SourceList sources_;
  std::vector<Head> heads_;  // of each source
  std::uint64_t sequence_ = 0;
};

}  // namespace waymark::host
