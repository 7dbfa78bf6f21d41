#include "codecs/codec.hpp"

namespace cvr::codecs {

std::string_view name_of(Granularity granularity) {
  switch (granularity) {
    case Granularity::kVolume: return "volume";
    case Granularity::kBrick: return "brick";
    case Granularity::kBlock: return "block";
    case Granularity::kVoxel: return "voxel";
  }
  return "?";
}

std::string_view name_of(ByteClass byte_class) {
  static constexpr std::array<std::string_view, kByteClasses> kNames{
      "header", "index", "operations", "stop_bits", "rank", "palette", "tables", "data", "padding"};
  return kNames[static_cast<std::size_t>(byte_class)];
}

Expected<GpuEncoding> Decoder::gpu_encoding(std::uint32_t, unsigned) const {
  return fail(ErrorCode::kUnsupported, "this codec has no decoder for the GPU");
}

Extent level_extent(const Extent& finest, unsigned lod) { return volumes::ceil_div(finest, std::uint64_t{1} << lod); }

VolumeInfo level_info(const VolumeInfo& finest, unsigned lod) {
  VolumeInfo info = finest;
  info.extent = level_extent(finest.extent, lod);
  for (double& size : info.voxel_size) size *= static_cast<double>(std::uint64_t{1} << lod);
  return info;
}

}  // namespace cvr::codecs
