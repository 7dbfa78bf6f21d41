#include "codecs/@NAME@/@NAME@.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "codecs/bytes.hpp"

namespace cvr::codecs {

namespace {

using Length = std::uint32_t;

/// Checked by open(): the runs are not empty and sum to the volume.
class @CLASS@Decoder final : public Decoder {
 public:
  explicit @CLASS@Decoder(const Stream& stream) : info_(stream.info), runs_(stream.payload.data()) {}

  Expected<void> decode(unsigned, unsigned, SlabSink& sink) const override {
    const std::size_t size = size_of(info_.type);
    const std::uint64_t plane = info_.extent.x * info_.extent.y, depth = std::max<std::uint64_t>(1, sink.preferred_depth());
    const std::byte* at = runs_;
    Length left = 0;
    const std::byte* voxel = nullptr;
    for (std::uint64_t z0 = 0; z0 < info_.extent.z; z0 += depth) {
      const std::uint64_t z1 = std::min(z0 + depth, info_.extent.z);
      std::byte* out = sink.begin(z0, z1);
      for (std::uint64_t n = 0; n < plane * (z1 - z0); ++n, --left, out += size) {
        if (left == 0) {
          std::memcpy(&left, at, sizeof left);
          voxel = at + sizeof left;
          at = voxel + size;
        }
        std::memcpy(out, voxel, size);
      }
      sink.end(z0, z1);
    }
    return {};
  }

 private:
  VolumeInfo info_;
  const std::byte* runs_;
};

class @CLASS@Codec final : public Codec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{.id = "@ID@",
                                .version = 1,
                                .family = "@ID@",
                                .summary = "runs of equal voxels",
                                .lossless = true,
                                .types = volumes::kVoxelTypes,
                                .access = Granularity::kVolume,
                                .levels_of_detail = false,
                                .stored_compressed = false};
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override { return {}; }

  /// The same bytes for any number of threads: here, because there is but one.
  Expected<Payload> encode(const VolumeSource& source, const Parameters&, unsigned) const override {
    const VolumeInfo& info = source.info();
    const std::size_t size = size_of(info.type);
    const std::uint64_t plane = info.extent.x * info.extent.y;
    volumes::SlabReader reader(source);
    ByteWriter out;
    std::array<std::byte, 8> voxel{};
    Length length = 0;
    const auto end_run = [&] {
      if (length == 0) return;
      out.put(length);
      out.append(std::span(voxel).first(size));
      length = 0;
    };
    for (std::uint64_t z = 0; z < info.extent.z; ++z) {
      const std::byte* voxels = reader.read(z, z + 1);
      for (std::uint64_t n = 0; n < plane; ++n, voxels += size) {
        if (length == std::numeric_limits<Length>::max() || std::memcmp(voxel.data(), voxels, size) != 0) end_run();
        std::memcpy(voxel.data(), voxels, size);
        ++length;
      }
    }
    end_run();
    Payload payload{out.take(), {}, 0};
    payload.breakdown[ByteClass::kData] = payload.published_bytes = payload.bytes.size();
    return payload;
  }

  Expected<std::unique_ptr<Decoder>> open(const Stream& stream) const override {
    const std::size_t run = sizeof(Length) + size_of(stream.info.type);
    if (stream.payload.size() % run != 0) return fail(ErrorCode::kTruncated, "the last run is cut off");
    std::uint64_t voxels = 0;
    for (std::size_t at = 0; at < stream.payload.size(); at += run) {
      Length length;
      std::memcpy(&length, stream.payload.data() + at, sizeof length);
      if (length == 0) return fail(ErrorCode::kMalformed, "a run without voxels");
      voxels += length;
    }
    if (voxels != stream.info.extent.voxels()) return fail(ErrorCode::kMalformed, "the runs do not sum to the volume");
    return std::make_unique<@CLASS@Decoder>(stream);
  }
};

}  // namespace

const Codec& @NAME@_codec() {
  static const @CLASS@Codec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
