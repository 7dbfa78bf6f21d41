// Pictures of scalar volumes: deferred filtering and direct decoding draw the same, and what the
// reference draws.
#include <gtest/gtest.h>

#include <cmath>

#include "codecs/raw/raw.hpp"
#include "codecs/registry.hpp"
#include "gpu/scalars/reference.hpp"
#include "gpu/scalars/renderer.hpp"
#include "tests/gpu/drawing.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::gpu_tests {
namespace {

using gpu::Camera;
using gpu::Image;
using gpu::Scene;
using volumes::Extent;
using volumes::Volume;
using volumes::VoxelType;

constexpr double kLeastPsnr =
    70;  ///< single against double precision; a wrong weight or slice costs tens of dB

/// Soft blobs with a little noise, in the middle of the type's range.
Volume blobs(const Extent& extent, VoxelType type, std::array<double, 3> voxel_size = {1, 1, 1}) {
  Volume volume({.extent = extent,
                 .type = type,
                 .kind = volumes::VolumeKind::kScalars,
                 .voxel_size = voxel_size,
                 .voxel_unit = ""});
  const auto value = [&](std::uint64_t i) {
    const double x = static_cast<double>(i % extent.x),
                 y = static_cast<double>(i / extent.x % extent.y),
                 z = static_cast<double>(i / extent.x / extent.y);
    const double noise = static_cast<double>(samples::random_at(5, i) % 1000) / 1000;
    return 0.5 + 0.3 * std::sin(0.7 * x) * std::cos(0.5 * y + 0.2) * std::sin(0.6 * z + 1) +
           0.1 * noise;
  };
  for (std::uint64_t i = 0; i < extent.voxels(); ++i) {
    switch (type) {
      case VoxelType::kU8:
        volume.voxels<std::uint8_t>()[i] = static_cast<std::uint8_t>(255 * value(i));
        break;
      case VoxelType::kU16:
        volume.voxels<std::uint16_t>()[i] = static_cast<std::uint16_t>(60000 * value(i));
        break;
      case VoxelType::kI16:
        volume.voxels<std::int16_t>()[i] = static_cast<std::int16_t>(4000 * value(i) - 2000);
        break;
      default:
        volume.voxels<float>()[i] = static_cast<float>(1e-3 * value(i) - 7);
        break;
    }
  }
  return volume;
}

Scene scalar_scene(std::uint32_t slice_samples = 1) {
  Scene scene;
  scene.width = 53;
  scene.height = 41;
  scene.slice_samples = slice_samples;
  scene.transfer = {
      {0.35, {30, 60, 200}, 0}, {0.55, {230, 120, 40}, 0.06}, {0.8, {250, 250, 230}, 0.3}};
  return scene;
}

/// Shows the scene; the transfer function spans the values of `volume`.
std::unique_ptr<gpu::ScalarRenderer> make_renderer(const codecs::GpuSamples& samples,
                                                   const Volume& volume, const Scene& scene,
                                                   const std::string& access,
                                                   std::uint64_t cache_bytes = 0) {
  auto renderer =
      gpu::ScalarRenderer::make(device(), samples, volume.info(), gpu::value_range(volume),
                                {.access = access,
                                 .cache_bytes = cache_bytes,
                                 .width = scene.width,
                                 .height = scene.height})
          .value();
  EXPECT_TRUE(renderer->set_scene(scene));
  return renderer;
}

Image draw_scalars(const Volume& volume, const std::string& access, const Scene& scene,
                   const Camera& camera, std::uint64_t cache_bytes = 0) {
  const volumes::MemorySource source(volume);
  const auto encoded = codecs::encode(codecs::raw_codec(), source, {}, 1).value();
  const auto file = codecs::open_file(encoded.bytes.bytes()).value();
  const auto decoder = codecs::open_decoder(file).value();
  const auto samples = decoder->gpu_samples(0).value();
  auto renderer = make_renderer(samples, volume, scene, access, cache_bytes);
  renderer->render(camera);
  return renderer->read_image();
}

double psnr(const Image& a, const Image& b) {
  const gpu::ImageDifference difference = gpu::compare(a, b);
  return difference.mse > 0 ? difference.psnr : 200;
}

void expect_pictures(const Volume& volume, const Scene& scene, const Camera& camera,
                     const std::string& what) {
  const Image truth = render_scalars(volume, scene, gpu::value_range(volume), camera, 2);
  const Image direct = draw_scalars(volume, "none", scene, camera);
  EXPECT_GT(psnr(truth, direct), kLeastPsnr) << what;
  const std::uint64_t slice = 4 * volume.extent().x * volume.extent().y;
  for (const std::uint64_t cache : {std::uint64_t{0}, 7 * slice, 1000 * slice})
    EXPECT_TRUE(
        gpu::compare(direct, draw_scalars(volume, "slices", scene, camera, cache)).identical())
        << what << ", ring of " << cache;
}

TEST(Scalars, EveryTypeIsDrawn) {
  for (const VoxelType type : volumes::kScalarTypes)
    expect_pictures(blobs({19, 14, 23}, type), scalar_scene(), corner_view(),
                    std::string(name_of(type)));
}

TEST(Scalars, EveryAxisAndOrderOfSlices) {
  const Volume volume = blobs({12, 17, 21}, VoxelType::kU8);
  for (const gpu::Vector3& eye : std::vector<gpu::Vector3>{{1.6, 0.2, 0.1},
                                                           {-1.6, 0.2, 0.1},
                                                           {0.1, 1.6, 0.2},
                                                           {0.1, -1.6, 0.2},
                                                           {0.2, 0.1, 1.6},
                                                           {0.2, 0.1, -1.6}}) {
    const Camera camera{.eye = eye,
                        .up = std::abs(eye[1]) > 1 ? gpu::Vector3{0, 0, 1} : gpu::Vector3{0, 1, 0}};
    expect_pictures(volume, scalar_scene(), camera, testing::PrintToString(eye));
  }
}

TEST(Scalars, SeveralPlanesASlab) {
  for (const std::uint32_t samples : {2u, 3u, 7u})
    expect_pictures(blobs({15, 16, 17}, VoxelType::kU8), scalar_scene(samples), corner_view(),
                    std::to_string(samples));
}

TEST(Scalars, AnisotropicVoxels) {
  expect_pictures(blobs({16, 20, 9}, VoxelType::kU16, {8, 8, 40}), scalar_scene(), corner_view(),
                  "8 x 8 x 40");
}

TEST(Scalars, ThinVolumes) {
  for (const Extent& extent : {Extent{1, 9, 7}, Extent{9, 1, 7}, Extent{9, 7, 1}, Extent{1, 1, 1},
                               Extent{2, 2, 2}, Extent{3, 40, 2}})
    expect_pictures(blobs(extent, VoxelType::kU8), scalar_scene(), corner_view(2),
                    to_string(extent));
}

TEST(Scalars, ACameraInsideTheVolume) {
  expect_pictures(blobs({24, 24, 24}, VoxelType::kU8), scalar_scene(),
                  {.eye = {0.1, 0.05, 0.1}, .target = {-0.4, -0.2, -0.3}}, "inside");
}

TEST(Scalars, AConstantVolumeAndAnEmptyTransferFunction) {
  Volume volume({.extent = {8, 8, 8},
                 .type = VoxelType::kF32,
                 .kind = volumes::VolumeKind::kScalars,
                 .voxel_unit = ""});
  for (float& v : volume.voxels<float>()) v = 3.5F;
  expect_pictures(volume, scalar_scene(), corner_view(), "constant");
  Scene nothing = scalar_scene();
  nothing.transfer = {};
  const Image image = draw_scalars(volume, "slices", nothing, corner_view());
  for (const float channel : image.colour) EXPECT_EQ(channel, 1.0F);
}

TEST(Scalars, SlabsThatAreDrawnAloneAddUp) {
  const Volume volume = blobs({16, 16, 40}, VoxelType::kU8);
  const volumes::MemorySource source(volume);
  const auto encoded = codecs::encode(codecs::raw_codec(), source, {}, 1).value();
  const auto file = codecs::open_file(encoded.bytes.bytes()).value();
  const auto decoder = codecs::open_decoder(file).value();
  const auto samples = decoder->gpu_samples(0).value();
  const Scene scene = scalar_scene();
  const auto renderer = make_renderer(samples, volume, scene, "slices");
  const Camera camera{.eye = {0.1, 0.2, 1.7}};
  renderer->render(camera);
  const gpu::Counters whole{{"cells_decoded", volume.extent().voxels()}};
  EXPECT_EQ(renderer->read_counters(), whole);
  renderer->clear_counters();
  renderer->render_slabs(camera, 10, 20);
  const gpu::Counters part{{"cells_decoded", 13 * 16 * 16}};  // slices 9 to 21
  EXPECT_EQ(renderer->read_counters(), part);
}

/// Every codec with a decoder of scalars for the GPU, every type, every progressive step: the
/// picture is that of what the CPU decodes.
TEST(Scalars, EveryCodecDrawsWhatItDecodes) {
  unsigned pictures = 0;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    if (!codec->traits().gpu_scalars) continue;
    for (const VoxelType type : volumes::kScalarTypes) {
      const Volume volume = blobs({22, 17, 30}, type);
      if (!codecs::accepts(codec->traits(), volume.info())) continue;
      const auto parameters = codecs::Parameters::parse(codec->parameters(), {}).value();
      const auto encoded =
          codecs::encode(*codec, volumes::MemorySource(volume), parameters, 2).value();
      const auto file = codecs::open_file(encoded.bytes.bytes()).value();
      const auto decoder = codecs::open_decoder(file).value();
      const codecs::ProgressiveAccess* progressive = decoder->progressive_access();
      for (unsigned step = 0; step < (progressive == nullptr ? 1 : progressive->steps()); ++step) {
        volumes::VolumeSink sink(volume.info());
        const auto decoded = progressive == nullptr ? decoder->decode(0, 1, sink)
                                                    : progressive->decode_step(step, 1, sink);
        ASSERT_TRUE(decoded);
        const Scene scene = scalar_scene();
        const Image truth =
            render_scalars(sink.take(), scene, gpu::value_range(volume), corner_view(), 2);
        for (const char* access : {"none", "slices"}) {
          const auto renderer =
              make_renderer(decoder->gpu_samples(step).value(), volume, scene, access);
          renderer->render(corner_view());
          EXPECT_GT(psnr(truth, renderer->read_image()), kLeastPsnr)
              << codec->traits().id << ", " << name_of(type) << ", step " << step << ", " << access;
          ++pictures;
        }
      }
    }
  }
  EXPECT_GE(pictures, 8u);
}

TEST(Scalars, RefusesWhatIsNotThere) {
  const Volume volume = blobs({8, 8, 8}, VoxelType::kU8);
  const codecs::GpuSamples samples{
      .decoder = "raw", .constants = {{"CVR_RAW_SCALAR", 0}}, .buffers = {}};
  const auto made = [&](const gpu::RenderOptions& options) {
    return gpu::ScalarRenderer::make(device(), samples, volume.info(), {0, 255}, options)
        .has_value();
  };
  EXPECT_TRUE(made({.access = "none", .width = 8, .height = 8}));
  EXPECT_FALSE(made({.access = "brick", .width = 8, .height = 8}));
  EXPECT_FALSE(made({.access = "no such mode", .width = 8, .height = 8}));
  EXPECT_FALSE(made({.access = "none", .width = 0, .height = 8}));
}

}  // namespace
}  // namespace cvr::gpu_tests
