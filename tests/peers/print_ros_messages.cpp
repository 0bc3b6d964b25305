// SPDX-License-Identifier: Apache-2.0
// Every message of ROS that waymark has, filled with values of its own, as lines of JSON: type, definition, bytes of
// CDR.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "unit/plugins/shared/cdr/all_messages.hpp"

int main() {
  using namespace waymark;
  ros_test::for_each_message([]<class Message>(const Message& message) {
    std::string hex;
    for (const std::uint8_t byte : ros::to_cdr(message)) hex += fmt::format("{:02x}", byte);
    const nlohmann::json line{{"type", Message::kType}, {"definition", ros::definition_text<Message>()}, {"cdr", hex}};
    std::puts(line.dump().c_str());
  });
}
