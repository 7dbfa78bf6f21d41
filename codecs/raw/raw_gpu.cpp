#include "codecs/raw/raw_gpu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "codecs/bytes.hpp"
#include "codecs/label_codes.hpp"
#include "volumes/parallel.hpp"
#include "volumes/pyramid.hpp"

namespace cvr::codecs::raw {

namespace {

constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;  // voxels narrowed at a time

/// Appends a level from a whole word on; u64 as u32 where `narrow`.
void append_level(const VolumeInfo& info, const std::byte* voxels, bool narrow, unsigned threads,
                  Buffer& out) {
  const std::uint64_t count = info.extent.voxels();
  const std::uint64_t bytes = narrow ? 4 * count : info.bytes();
  const std::size_t at = out.size();
  out.resize(at + (bytes + 3) / 4 * 4);
  if (bytes % 4 != 0) std::memset(out.data() + at + bytes, 0, 4 - bytes % 4);
  const std::uint64_t voxel = size_of(info.type);
  volumes::parallel_for(threads, (count + kPiece - 1) / kPiece, [&](unsigned, std::uint64_t i) {
    const std::uint64_t first = i * kPiece, n = std::min(kPiece, count - first);
    if (!narrow) {
      std::memcpy(out.data() + at + first * voxel, voxels + first * voxel, n * voxel);
      return;
    }
    for (std::uint64_t k = first; k < first + n; ++k)
      std::memcpy(out.data() + at + 4 * k, voxels + 8 * k, 4);
  });
}

}  // namespace

Expected<GpuEncoding> gpu_encoding(const VolumeInfo& info, const std::byte* voxels,
                                   std::uint32_t brick, unsigned threads) {
  if (info.kind != VolumeKind::kLabels || !volumes::is_label_type(info.type)) {
    return fail(ErrorCode::kUnsupported, "only labels have a decoder for the GPU");
  }
  if (!is_brick_edge(brick)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("brick edge: expected a power of two, 2..64, found {}", brick));
  }
  Buffer aligned;
  if (reinterpret_cast<std::uintptr_t>(voxels) % alignof(std::uint64_t) != 0) {
    aligned.append(voxels, info.bytes());
    voxels = aligned.data();
  }
  threads = std::max(1u, threads);
  DistinctLabels distinct(threads);
  distinct.add(info.type, {voxels, info.bytes()});
  const std::vector<std::uint64_t> labels = distinct.take();
  const bool narrow = info.type == VoxelType::kU64 && labels.back() <= UINT32_MAX;

  GpuEncoding encoding;
  encoding.decoder = "raw";
  encoding.brick = brick;
  encoding.levels = static_cast<unsigned>(std::countr_zero(brick)) + 1;
  encoding.voxel_access = true;
  encoding.constants = {
      {"CVR_RAW_BITS", narrow ? 32u : static_cast<std::uint32_t>(8 * size_of(info.type))}};

  auto all = std::make_shared<Buffer>();
  ByteWriter table;
  Volume level;
  for (unsigned lod = 0; lod < encoding.levels; ++lod) {
    if (lod > 0)
      level = volumes::coarser_level(
          lod == 1 ? volumes::MemorySource(info, voxels) : volumes::MemorySource(level), threads);
    const VolumeInfo& level_info = lod == 0 ? info : level.info();
    table.put(std::uint64_t{all->size() / 4});
    table.put(static_cast<std::uint32_t>(level_info.extent.x));
    table.put(static_cast<std::uint32_t>(level_info.extent.y));
    table.put(static_cast<std::uint32_t>(level_info.extent.z));
    append_level(level_info, lod == 0 ? voxels : level.data(), narrow, threads, *all);
  }
  auto levels = std::make_shared<Buffer>(table.take());
  encoding.buffers.push_back({"voxels", all->bytes(), all});
  encoding.buffers.push_back({"levels", levels->bytes(), levels});
  assign_codes(labels, encoding);
  return encoding;
}

Expected<GpuSamples> gpu_samples(const VolumeInfo& info, const std::byte* voxels) {
  if (info.kind != VolumeKind::kScalars)
    return fail(ErrorCode::kUnsupported, "labels are not samples");
  std::uint32_t type = 0;
  switch (info.type) {
    case VoxelType::kU8:
      type = 0;
      break;
    case VoxelType::kU16:
      type = 1;
      break;
    case VoxelType::kI16:
      type = 2;
      break;
    case VoxelType::kF32:
      type = 3;
      break;
    default:
      return fail(ErrorCode::kUnsupported,
                  fmt::format("no samples of type {} on the GPU", name_of(info.type)));
  }
  auto words = std::make_shared<Buffer>((info.bytes() + 3) / 4 * 4);
  std::memset(words->data() + words->size() - 4, 0, 4);
  std::memcpy(words->data(), voxels, info.bytes());
  GpuSamples samples{.decoder = "raw", .constants = {{"CVR_RAW_SCALAR", type}}, .buffers = {}};
  samples.buffers.push_back({"voxels", words->bytes(), words});
  return samples;
}

}  // namespace cvr::codecs::raw
