#include "gpu/scalars/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>

#include "gpu/reference/vector.hpp"
#include "gpu/scalars/frame.hpp"

namespace cvr::gpu {

namespace {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

constexpr std::uint32_t kGroup = 256;
constexpr std::uint32_t kLargestImage = 16384;
/// Loops of one sample: eight corners and 4^3 neighbours (shaders/scalars/composite.comp).
constexpr std::uint32_t kSampleLoops = 1 + 8 + 64;
/// Slices in the ring besides one for each slab that is drawn at a time.
constexpr std::uint32_t kAround = 3;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A vector in slice space.
Vector3 permuted(const Vector3& v, std::size_t axis) {
  return {v[axis == 0 ? 1 : 0], v[axis == 2 ? 1 : 2], v[axis]};
}

void store(const Vector3& v, float (&out)[3]) {
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

}  // namespace

struct ScalarRenderer::Impl {
  Impl(Device& d, const codecs::GpuSamples& s, const volumes::VolumeInfo& i,
       const ScalarRenderOptions& o)
      : device(d),
        info(i),
        options(o),
        ring_of_slices(o.access == "slices"),
        width(o.width),
        height(o.height),
        commands(d, sizeof(ScalarFrame)),
        samples(s) {}

  Expected<void> upload();
  Expected<void> make_kernels();
  void describe_camera(const Camera& camera);
  std::uint64_t draw_from_ring(std::uint32_t first, std::uint32_t last);
  void decode_slices(std::uint32_t first, std::uint32_t last);
  void composite_slabs(std::uint32_t first, std::uint32_t last, bool begins, bool ends);
  std::uint32_t groups(std::uint64_t invocations) const {
    return static_cast<std::uint32_t>((invocations + kGroup - 1) / kGroup);
  }

  Device& device;
  volumes::VolumeInfo info;
  ScalarRenderOptions options;
  bool ring_of_slices;
  std::uint32_t width, height;
  Commands commands;
  codecs::GpuSamples samples;  ///< without the buffers' bytes once they are uploaded
  Allocations allocations{device};
  DeviceBuffer ring, colours, transfer;
  std::unique_ptr<Kernel> decode, composite;
  ScalarFrame frame{};
  Scene scene;
  std::vector<std::pair<std::string, double>> start;
};

Expected<void> ScalarRenderer::Impl::upload() {
  if (auto done = allocations.upload(samples.buffers, frame.encoding); !done) return done;
  const volumes::Extent& e = info.extent;
  const std::uint64_t largest_slice = std::max({e.x * e.y, e.x * e.z, e.y * e.z});
  const std::uint64_t slices = std::clamp<std::uint64_t>(
      std::bit_floor(options.cache_bytes / (4 * largest_slice)), kAround + 1,
      std::max<std::uint64_t>(kAround + 1, std::bit_ceil(std::max({e.x, e.y, e.z}))));
  frame.ring_slices = static_cast<std::uint32_t>(slices);
  const struct {
    DeviceBuffer& buffer;
    std::uint64_t bytes;
    const char* use;
    std::uint64_t& address;
  } pieces[] = {{ring, ring_of_slices ? 4 * largest_slice * slices : 0, "slices", frame.ring},
                {colours, std::uint64_t{width} * height * 16, "image", frame.colours},
                {transfer, kTransferEntries * 16, "transfer function", frame.transfer}};
  for (const auto& piece : pieces) {
    if (piece.bytes == 0) continue;
    if (auto done = allocations.make(piece.buffer, piece.bytes, piece.use); !done) return done;
    piece.address = piece.buffer.address();
  }
  if (groups(largest_slice) > device.limits().groups ||
      groups(std::uint64_t{width} * height) > device.limits().groups)
    return fail(
        ErrorCode::kUnsupported,
        "a slice or the picture needs more workgroups than the device's maxComputeWorkGroupCount");
  return {};
}

Expected<void> ScalarRenderer::Impl::make_kernels() {
  KernelSource common;
  common.definitions = {{"CVR_TRANSFER_ENTRIES", std::to_string(kTransferEntries)},
                        {"CVR_GROUP", std::to_string(kGroup)}};
  for (const auto& [name, value] : samples.constants)
    common.definitions.emplace_back(name, std::to_string(value));
  common.files = {"shaders/scalars/frame.glsl",
                  fmt::format("shaders/scalars/{}.glsl", samples.decoder)};
  const auto kernel = [&](const char* path, bool from_ring) {
    KernelSource source = common;
    source.name = fmt::format("{} {}", path, samples.decoder);
    if (from_ring) source.definitions.emplace_back("CVR_FROM_RING", "1");
    source.files.emplace_back(path);
    return std::make_unique<Kernel>(device, commands, source);
  };
  if (ring_of_slices) decode = kernel("shaders/scalars/slice.comp", false);
  composite = kernel("shaders/scalars/composite.comp", ring_of_slices);
  return {};
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
  store(permuted((half / height) * right / scale, axis), frame.right);
  store(permuted((-half / height) * up / scale, axis), frame.down);
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

/// Slices [first, last) in the view's order, in as many dispatches as the device asks for.
void ScalarRenderer::Impl::decode_slices(std::uint32_t first, std::uint32_t last) {
  const std::uint64_t runs = std::uint64_t{(frame.slices[0] + 3) / 4} * frame.slices[1];
  const auto at_a_time =
      static_cast<std::uint32_t>(kGroup * std::uint64_t{device.limits().groups} / runs);
  const std::uint32_t count = frame.slices[2];
  for (std::uint32_t from = first; from < last; from += std::min(at_a_time, last - from)) {
    const std::uint32_t to = from + std::min(at_a_time, last - from);
    const std::uint32_t begin = frame.backwards != 0 ? count - to : from;
    commands.dispatch(*decode, groups(runs * (to - from)), {begin, begin + (to - from), 0, 0});
  }
}

/// Slabs [first, last) of the frame's [0 .. end); what is in the ring suffices.
void ScalarRenderer::Impl::composite_slabs(std::uint32_t first, std::uint32_t last, bool begins,
                                           bool ends) {
  const std::uint32_t at_a_time =
      std::max(1u, device.limits().loop_iterations / 2 / (kSampleLoops * frame.samples));
  for (std::uint32_t from = first; from < last; from += std::min(at_a_time, last - from)) {
    const std::uint32_t to = from + std::min(at_a_time, last - from);
    commands.dispatch(*composite, groups(std::uint64_t{width} * height),
                      {from, to, begins && from == first ? 1u : 0u, ends && to == last ? 1u : 0u});
  }
}

/// Slab m lies between slices m and m + 1 and needs m - 1 to m + 2, in the view's order.
std::uint64_t ScalarRenderer::Impl::draw_from_ring(std::uint32_t first, std::uint32_t last) {
  const std::uint32_t count = frame.slices[2];
  const std::uint32_t batch = frame.ring_slices >= count ? count : frame.ring_slices - kAround;
  std::uint32_t have = first > 0 ? first - 1 : 0;
  const std::uint32_t begin = have;
  for (std::uint32_t slab = first; slab < last; slab += std::min(batch, last - slab)) {
    const std::uint32_t next = slab + std::min(batch, last - slab);
    const std::uint32_t need = std::min(next + 2, count);
    decode_slices(have, need);
    have = need;
    composite_slabs(slab, next, slab == first, next == last);
  }
  return std::uint64_t{frame.slices[0]} * frame.slices[1] * (have - begin);
}

Expected<std::unique_ptr<ScalarRenderer>> ScalarRenderer::make(Device& device,
                                                               const codecs::GpuSamples& samples,
                                                               const volumes::VolumeInfo& info,
                                                               const ScalarRenderOptions& options) {
  const auto& [access, cache_bytes, width, height] = options;
  if (access != "none" && access != "slices")
    return fail(ErrorCode::kUnsupported,
                fmt::format("scalar volumes are drawn by none or slices, not by {}", access));
  if (width == 0 || height == 0 || width > kLargestImage || height > kLargestImage)
    return fail(ErrorCode::kBadArgument,
                fmt::format("expected a picture of 1 to {} pixels a side, found {}x{}",
                            kLargestImage, width, height));
  auto impl = std::make_unique<Impl>(device, samples, info, options);
  const double begin = now();
  if (auto done = impl->upload(); !done) return tl::unexpected(done.error());
  const double uploaded = now();
  if (auto done = impl->make_kernels(); !done) return tl::unexpected(done.error());
  impl->start = {{"upload", uploaded - begin}, {"kernels", now() - uploaded}};
  return std::unique_ptr<ScalarRenderer>(new ScalarRenderer(std::move(impl)));
}

ScalarRenderer::ScalarRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ScalarRenderer::~ScalarRenderer() = default;

void ScalarRenderer::set_scene(const Scene& scene, const ValueRange& range) {
  Impl& my = *impl_;
  my.scene = scene;
  std::vector<float> entries;
  for (const TransferEntry& entry : transfer_table(scene.transfer))
    for (const double channel : entry) entries.push_back(static_cast<float>(channel));
  my.transfer.write(0, std::as_bytes(std::span(entries)));
  my.frame.value_at = static_cast<float>(range.least);
  const double width = range.largest - range.least;
  my.frame.value_step = width > 0 ? static_cast<float>((kTransferEntries - 1) / width) : 0;
  my.frame.knee = static_cast<float>(kShadingKnee * width);
  my.frame.samples = scene.slice_samples;
  my.frame.ambient = static_cast<float>(scene.ambient);
  for (std::size_t i = 0; i < 3; ++i)
    my.frame.background[i] = static_cast<float>(scene.background[i]) / 255;
  my.frame.width = my.width;
  my.frame.height = my.height;
}

ScalarFrameResult ScalarRenderer::render(const Camera& camera, std::uint32_t first,
                                         std::uint32_t last) {
  Impl& my = *impl_;
  ScalarFrameResult result;
  const double begin = now();
  my.describe_camera(camera);
  last = std::min(last, my.frame.slices[2] - 1);
  first = std::min(first, last);
  my.commands.begin(std::as_bytes(std::span(&my.frame, 1)));
  my.commands.pass("render");
  if (first == last) {  // one slice has no slab: the background alone
    my.commands.dispatch(*my.composite, my.groups(std::uint64_t{my.width} * my.height),
                         {0, 0, 1, 1});
  } else if (my.ring_of_slices) {
    result.decoded = my.draw_from_ring(first, last);
  } else {
    my.composite_slabs(first, last, true, true);
  }
  result.passes = my.commands.submit();
  for (const PassTime& pass : result.passes) result.gpu_seconds += pass.seconds;
  result.host_seconds = now() - begin;
  return result;
}

Image ScalarRenderer::read_image() const {
  const Impl& my = *impl_;
  Image image{.width = my.width, .height = my.height, .colour = {}, .labels = {}, .complete = {}};
  std::vector<float> colours(4 * image.pixels());
  my.colours.read(0, std::as_writable_bytes(std::span(colours)));
  image.colour.resize(3 * image.pixels());
  for (std::size_t i = 0; i < image.pixels(); ++i)
    std::copy_n(colours.data() + 4 * i, 3, image.colour.data() + 3 * i);
  image.labels.assign(image.pixels(), kNoLabel);
  image.complete.assign(image.pixels(), 1);
  return image;
}

std::vector<MemoryUse> ScalarRenderer::memory() const { return impl_->allocations.uses(); }
std::vector<std::pair<std::string, double>> ScalarRenderer::start_parts() const {
  return impl_->start;
}

}  // namespace cvr::gpu
