// SPDX-License-Identifier: Apache-2.0
// What the tests of DDS share.
#pragma once

#include <unistd.h>

#include <cstdint>

namespace waymark::test {

/// A domain of this process alone: tests that run beside each other must not see each other's topics. Domains from 200
/// on would need ports that Linux gives to others.
inline std::uint32_t own_domain() { return 1 + static_cast<std::uint32_t>(::getpid()) % 199; }

}  // namespace waymark::test
