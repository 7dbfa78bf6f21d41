// What every generator shares: a request (extent, seed, checked parameters, threads) and a source that cuts
// any box into tiles of the volume's own fixed grid and has them made in parallel. A generator implements one
// function: the labels of a box that lies inside one tile. Those labels may depend on the position alone,
// never on the box that was asked for.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "volumes/generators/generator.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

struct GeneratorRequest {
  Extent extent;
  std::uint64_t seed;
  std::map<std::string, double, std::less<>> values;  ///< every declared parameter has one
  unsigned threads;

  double operator[](std::string_view name) const { return values.find(name)->second; }
};

class TiledSource : public VolumeSource {
 public:
  const VolumeInfo& info() const override { return info_; }
  void read(const Box& box, std::byte* out) const override;

 protected:
  /// Tiles have `tile` voxels and start at multiples of it.
  TiledSource(const GeneratorRequest& request, VoxelType type, const Extent& tile);
  /// Writes the labels of `box`, which lies inside one tile, x fastest and densely packed. Called by several
  /// threads at once.
  virtual void fill(const Box& box, std::uint32_t* labels) const = 0;

 private:
  VolumeInfo info_;
  Extent tile_;
  unsigned threads_;
};

}  // namespace cvr::volumes
