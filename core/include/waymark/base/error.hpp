// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "waymark/base/api.hpp"

namespace waymark {

/// An error that the user can correct: in the configuration, the data or a plugin. The message has place, value and
/// expectation. Program errors are assertions instead.
class WAYMARK_TYPE Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Invalid configuration. The message starts with `file:line:col: key.path:`.
class WAYMARK_TYPE ConfigError : public Error {
 public:
  using Error::Error;
};

/// Invalid log or measurement. The message starts with `file:line:` if there is one.
class WAYMARK_TYPE DataError : public Error {
 public:
  using Error::Error;
};

/// A shared library is missing, is not a plugin, or was built for another host.
class WAYMARK_TYPE PluginError : public Error {
 public:
  using Error::Error;
};

}  // namespace waymark
