// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <chrono>

#include "plugins/shared/dds/participant.hpp"

namespace waymark::dds {

/// Qualities as CycloneDDS takes them.
class Qos {
 public:
  /// `patience`: how long a reliable writer waits for slow readers.
  Qos(const Quality& quality, std::chrono::nanoseconds patience) : qos_(dds_create_qos()) {
    dds_qset_reliability(qos_, quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         patience.count());
    dds_qset_durability(qos_, quality.latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, quality.depth);
    // What a latched topic keeps for those who come later has a setting of its own.
    if (quality.latched) {
      dds_qset_durability_service(qos_, 0, DDS_HISTORY_KEEP_LAST, quality.depth, DDS_LENGTH_UNLIMITED,
                                  DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    }
    dds_qset_writer_data_lifecycle(qos_, false);
    const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos_, 1, &representation);
  }
  ~Qos() { dds_delete_qos(qos_); }
  Qos(const Qos&) = delete;
  Qos& operator=(const Qos&) = delete;

  const dds_qos_t* get() const { return qos_; }

 private:
  dds_qos_t* qos_;
};

}  // namespace waymark::dds
