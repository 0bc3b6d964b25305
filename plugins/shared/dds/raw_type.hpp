// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct ddsi_sertype;
struct ddsi_serdata;

/// A type of DDS whose samples stay bytes. CycloneDDS would decode them by code that it generates from IDL, and drop in
/// silence what it cannot decode; here a sample arrives as it was sent, and is decoded by waymark's own CDR.
namespace waymark::dds {

/// What readers of one participant count.
struct Reception {
  std::size_t most_bytes = 0;              ///< of a sample; the bytes of larger ones are not kept
  std::atomic<std::uint64_t> arrived = 0;  ///< samples so far: their order
};

/// What one reader counts.
struct Losses {
  std::atomic<std::uint64_t> overwritten = 0;  ///< samples that newer ones replaced before they were taken
};

/// A sample of CDR with its encapsulation header, counted by references.
class Sample {
 public:
  explicit Sample(ddsi_serdata* owned) : data_(owned) {}
  ~Sample();
  Sample(Sample&& other) noexcept : data_(other.data_) { other.data_ = nullptr; }
  Sample& operator=(Sample&& other) noexcept;
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;

  /// Padded to a multiple of four bytes; empty if the sample is too large.
  const std::vector<std::uint8_t>& bytes() const;
  std::size_t size() const;         ///< as sent
  std::uint64_t order() const;      ///< of its arrival, among all readers of the participant
  std::int64_t written_ns() const;  ///< when it was written, by the writer's clock: since 1970

 private:
  ddsi_serdata* data_;
};

/// A new type, to be given to dds_create_topic_sertype. `losses` may be null. Throws std::bad_alloc.
ddsi_sertype* make_raw_type(const std::string& dds_type, std::shared_ptr<Reception> reception,
                            std::shared_ptr<Losses> losses);

/// A sample of that type, to be given to dds_writecdr.
ddsi_serdata* make_raw_sample(const ddsi_sertype* type, std::vector<std::uint8_t> cdr);

/// Marks a sample as taken by its reader.
void note_taken(ddsi_serdata* sample);

}  // namespace waymark::dds
