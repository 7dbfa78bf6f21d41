// The decoder texts of shaders/decode, built as C++ and run on the buffers of a GpuEncoding: what a
// kernel would compute, without a GPU. Every buffer is copied to memory of its exact size, so that
// a sanitizer sees a read beyond it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "codecs/codec.hpp"

namespace cvr::samples {

class DecodeText {
 public:
  /// `info` is that of the volume. The encoding's payload need not live on.
  DecodeText(const codecs::GpuEncoding& encoding, const volumes::VolumeInfo& info);

  const volumes::Extent& grid() const { return grid_; }
  /// The label that a code stands for.
  std::uint64_t label(std::uint32_t code) const { return remap_.empty() ? code : remap_.at(code); }

  std::uint32_t root(const volumes::Coordinate& brick) const;
  bool visible(const volumes::Coordinate& brick,
               const std::function<bool(std::uint32_t code)>& shown) const;
  std::uint32_t cell(const volumes::Coordinate& cell, unsigned lod) const;
  /// All nodes of a brick at a level, in Morton order.
  std::vector<std::uint32_t> brick(const volumes::Coordinate& brick, unsigned lod) const;

 private:
  codecs::GpuEncoding encoding_;  ///< without its buffers
  volumes::Extent extent_, grid_;
  std::vector<std::vector<std::uint32_t>> buffers_;
  std::vector<std::uint64_t> remap_;
};

}  // namespace cvr::samples
