// Where decoded voxels go while they are timed: memory that is there already, so that page faults
// are not measured.
#pragma once

#include <algorithm>
#include <cstring>

#include "volumes/source.hpp"

namespace cvr::experiments {

/// The whole volume, or where that exceeds `budget` bytes one slab that every slab is written over.
class Destination final : public volumes::SlabSink {
 public:
  Destination(const volumes::VolumeInfo& info, std::uint64_t budget)
      : plane_(info.extent.x * info.extent.y * size_of(info.type)),
        whole_(budget == 0 || info.bytes() <= budget) {
    depth_ = whole_ ? info.extent.z : std::min<std::uint64_t>(info.extent.z, kSlabPlanes);
    memory_.resize(depth_ * plane_);
    std::memset(memory_.data(), 0, memory_.size());
  }
  bool whole() const { return whole_; }
  std::uint64_t preferred_depth() const override { return depth_; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    if (whole_) return memory_.data() + z0 * plane_;
    memory_.resize(std::max<std::size_t>(memory_.size(), (z1 - z0) * plane_));
    return memory_.data();
  }
  void end(std::uint64_t, std::uint64_t) override {}

 private:
  static constexpr std::uint64_t kSlabPlanes = 64;
  std::size_t plane_;
  bool whole_;
  std::uint64_t depth_;
  volumes::Buffer memory_;
};

}  // namespace cvr::experiments
