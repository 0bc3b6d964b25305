// SPDX-License-Identifier: Apache-2.0
#include "checkpoint_file.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/crc.hpp>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <system_error>

#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::host {

namespace {

constexpr std::string_view kMagic = "waymark checkpoint 1\n";

/// What stands between the magic words and the state.
struct Header {
  CheckpointIdentity identity;
  std::uint64_t size = 0;  ///< of the state [bytes]
  std::uint64_t crc = 0;   ///< of identity, size and state
};

/// FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo, 1991).
std::uint64_t mix(std::uint64_t hash, std::string_view bytes) {
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
  return hash;
}

std::uint64_t checksum(const Header& header, std::string_view state) {
  boost::crc_32_type crc;
  crc.process_bytes(&header.identity, sizeof header.identity);
  crc.process_bytes(&header.size, sizeof header.size);
  crc.process_bytes(state.data(), state.size());
  return crc.checksum();
}

}  // namespace

void LogIdentity::add(const Measurement& measurement) {
  if (count_++ >= kMeasurements) return;
  for (const std::int64_t number : {measurement.stamp.time_since_epoch().count(),
                                    measurement.arrival.time_since_epoch().count(), std::int64_t{measurement.sensor}}) {
    hash_ = mix(hash_, {reinterpret_cast<const char*>(&number), sizeof number});
  }
}

std::uint64_t identity_of(std::string_view effective_config) {
  std::uint64_t result = kEmptyHash;
  bool counts = true;  // the block of the top level that a line belongs to
  bool of_filter = false;
  while (!effective_config.empty()) {
    const std::size_t end = effective_config.find('\n');
    const std::string_view line = effective_config.substr(0, end);
    effective_config.remove_prefix(end == std::string_view::npos ? effective_config.size() : end + 1);
    if (!line.starts_with(' ')) {
      counts = !line.starts_with("sinks:") && !line.starts_with("report:") && !line.starts_with("plugin_path:") &&
               !line.starts_with("live:") && !line.starts_with("diagnosis:");
      of_filter = line.starts_with("filter:");
    }
    if (counts && !(of_filter && line.starts_with("  threads:"))) result = mix(mix(result, line), "\n");
  }
  return result;
}

void write_checkpoint(const std::filesystem::path& file, const CheckpointIdentity& identity, std::string_view state) {
  Header header{identity, state.size(), 0};
  header.crc = checksum(header, state);
  std::string bytes(kMagic);
  bytes.append(reinterpret_cast<const char*>(&header), sizeof header);
  bytes.append(state);
  write_file(file, bytes, Belongs::to_nobody);  // later runs begin at it
}

std::string read_checkpoint(const std::filesystem::path& file, CheckpointIdentity& identity) {
  std::ifstream stream(file, std::ios::binary);
  const auto fail = [&](std::string_view why) -> void { throw Error(fmt::format("{}: {}", file.string(), why)); };
  if (!stream || std::filesystem::is_directory(file)) fail("the checkpoint cannot be read");
  // Piece by piece: neither a file without end nor a size that it claims may take the memory.
  std::string magic(kMagic.size(), '\0');
  stream.read(magic.data(), std::ssize(magic));
  if (magic != kMagic) fail("is not a checkpoint of this version of waymark");
  Header header;
  if (!stream.read(reinterpret_cast<char*>(&header), sizeof header)) fail("the checkpoint is cut off");
  std::string state;
  std::array<char, 1 << 16> piece{};
  while (stream && state.size() <= header.size) {
    stream.read(piece.data(), std::ssize(piece));
    state.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (state.size() < header.size) fail("the checkpoint is cut off");
  if (state.size() != header.size || checksum(header, state) != header.crc)
    fail("the checkpoint is damaged: its checksum does not fit");
  identity = header.identity;
  return state;
}

}  // namespace waymark::host
