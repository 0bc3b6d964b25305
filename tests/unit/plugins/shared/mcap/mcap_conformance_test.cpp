// SPDX-License-Identifier: Apache-2.0
// A few of the public conformance cases (foxglove/mcap, tests/conformance): the two checksums of a case cover all of
// its bytes. tests/peers/compare_mcap_cases.py has all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "plugins/shared/mcap/writer.hpp"

namespace waymark::mcap_test {
namespace {

using Data = std::vector<std::uint8_t>;
using mcap::Writer;
using mcap::WriterOptions;

struct Case {
  std::size_t size;
  std::uint32_t data_crc;
  std::uint32_t summary_crc;
};

WriterOptions nothing_else() {
  WriterOptions options;
  options.compression = WriterOptions::Compression::none;
  options.chunks = options.message_index = options.repeat_schemas = options.repeat_channels = options.statistics =
      options.chunk_index = options.attachment_index = options.metadata_index = options.summary_offsets = false;
  return options;
}

void expect(const Case& expected, const WriterOptions& options, const std::function<void(Writer&)>& add) {
  Writer writer(options);
  add(writer);
  writer.finish();
  const Data bytes = writer.take();
  EXPECT_EQ(bytes.size(), expected.size);
  std::uint32_t summary_crc = 0;
  std::memcpy(&summary_crc, bytes.data() + bytes.size() - 12, sizeof summary_crc);
  EXPECT_EQ(summary_crc, expected.summary_crc);
  Data wanted(9 + sizeof expected.data_crc);
  wanted[0] = 15;  // DataEnd
  wanted[1] = sizeof expected.data_crc;
  std::memcpy(wanted.data() + 9, &expected.data_crc, sizeof expected.data_crc);
  EXPECT_NE(std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end()), bytes.end());
}

void add_example(Writer& writer) {
  writer.add(mcap::Schema{1, "Example", "c", {4, 5, 6}});
  writer.add(mcap::Channel{1, 1, "example", "a", {{"foo", "bar"}}});
}

const Data kData{1, 2, 3};

TEST(McapConformance, NoData) {
  expect({75, 3959079795U, 1875167664U}, nothing_else(), [](Writer&) {});
}

TEST(McapConformance, OneMessageInAChunkWithAllIndices) {
  WriterOptions options = nothing_else();
  options.chunks = options.message_index = options.repeat_schemas = options.repeat_channels = options.statistics =
      options.chunk_index = options.summary_offsets = true;
  expect({603, 1703938896U, 3886418329U}, options, [](Writer& writer) {
    add_example(writer);
    writer.add(mcap::Message{1, 10, 2, 1, kData});
  });
}

TEST(McapConformance, OneAttachment) {
  WriterOptions options = nothing_else();
  options.attachment_index = options.statistics = options.summary_offsets = true;
  expect({258 + 2 * 26 + 29 + 8, 3051995293U, 537080127U}, options, [](Writer& writer) {
    writer.add(mcap::Attachment{2, 1, "myFile", "application/octet-stream", kData, 0});
  });
}

TEST(McapConformance, OneMetadata) {
  WriterOptions options = nothing_else();
  options.metadata_index = options.statistics = options.summary_offsets = true;
  expect({173 + 2 * 26 + 29 + 8, 864453130U, 1977374533U}, options, [](Writer& writer) {
    writer.add(mcap::Metadata{"myMetadata", {{"foo", "bar"}}});
  });
}

}  // namespace
}  // namespace waymark::mcap_test
