#include "gpu/decode_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "gpu/allocations.hpp"
#include "gpu/frame.hpp"
#include "gpu/kernels.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::gpu {

namespace {

constexpr std::uint32_t kCellsWidth = 64;

volumes::Extent level_extent(const volumes::Extent& finest, unsigned lod) {
  return volumes::ceil_div(finest, std::uint64_t{1} << lod);
}

}  // namespace

struct DecodeProbe::Impl {
  Impl(Device& d, const codecs::GpuEncoding& e, const volumes::VolumeInfo& i)
      : device(d),
        encoding(e),
        info(i),
        remap(e.remap.begin(), e.remap.end()),
        commands(d, sizeof(FrameConstants)) {}

  Kernel& kernel(DecodePath path);
  std::uint32_t width(DecodePath path) const {
    return path == DecodePath::kShared ? device.limits().subgroup : kCellsWidth;
  }

  Device& device;
  codecs::GpuEncoding encoding;
  volumes::VolumeInfo info;
  std::vector<std::uint64_t> remap;
  Commands commands;
  Allocations allocations{device};
  FrameConstants frame{};
  std::map<DecodePath, std::unique_ptr<Kernel>> kernels;
};

Kernel& DecodeProbe::Impl::kernel(DecodePath path) {
  std::unique_ptr<Kernel>& slot = kernels[path];
  if (slot) return *slot;
  KernelSource source = frame_kernel("probe " + encoding.decoder, encoding);
  source.definitions.emplace_back("CVR_PROBE_WIDTH", fmt::format("{}u", width(path)));
  if (path == DecodePath::kBricks) source.definitions.emplace_back("CVR_PROBE_BRICKS", "1");
  if (path == DecodePath::kShared) {
    source.definitions.emplace_back("CVR_WORDS_SHARED", "1");
    source.definitions.emplace_back("CVR_SHARED_WORDS", fmt::format("{}u", encoding.shared_words));
    source.files.emplace_back("shaders/caches/shared_words.glsl");
  }
  append_source(source, decoder_source(device, encoding));
  source.files.emplace_back("shaders/render/probe.comp");
  slot = std::make_unique<Kernel>(device, commands, source);
  return *slot;
}

volumes::Expected<std::unique_ptr<DecodeProbe>> DecodeProbe::make(
    Device& device, const codecs::GpuEncoding& encoding, const volumes::VolumeInfo& info) {
  auto impl = std::make_unique<Impl>(device, encoding, info);
  if (auto done = impl->allocations.upload(impl->encoding.buffers, impl->frame.encoding); !done)
    return tl::unexpected(done.error());
  const volumes::Extent grid = volumes::ceil_div(info.extent, encoding.brick);
  for (int b = 0; b < 3; ++b) {
    impl->frame.extent[b] = static_cast<std::uint32_t>((&info.extent.x)[b]);
    impl->frame.grid[b] = static_cast<std::uint32_t>((&grid.x)[b]);
  }
  return std::unique_ptr<DecodeProbe>(new DecodeProbe(std::move(impl)));
}

DecodeProbe::DecodeProbe(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DecodeProbe::~DecodeProbe() = default;

std::string DecodeProbe::refuses(DecodePath path) const {
  const codecs::GpuEncoding& e = impl_->encoding;
  const DeviceLimits& limits = impl_->device.limits();
  if (path == DecodePath::kBricks) {
    if (!e.serial) return "no serial decoder";
    return e.brick_loops > limits.loop_iterations
               ? "more loop iterations a brick than the driver runs"
               : "";
  }
  if (!e.voxel_access) return "no access to single voxels";
  if (path == DecodePath::kCells) return "";
  return e.shared_words == 0                         ? "nothing to copy"
         : e.shared_words * 4 > limits.shared_memory ? "too large for shared memory"
                                                     : "";
}

volumes::Expected<std::vector<std::uint64_t>> DecodeProbe::decode(DecodePath path, unsigned lod) {
  Impl& my = *impl_;
  const volumes::Extent level = level_extent(my.info.extent, lod);
  const volumes::Extent grid = volumes::ceil_div(my.info.extent, my.encoding.brick);
  const std::uint32_t brick_cells = 1u << (3 * (my.encoding.levels - 1 - lod));
  const bool by_brick = path != DecodePath::kCells;
  const std::uint64_t count = by_brick ? grid.voxels() * brick_cells : level.voxels();
  auto out = DeviceBuffer::make(my.device, count * 4, "decoded level");
  if (!out) return tl::unexpected(out.error());
  my.frame.labels = out->address();
  const std::uint64_t invocations = path == DecodePath::kBricks ? grid.voxels() : level.voxels();
  const std::uint64_t groups =
      path == DecodePath::kShared ? grid.voxels() : (invocations + kCellsWidth - 1) / kCellsWidth;
  if (groups > my.device.limits().groups)
    return volumes::fail(
        volumes::ErrorCode::kUnsupported,
        "the level needs more workgroups than the device's maxComputeWorkGroupCount");
  my.commands.begin(std::as_bytes(std::span(&my.frame, 1)));
  my.commands.pass("decode");
  const std::uint32_t turns =
      std::max(1u, my.device.limits().loop_iterations / 2 / (my.encoding.cell_loops + 1));
  const std::uint32_t part = path == DecodePath::kShared
                                 ? static_cast<std::uint32_t>(std::min<std::uint64_t>(
                                       brick_cells, std::uint64_t{turns} * my.width(path)))
                                 : brick_cells;
  for (std::uint32_t first = 0; first < brick_cells; first += part)
    my.commands.dispatch(my.kernel(path), static_cast<std::uint32_t>(groups),
                         {lod, first, part, 0});
  my.commands.submit();

  std::vector<std::uint32_t> codes(count);
  out->read(0, std::as_writable_bytes(std::span(codes)));
  std::vector<std::uint64_t> labels(level.voxels());
  const unsigned shift = my.encoding.levels - 1 - lod;
  const std::uint64_t inside = (std::uint64_t{1} << shift) - 1;
  for (std::uint64_t i = 0; i < labels.size(); ++i) {
    std::uint64_t at = i;
    if (by_brick) {
      const std::uint64_t x = i % level.x, y = i / level.x % level.y, z = i / level.x / level.y;
      const std::uint64_t brick = grid.index({x >> shift, y >> shift, z >> shift});
      const auto part_of = [&](std::uint64_t c) { return static_cast<std::uint32_t>(c & inside); };
      at = brick * brick_cells + shaders::cvr_morton_encode(part_of(x), part_of(y), part_of(z));
    }
    labels[i] = my.remap.empty() ? codes[at] : my.remap.at(codes[at]);
  }
  return labels;
}

}  // namespace cvr::gpu
