// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/mcap/file.hpp"
#include "plugins/shared/message_log/chunked_log.hpp"

namespace waymark::mcap {

/// Keys of a channel's metadata in files that waymark writes.
inline constexpr std::string_view kSensorKey = "waymark.sensor";    ///< name in the YAML
inline constexpr std::string_view kPayloadKey = "waymark.payload";  ///< "waymark/LaserScan@1"
inline constexpr std::string_view kRoleKey = "waymark.role";        ///< one of the following
inline constexpr std::string_view kMeasurementRole = "measurement";
inline constexpr std::string_view kDroppedRole = "dropped";
inline constexpr std::string_view kCommandRole = "command";
/// The sequence number of the channel's first message, as a decimal number of 64 bits. A message has only 32 of them.
inline constexpr std::string_view kFirstSequenceKey = "waymark.first_sequence";

/// MCAP files that are read as one.
class McapLog final : public message_log::ChunkedLog<McapFile> {
 public:
  /// Opens the files, which may be packed as a whole (.gz, .zst, .zstd). Throws DataError.
  explicit McapLog(const std::vector<std::filesystem::path>& files);
  explicit McapLog(std::vector<McapFile> files);

 private:
  std::string read_messages(const Bytes& chunk, const NewMessage& new_message) const override;
};

}  // namespace waymark::mcap
