// Everything that a decoder can be asked, on bytes that nobody vouches for. Shared by the mutation
// test and the libFuzzer targets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/container.hpp"
#include "tests/samples/shared_decoders.hpp"

namespace cvr::fuzz {

/// Levels above this size are not asked for: memory of that size is the caller's own wish, stated
/// in the envelope.
inline constexpr std::uint64_t kLargestLevel = std::uint64_t{4} << 20;

/// A slab at a time, allocated to the byte, so that a sanitizer sees a write beyond it.
class ThrowAwaySink final : public volumes::SlabSink {
 public:
  explicit ThrowAwaySink(const volumes::VolumeInfo& info) : info_(info) {}
  std::uint64_t preferred_depth() const override { return 1; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    slab_ =
        std::vector<std::byte>((z1 - z0) * info_.extent.x * info_.extent.y * size_of(info_.type));
    return slab_.data();
  }
  void end(std::uint64_t, std::uint64_t) override {}

 private:
  volumes::VolumeInfo info_;
  std::vector<std::byte> slab_;
};

/// The decoder texts of the GPU on what they would be given, a brick or a cell in each corner of
/// the volume. True if nothing was refused, or if there is no such text.
inline bool exercise_gpu(const codecs::Decoder& decoder, const volumes::VolumeInfo& info) {
  if (info.bytes() > kLargestLevel) return true;
  const auto encoding = decoder.gpu_encoding(0, 1);
  if (!encoding) return encoding.error().code == codecs::ErrorCode::kUnsupported;
  const samples::DecodeText text(*encoding, info);
  const volumes::Extent grid = text.grid();
  for (const volumes::Coordinate& brick :
       {volumes::Coordinate{0, 0, 0}, {grid.x - 1, grid.y - 1, grid.z - 1}}) {
    text.label(text.root(brick));
    text.visible(brick, [](std::uint32_t) { return false; });
    for (unsigned lod = 0; lod < encoding->levels; lod += 2) {
      const volumes::Extent e = codecs::level_extent(info.extent, lod);
      if (encoding->voxel_access) {
        text.label(
            text.cell({brick.x == 0 ? 0 : e.x - 1, brick.y == 0 ? 0 : e.y - 1, e.z - 1}, lod));
      }
      if (encoding->serial) {
        for (const std::uint32_t code : text.brick(brick, lod)) text.label(code);
      }
    }
  }
  return true;
}

/// Decodes all levels, some voxels, some bricks and all steps. Results do not matter; returning
/// does. True if nothing was refused.
inline bool exercise(const codecs::Decoder& decoder, const volumes::VolumeInfo& info) {
  bool accepted = true;
  for (unsigned lod = 0; lod < decoder.levels(); ++lod) {
    const volumes::VolumeInfo level = codecs::level_info(info, lod);
    if (level.bytes() <= kLargestLevel) {
      ThrowAwaySink sink(level);
      accepted &= decoder.decode(lod, 1, sink).has_value();
    }
    const volumes::Extent& e = info.extent;
    const std::vector<volumes::Coordinate> points{{0, 0, 0},
                                                  {e.x - 1, e.y - 1, e.z - 1},
                                                  {e.x / 2, e.y / 2, e.z / 2},
                                                  {e.x / 3, e.y - 1, e.z / 5}};
    if (const codecs::VoxelAccess* access = decoder.voxel_access()) {
      std::vector<std::uint64_t> labels(points.size());
      accepted &= access->at(points, lod, labels).has_value();
    }
    const codecs::BrickAccess* access = decoder.brick_access();
    if (access == nullptr) continue;
    const volumes::Extent size = codecs::level_extent(access->brick_size(), lod);
    if (size.voxels() * size_of(info.type) > kLargestLevel) continue;
    std::vector<std::byte> brick(size.voxels() * size_of(info.type));
    const volumes::Extent grid = access->brick_grid();
    accepted &= access->only_label({0, 0, 0}).has_value();
    accepted &= access->decode_brick({0, 0, 0}, lod, brick.data()).has_value();
    accepted &=
        access->decode_brick({grid.x - 1, grid.y - 1, grid.z - 1}, lod, brick.data()).has_value();
  }
  if (const codecs::ProgressiveAccess* access = decoder.progressive_access();
      access != nullptr && info.bytes() <= kLargestLevel) {
    for (unsigned step = 0; step < access->steps(); ++step) {
      ThrowAwaySink sink(info);
      accepted &= access->decode_step(step, 1, sink).has_value();
    }
  }
  return accepted && exercise_gpu(decoder, info);
}

/// A payload in the place of the one that the envelope announces.
inline bool exercise_payload(const codecs::Codec& codec, const codecs::Stream& stream) {
  const auto decoder = codec.open(stream);
  return decoder.has_value() && exercise(**decoder, stream.info);
}

/// A whole file. False where it was refused.
inline bool exercise_file(std::span<const std::byte> bytes) {
  const auto file = codecs::open_file(bytes);
  return file.has_value() && exercise_payload(*file->codec, file->stream);
}

}  // namespace cvr::fuzz
