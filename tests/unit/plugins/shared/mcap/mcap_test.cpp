// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "unit/plugins/shared/mcap/small_file.hpp"
#include "waymark/base/error.hpp"

namespace waymark::mcap_test {
namespace {

using mcap::WriterOptions;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Compression = WriterOptions::Compression;

/// All ways of writing that a reader must not care about.
std::vector<WriterOptions> all_options() {
  std::vector<WriterOptions> all;
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    for (const bool indexed : {true, false}) {
      for (const bool repeated : {true, false}) {
        WriterOptions options;
        options.compression = compression;
        options.message_index = options.chunk_index = options.summary_offsets = indexed;
        options.repeat_channels = options.repeat_schemas = repeated;
        all.push_back(options);
      }
    }
  }
  WriterOptions loose;
  loose.chunks = false;
  all.push_back(loose);
  return all;
}

TEST(Mcap, MessagesComeInOrderOfTimeHoweverTheFileIsWritten) {
  for (const WriterOptions& options : all_options()) {
    const auto log = open(small_file(options));
    EXPECT_EQ(log->topics().at(0).messages, 100U);
    EXPECT_EQ(log->topics().at(1).messages, 50U);
    EXPECT_EQ(log->topics().at(1).type, "std_msgs/msg/String");
    EXPECT_EQ(log->topics().at(1).definition, "string data\n");
    EXPECT_EQ(log->topics().at(0).metadata.at("key"), "value");
    const Content content = read_all(*log);
    EXPECT_THAT(content.bad, IsEmpty());
    ASSERT_THAT(content.messages, SizeIs(150));
    EXPECT_THAT(std::vector(content.messages.begin(), content.messages.begin() + 4),
                ElementsAre("0 /a message a 0", "5 /b message b 0", "10 /a message a 1", "20 /a message a 2"));
    EXPECT_EQ(content.messages.back(), "990 /a message a 99");
  }
}

TEST(Mcap, AttachmentsAndMetadataAreRead) {
  mcap::McapFile file(std::make_unique<mcap::MemoryBytes>(small_file({})), "small.mcap");
  EXPECT_THAT(file.attachment_names(), ElementsAre("note.txt"));
  EXPECT_EQ(file.attachment("note.txt"), bytes_of("attached text"));
  EXPECT_FALSE(file.attachment("other.txt"));
  EXPECT_THAT(file.metadata(), ElementsAre(mcap::Metadata{"about", {{"robot", "r2"}}}));
  EXPECT_EQ(file.header(), (mcap::Header{"ros2", "test"}));
  EXPECT_EQ(file.statistics()->message_count, 150U);
}

TEST(Mcap, AFileThatWasNeverClosedLosesNothing) {
  for (const WriterOptions& options : all_options()) {
    const Content content = read_all(small_file(options, false));
    EXPECT_THAT(content.bad, IsEmpty());
    EXPECT_THAT(content.messages, SizeIs(150));
  }
}

TEST(Mcap, AFileThatWasCutOffIsReadUpToTheCut) {
  for (const WriterOptions& options : all_options()) {
    const Data whole = small_file(options);
    const auto messages = read_all(whole).messages;
    std::size_t before = 0;
    for (std::size_t size = 8; size < whole.size(); size += 7) {
      const Content content = read_all(Data(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      ASSERT_LE(content.messages.size(), messages.size());
      EXPECT_TRUE(std::equal(content.messages.begin(), content.messages.end(), messages.begin())) << size;
      EXPECT_LE(content.bad.size(), 1U);
      EXPECT_GE(content.messages.size(), before) << "more bytes hold more messages";
      before = content.messages.size();
    }
  }
}

TEST(Mcap, UncompressedMessagesBeforeTheCutAreNotLost) {
  WriterOptions options;
  options.compression = Compression::none;
  options.chunk_size = 1 << 20;
  const Data whole = small_file(options);
  const std::string text(whole.begin(), whole.end());
  const std::size_t cut = text.find("message a 60");
  EXPECT_THAT(read_all(Data(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut))).messages, SizeIs(90));
}

TEST(Mcap, ADamagedChunkIsSkippedAndReported) {
  WriterOptions options;
  options.compression = Compression::none;
  Data bytes = small_file(options);
  const std::string text(bytes.begin(), bytes.end());
  bytes.at(text.find("message a 50") + 8) = 'x';
  const Content content = read_all(bytes);
  ASSERT_THAT(content.bad, SizeIs(1));
  EXPECT_THAT(content.bad[0].place, HasSubstr("small.mcap:byte "));
  EXPECT_THAT(content.bad[0].reason, HasSubstr("a chunk is damaged: its checksum is another one"));
  EXPECT_GT(content.messages.size(), 100U);
  EXPECT_LT(content.messages.size(), 150U);
}

TEST(Mcap, ADamagedSummaryIsNotTrusted) {
  Data bytes = small_file({});
  const std::string text(bytes.begin(), bytes.end());
  bytes.at(text.rfind("/a") + 1) = 'z';  // of the channel in the summary
  const auto log = open(bytes);
  EXPECT_EQ(log->topics().at(0).name, "/a");
  EXPECT_THAT(read_all(*log).messages, SizeIs(150));
}

/// Inserts bytes and keeps nothing else in step.
Data with(Data bytes, std::size_t at, const Data& inserted) {
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), inserted.begin(), inserted.end());
  return bytes;
}

TEST(Mcap, RecordsOfUnknownKindAreSkipped) {
  const Data whole = small_file({}, false);
  const std::size_t behind_header = 8 + 9 + 4 + 4 + 4 + 4;
  const Data unknown{0x80, 3, 0, 0, 0, 0, 0, 0, 0, 'a', 'b', 'c'};
  EXPECT_THAT(read_all(with(whole, behind_header, unknown)).messages, SizeIs(150));
}

TEST(Mcap, LengthsThatTheFileCannotHoldAreRefusedWithoutMemory) {
  const Data whole = small_file({}, false);
  const std::size_t behind_header = 8 + 9 + 4 + 4 + 4 + 4;
  for (const int op : {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0x80}) {
    Data endless{static_cast<std::uint8_t>(op)};
    for (int i = 0; i < 8; ++i) endless.push_back(i == 7 ? 0x7f : 0xff);
    const Content content = read_all(with(whole, behind_header, endless));
    ASSERT_THAT(content.bad, SizeIs(1)) << op;
    EXPECT_THAT(content.messages, IsEmpty());
  }
}

TEST(Mcap, AChunkThatClaimsTooMuchIsRefused) {
  mcap::Chunk chunk;
  const Data nothing = bytes_of("nothing");
  chunk.records = nothing;
  for (const std::uint64_t size : {std::uint64_t{1} << 29, ~std::uint64_t{0}}) {
    for (const char* compression : {"", "lz4", "zstd"}) {
      chunk.uncompressed_size = size;
      chunk.compression = compression;
      Data bytes(std::begin(mcap::kMagic), std::end(mcap::kMagic));
      mcap::append(bytes, chunk);
      EXPECT_THAT(read_all(bytes).bad, SizeIs(1));
    }
  }
}

TEST(Mcap, WhatIsNoMcapFileIsAnError) {
  EXPECT_THROW(open({}), DataError);
  EXPECT_THROW(open(bytes_of("#ROSBAG V2.0\n")), DataError);
  mcap::Chunk chunk;
  chunk.compression = "br";
  Data bytes(std::begin(mcap::kMagic), std::end(mcap::kMagic));
  mcap::append(bytes, chunk);
  try {
    open(bytes);
    ADD_FAILURE();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the compression \"br\" is not known"));
  }
}

TEST(Mcap, AChannelThatIsDefinedTwiceInDifferentWaysIsAnError) {
  mcap::Writer writer({});
  writer.add(mcap::Channel{1, 0, "/a", "cdr", {}});
  writer.finish_chunk();
  writer.add(mcap::Channel{1, 0, "/b", "cdr", {}});
  writer.finish_chunk();
  EXPECT_THROW(open(writer.take()), DataError);
}

TEST(Mcap, EveryChangedByteIsReadWithoutHarm) {
  for (const WriterOptions& options : all_options()) {
    const Data whole = small_file(options);
    for (std::size_t at = 0; at < whole.size(); at += 11) {
      Data bytes = whole;
      bytes[at] ^= 0xff;
      try {
        read_all(bytes);
      } catch (const DataError&) {
        continue;  // the only error that may leave the reader
      }
    }
  }
}

TEST(Mcap, PiecesAreTheSameFileAsTheWhole) {
  WriterOptions options;
  options.chunk_size = 1000;
  const Data whole = small_file(options);
  options.profile = "ros2";
  options.library = "test";
  mcap::Writer writer(options);
  Data pieces;
  const auto move = [&] {
    const Data piece = writer.take();
    pieces.insert(pieces.end(), piece.begin(), piece.end());
  };
  writer.add(mcap::Schema{1, "std_msgs/msg/String", "ros2msg", bytes_of("string data\n")});
  move();
  writer.add(mcap::Channel{1, 1, "/a", "cdr", {{"key", "value"}}});
  writer.add(mcap::Channel{2, 1, "/b", "cdr", {}});
  writer.add(mcap::Metadata{"about", {{"robot", "r2"}}});
  move();
  const Data attached = bytes_of("attached text");
  writer.add(mcap::Attachment{1, 2, "note.txt", "text/plain", attached, 0});
  for (std::uint32_t k = 0; k < 100; ++k) {
    const Data a = bytes_of("message a " + std::to_string(k));
    writer.add(mcap::Message{1, k, 10 * k, 10 * k, a});
    move();
    if (k % 2 == 1) continue;
    const Data b = bytes_of("message b " + std::to_string(k / 2));
    writer.add(mcap::Message{2, k / 2, 10 * k + 5, 10 * k + 5, b});
  }
  writer.finish();
  move();
  EXPECT_EQ(pieces, whole);
}

}  // namespace
}  // namespace waymark::mcap_test
