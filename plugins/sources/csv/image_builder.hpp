// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "payload_builders.hpp"

namespace waymark::csv {

/// Images that lie beside the text file, each in a file of its own that a column names.
class ImageBuilder final : public PayloadBuilder {
 public:
  /// Relative names count from `folder`, that of the text file. Throws ConfigError.
  ImageBuilder(const Config& columns, std::filesystem::path folder, ColumnFinder& finder);

  /// The file's bytes as they are, as a compressed image. Throws BadRow if it cannot be read.
  std::shared_ptr<Payload> build(Row row) const override;

 private:
  Column file_;
  std::filesystem::path folder_;
};

}  // namespace waymark::csv
