// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace waymark::kitti {

/// A frame of the recording that cannot be used. Never leaves the source.
class Unusable : public std::runtime_error {
 public:
  Unusable(std::string place, const std::string& reason) : std::runtime_error(reason), place_(std::move(place)) {}
  const std::string& place() const { return place_; }  ///< the file

 private:
  std::string place_;
};

}  // namespace waymark::kitti
