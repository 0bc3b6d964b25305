// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "plugins/shared/cdr/wire_reader.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace waymark::rosbag2 {

/// Rows of a query. Throws ros::Unusable for what the database cannot deliver.
class Rows {
 public:
  Rows(sqlite3* database, const std::string& query);

  /// The next row; false at the end.
  bool next();
  std::int64_t number(int column) const;
  std::string text(int column) const;
  /// Valid until the next row.
  ros::Bytes bytes(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// A database that is only read, and whose schema is not trusted.
class Database {
 public:
  /// Throws ros::Unusable.
  explicit Database(const std::filesystem::path& file);

  Rows rows(const std::string& query) const { return {database_.get(), query}; }
  /// True if there is a table (no view) that has this column.
  bool has_column(std::string_view table, std::string_view column) const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace waymark::rosbag2
