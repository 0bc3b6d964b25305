// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/raw_type.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace waymark::dds {
namespace {

struct RawType : ddsi_sertype {
  std::shared_ptr<Reception> reception;
  std::shared_ptr<Losses> losses;
};

struct RawSample : ddsi_serdata {
  std::vector<std::uint8_t> bytes;
  std::size_t sent_bytes = 0;
  std::uint64_t order = 0;
  bool was_received = false;
  std::atomic<bool> was_taken = false;
};

const RawType& type_of(const ddsi_sertype* type) { return *static_cast<const RawType*>(type); }
const RawSample& sample_of(const ddsi_serdata* sample) { return *static_cast<const RawSample*>(sample); }

constexpr std::size_t kUnit = 4;  // the protocol sends multiples of it

RawSample* new_sample(const ddsi_sertype* type, ddsi_serdata_kind kind) {
  auto* const sample = new RawSample();
  ddsi_serdata_init(sample, type, kind);
  return sample;
}

/// A sample that arrives. Nothing is allocated for one that is too large.
RawSample* new_arrival(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  Reception& reception = *type_of(type).reception;
  RawSample* const sample = new_sample(type, kind);
  sample->sent_bytes = size;
  sample->order = reception.arrived++;
  sample->was_received = kind == SDK_DATA;
  if (kind == SDK_DATA && size <= reception.most_bytes) sample->bytes.resize((size + kUnit - 1) / kUnit * kUnit);
  return sample;
}

// --- operations on samples -------------------------------------------------------------------------------------------

/// Exceptions must not cross C: without memory there is no sample.
template <class Make>
ddsi_serdata* or_none(Make make) noexcept {
  try {
    return make();
  } catch (const std::exception&) {
    return nullptr;
  }
}

ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                             std::size_t size) {
  return or_none([&] {
    RawSample* const sample = new_arrival(type, kind, size);
    // Fragments are in order; they may overlap.
    std::size_t filled = 0;
    for (; fragment != nullptr && !sample->bytes.empty(); fragment = fragment->nextfrag) {
      const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
      if (end <= filled || fragment->min > filled) continue;
      const unsigned char* const payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
      std::memcpy(sample->bytes.data() + filled, payload + (filled - fragment->min), end - filled);
      filled = end;
    }
    return sample;
  });
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, std::size_t size) {
  return or_none([&] {
    RawSample* const sample = new_arrival(type, kind, size);
    std::size_t filled = 0;
    for (ddsrt_msg_iovlen_t i = 0; i < count && !sample->bytes.empty(); ++i) {
      const std::size_t length = std::min<std::size_t>(pieces[i].iov_len, sample->bytes.size() - filled);
      std::memcpy(sample->bytes.data() + filled, pieces[i].iov_base, length);
      filled += length;
    }
    return sample;
  });
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return or_none([&] { return new_sample(type, SDK_KEY); });  // messages of ROS have no keys
}

/// Samples are written as CDR only; what else asks for one has a key.
ddsi_serdata* from_memory(const ddsi_sertype* type, ddsi_serdata_kind kind, const void*) {
  return kind == SDK_DATA ? nullptr : or_none([&] { return new_sample(type, kind); });
}

ddsi_serdata* without_type(const ddsi_serdata* sample) {
  return or_none([&] {
    RawSample* const key = new_sample(sample->type, SDK_KEY);
    key->type = nullptr;
    return key;
  });
}

void copy_out(const ddsi_serdata* sample, std::size_t offset, std::size_t count, void* to) {
  std::memcpy(to, sample_of(sample).bytes.data() + offset, count);
}

ddsi_serdata* lend(const ddsi_serdata* sample, std::size_t offset, std::size_t count, ddsrt_iovec_t* piece) {
  // CycloneDDS reads it only; iovec knows no constant memory.
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  piece->iov_base = const_cast<std::uint8_t*>(sample_of(sample).bytes.data()) + offset;
  piece->iov_len = count;
  return ddsi_serdata_ref(sample);
}

void take_back(ddsi_serdata* sample, const ddsrt_iovec_t*) { ddsi_serdata_unref(sample); }

void free_sample(ddsi_serdata* data) {
  auto* const sample = static_cast<RawSample*>(data);
  if (sample->was_received && !sample->was_taken && sample->type != nullptr) {
    if (const auto& losses = type_of(sample->type).losses) ++losses->overwritten;
  }
  delete sample;
}

std::uint32_t size_of(const ddsi_serdata* sample) { return static_cast<std::uint32_t>(sample_of(sample).bytes.size()); }

std::size_t print(const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t size) {
  if (size > 0) *text = '\0';
  return 0;
}

const ddsi_serdata_ops kSampleOperations = [] {
  ddsi_serdata_ops operations{};
  operations.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };
  operations.get_size = size_of;
  operations.from_ser = from_fragments;
  operations.from_ser_iov = from_pieces;
  operations.from_keyhash = from_keyhash;
  operations.from_sample = from_memory;
  operations.to_ser = copy_out;
  operations.to_ser_ref = lend;
  operations.to_ser_unref = take_back;
  operations.to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; };
  operations.to_untyped = without_type;
  operations.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return true; };
  operations.free = free_sample;
  operations.print = print;
  operations.get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* hash, bool) { std::memset(hash, 0, sizeof *hash); };
  return operations;
}();

// --- operations on types ---------------------------------------------------------------------------------------------

const ddsi_sertype_ops kTypeOperations = [] {
  ddsi_sertype_ops operations{};
  operations.version = ddsi_sertype_v0;
  operations.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete static_cast<RawType*>(type);
  };
  // Samples in memory are never asked for.
  operations.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  operations.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
  operations.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  operations.equal = [](const ddsi_sertype* a, const ddsi_sertype* b) {
    return type_of(a).reception == type_of(b).reception && type_of(a).losses == type_of(b).losses;
  };
  operations.hash = [](const ddsi_sertype*) { return std::uint32_t{0}; };
  return operations;
}();

}  // namespace

Sample::~Sample() {
  if (data_ != nullptr) ddsi_serdata_unref(data_);
}

Sample& Sample::operator=(Sample&& other) noexcept {
  std::swap(data_, other.data_);
  return *this;
}

const std::vector<std::uint8_t>& Sample::bytes() const { return sample_of(data_).bytes; }
std::size_t Sample::size() const { return sample_of(data_).sent_bytes; }
std::uint64_t Sample::order() const { return sample_of(data_).order; }
std::int64_t Sample::written_ns() const { return data_->timestamp.v; }

ddsi_sertype* make_raw_type(const std::string& dds_type, std::shared_ptr<Reception> reception,
                            std::shared_ptr<Losses> losses) {
  auto* const type = new RawType();
  ddsi_sertype_init(type, dds_type.c_str(), &kTypeOperations, &kSampleOperations, true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  type->reception = std::move(reception);
  type->losses = std::move(losses);
  return type;
}

ddsi_serdata* make_raw_sample(const ddsi_sertype* type, std::vector<std::uint8_t> cdr) {
  RawSample* const sample = new_sample(type, SDK_DATA);
  sample->sent_bytes = cdr.size();
  sample->bytes = std::move(cdr);
  sample->bytes.resize((sample->sent_bytes + kUnit - 1) / kUnit * kUnit);
  return sample;
}

void note_taken(ddsi_serdata* sample) { static_cast<RawSample*>(sample)->was_taken = true; }

}  // namespace waymark::dds
