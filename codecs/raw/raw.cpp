// Payload: the voxels, x fastest, in the volume's type. Nothing else.
#include "codecs/raw/raw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "codecs/raw/raw_gpu.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs {

namespace {

using volumes::parallel_for;

class RawDecoder final : public Decoder, public VoxelAccess {
 public:
  explicit RawDecoder(const Stream& stream) : info_(stream.info), voxels_(stream.payload.data()) {}

  Expected<void> decode(unsigned, unsigned threads, SlabSink& sink) const override {
    const std::size_t plane = info_.extent.x * info_.extent.y * size_of(info_.type);
    const std::uint64_t depth = std::max<std::uint64_t>(1, sink.preferred_depth());
    for (std::uint64_t z0 = 0; z0 < info_.extent.z; z0 += depth) {
      const std::uint64_t z1 = std::min(z0 + depth, info_.extent.z);
      std::byte* out = sink.begin(z0, z1);
      parallel_for(threads, z1 - z0, [&](unsigned, std::uint64_t z) {
        std::memcpy(out + z * plane, voxels_ + (z0 + z) * plane, plane);
      });
      sink.end(z0, z1);
    }
    return {};
  }

  const VoxelAccess* voxel_access() const override { return this; }

  Expected<void> at(std::span<const Coordinate> points, unsigned lod,
                    std::span<std::uint64_t> labels) const override {
    if (lod != 0)
      return fail(ErrorCode::kBadArgument,
                  "level of detail: expected 0, raw has only the finest level");
    volumes::with_voxel_type(info_.type, [&]<class T>() {
      for (std::size_t i = 0; i < points.size(); ++i) {
        labels[i] = 0;
        std::memcpy(&labels[i], voxels_ + info_.extent.index(points[i]) * sizeof(T), sizeof(T));
      }
    });
    return {};
  }

  Expected<GpuEncoding> gpu_encoding(std::uint32_t brick, unsigned threads) const override {
    return raw::gpu_encoding(info_, voxels_, brick == 0 ? 32 : brick, threads);
  }
  Expected<GpuSamples> gpu_samples(unsigned) const override {
    return raw::gpu_samples(info_, voxels_);
  }

 private:
  VolumeInfo info_;
  const std::byte* voxels_;
};

/// Room for the envelope, which goes in front of the voxels in the same block: growing it then
/// could copy them.
constexpr std::size_t kEnvelope = 1024;

class RawCodec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{.id = "raw",
                                .version = 1,
                                .family = "general",
                                .summary = "the voxels as they are",
                                .lossless = true,
                                .types = volumes::kVoxelTypes,
                                .access = Granularity::kVoxel,
                                .levels_of_detail = false,
                                .stored_compressed = false,
                                .gpu_decodable = true,
                                .gpu_scalars = true};
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override { return {}; }

  Expected<Payload> encode(const VolumeSource& source, const Parameters&,
                           unsigned threads) const override {
    const VolumeInfo& info = source.info();
    Payload payload{{}, {}, info.bytes()};
    payload.bytes.reserve(info.bytes() + kEnvelope);
    payload.bytes.resize(info.bytes());
    const std::size_t plane = info.extent.x * info.extent.y * size_of(info.type);
    if (const std::byte* voxels = source.data(); voxels != nullptr) {
      parallel_for(threads, info.extent.z, [&](unsigned, std::uint64_t z) {
        std::memcpy(payload.bytes.data() + z * plane, voxels + z * plane, plane);
      });
    } else {
      source.read({{0, 0, 0}, info.extent}, payload.bytes.data());
    }
    payload.breakdown[ByteClass::kData] = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    if (stream.payload.size() != stream.info.bytes()) {
      return fail(ErrorCode::kTruncated, fmt::format("expected {} bytes of voxels, found {}",
                                                     stream.info.bytes(), stream.payload.size()));
    }
    return std::make_unique<RawDecoder>(stream);
  }
};

}  // namespace

const Codec& raw_codec() {
  static const RawCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
