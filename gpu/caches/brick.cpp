// `brick`: one invocation decodes one brick; and what all brick caches share.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "gpu/caches/brick_cache.hpp"
#include "gpu/kernels.hpp"
#include "shaders/caches/brick_control.glsl"

namespace cvr::gpu {

namespace {

constexpr std::uint32_t kThreads = 64;
constexpr std::uint64_t kUnitBytes = 32;

KernelSource management_kernel(const CacheSetting& setting, const std::string& name,
                               const std::string& file) {
  KernelSource source = frame_kernel(name, setting.encoding);
  source.files.push_back(file);
  return source;
}

}  // namespace

volumes::Expected<std::unique_ptr<Cache>> BrickCache::make(const CacheSetting& setting,
                                                           BrickDecoding decoding) {
  std::unique_ptr<BrickCache> cache(new BrickCache(setting, decoding));
  if (setting.grid.voxels() >= std::uint64_t{1} << 28)
    return volumes::fail(volumes::ErrorCode::kUnsupported, "brick cache: at most 2^28 bricks");
  if (setting.cache_bytes / kUnitBytes > UINT32_MAX)
    return volumes::fail(volumes::ErrorCode::kUnsupported,
                         "brick cache: units have 32-bit numbers, so at most 128 GiB");
  const std::uint64_t largest = kUnitBytes << (3 * (setting.encoding.levels - 2));
  if (setting.cache_bytes < largest) {
    return volumes::fail(
        volumes::ErrorCode::kUnsupported,
        fmt::format("brick cache: a brick of {}^3 labels takes {} bytes, the cache has {}",
                    setting.encoding.brick, largest, setting.cache_bytes));
  }
  cache->bricks_ = static_cast<std::uint32_t>(setting.grid.voxels());
  cache->units_ = static_cast<std::uint32_t>(setting.cache_bytes / kUnitBytes);
  if (auto ok = cache->make_buffers(); !ok) return tl::unexpected(ok.error());
  cache->make_kernels();
  return cache;
}

volumes::Expected<void> BrickCache::make_buffers() {
  const struct {
    DeviceBuffer& buffer;
    std::uint64_t bytes;
    const char* use;
    Residency residency = Residency::kDevice;
  } pieces[] = {{cache_, units_ * kUnitBytes, "brick cache"},
                {state_, std::uint64_t{bricks_} * 12, "brick states"},
                {control_, CVR_CONTROL_WORDS * 4, "brick cache control", Residency::kShared},
                {stacks_, std::uint64_t{bricks_} * 4 * setting_.encoding.levels, "free regions"},
                {list_, std::uint64_t{bricks_} * 4, "bricks to decode"},
                {roots_, std::uint64_t{bricks_} * 4, "coarsest labels"}};
  for (const auto& piece : pieces) {
    auto buffer = DeviceBuffer::make(setting_.device, piece.bytes, piece.use, piece.residency);
    if (!buffer) return tl::unexpected(buffer.error());
    piece.buffer = std::move(*buffer);
  }
  return {};
}

void BrickCache::make_kernels() {
  Device& device = setting_.device;
  provision_ = std::make_unique<Kernel>(
      device, setting_.commands,
      management_kernel(setting_, "provision", "shaders/caches/brick_provision.comp"));
  assign_ = std::make_unique<Kernel>(
      device, setting_.commands,
      management_kernel(setting_, "assign", "shaders/caches/brick_assign.comp"));
  KernelSource roots = frame_kernel("roots " + setting_.encoding.decoder, setting_.encoding);
  append_source(roots, setting_.decoder);
  roots.files.emplace_back("shaders/caches/brick_roots.comp");
  find_roots_ = std::make_unique<Kernel>(device, setting_.commands, roots);
  const std::uint32_t width = device.limits().subgroup;
  bricks_a_group_ = decoding_ == BrickDecoding::kSerial ? width : 1;
  const bool together = decoding_ == BrickDecoding::kCooperative && setting_.encoding.together;
  const bool sweeps = together || (decoding_ == BrickDecoding::kSerial && setting_.encoding.serial);
  const std::uint64_t cells = std::uint64_t{1} << (3 * (setting_.encoding.levels - 1));
  const std::uint64_t invocations = decoding_ == BrickDecoding::kSerial ? 1 : width;
  const std::uint64_t turns =
      std::max(1u, device.limits().loop_iterations / 2 / (setting_.encoding.cell_loops + 1));
  cells_a_part_ = static_cast<std::uint32_t>(sweeps ? cells : std::min(cells, turns * invocations));
  KernelSource decode =
      frame_kernel("decode " + setting_.encoding.decoder, setting_.encoding, setting_.instrumented);
  decode.definitions.emplace_back("CVR_DECODE_WIDTH", fmt::format("{}u", width));
  if (decoding_ == BrickDecoding::kSerial) {
    decode.definitions.emplace_back("CVR_DECODE_SERIAL", "1");
    if (setting_.encoding.serial) decode.definitions.emplace_back("CVR_HAS_SERIAL", "1");
  }
  if (together) decode.definitions.emplace_back("CVR_HAS_TOGETHER", "1");
  if (decoding_ == BrickDecoding::kCooperativeShared) {
    decode.definitions.emplace_back("CVR_WORDS_SHARED", "1");
    decode.definitions.emplace_back("CVR_SHARED_WORDS",
                                    fmt::format("{}u", setting_.encoding.shared_words));
    decode.files.emplace_back("shaders/caches/shared_words.glsl");
  }
  append_source(decode, setting_.decoder);
  decode.files.emplace_back("shaders/caches/brick_decode.comp");
  decode_ = std::make_unique<Kernel>(device, setting_.commands, decode);
}

void BrickCache::extend_kernel(KernelSource& source) const {
  source.files.emplace_back("shaders/caches/brick.glsl");
}

void BrickCache::describe(FrameConstants& frame) const {
  frame.cache[0] = cache_.address();
  frame.cache[1] = state_.address();
  frame.cache[2] = control_.address();
  frame.cache[3] = stacks_.address();
  frame.cache[4] = list_.address();
  frame.cache[5] = roots_.address();
  frame.cache_sizes[0] = units_;
  frame.cache_sizes[1] = bricks_;
}

void BrickCache::clear(Commands& commands, bool everything) {
  if (!everything) return;
  commands.fill(state_, 0, state_.bytes(), CVR_NO_LEVEL);
  commands.fill(control_, 0, control_.bytes(), 0);
  relief_ = Relief::kNone;
  if (std::exchange(roots_found_, true)) return;
  commands.dispatch(*find_roots_,
                    std::min((bricks_ + kThreads - 1) / kThreads, setting_.device.limits().groups),
                    {});
}

void BrickCache::record(Commands& commands, std::uint32_t frame) {
  const std::uint32_t groups = (bricks_ + kThreads - 1) / kThreads;
  commands.pass("provision");
  // Workgroups 0 1 1, empty list; when everything is given up also the stacks and the untouched
  // end.
  commands.fill(control_, 0, 4 * CVR_CONTROL_BUMP, 0);
  commands.fill(control_, 4, 8, 1);
  if (relief_ == Relief::kEverything)
    commands.fill(control_, 4 * CVR_CONTROL_BUMP, 4 * (CVR_CONTROL_WORDS - CVR_CONTROL_BUMP), 0);
  const std::uint32_t last = frame == 1 ? CVR_LAST_FRAME : frame - 1;
  commands.dispatch(*provision_, groups, {static_cast<std::uint32_t>(relief_), last, 0, 0});
  commands.pass("assign");
  commands.dispatch(*assign_, groups, {bricks_a_group_, setting_.device.limits().groups, 0, 0});
  commands.pass("decode");
  const std::uint32_t cells = 1u << (3 * (setting_.encoding.levels - 1));
  for (std::uint32_t first = 0; first < cells; first += cells_a_part_)
    commands.dispatch_indirect(*decode_, control_, 4 * CVR_CONTROL_GROUPS,
                               {first, cells_a_part_, 0, 0});
}

CacheReport BrickCache::report() {
  std::array<std::uint32_t, CVR_CONTROL_WORDS> words{};
  control_.read(0, std::as_writable_bytes(std::span(words)));
  CacheReport report{.requested = words[CVR_CONTROL_REQUESTED],
                     .decoded = words[CVR_CONTROL_DECODE],
                     .refused = words[CVR_CONTROL_REFUSED]};
  if (report.refused == 0)
    relief_ = Relief::kNone;
  else
    relief_ = relief_ == Relief::kUnwanted ? Relief::kEverything : Relief::kUnwanted;
  return report;
}

std::vector<MemoryUse> BrickCache::memory() const {
  return {{"cache", cache_.bytes()},
          {"cache tables",
           state_.bytes() + control_.bytes() + stacks_.bytes() + list_.bytes() + roots_.bytes()}};
}

std::string BrickCache::refuses_sweep(const codecs::GpuEncoding& encoding,
                                      const DeviceLimits& limits) {
  if (encoding.brick_loops <= limits.loop_iterations) return "";
  return fmt::format(
      "a brick takes up to {} iterations of loops, the driver ends an invocation's loops after {}",
      encoding.brick_loops, limits.loop_iterations);
}

CacheTraits brick_cache() {
  return {.id = "brick",
          .summary = "whole bricks, each decoded by one invocation, a frame late",
          .sized = true,
          .placeholders = true,
          .refuses = [](const codecs::GpuEncoding& encoding,
                        const DeviceLimits& limits) -> std::string {
            if (!encoding.serial)
              return encoding.voxel_access ? "" : "the codec has no decoder for bricks";
            return BrickCache::refuses_sweep(encoding, limits);
          },
          .make =
              [](const CacheSetting& setting) {
                return BrickCache::make(setting, BrickDecoding::kSerial);
              }};
}

}  // namespace cvr::gpu
