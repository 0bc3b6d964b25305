// SPDX-License-Identifier: Apache-2.0
// A file of two topics, and its reading.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/mcap/mcap_log.hpp"
#include "plugins/shared/mcap/writer.hpp"

namespace waymark::mcap_test {

using Data = std::vector<std::uint8_t>;

inline Data bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

/// 100 messages on /a, 50 on /b; message k of /a is recorded at 10 k, of /b at 20 k + 5. One metadata, one attachment.
inline Data small_file(mcap::WriterOptions options, bool finished = true) {
  options.profile = "ros2";
  options.library = "test";
  if (options.chunk_size == mcap::WriterOptions().chunk_size) options.chunk_size = 1000;
  mcap::Writer writer(options);
  writer.add(mcap::Schema{1, "std_msgs/msg/String", "ros2msg", bytes_of("string data\n")});
  writer.add(mcap::Channel{1, 1, "/a", "cdr", {{"key", "value"}}});
  writer.add(mcap::Channel{2, 1, "/b", "cdr", {}});
  writer.add(mcap::Metadata{"about", {{"robot", "r2"}}});
  const Data attached = bytes_of("attached text");
  writer.add(mcap::Attachment{1, 2, "note.txt", "text/plain", attached, 0});
  for (std::uint32_t k = 0; k < 100; ++k) {
    const Data a = bytes_of("message a " + std::to_string(k));
    writer.add(mcap::Message{1, k, 10 * k, 10 * k, a});
    if (k % 2 == 1) continue;
    const Data b = bytes_of("message b " + std::to_string(k / 2));
    writer.add(mcap::Message{2, k / 2, 10 * k + 5, 10 * k + 5, b});
  }
  if (finished) {
    writer.finish();
  } else {
    writer.finish_chunk();
  }
  return writer.take();
}

inline std::unique_ptr<mcap::McapLog> open(Data bytes) {
  std::vector<mcap::McapFile> files;
  files.emplace_back(std::make_unique<mcap::MemoryBytes>(std::move(bytes)), "small.mcap");
  return std::make_unique<mcap::McapLog>(std::move(files));
}

/// What a log has, as lines "time topic text".
struct Content {
  std::vector<std::string> messages;
  std::vector<BadRecord> bad;
};

inline Content read_all(mcap::McapLog& log) {
  std::set<std::size_t> all;
  for (std::size_t i = 0; i < log.topics().size(); ++i) all.insert(i);
  log.select(all);
  BadRecordList bad(1000, {"record", "limit", "raises it"});
  Content content;
  while (const auto message = log.next(bad)) {
    content.messages.push_back(std::to_string(message->recorded.time_since_epoch().count()) + " " +
                               log.topics()[message->topic].name + " " +
                               std::string(message->data.begin(), message->data.end()));
  }
  content.bad = bad.records();
  return content;
}

inline Content read_all(Data bytes) { return read_all(*open(std::move(bytes))); }

}  // namespace waymark::mcap_test
