// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "fusion/committed.hpp"
#include "fusion/horizon.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// What the two horizons of the committed side have in common: sensors, maps, counters, events, health.
class CommittedSteps {
 public:
  CommittedSteps(Committed& committed, MapExtraction& maps, std::optional<Datum>& datum)
      : committed_(committed), maps_(maps), datum_(datum) {}

  Committed& committed() { return committed_; }
  MapExtraction& maps() { return maps_; }

  /// What the sensor reports of the start; it may settle the map's origin.
  std::optional<StartHint> start_hint(const Measurement& m);
  const Datum* datum(const Measurement& m);
  /// Counts an update and reports it to the sensor. False if nothing was applied.
  bool account(const Measurement& m, std::size_t index, const particles::MixtureOutcome& outcome, UpdateResult& result);
  Extraction extract(const Measurement& m, const Belief& belief);
  void map(const Measurement& m, particles::Instant& at, const Extraction& extraction, UpdateResult& result);
  void note_unusable(const Measurement& m, std::string_view why);
  void conclude(const Measurement& m, UpdateResult& result);

 private:
  Committed& committed_;
  MapExtraction& maps_;
  std::optional<Datum>& datum_;
};

}  // namespace waymark::fusion
