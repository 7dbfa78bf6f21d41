#include "codecs/codec.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "volumes/enum_names.hpp"

namespace cvr::codecs {

std::string_view name_of(Granularity granularity) {
  static constexpr auto kNames = volumes::enum_names<Granularity>({{Granularity::kVolume, "volume"},
                                                                   {Granularity::kBrick, "brick"},
                                                                   {Granularity::kBlock, "block"},
                                                                   {Granularity::kVoxel, "voxel"}});
  return kNames.of(granularity);
}

std::string_view name_of(ByteClass byte_class) {
  static constexpr std::array<std::string_view, kByteClasses> kNames{
      "header", "index", "operations", "stop_bits", "rank", "palette", "tables", "data", "padding"};
  return kNames[static_cast<std::size_t>(byte_class)];
}

Expected<std::optional<std::uint64_t>> Decoder::entropy_bytes(unsigned) const {
  return std::nullopt;
}

std::optional<double> Codec::promised_error(const Parameters&) const { return std::nullopt; }

Expected<GpuEncoding> Decoder::gpu_encoding(std::uint32_t, unsigned) const {
  return fail(ErrorCode::kUnsupported, "this codec has no decoder for the GPU");
}

Expected<GpuSamples> Decoder::gpu_samples(unsigned) const {
  return fail(ErrorCode::kUnsupported, "this codec has no decoder of scalars for the GPU");
}

Extent level_extent(const Extent& finest, unsigned lod) {
  return volumes::ceil_div(finest, std::uint64_t{1} << lod);
}

VolumeInfo level_info(const VolumeInfo& finest, unsigned lod) {
  VolumeInfo info = finest;
  info.extent = level_extent(finest.extent, lod);
  for (double& size : info.voxel_size) size *= static_cast<double>(std::uint64_t{1} << lod);
  if (finest.step_extent().z % (std::uint64_t{1} << lod) != 0) info.time_steps = 1;
  return info;
}

Expected<void> accepts(const Traits& traits, const VolumeInfo& info) {
  if (std::ranges::find(traits.types, info.type) == traits.types.end()) {
    return fail(ErrorCode::kUnsupported, fmt::format("codec {} does not accept voxels of type {}",
                                                     traits.id, name_of(info.type)));
  }
  if (info.kind == VolumeKind::kScalars) return {};
  if (!volumes::is_label_type(info.type)) {
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("labels are of type u8, u16, u32 or u64, found {}", name_of(info.type)));
  }
  if (!traits.lossless)
    return fail(ErrorCode::kUnsupported,
                fmt::format("codec {} is lossy and takes scalars, not labels", traits.id));
  return {};
}

}  // namespace cvr::codecs
