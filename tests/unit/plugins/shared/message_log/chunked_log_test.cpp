// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/message_log/chunked_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::message_log {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

BadRecordList most(std::uint64_t bad_records) { return {bad_records, {"a record", "max_bad_records", "skips it"}}; }

Time at(int seconds) { return Time{std::chrono::seconds(seconds)}; }

/// A chunk whose bytes are pairs: channel, second of the recording.
struct FakeChunk {
  std::uint64_t offset = 0;
  bool whole = true;
  Time first = Time::max();
  std::map<std::uint16_t, std::uint64_t> count;
  std::vector<std::uint8_t> bytes;
  std::string problem;
};

struct FakeContent {
  std::vector<std::uint8_t> bytes;
  std::string problem;
};

class FakeFile {
 public:
  explicit FakeFile(std::vector<FakeChunk> chunks, std::string broken = "")
      : chunks_(std::move(chunks)), broken_(std::move(broken)) {}
  const std::vector<FakeChunk>& chunks() const { return chunks_; }
  FakeContent load(const FakeChunk& chunk) { return {chunk.bytes, chunk.problem}; }
  std::string place(std::uint64_t offset) const { return fmt::format("fake:byte {}", offset); }
  std::uint64_t broken_at() const { return 99; }
  const std::string& broken_because() const { return broken_; }

 private:
  std::vector<FakeChunk> chunks_;
  std::string broken_;
};

FakeChunk chunk(std::uint64_t offset, std::vector<std::uint8_t> bytes) {
  FakeChunk result;
  result.offset = offset;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    result.first = std::min(result.first, at(bytes[i + 1]));
    ++result.count[bytes[i]];
  }
  result.bytes = std::move(bytes);
  return result;
}

class FakeLog final : public ChunkedLog<FakeFile> {
 public:
  FakeLog(std::vector<FakeFile> opened, const std::vector<std::pair<std::size_t, std::uint32_t>>& channels)
      : ChunkedLog(std::move(opened)) {
    for (const auto& [file, channel] : channels) add_topic(file, channel, {});
  }

  /// The seconds of the messages of these topics.
  std::vector<int> seconds(std::set<std::size_t> topics, BadRecordList& bad) {
    select(std::move(topics));
    std::vector<int> all;
    while (const auto message = next(bad)) all.push_back(static_cast<int>(to_seconds(message->recorded - Time{})));
    return all;
  }

 private:
  std::string read_messages(const Bytes& bytes, const NewMessage& new_message) const override {
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
      if (Message* message = new_message(bytes[i])) {
        message->recorded = at(bytes[i + 1]);
        message->offset = i;
      }
    }
    return bytes.size() % 2 == 0 ? "" : "half a message";
  }
};

TEST(ChunkedLog, PutsTheMessagesOfAllFilesInTheOrderOfRecording) {
  FakeLog log({FakeFile({chunk(0, {1, 5, 1, 7}), chunk(4, {1, 6})}), FakeFile({chunk(0, {1, 1, 1, 9})})},
              {{0, 1}, {1, 1}});
  BadRecordList bad = most(0);
  EXPECT_THAT(log.seconds({0, 1}, bad), ElementsAre(1, 5, 6, 7, 9));
}

TEST(ChunkedLog, DeliversTheSelectedTopicsOnly) {
  FakeLog log({FakeFile({chunk(0, {1, 1, 2, 2, 1, 3}), chunk(6, {2, 4})})}, {{0, 1}, {0, 2}});
  BadRecordList bad = most(0);
  EXPECT_THAT(log.seconds({1}, bad), ElementsAre(2, 4));
}

TEST(ChunkedLog, NamesAChunkThatIsDamaged) {
  FakeLog log({FakeFile({chunk(40, {1, 1, 1})})}, {{0, 1}});
  BadRecordList bad = most(1);
  EXPECT_THAT(log.seconds({0}, bad), ElementsAre(1));
  ASSERT_EQ(bad.records().size(), 1U);
  EXPECT_EQ(bad.records()[0].place, "fake:byte 40");
  EXPECT_THAT(bad.records()[0].reason, HasSubstr("half a message"));
}

TEST(ChunkedLog, ReportsWhereAFileBreaksOffAfterItsMessages) {
  FakeLog log({FakeFile({chunk(0, {1, 1})}, "a record is cut off")}, {{0, 1}});
  EXPECT_THAT(log.problem(), HasSubstr("fake:byte 99: a record is cut off"));
  BadRecordList none = most(0);
  EXPECT_THROW(log.seconds({0}, none), DataError);
}

}  // namespace
}  // namespace waymark::message_log
