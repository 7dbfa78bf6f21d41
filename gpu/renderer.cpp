#include "gpu/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "gpu/caches/cache.hpp"
#include "gpu/frame.hpp"
#include "gpu/kernels.hpp"
#include "gpu/rays.hpp"
#include "shaders/caches/brick_control.glsl"

namespace cvr::gpu {

namespace {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

constexpr std::uint64_t kLargestExtent = std::uint64_t{1} << 15;  ///< see shaders/render/ray.glsl
constexpr std::uint32_t kTile = 8;
constexpr unsigned kPatience =
    6;  ///< frames without progress before a smaller part of the image is tried

constexpr std::array<const char*, CVR_COUNTERS> kCounterNames{"rays",
                                                              "bricks_entered",
                                                              "cells_read",
                                                              "cells_decoded",
                                                              "chain_hops",
                                                              "words_touched",
                                                              "cache_hits",
                                                              "cache_misses",
                                                              "cache_ejections",
                                                              "cache_losses",
                                                              "wrong_labels",
                                                              "empty_space_skips",
                                                              "empty_space_marks",
                                                              "bricks_requested",
                                                              "bricks_decoded",
                                                              "placeholder_cells"};

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace

struct Renderer::Impl {
  Impl(Device& d, const codecs::GpuEncoding& e, const volumes::VolumeInfo& i,
       const RenderOptions& o)
      : device(d),
        info(i),
        options(o),
        encoding(e),
        remap(e.remap.begin(), e.remap.end()),
        grid(volumes::ceil_div(i.extent, e.brick)),
        commands(d, sizeof(FrameConstants)) {
    encoding.remap = remap;
  }

  Expected<void> upload();
  Expected<void> make_kernels();
  Expected<void> write_materials(const Scene& scene);
  void write_levels(const Camera& camera);
  void describe_camera(const Camera& camera);
  FrameResult draw();
  void warm_up();
  bool settle_part(std::uint32_t& frames, std::uint32_t& incomplete);

  Device& device;
  volumes::VolumeInfo info;
  RenderOptions options;
  codecs::GpuEncoding encoding;  ///< without the buffers' bytes once they are uploaded
  std::vector<std::uint64_t> remap;
  volumes::Extent grid;
  Commands commands;
  Allocations allocations{device};
  DeviceBuffer bricks, materials, colours, labels, counters, suspended, status;
  bool hashed = false, warm = false;
  std::unique_ptr<Cache> cache;
  std::unique_ptr<Kernel> visibility, march;
  FrameConstants frame{};
  Scene scene;
  std::vector<std::uint32_t> visible;  ///< of each brick
  std::vector<std::uint32_t> levels;   ///< of each brick, as `bricks` holds them
  std::vector<std::pair<std::string, double>> start;
};

Expected<void> Renderer::Impl::upload() {
  if (auto done = allocations.upload(encoding.buffers, frame.encoding); !done) return done;
  const std::uint64_t pixels = std::uint64_t{options.width} * options.height;
  const struct {
    DeviceBuffer& buffer;
    std::uint64_t bytes;
    const char* use;
    uint64_t& address;
    Residency residency = Residency::kDevice;
  } pieces[] = {
      {bricks, grid.voxels() * 4, "bricks", frame.bricks, Residency::kShared},
      {colours, pixels * 16, "image", frame.colours},
      {labels, pixels * 8, "label image", frame.labels},
      {counters, CVR_COUNTERS * 8, "counters", frame.counters},
      {suspended, device.limits().loop_iterations < UINT32_MAX ? pixels * CVR_PIXEL_STATE_BYTES : 0,
       "suspended rays", frame.suspended},
      {status, CVR_STATUS_WORDS * 4, "status", frame.status, Residency::kShared}};
  for (const auto& piece : pieces) {
    if (auto done = allocations.make(piece.buffer, piece.bytes, piece.use, piece.residency); !done)
      return done;
    piece.address = piece.buffer.address();
  }
  const std::vector<std::byte> zeros(std::max<std::size_t>(pixels * 16, 1));
  colours.write(0, std::span(zeros).first(pixels * 16));
  const std::array<std::byte, CVR_COUNTERS * 8> none{};
  counters.write(0, none);
  return {};
}

Expected<void> Renderer::Impl::make_kernels() {
  const std::uint64_t count = encoding.codes.size();
  const std::uint64_t direct =
      encoding.codes.empty() ? 1 : std::uint64_t{encoding.codes.back()} + 1;
  hashed = direct > std::max<std::uint64_t>(std::uint64_t{1} << 20, 8 * count);
  const CacheTraits* traits = find_cache(options.access);
  const CacheSetting setting{device,
                             commands,
                             encoding,
                             info,
                             grid,
                             options.cache_bytes,
                             decoder_source(device, encoding),
                             options.instrumented};
  auto made = traits->make(setting);
  if (!made) return tl::unexpected(made.error());
  cache = std::move(*made);
  cache->describe(frame);
  KernelSource visible_source = frame_kernel("visibility", encoding);
  if (hashed) visible_source.definitions.emplace_back("CVR_MATERIALS_HASHED", "1");
  append_source(visible_source, setting.decoder);
  visible_source.files.emplace_back("shaders/render/visibility.comp");
  visibility = std::make_unique<Kernel>(device, commands, visible_source);
  KernelSource source = frame_kernel(
      fmt::format("march {} {} {}", encoding.decoder, options.access, name_of(options.shading)),
      encoding, options.instrumented);
  if (hashed) source.definitions.emplace_back("CVR_MATERIALS_HASHED", "1");
  if (device.limits().loop_iterations < UINT32_MAX)
    source.definitions.emplace_back("CVR_LOOP_LIMIT",
                                    fmt::format("{}u", device.limits().loop_iterations));
  source.definitions.emplace_back("CVR_CELL_LOOPS", fmt::format("{}u", encoding.cell_loops));
  source.definitions.emplace_back("CVR_SHADING", std::to_string(static_cast<int>(options.shading)));
  cache->extend_kernel(source);
  source.files.emplace_back("shaders/render/march.comp");
  march = std::make_unique<Kernel>(device, commands, source);
  return {};
}

Expected<std::unique_ptr<Renderer>> Renderer::make(Device& device,
                                                   const codecs::GpuEncoding& encoding,
                                                   const volumes::VolumeInfo& info,
                                                   const RenderOptions& options) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  const CacheTraits* traits = find_cache(options.access);
  if (traits->sized && options.cache_bytes < kLeastCacheBytes)
    return fail(ErrorCode::kBadArgument,
                fmt::format("cache: expected at least 1 MiB, found {} bytes", options.cache_bytes));
  if (std::max({info.extent.x, info.extent.y, info.extent.z}) > kLargestExtent)
    return fail(ErrorCode::kUnsupported,
                fmt::format("volume {}: rays reach {} voxels along an axis at most",
                            to_string(info.extent), kLargestExtent));
  if (const std::string reason = traits->refuses(encoding, device.limits()); !reason.empty())
    return fail(ErrorCode::kUnsupported, fmt::format("{}: {}", options.access, reason));
  auto impl = std::make_unique<Impl>(device, encoding, info, options);
  const std::uint32_t tiles =
      (options.width + kTile - 1) / kTile * ((options.height + kTile - 1) / kTile);
  if (tiles > device.limits().groups)
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("image {}x{}: its {} tiles exceed the device's maxComputeWorkGroupCount of {}",
                    options.width, options.height, tiles, device.limits().groups));
  const double before = seconds_now();
  if (auto ok = impl->upload(); !ok) return tl::unexpected(ok.error());
  const double uploaded = seconds_now();
  if (auto ok = impl->make_kernels(); !ok) return tl::unexpected(ok.error());
  impl->start = {{"upload", uploaded - before}, {"kernels", seconds_now() - uploaded}};
  return std::unique_ptr<Renderer>(new Renderer(std::move(impl)));
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::~Renderer() = default;

Expected<void> Renderer::Impl::write_materials(const Scene& now_shown) {
  const auto rgba_of = [&](std::uint32_t code) {
    const Rgba m = now_shown.material(remap.empty() ? code : remap[code]);
    return std::uint32_t{m.r} | std::uint32_t{m.g} << 8 | std::uint32_t{m.b} << 16 |
           std::uint32_t{m.a} << 24;
  };
  const auto keep = [&](std::span<const std::byte> table) -> Expected<void> {
    if (materials.bytes() < table.size() || frame.materials == 0) {
      if (auto done = allocations.make(materials, table.size(), "materials"); !done) return done;
      frame.materials = materials.address();
    }
    materials.write(0, table);
    return {};
  };
  if (!hashed) {
    std::vector<std::uint32_t> table(
        encoding.codes.empty() ? 1 : std::size_t{encoding.codes.back()} + 1);
    for (const std::uint32_t code : encoding.codes) table[code] = rgba_of(code);
    frame.material_slots = static_cast<std::uint32_t>(table.size());
    return keep(bytes_of(table));
  }
  const std::uint64_t slots = std::bit_ceil(2 * std::uint64_t{encoding.codes.size()} + 2);
  std::vector<std::uint64_t> table(slots);
  for (const std::uint32_t code : encoding.codes) {
    const std::uint32_t rgba = rgba_of(code);
    if (rgba >> 24 == 0) continue;
    std::uint64_t slot = (code * 0x9e3779b1u) & (slots - 1);
    while (table[slot] >> 32 != 0) slot = (slot + 1) & (slots - 1);
    table[slot] = std::uint64_t{rgba} << 32 | code;
  }
  frame.material_slots = static_cast<std::uint32_t>(slots - 1);
  return keep(bytes_of(table));
}

Expected<std::vector<PassTime>> Renderer::set_scene(const Scene& scene) {
  Impl& my = *impl_;
  my.scene = scene;
  FrameConstants& f = my.frame;
  if (auto ok = my.write_materials(scene); !ok) return tl::unexpected(ok.error());
  const Vector3 scale = world_scale(my.info);
  const double length = std::hypot(scene.light[0], scene.light[1], scene.light[2]);
  Vector3 light_voxel{};
  for (int b = 0; b < 3; ++b) {
    f.extent[b] = static_cast<std::uint32_t>((&my.info.extent.x)[b]);
    f.grid[b] = static_cast<std::uint32_t>((&my.grid.x)[b]);
    f.light_world[b] = static_cast<float>(scene.light[b] / length);
    light_voxel[b] = scene.light[b] / length / scale[b];
    f.background[b] = static_cast<float>(scene.background[b]) / 255.0f;
    f.inverse_scale[b] = static_cast<float>(1 / scale[b]);
  }
  const auto light = integer_direction(light_voxel);
  std::ranges::copy(light, f.light);
  f.width = my.options.width;
  f.height = my.options.height;
  f.ambient = static_cast<float>(scene.ambient);
  f.ao_distance = static_cast<float>(scene.ao_distance * world_size(my.info));
  f.ao_roulette = scene.ao_roulette ? 1 : 0;
  my.visible.assign(my.grid.voxels(), 0);
  my.commands.begin(std::as_bytes(std::span(&f, 1)));
  my.commands.pass("clear");
  my.cache->clear(my.commands, true);
  my.commands.pass("visibility");
  my.commands.fill(my.bricks, 0, my.bricks.bytes(), 0);
  const std::uint64_t groups = std::min<std::uint64_t>(
      (my.grid.voxels() * my.encoding.brick + 63) / 64, my.device.limits().groups);
  my.commands.dispatch(*my.visibility, static_cast<std::uint32_t>(groups));
  auto times = my.commands.submit();
  my.bricks.read(0, std::as_writable_bytes(std::span(my.visible)));
  if (!my.warm) my.warm_up();
  return times;
}

bool Renderer::keeps_voxels() const { return find_cache(impl_->options.access)->sized; }

void Renderer::clear_cache() {
  Impl& my = *impl_;
  my.commands.begin(std::as_bytes(std::span(&my.frame, 1)));
  my.commands.pass("clear");
  my.cache->clear(my.commands, true);
  my.commands.submit();
}

void Renderer::Impl::write_levels(const Camera& camera) {
  const Vector3 scale = world_scale(info);
  const Vector3 eye = world_from_scene(info, camera.eye);
  const double half_view = camera.vertical_fov_degrees * std::numbers::pi / 360;
  const double pixel = 2 * std::tan(half_view) / options.height * std::exp2(scene.lod_bias);
  std::array<double, 8> from{};  // distance of a brick's centre from which on level n is taken
  for (unsigned n = 1; n < encoding.levels; ++n) from[n] = std::exp2(n) / pixel - encoding.brick;
  levels.resize(visible.size());
  std::size_t at = 0;
  for (std::uint64_t z = 0; z < grid.z; ++z) {
    const double dz = (static_cast<double>(z) + 0.5) * encoding.brick * scale[2] - eye[2];
    for (std::uint64_t y = 0; y < grid.y; ++y) {
      const double dy = (static_cast<double>(y) + 0.5) * encoding.brick * scale[1] - eye[1];
      for (std::uint64_t x = 0; x < grid.x; ++x, ++at) {
        if (visible[at] == 0) {
          levels[at] = CVR_EMPTY_BRICK;
          continue;
        }
        const double dx = (static_cast<double>(x) + 0.5) * encoding.brick * scale[0] - eye[0];
        const double distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        unsigned lod = 0;
        while (lod + 1 < encoding.levels && distance >= from[lod + 1]) ++lod;
        levels[at] = lod;
      }
    }
  }
  bricks.write(0, bytes_of(levels));
}

void Renderer::Impl::describe_camera(const Camera& camera) {
  const IntegerCamera rays = integer_camera(info, camera, options.width, options.height);
  std::ranges::copy(rays.eye, frame.eye);
  std::ranges::copy(rays.towards, frame.towards);
  std::ranges::copy(rays.right, frame.right);
  std::ranges::copy(rays.down, frame.down);
}

FrameResult Renderer::Impl::draw() {
  FrameResult result;
  frame.frame = frame.frame % CVR_LAST_FRAME + 1;
  commands.begin(std::as_bytes(std::span(&frame, 1)));
  commands.fill(status, 0, status.bytes(), 0);
  cache->record(commands, frame.frame);
  commands.pass("render");
  const std::uint32_t tiles =
      (options.width + kTile - 1) / kTile * ((options.height + kTile - 1) / kTile);
  commands.dispatch(*march, tiles);
  result.passes = commands.submit();
  std::array<std::uint32_t, CVR_STATUS_WORDS> words{};
  status.read(0, std::as_writable_bytes(std::span(words)));
  result.incomplete = words[CVR_STATUS_INCOMPLETE];
  frame.resume = 1;
  while (words[CVR_STATUS_SUSPENDED] > 0) {  // the driver bounds loops: the same pass goes on
    commands.begin(std::as_bytes(std::span(&frame, 1)));
    commands.fill(status, 0, status.bytes(), 0);
    commands.pass("render");
    commands.dispatch(*march, tiles);
    result.passes.back().seconds += commands.submit().back().seconds;
    status.read(0, std::as_writable_bytes(std::span(words)));
    result.incomplete += words[CVR_STATUS_INCOMPLETE];
    ++result.resumed;
  }
  frame.resume = 0;
  for (const PassTime& pass : result.passes) result.gpu_seconds += pass.seconds;
  result.cache = cache->report();
  return result;
}

/// Drivers may translate a kernel at its first dispatch: a frame without pixels keeps that out of
/// the first frame's time.
void Renderer::Impl::warm_up() {
  const double before = seconds_now();
  frame.focus_mask = 0;
  frame.focus_value = 1;
  draw();
  warm = true;
  start.emplace_back("first dispatch", seconds_now() - before);
}

FrameResult Renderer::render(const Camera& camera, bool restart) {
  Impl& my = *impl_;
  const double start = seconds_now();
  my.write_levels(camera);
  my.describe_camera(camera);
  my.frame.restart = restart ? 1 : 0;
  my.frame.samples = UINT32_MAX;
  my.frame.focus_mask = my.frame.focus_value = 0;
  FrameResult result = my.draw();
  result.host_seconds = seconds_now() - start;
  return result;
}

/// Draws the pixels that are not done until none is left, or as long as there is progress; false if
/// there is none.
bool Renderer::Impl::settle_part(std::uint32_t& frames, std::uint32_t& incomplete) {
  std::uint32_t least = UINT32_MAX;
  for (unsigned waited = 0; waited < kPatience; ++waited) {
    const FrameResult result = draw();
    frame.restart = 0;
    ++frames;
    incomplete = result.incomplete;
    if (incomplete == 0) return true;
    // A ray sees as far as its bricks are there: new ones without a refusal are progress too.
    const bool grows = result.cache.decoded > 0 && result.cache.refused == 0;
    if (incomplete < least || grows) {
      least = std::min(least, incomplete);
      waited = 0;
    }
  }
  return false;
}

Settled Renderer::settle(const Camera& camera, std::uint32_t samples) {
  Impl& my = *impl_;
  my.write_levels(camera);
  my.describe_camera(camera);
  my.frame.restart = 1;
  Settled settled;
  const std::uint32_t tiles =
      (my.options.width + kTile - 1) / kTile * ((my.options.height + kTile - 1) / kTile);
  for (std::uint32_t sample = 1; sample <= samples; ++sample) {
    my.frame.samples = sample;
    std::uint32_t mask = 0;
    my.frame.focus_mask = my.frame.focus_value = 0;
    while (!my.settle_part(settled.frames, settled.incomplete)) {
      if (mask >= tiles) return settled;
      mask = 2 * mask + 1;
      for (std::uint32_t part = 0; part <= mask; ++part) {
        my.frame.focus_mask = mask;
        my.frame.focus_value = part;
        std::uint32_t left = 0;
        my.settle_part(settled.frames, left);
      }
      my.frame.focus_mask = my.frame.focus_value = 0;
    }
  }
  settled.complete = true;
  return settled;
}

Image Renderer::read_image() const {
  const Impl& my = *impl_;
  Image image;
  image.width = my.options.width;
  image.height = my.options.height;
  std::vector<float> sums(image.pixels() * 4);
  std::vector<std::uint64_t> codes(image.pixels());
  my.colours.read(0, std::as_writable_bytes(std::span(sums)));
  my.labels.read(0, std::as_writable_bytes(std::span(codes)));
  image.colour.resize(image.pixels() * 3);
  image.labels.resize(image.pixels());
  image.complete.resize(image.pixels());
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    const float count = std::max(sums[4 * i + 3], 1.0f);
    for (std::size_t c = 0; c < 3; ++c) image.colour[3 * i + c] = sums[4 * i + c] / count;
    image.complete[i] = sums[4 * i + 3] > 0 ? 1 : 0;
    image.labels[i] = codes[i] == UINT64_MAX ? kNoLabel
                      : my.remap.empty()     ? codes[i]
                                             : my.remap[codes[i]];
  }
  return image;
}

Counters Renderer::read_counters() const {
  std::array<std::uint64_t, CVR_COUNTERS> values{};
  impl_->counters.read(0, std::as_writable_bytes(std::span(values)));
  Counters counters;
  for (std::size_t i = 0; i < values.size(); ++i)
    counters.emplace_back(kCounterNames[i], values[i]);
  return counters;
}

void Renderer::clear_counters() {
  const std::array<std::byte, CVR_COUNTERS * 8> none{};
  impl_->counters.write(0, none);
}

std::vector<MemoryUse> Renderer::memory() const {
  std::vector<MemoryUse> uses = impl_->allocations.uses();
  for (const MemoryUse& use : impl_->cache->memory()) uses.push_back(use);
  return uses;
}

std::vector<std::pair<std::string, double>> Renderer::start_parts() const { return impl_->start; }

}  // namespace cvr::gpu
