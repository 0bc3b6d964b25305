// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bag.hpp"
#include "plugins/shared/message_log/chunked_log.hpp"

namespace waymark::rosbag1 {

/// Bags that are read as one.
class BagLog final : public message_log::ChunkedLog<Bag> {
 public:
  /// Throws DataError.
  explicit BagLog(const std::vector<std::filesystem::path>& bags);

 private:
  std::string read_messages(const Bytes& chunk, const NewMessage& new_message) const override;
  std::uint64_t most_bytes() const override { return most_bytes_; }

  std::uint64_t most_bytes_ = 0;
};

}  // namespace waymark::rosbag1
