// 20 GiB of labels within 4 GiB of address space.
#include "tests/cli/streaming.hpp"

namespace cvr::cli_tests {
namespace {

TEST(LargeStreaming, TwentyGiBPassThroughFour) {
  const Program program;
  constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
  // HDF5: sheets take a hundredth of their voxels on the disk.
  expect_streams(program,
                 {"2048,2048,1280", 20 * kGiB, 4 * kGiB, "csgvr-sb -p brick=32", "v.h5", "d.h5"});
}

}  // namespace
}  // namespace cvr::cli_tests
