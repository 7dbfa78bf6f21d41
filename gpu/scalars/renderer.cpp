#include "gpu/scalars/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gpu/caches/cache.hpp"
#include "gpu/reference/vector.hpp"
#include "gpu/scalars/frame.hpp"
#include "gpu/scalars/groups.hpp"

namespace cvr::gpu {

namespace {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

/// Loops of one sample: eight corners and 4^3 neighbours (shaders/scalars/composite.comp).
constexpr std::uint32_t kSampleLoops = 1 + 8 + 64;

/// A vector in slice space.
Vector3 permuted(const Vector3& v, std::size_t axis) {
  return {v[axis == 0 ? 1 : 0], v[axis == 2 ? 1 : 2], v[axis]};
}

void store(const Vector3& v, float (&out)[3]) {
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

/// What all kernels of scalars begin with.
KernelSource decoder_source(const codecs::GpuSamples& samples) {
  KernelSource source;
  source.definitions = {{"CVR_TRANSFER_ENTRIES", std::to_string(kTransferEntries)},
                        {"CVR_GROUP", std::to_string(kScalarGroup)}};
  for (const auto& [name, value] : samples.constants)
    source.definitions.emplace_back(name, std::to_string(value));
  source.files = {"shaders/scalars/frame.glsl",
                  fmt::format("shaders/scalars/{}.glsl", samples.decoder)};
  return source;
}

}  // namespace

struct ScalarRenderer::Impl {
  Impl(Device& d, const codecs::GpuSamples& s, const volumes::VolumeInfo& i, const ValueRange& r,
       const RenderOptions& o)
      : device(d), info(i), range(r), options(o), commands(d, sizeof(ScalarFrame)), samples(s) {}

  Expected<void> make_access();
  Expected<void> make_image();
  void make_kernel();
  void describe_camera(const Camera& camera);
  void composite_slabs(std::uint32_t first, std::uint32_t last, bool begins, bool ends);
  void draw_slabs(std::uint32_t first, std::uint32_t last);
  std::uint64_t pixels() const { return std::uint64_t{options.width} * options.height; }

  Device& device;
  volumes::VolumeInfo info;
  ValueRange range;
  RenderOptions options;
  Commands commands;
  codecs::GpuSamples samples;  ///< without the buffers' bytes once they are uploaded
  Allocations allocations{device};
  DeviceBuffer colours, transfer;
  std::unique_ptr<SampleAccess> access;
  std::unique_ptr<Kernel> composite;
  ScalarFrame frame{};
  Scene scene;
  std::uint64_t decoded = 0;
  std::vector<std::pair<std::string, double>> start;
};

Expected<void> ScalarRenderer::Impl::make_access() {
  auto made = find_cache(options.access)
                  ->make_samples({.device = device,
                                  .commands = commands,
                                  .allocations = allocations,
                                  .info = info,
                                  .cache_bytes = options.cache_bytes,
                                  .decoder = decoder_source(samples)});
  if (!made) return tl::unexpected(made.error());
  access = std::move(*made);
  access->describe(frame);
  return {};
}

Expected<void> ScalarRenderer::Impl::make_image() {
  const struct {
    DeviceBuffer& buffer;
    std::uint64_t bytes;
    const char* use;
    std::uint64_t& address;
  } pieces[] = {{colours, pixels() * 16, "image", frame.colours},
                {transfer, kTransferEntries * 16, "transfer function", frame.transfer}};
  for (const auto& piece : pieces) {
    if (auto done = allocations.make(piece.buffer, piece.bytes, piece.use); !done) return done;
    piece.address = piece.buffer.address();
  }
  const volumes::Extent& e = info.extent;
  if (scalar_groups(std::max({e.x * e.y, e.x * e.z, e.y * e.z})) > device.limits().groups ||
      scalar_groups(pixels()) > device.limits().groups)
    return fail(
        ErrorCode::kUnsupported,
        "a slice or the image needs more workgroups than the device's maxComputeWorkGroupCount");
  return {};
}

void ScalarRenderer::Impl::make_kernel() {
  KernelSource source = decoder_source(samples);
  source.name = fmt::format("composite {} {}", samples.decoder, options.access);
  access->extend_kernel(source);
  source.files.emplace_back("shaders/scalars/composite.comp");
  composite = std::make_unique<Kernel>(device, commands, source);
}

void ScalarRenderer::Impl::describe_camera(const Camera& camera) {
  const SliceOrder order = slice_order(info, camera);
  const Vector3 scale = world_scale(info);
  const Vector3 forward = normalize(camera.target - camera.eye);
  const Vector3 right = normalize(cross(forward, camera.up));
  const Vector3 up = cross(right, forward);
  const double half = std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
  const auto axis = order.axis;
  // Voxel centres lie at integers.
  store(permuted(world_from_scene(info, camera.eye) / scale - Vector3{0.5, 0.5, 0.5}, axis),
        frame.eye);
  store(permuted(forward / scale, axis), frame.towards);
  store(permuted((half / options.height) * right / scale, axis), frame.right);
  store(permuted((-half / options.height) * up / scale, axis), frame.down);
  store(permuted(scale, axis), frame.scale);
  store(permuted(normalize(scene.light), axis), frame.light);
  const Vector3 extent{static_cast<double>(info.extent.x), static_cast<double>(info.extent.y),
                       static_cast<double>(info.extent.z)};
  const Vector3 slices = permuted(extent, axis);
  for (std::size_t i = 0; i < 3; ++i) {
    frame.extent[i] = static_cast<std::uint32_t>(extent[i]);
    frame.slices[i] = static_cast<std::uint32_t>(slices[i]);
  }
  frame.axis = static_cast<std::uint32_t>(axis);
  frame.backwards = order.backwards ? 1 : 0;
}

/// Slabs [first, last) of the frame, whose slices are available.
void ScalarRenderer::Impl::composite_slabs(std::uint32_t first, std::uint32_t last, bool begins,
                                           bool ends) {
  const std::uint32_t at_a_time =
      std::max(1u, device.limits().loop_iterations / 2 / (kSampleLoops * frame.samples));
  for (std::uint32_t from = first; from < last; from += std::min(at_a_time, last - from)) {
    const std::uint32_t to = from + std::min(at_a_time, last - from);
    commands.dispatch(*composite, scalar_groups(pixels()),
                      {from, to, begins && from == first ? 1u : 0u, ends && to == last ? 1u : 0u});
  }
}

void ScalarRenderer::Impl::draw_slabs(std::uint32_t first, std::uint32_t last) {
  const std::uint32_t batch = access->slabs_at_a_time(frame);
  std::uint32_t have = first > 0 ? first - 1 : 0;
  for (std::uint32_t slab = first; slab < last; slab += std::min(batch, last - slab)) {
    const std::uint32_t next = slab + std::min(batch, last - slab);
    const std::uint32_t need = std::min(next + 2, frame.slices[2]);
    decoded += access->record(commands, frame, have, need);
    have = need;
    composite_slabs(slab, next, slab == first, next == last);
  }
}

Expected<std::unique_ptr<ScalarRenderer>> ScalarRenderer::make(Device& device,
                                                               const codecs::GpuSamples& samples,
                                                               const volumes::VolumeInfo& info,
                                                               const ValueRange& range,
                                                               const RenderOptions& options) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  if (!find_cache(options.access)->scalars)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{} serves label volumes alone", options.access));
  auto impl = std::make_unique<Impl>(device, samples, info, range, options);
  const double begin = seconds_now();
  if (auto done = impl->allocations.upload(impl->samples.buffers, impl->frame.encoding); !done)
    return tl::unexpected(done.error());
  const double uploaded = seconds_now();
  if (auto done = impl->make_access(); !done) return tl::unexpected(done.error());
  if (auto done = impl->make_image(); !done) return tl::unexpected(done.error());
  impl->make_kernel();
  impl->start = {{"upload", uploaded - begin}, {"kernels", seconds_now() - uploaded}};
  return std::unique_ptr<ScalarRenderer>(new ScalarRenderer(std::move(impl)));
}

ScalarRenderer::ScalarRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ScalarRenderer::~ScalarRenderer() = default;

Expected<std::vector<PassTime>> ScalarRenderer::set_scene(const Scene& scene) {
  Impl& my = *impl_;
  my.scene = scene;
  std::vector<float> entries;
  for (const TransferEntry& entry : transfer_table(scene.transfer))
    for (const double channel : entry) entries.push_back(static_cast<float>(channel));
  my.transfer.write(0, std::as_bytes(std::span(entries)));
  my.frame.value_at = static_cast<float>(my.range.least);
  const double width = my.range.largest - my.range.least;
  my.frame.value_step = width > 0 ? static_cast<float>((kTransferEntries - 1) / width) : 0;
  my.frame.knee = static_cast<float>(kShadingKnee * width);
  my.frame.samples = scene.slice_samples;
  my.frame.ambient = static_cast<float>(scene.ambient);
  for (std::size_t i = 0; i < 3; ++i)
    my.frame.background[i] = static_cast<float>(scene.background[i]) / 255;
  my.frame.width = my.options.width;
  my.frame.height = my.options.height;
  return std::vector<PassTime>{};
}

FrameResult ScalarRenderer::render(const Camera& camera, bool) {
  return render_slabs(camera, 0, UINT32_MAX);
}

FrameResult ScalarRenderer::render_slabs(const Camera& camera, std::uint32_t first,
                                         std::uint32_t last) {
  Impl& my = *impl_;
  FrameResult result;
  const double begin = seconds_now();
  my.describe_camera(camera);
  last = std::min(last, my.frame.slices[2] - 1);
  first = std::min(first, last);
  my.commands.begin(std::as_bytes(std::span(&my.frame, 1)));
  my.commands.pass("render");
  if (first == last)  // one slice has no slab: the background alone
    my.commands.dispatch(*my.composite, scalar_groups(my.pixels()), {0, 0, 1, 1});
  else
    my.draw_slabs(first, last);
  result.passes = my.commands.submit();
  for (const PassTime& pass : result.passes) result.gpu_seconds += pass.seconds;
  result.host_seconds = seconds_now() - begin;
  return result;
}

Settled ScalarRenderer::settle(const Camera& camera, std::uint32_t) {
  render(camera);
  return {.complete = true, .frames = 1, .incomplete = 0};
}

Image ScalarRenderer::read_image() const {
  const Impl& my = *impl_;
  Image image{.width = my.options.width,
              .height = my.options.height,
              .colour = {},
              .labels = {},
              .complete = {}};
  std::vector<float> colours(4 * image.pixels());
  my.colours.read(0, std::as_writable_bytes(std::span(colours)));
  image.colour.resize(3 * image.pixels());
  for (std::size_t i = 0; i < image.pixels(); ++i)
    std::copy_n(colours.data() + 4 * i, 3, image.colour.data() + 3 * i);
  image.labels.assign(image.pixels(), kNoLabel);
  image.complete.assign(image.pixels(), 1);
  return image;
}

Counters ScalarRenderer::read_counters() const { return {{"cells_decoded", impl_->decoded}}; }
void ScalarRenderer::clear_counters() { impl_->decoded = 0; }
std::vector<MemoryUse> ScalarRenderer::memory() const { return impl_->allocations.uses(); }
std::vector<std::pair<std::string, double>> ScalarRenderer::start_parts() const {
  return impl_->start;
}

}  // namespace cvr::gpu
