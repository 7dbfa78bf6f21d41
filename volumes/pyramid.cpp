#include "volumes/pyramid.hpp"

#include <algorithm>
#include <array>

#include "volumes/parallel.hpp"

namespace cvr::volumes {

namespace {

/// Finer planes that are read at once, an even number.
constexpr std::uint64_t kSlabBytes = std::uint64_t{32} << 20;

template <class T>
T most_frequent(const std::array<T, 8>& labels, unsigned count) {
  T best = labels[0];
  unsigned most = 0;
  for (unsigned i = 0; i < count; ++i) {
    unsigned votes = 0;
    for (unsigned j = i; j < count; ++j) votes += labels[j] == labels[i];
    if (votes > most) {
      most = votes;
      best = labels[i];
    }
  }
  return best;
}

}  // namespace

template <class T>
void coarsen_planes(const T* finer, const Extent& fine, T* coarse) {
  for (std::uint64_t y = 0; y < fine.y; y += 2) {
    // The rows of the children in Morton order: y, y + 1, then the next plane's.
    const T* rows[4];
    unsigned row_count = 0;
    for (std::uint64_t z = 0; z < fine.z; ++z) {
      for (std::uint64_t child = y; child < std::min(y + 2, fine.y); ++child) {
        rows[row_count++] = finer + fine.x * (child + fine.y * z);
      }
    }
    std::uint64_t x = 0;
    if (row_count == 4) {
      for (; x + 2 <= fine.x; x += 2) {
        const std::array<T, 8> labels{rows[0][x], rows[0][x + 1], rows[1][x], rows[1][x + 1],
                                      rows[2][x], rows[2][x + 1], rows[3][x], rows[3][x + 1]};
        T differences = 0;
        for (int i = 1; i < 8; ++i)
          differences = static_cast<T>(differences | (labels[i] ^ labels[0]));
        *coarse++ = differences == 0 ? labels[0] : most_frequent(labels, 8);
      }
    }
    for (; x < fine.x; x += 2) {
      std::array<T, 8> labels{};
      unsigned count = 0;
      for (unsigned row = 0; row < row_count; ++row) {
        for (std::uint64_t child = x; child < std::min(x + 2, fine.x); ++child)
          labels[count++] = rows[row][child];
      }
      *coarse++ = most_frequent(labels, count);
    }
  }
}

template void coarsen_planes(const std::uint8_t*, const Extent&, std::uint8_t*);
template void coarsen_planes(const std::uint16_t*, const Extent&, std::uint16_t*);
template void coarsen_planes(const std::uint32_t*, const Extent&, std::uint32_t*);
template void coarsen_planes(const std::uint64_t*, const Extent&, std::uint64_t*);

Volume coarser_level(const VolumeSource& finer, unsigned threads) {
  const Extent fine = finer.info().extent;
  VolumeInfo info = finer.info();
  info.extent = ceil_div(fine, 2);
  for (double& size : info.voxel_size) size *= 2;
  Volume coarse(info);
  const std::uint64_t fine_plane = fine.x * fine.y;
  const std::uint64_t coarse_plane = info.extent.x * info.extent.y;
  const std::uint64_t pairs =
      std::max<std::uint64_t>(1, kSlabBytes / (2 * fine_plane * size_of(info.type)));
  SlabReader reader(finer);
  with_label_type(info.type, [&]<class T>() {
    for (std::uint64_t z0 = 0; z0 < info.extent.z; z0 += pairs) {
      const std::uint64_t z1 = std::min(z0 + pairs, info.extent.z);
      const auto* labels =
          reinterpret_cast<const T*>(reader.read(2 * z0, std::min(2 * z1, fine.z)));
      parallel_for(threads, z1 - z0, [&](unsigned, std::uint64_t i) {
        const std::uint64_t planes = std::min<std::uint64_t>(2, fine.z - 2 * (z0 + i));
        coarsen_planes(labels + 2 * i * fine_plane, {fine.x, fine.y, planes},
                       coarse.voxels<T>().data() + (z0 + i) * coarse_plane);
      });
    }
  });
  return coarse;
}

}  // namespace cvr::volumes
