// What every generator shares: a request (extent, seed, checked parameters, threads) and a source
// that cuts any box into tiles of the volume's own fixed grid and has them made in parallel. A
// generator implements one function: the labels or the scalars of a box that lies inside one tile.
// Those may depend on the position alone, never on the box that was asked for.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

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

/// The cutting into tiles, whatever the voxels are.
class TiledVolume : public VolumeSource {
 public:
  const VolumeInfo& info() const override { return info_; }
  void read(const Box& box, std::byte* out) const override;

 protected:
  /// `request.extent` is that of all time steps.
  TiledVolume(const GeneratorRequest& request, VoxelType type, VolumeKind kind, const Extent& tile,
              std::uint64_t time_steps = 1);
  /// Writes the voxels of `part`, which lies inside one tile and inside `box`, to their places in
  /// `out`, the voxels of `box`. `scratch` is the caller's to use. Called by several threads at
  /// once.
  virtual void fill_part(const Box& part, const Box& box, std::byte* out,
                         std::vector<std::uint32_t>& scratch) const = 0;

 private:
  VolumeInfo info_;
  Extent tile_;
  unsigned threads_;
};

/// Labels.
class TiledSource : public TiledVolume {
 protected:
  /// Tiles have `tile` voxels and start at multiples of it.
  TiledSource(const GeneratorRequest& request, VoxelType type, const Extent& tile)
      : TiledVolume(request, type, VolumeKind::kLabels, tile) {}
  /// Writes the labels of `box`, which lies inside one tile, x fastest and densely packed. Called
  /// by several threads at once.
  virtual void fill(const Box& box, std::uint32_t* labels) const = 0;

 private:
  void fill_part(const Box& part, const Box& box, std::byte* out,
                 std::vector<std::uint32_t>& labels) const final;
};

/// Scalars: u8 and u16 take 0..1 to their range, f32 holds the value.
class TiledScalars : public TiledVolume {
 protected:
  /// The type comes from the request's parameter "bits": 8 (u8), 16 (u16) or 32 (f32). Throws
  /// InputError on another.
  TiledScalars(std::string_view kind, const GeneratorRequest& request,
               std::uint64_t time_steps = 1);
  /// Writes the value in 0..1 of each voxel of a row of `count` from `start` along x. Called by
  /// several threads at once.
  virtual void fill_row(const Coordinate& start, std::uint64_t count, float* values) const = 0;

 private:
  void fill_part(const Box& part, const Box& box, std::byte* out,
                 std::vector<std::uint32_t>& labels) const final;
};

/// Of every generator of scalars.
inline constexpr GeneratorParameter kScalarBits{
    "bits", 8, 8, 32, "of a voxel: 8 (u8), 16 (u16) or 32 (f32)", true};

}  // namespace cvr::volumes
