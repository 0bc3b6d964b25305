// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/writer.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>

#include <utility>

#include "plugins/shared/dds/qos.hpp"
#include "waymark/base/error.hpp"

namespace waymark::dds {

Writer::Writer(const Participant& participant, const std::string& topic, const std::string& type,
               const Quality& quality, std::chrono::nanoseconds patience)
    : topic_(participant.make_topic(topic, type, nullptr)),
      entity_(dds_create_writer(participant.handle(), topic_.entity.handle(), Qos(quality, patience).get(), nullptr)) {
  if (entity_.handle() < 0)
    throw Error(fmt::format("DDS: {} cannot be written: {}", topic, text_of_failure(entity_.handle())));
}

void Writer::write(std::vector<std::uint8_t> cdr, std::optional<Time> written) {
  ddsi_serdata* const sample = make_raw_sample(topic_.type, std::move(cdr));
  sample->statusinfo = 0;
  sample->timestamp.v = written ? written->time_since_epoch().count() : dds_time();
  if (dds_forwardcdr(entity_.handle(), sample) != DDS_RETCODE_OK) ++left_out_;
}

void Writer::wait_for_readers(std::chrono::nanoseconds limit) { dds_wait_for_acks(entity_.handle(), limit.count()); }

std::size_t Writer::readers() const {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(entity_.handle(), &status);
  return status.current_count;
}

}  // namespace waymark::dds
