// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "waymark/interface/measurement.hpp"

namespace waymark::testing {

/// How many numbers a payload registers: doubles, and of each list of floats or points the first one.
std::size_t count_numbers(const Payload& payload);

/// Another value in the place of one number of a payload, until `restore` or the end of its life. The payload must have
/// been made without const, as `std::make_shared<P>()` does.
class NumberInPlace {
 public:
  NumberInPlace(const Payload& payload, std::size_t index, double value);
  ~NumberInPlace() { restore(); }
  NumberInPlace(const NumberInPlace&) = delete;
  NumberInPlace& operator=(const NumberInPlace&) = delete;

  const std::string& name() const { return name_; }
  void restore() const;

 private:
  const Payload& payload_;
  std::size_t index_;
  double before_;
  std::string name_;
};

}  // namespace waymark::testing
