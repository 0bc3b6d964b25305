// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/match_record.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace waymark {
namespace {

using scan_matching::MatchAssociation;
using scan_matching::MatchRecord;

TEST(MatchRecord, OfAMatchThatTheHostRefusesWhatIsUsedInsteadCounts) {
  using Kind = MatchAssociation::Outcome::Kind;
  MatchAssociation how;
  how.found = {Kind::matched, true, 0.8};
  how.if_refused = {Kind::matched, false, 0.4};
  MatchRecord record;
  record.count(how);
  how.refused = true;
  record.count(how);
  how.if_refused = {Kind::failed, false, 0.1};
  record.count(how);
  std::vector<MapFigure> figures;
  record.describe(figures);
  std::map<std::string, double> by_name;
  for (const MapFigure& figure : figures) by_name[figure.name] = figure.value;
  EXPECT_EQ(by_name["matches"], 2.0);
  EXPECT_EQ(by_name["failed_matches"], 1.0);
  EXPECT_EQ(by_name["slips"], 1.0);
  EXPECT_DOUBLE_EQ(by_name["mean_score"], 0.6);
}

}  // namespace
}  // namespace waymark
