// SPDX-License-Identifier: Apache-2.0
#include "database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

namespace waymark::rosbag2 {
namespace {

constexpr int kLargestValue = 1 << 28;

int open(const std::filesystem::path& file, bool immutable, sqlite3** database) {
  // As a URI, in which these characters have a meaning.
  std::string name;
  for (const char c : std::filesystem::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#') {
      name += fmt::format("%{:02x}", static_cast<unsigned>(c));
    } else {
      name += c;
    }
  }
  const std::string uri = fmt::format("file:{}{}", name, immutable ? "?immutable=1" : "");
  return ::sqlite3_open_v2(uri.c_str(), database, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
}

}  // namespace

void Rows::Finalize::operator()(sqlite3_stmt* statement) const { ::sqlite3_finalize(statement); }

void Database::Close::operator()(sqlite3* database) const { ::sqlite3_close_v2(database); }

Rows::Rows(sqlite3* database, const std::string& query) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int status = ::sqlite3_prepare_v2(database, query.c_str(), -1, &statement, nullptr);
  statement_.reset(statement);
  if (status != SQLITE_OK) throw ros::Unusable(::sqlite3_errmsg(database));
}

bool Rows::next() {
  const int status = ::sqlite3_step(statement_.get());
  if (status == SQLITE_ROW) return true;
  if (status == SQLITE_DONE) return false;
  throw ros::Unusable(::sqlite3_errmsg(database_));
}

std::int64_t Rows::number(int column) const { return ::sqlite3_column_int64(statement_.get(), column); }

std::string Rows::text(int column) const {
  const ros::Bytes value = bytes(column);
  return {value.begin(), value.end()};
}

ros::Bytes Rows::bytes(int column) const {
  const auto* const data = static_cast<const std::uint8_t*>(::sqlite3_column_blob(statement_.get(), column));
  const int size = ::sqlite3_column_bytes(statement_.get(), column);
  return data == nullptr ? ros::Bytes() : ros::Bytes(data, static_cast<std::size_t>(size));
}

Database::Database(const std::filesystem::path& file) {
  for (const bool immutable : {false, true}) {
    sqlite3* opened = nullptr;
    const int status = open(file, immutable, &opened);
    database_.reset(opened);
    if (status == SQLITE_OK) {
      ::sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
      ::sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
      ::sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, kLargestValue);
    }
    try {
      if (status != SQLITE_OK) throw ros::Unusable(opened == nullptr ? "no memory" : ::sqlite3_errmsg(opened));
      rows("SELECT count(*) FROM sqlite_master").next();
      return;
    } catch (const ros::Unusable&) {
      // A folder in which nothing can be written, with a journal beside the database: without the journal it can be
      // read.
      if (immutable) throw;
    }
  }
}

bool Database::has_column(std::string_view table, std::string_view column) const {
  Rows found = rows(fmt::format("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = '{}'", table));
  if (!found.next() || found.number(0) == 0) return false;
  Rows columns = rows(fmt::format("SELECT count(*) FROM pragma_table_info('{}') WHERE name = '{}'", table, column));
  return columns.next() && columns.number(0) > 0;
}

}  // namespace waymark::rosbag2
