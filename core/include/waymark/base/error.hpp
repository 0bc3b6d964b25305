// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "waymark/base/api.hpp"

namespace waymark {

/// A fault that the user can mend: bad configuration, bad data, a plugin that does not fit. The text names the place,
/// the value and what was expected. Faults of our own are asserts, not errors.
class WAYMARK_TYPE Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The configuration is wrong; the text starts with `file:line:col: key.path:`.
class WAYMARK_TYPE ConfigError : public Error {
 public:
  using Error::Error;
};

/// A log or a measurement is wrong; the text starts with `file:line:` where there is one.
class WAYMARK_TYPE DataError : public Error {
 public:
  using Error::Error;
};

/// A shared library is missing, is no plugin, or was built for another host.
class WAYMARK_TYPE PluginError : public Error {
 public:
  using Error::Error;
};

}  // namespace waymark
