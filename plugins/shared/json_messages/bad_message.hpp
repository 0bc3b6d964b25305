// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace waymark::json_messages {

/// Why a line is not a message. The text is printable, and not long, whatever the line holds.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A text of unknown origin, for a message to the user: shortened, with '?' for what is not printable ASCII.
std::string printable(std::string_view text, std::size_t longest = 40);

}  // namespace waymark::json_messages
