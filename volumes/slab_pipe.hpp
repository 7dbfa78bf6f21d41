// From decoders, which push slabs into a SlabSink, to writers, which pull boxes from a
// VolumeSource, without the whole volume in memory.
//
// The producer runs in a thread of its own. What it delivers waits in the pipe until a box asks for
// it: the planes of the box that was read last, one slab more at most, which the producer is
// filling or has filled, and the memory of a slab that was read. Boxes in ascending z, as writers
// and encoders read them, take one pass; a box above the planes that are still there starts the
// producer anew.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "volumes/error.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

class SlabPipe final : public VolumeSource {
 public:
  /// Delivers the whole volume `info` to the sink in slabs of ascending z; every call delivers the
  /// same. Called in another thread, by one at a time. What it throws, and exceptions that come
  /// from the sink, must pass through it.
  using Producer = std::function<Expected<void>(SlabSink&)>;

  /// `file` is what the producer reads, and begins the messages of its errors; slabs take about
  /// `slab_bytes` where the producer can cut them so small.
  SlabPipe(const VolumeInfo& info, std::string file, Producer produce,
           std::uint64_t slab_bytes = std::uint64_t{32} << 20);
  /// Stops the producer at its next slab and waits for it.
  ~SlabPipe() override;
  SlabPipe(const SlabPipe&) = delete;
  SlabPipe& operator=(const SlabPipe&) = delete;

  const VolumeInfo& info() const override { return info_; }
  /// Throws InputError "FILE: message" for an error of the producer, std::bad_alloc for
  /// kOutOfMemory, and what the producer throws. The last plane is handed out only after the
  /// producer has ended well, so whoever has read it has a whole volume.
  void read(const Box& box, std::byte* out) const override;
  std::vector<std::string> files() const override { return {file_}; }
  /// How often the producer was started.
  unsigned passes() const { return passes_; }

 private:
  struct Slab {
    std::uint64_t z0 = 0, z1 = 0;
    Buffer voxels;
  };
  struct Cancelled {};
  class Sink;

  void start() const;
  void stop() const;
  void run() const;
  void take_next() const;
  void drop_first() const;
  std::uint64_t window_end() const { return window_.empty() ? window_begin_ : window_.back().z1; }

  VolumeInfo info_;
  std::string file_;
  Producer produce_;
  std::uint64_t plane_bytes_, depth_;

  // The reader's own.
  mutable std::deque<Slab> window_;  ///< ascending, without gaps
  mutable std::uint64_t window_begin_ =
      0;  ///< the first plane that no pass has delivered and dropped
  mutable unsigned passes_ = 0;
  mutable std::thread thread_;

  // Between the threads, by mutex_.
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  mutable std::deque<Slab> ready_;    ///< at most one
  mutable std::deque<Buffer> spare_;  ///< memory of slabs that were read
  mutable bool cancelled_ = false, ended_ = false;
  mutable Expected<void> result_;
  mutable std::exception_ptr thrown_;
};

}  // namespace cvr::volumes
