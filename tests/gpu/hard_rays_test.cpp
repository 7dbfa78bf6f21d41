// Rays that are hard to follow, drawn on the device and by the reference: along axes, from faces,
// edges and corners, inside, grazing, from a million voxels away, through extents above 2^13,
// through anisotropic voxels, with a level of detail that changes on the way.
#include <gtest/gtest.h>

#include "gpu/reference/reference.hpp"
#include "tests/gpu/drawing.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::gpu_tests {
namespace {

/// Labels differ from voxel to voxel, so that a wrong step shows; one in three is invisible.
volumes::Volume speckled(const volumes::Extent& extent,
                         std::array<double, 3> voxel_size = {1, 1, 1}) {
  volumes::VolumeInfo info{
      .extent = extent, .type = volumes::VoxelType::kU16, .voxel_size = voxel_size};
  return samples::make_labels(info, [](const volumes::Coordinate& c) {
    return 1 + (c.x * 7 + c.y * 13 + c.z * 29 + c.x * c.y) % 30;
  });
}

void expect_equal(const volumes::Volume& volume, const gpu::Camera& camera, const std::string& what,
                  std::uint32_t brick = 16, std::uint32_t size = 33, std::uint64_t near_ties = 0) {
  gpu::Scene scene;
  scene.materials = {{.modulus = 10, .remainder = 3}};
  scene.width = scene.height = size;  // odd: the middle ray keeps zero components
  const auto encoded = encode_for_gpu(volume, "csgvr-sb", {}, brick);
  const gpu::ReferenceRenderer reference(volume, brick, 2);
  const gpu::Image truth = reference.render(scene, camera);
  for (const std::string access : {"none", "voxel-es", "brick"}) {
    const gpu::Image image = draw(*encoded, volume.info(), scene, camera,
                                  {.access = access, .width = size, .height = size});
    const gpu::LabelCheck check = gpu::check_labels(reference, scene, camera, truth, image);
    EXPECT_EQ(check.differing, check.near_ties) << what << " " << access;
    EXPECT_LE(check.near_ties, near_ties) << what << " " << access;
  }
}

TEST(HardRays, AlongEachAxis) {
  const volumes::Volume volume = speckled({40, 33, 27});
  expect_equal(volume, {{2, 0.013, 0.017}, {0, 0.013, 0.017}, {0, 0, 1}, 20}, "x");
  expect_equal(volume, {{0.013, -2, 0.017}, {0.013, 0, 0.017}, {0, 0, 1}, 20}, "y");
  expect_equal(volume, {{0.013, 0.017, 2}, {0.013, 0.017, 0}, {0, 1, 0}, 20}, "z");
}

TEST(HardRays, FromFacesEdgesAndCorners) {
  const volumes::Volume volume = speckled({32, 32, 32});
  // The corner of the volume, the middle of a face, a point of an edge, a corner of a voxel inside.
  // Rays in a plane of voxel faces may take either side: ties.
  expect_equal(volume, {{0.5, 0.5, 0.5}, {0.03, 0.01, 0}, {0, 1, 0}, 60}, "corner", 16, 33, 3);
  expect_equal(volume, {{0.5, 0.013, 0.02}, {0, 0.07, 0.03}, {0, 1, 0}, 60}, "face", 16, 33, 3);
  expect_equal(volume, {{-0.5, 0.5, 0.1}, {0.03, 0, 0}, {0, 1, 0}, 60}, "edge", 16, 33, 3);
  expect_equal(volume, {{0.125, -0.25, 0.0625}, {0.5, 0.3, 0.1}, {0, 1, 0}, 70}, "inside", 16, 33,
               3);
}

TEST(HardRays, GrazingAFace) {
  const volumes::Volume volume = speckled({64, 64, 8});
  expect_equal(volume, {{-1.2, 0.01, 0.0626}, {0, 0.01, 0.0622}, {0, 0, 1}, 8}, "grazing", 16, 33,
               2);
}

TEST(HardRays, FromAMillionVoxelsAway) {
  const volumes::Volume volume = speckled({32, 32, 32});
  const double away = 1e6 / 32;
  expect_equal(volume, {{0.5 * away, 0.4 * away, 0.77 * away}, {0, 0, 0}, {0, 1, 0}, 0.003}, "far",
               16, 33, 2);
}

TEST(HardRays, ThroughAnExtentAboveTwoToThe13) {
  const volumes::Volume volume = speckled({16384, 5, 4});
  expect_equal(volume, {{0.5004, 0.00007, 0.00005}, {0.1, 0, 0}, {0, 1, 0}, 0.05}, "long", 16, 33,
               2);
  expect_equal(volume, {{-0.3, 0.001, 0.0015}, {-0.29, 0, 0}, {0, 1, 0}, 30}, "beside", 16, 33, 2);
}

TEST(HardRays, ThroughAnisotropicVoxelsAndLevels) {
  const volumes::Volume volume = speckled({70, 60, 20}, {4, 4, 30});
  expect_equal(volume, {{0.9, 0.5, 0.8}, {0, 0, 0}, {0, 1, 0}, 45}, "anisotropic", 32, 33, 1);
  expect_equal(volume, {{3, 2.2, 2.9}, {0, 0, 0}, {0, 1, 0}, 40}, "coarse", 32, 33, 1);
}

}  // namespace
}  // namespace cvr::gpu_tests
