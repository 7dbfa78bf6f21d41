// Decodes whole levels on the device and reads them back: the proof that a decoder source computes
// there what the codec computes here.
#pragma once

#include <memory>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "gpu/vulkan/commands.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

enum class DecodePath : std::uint8_t {
  kCells,   ///< each cell by an invocation of its own; needs voxel_access
  kBricks,  ///< each brick in one sweep; needs serial
  kShared,  ///< each brick by a subgroup from a copy in shared memory; needs shared_words that the device holds
};

class DecodeProbe {
 public:
  /// Uploads the encoding.
  static volumes::Expected<std::unique_ptr<DecodeProbe>> make(Device& device,
                                                              const codecs::GpuEncoding& encoding,
                                                              const volumes::VolumeInfo& info);
  ~DecodeProbe();

  /// Empty if this encoding has the path on this device.
  std::string refuses(DecodePath path) const;
  /// Labels of all cells of a level, x fastest.
  volumes::Expected<std::vector<std::uint64_t>> decode(DecodePath path, unsigned lod);

 private:
  struct Impl;
  explicit DecodeProbe(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cvr::gpu
