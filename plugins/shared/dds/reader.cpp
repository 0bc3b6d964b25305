// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/reader.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>

#include <array>

#include "plugins/shared/dds/qos.hpp"
#include "waymark/base/error.hpp"

namespace waymark::dds {

Reader::Reader(const Participant& participant, const std::string& topic, const std::string& type,
               const Quality& quality)
    : losses_(std::make_shared<Losses>()),
      topic_(participant.make_topic(topic, type, losses_)),
      entity_(dds_create_reader(participant.handle(), topic_.entity.handle(), Qos(quality, {}).get(), nullptr)) {
  if (handle() < 0) throw Error(fmt::format("DDS: {} cannot be read: {}", topic, text_of_failure(handle())));
  dds_set_status_mask(handle(), DDS_DATA_AVAILABLE_STATUS);
}

void Reader::take(std::vector<Sample>& samples) {
  constexpr std::size_t kMost = 64;
  std::array<ddsi_serdata*, kMost> taken{};
  std::array<dds_sample_info_t, kMost> infos;
  for (;;) {
    const auto count = dds_takecdr(handle(), taken.data(), kMost, infos.data(), DDS_ANY_STATE);
    for (std::size_t i = 0; count > 0 && i < static_cast<std::size_t>(count); ++i) {
      Sample sample(taken.at(i));
      note_taken(taken.at(i));
      // Without data: a writer has gone.
      if (infos.at(i).valid_data) samples.push_back(std::move(sample));
    }
    if (count < static_cast<dds_return_t>(kMost)) return;
  }
}

std::size_t Reader::writers() const {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(handle(), &status);
  return status.current_count;
}

std::size_t Reader::refused_writers() const {
  dds_requested_incompatible_qos_status_t status{};
  dds_get_requested_incompatible_qos_status(handle(), &status);
  return status.total_count;
}

std::uint64_t Reader::lost() const {
  dds_sample_lost_status_t status{};
  dds_get_sample_lost_status(handle(), &status);
  return status.total_count + losses_->overwritten;
}

Wait::Wait(const Participant& participant)
    : stop_(dds_create_guardcondition(participant.handle())), set_(dds_create_waitset(participant.handle())) {
  if (stop_.handle() < 0 || set_.handle() < 0 || dds_waitset_attach(set_.handle(), stop_.handle(), 0) < 0)
    throw Error("DDS: out of resources");
}

void Wait::add(const Reader& reader) { dds_waitset_attach(set_.handle(), reader.handle(), 0); }

void Wait::wait(std::chrono::nanoseconds limit) { dds_waitset_wait(set_.handle(), nullptr, 0, limit.count()); }

void Wait::stop() { dds_set_guardcondition(stop_.handle(), true); }

}  // namespace waymark::dds
