// SPDX-License-Identifier: Apache-2.0
// Messages of ROS as ROS 1 and ROS 2 serialize them, payloads as CDR, and messages of a recorded definition. The first
// byte of an input is the kind, the second says whether the bytes are CDR.
#include <fmt/format.h>

#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "plugins/shared/cdr/definition.hpp"
#include "plugins/shared/cdr/message_kinds.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/message_log/field_decoder.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::fuzz::cdr_harness {
namespace {

ros::Bytes bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

ros::WireReader reader(std::string_view text, bool is_cdr) {
  return is_cdr ? ros::WireReader::cdr(bytes_of(text)) : ros::WireReader(bytes_of(text));
}

/// Two messages behind another, since some payloads are made of two: the first byte is a quarter of the length of the
/// first.
void decode(const ros::Decoder& decoder, std::string_view rest, bool is_cdr) {
  const Choice first = choose(rest, 256);
  const std::size_t length = std::min(4 * first.which, first.rest.size());
  for (const std::string_view message : {first.rest.substr(0, length), first.rest.substr(length)}) {
    if (message.empty()) continue;
    const ros::Decoded decoded = decoder(reader(message, is_cdr));
    if (decoded.payload == nullptr) continue;
    const std::string problem = decoded.payload->problem();
    if (!problem.empty()) violation("a payload has bad values: " + problem);
  }
}

const std::vector<std::string>& payload_types() {
  static const std::vector<std::string> types = [] {
    std::vector<std::string> list;
    std::apply([&]<class... P>(const P&...) { (list.emplace_back(P::kType), ...); }, CorePayloads());
    return list;
  }();
  return types;
}

/// What was read is written with the same bytes, padding aside, which is read again.
void read_payload(const std::string& type, std::string_view rest) {
  const auto payload = ros::payload_from_cdr(type, bytes_of(rest));
  const std::vector<std::uint8_t> written = ros::payload_to_cdr(*payload);
  if (ros::payload_to_cdr(*ros::payload_from_cdr(type, ros::Bytes(written))) != written)
    violation("a payload changes from writing to reading");
  (void)payload->problem();
}

/// A definition and, behind a zero, a message of it.
void read_defined(std::string_view rest, bool is_cdr) {
  static const Config kEntry =
      Config::parse("{ topic: /dvl, fields: { v_x_mps: velocity.x, w_z_radps: -rate } }", "source.yaml");
  const std::size_t end = std::min(rest.find('\0'), rest.size());
  const std::string text(rest.substr(0, end));
  const std::string_view message = rest.substr(std::min(end + 1, rest.size()));
  const ros::Definition definition("dvl_msgs/msg/DVL", text);
  (void)definition.layout();
  if (definition.number_paths().size() != [&] {
        try {
          return definition.numbers(reader(message, is_cdr)).size();
        } catch (const ros::Unusable&) {
          return definition.number_paths().size();
        }
      }())
    violation("a message has not as many numbers as its definition");
  expect_value_or_error([&] {
    decode(message_log::make_field_decoder("dvl_msgs/msg/DVL", text, BodyTwist::kType, kEntry), message, is_cdr);
  });
}

void run(std::string_view input) {
  static const Config kEntry = Config::parse("{ topic: /x, sensor: a }", "source.yaml");
  static const ros::DecoderSettings kSettings{{{"left"}, {"right"}, 0.1}};
  const std::span<const ros::MessageKind> kinds = ros::message_kinds();
  const Choice kind = choose(input, kinds.size() + payload_types().size() + 1);
  const Choice wire = choose(kind.rest, 2);
  const bool is_cdr = wire.which == 1;
  try {
    if (kind.which < kinds.size()) {
      decode(kinds[kind.which].make(kSettings, kEntry), wire.rest, is_cdr);
    } else if (kind.which < kinds.size() + payload_types().size()) {
      read_payload(payload_types()[kind.which - kinds.size()], wire.rest);
    } else {
      read_defined(wire.rest, is_cdr);
    }
  } catch (const ros::Unusable&) {
    // the message is refused
  }
}

const Harness kHarness("cdr", run);

}  // namespace
}  // namespace waymark::fuzz::cdr_harness
