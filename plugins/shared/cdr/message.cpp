// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/message.hpp"

#include <fmt/format.h>

#include "plugins/shared/cdr/definition_text.hpp"

namespace waymark::ros {

void require_end(const WireReader& in, std::string_view type) {
  if (in.left() > (in.is_cdr() ? kMostPadding : 0))
    throw Unusable(fmt::format("{} bytes are left behind a {}", in.left(),
                               in.is_cdr() ? std::string(type) : short_message_name(type)));
}

}  // namespace waymark::ros
