// worst-case: hard patterns that every codec, cache and figure must survive. Labels are spread over
// all 32 bits; 0 and 2^32 - 1 occur.
//
//   0 checkerboard   two labels, no two face neighbours alike
//   1 distinct       every voxel a label of its own (up to 2^32 voxels)
//   2 sheets         diagonal sheets x + y + z = constant of `thickness` voxels, each a label
//   3 salt           one label, and at the share `density` of the voxels other labels, each once in a long while
//   4 constant       one label, `value`
//   5 noise          each voxel one of two labels at random
#include <fmt/format.h>

#include <array>

#include "volumes/error.hpp"
#include "volumes/generators/kinds.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{"pattern", 0, 0, 5,
                       "0 checkerboard, 1 distinct, 2 sheets, 3 salt, 4 constant, 5 noise", true},
    GeneratorParameter{"bits", 32, 8, 64, "of a voxel: 8, 16, 32 or 64; with 64 ids exceed 2^32",
                       true},
    GeneratorParameter{"thickness", 1, 1, 1024, "of a sheet in voxels along an axis", true},
    GeneratorParameter{"density", 0.01, 0, 1, "share of the salt"},
    GeneratorParameter{"value", 4294967295.0, 0, 4294967295.0, "the constant label", true},
};

enum Pattern : std::uint8_t { kCheckerboard, kDistinct, kSheets, kSalt, kConstant, kNoise };

VoxelType type_of(double bits) {
  if (bits == 8) return VoxelType::kU8;
  if (bits == 16) return VoxelType::kU16;
  if (bits == 32) return VoxelType::kU32;
  if (bits == 64) return VoxelType::kU64;
  throw InputError(
      fmt::format("generator worst-case: bits: expected 8, 16, 32 or 64, found {}", bits));
}

/// A bijection of 32-bit numbers that scatters them, with 0 -> 0 and 1 -> 2^32 - 1.
std::uint32_t spread(std::uint64_t index) {
  constexpr std::uint32_t kFactor = 0x9E3779B1u, kLargest = 0xFFFFFFFFu;
  const auto i = static_cast<std::uint32_t>(index);
  if (i == 1) return kLargest;
  const std::uint32_t scattered = i * kFactor;
  return scattered == kLargest ? kFactor : scattered;
}

class WorstCaseSource final : public TiledSource {
 public:
  explicit WorstCaseSource(const GeneratorRequest& request)
      : TiledSource(request, type_of(request["bits"]), {128, 64, 64}),
        seed_(mix64(request.seed ^ 0x30857)),
        pattern_(static_cast<Pattern>(request["pattern"])),
        thickness_(static_cast<std::uint64_t>(request["thickness"])),
        density_(request["density"]),
        value_(static_cast<std::uint32_t>(request["value"])) {}

 protected:
  void fill(const Box& box, std::uint32_t* labels) const override {
    for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
      for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y) {
        for (std::uint64_t x = box.origin.x; x < box.origin.x + box.size.x; ++x)
          *labels++ = label({x, y, z});
      }
    }
  }

 private:
  std::uint32_t label(const Coordinate& c) const {
    const auto random = [&] { return mix64(seed_ ^ info().extent.index(c)); };
    switch (pattern_) {
      case kCheckerboard:
        return spread((c.x + c.y + c.z) % 2);
      case kDistinct:
        return spread(info().extent.index(c));
      case kSheets:
        return spread((c.x + c.y + c.z) / thickness_);
      case kSalt: {
        const std::uint64_t r = random();
        return static_cast<double>(r >> 11) * 0x1p-53 < density_ ? spread(mix64(r)) : 0xFFFFFFFFu;
      }
      case kNoise:
        return spread(random() >> 63);
      default:
        return value_;
    }
  }

  std::uint64_t seed_;
  Pattern pattern_;
  std::uint64_t thickness_;
  double density_;
  std::uint32_t value_;
};

}  // namespace

constinit const GeneratorInfo kWorstCaseInfo{
    .kind = "worst-case",
    .summary = "checkerboard, distinct labels, diagonal sheets, salt, constant, noise",
    .volume_kind = VolumeKind::kLabels,
    .default_extent = {130, 97, 71},
    .paper_extent = {},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_worst_case(const GeneratorRequest& request) {
  return std::make_unique<WorstCaseSource>(request);
}

}  // namespace cvr::volumes
