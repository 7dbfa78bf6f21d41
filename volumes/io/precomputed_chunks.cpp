// Names of chunk files: made, taken apart, and a folder of them held against the grid of its scale.
#include <fmt/format.h>

#include <charconv>
#include <filesystem>

#include "volumes/io/precomputed.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

/// What a name says of one axis, including voxel_offset.
struct Range {
  std::int64_t begin = 0, end = 0;
};
using Ranges = std::array<Range, 3>;

/// "x0-x1_y0-y1_z0-z1" at the start of a name, and what stands behind it.
std::optional<std::pair<Ranges, std::string_view>> parse_ranges(std::string_view name) {
  Ranges ranges;
  const char* at = name.data();
  const char* const end = at + name.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::int64_t* number : {&ranges[axis].begin, &ranges[axis].end}) {
      const bool first = axis == 0 && number == &ranges[axis].begin;
      const char separator = number == &ranges[axis].begin ? '_' : '-';
      if (!first && (at == end || *at++ != separator)) return std::nullopt;
      const auto [next, error] = std::from_chars(at, end, *number);
      if (error != std::errc{}) return std::nullopt;
      at = next;
    }
  }
  return std::pair{ranges, name.substr(static_cast<std::size_t>(at - name.data()))};
}

/// Whether a range is that of a chunk of the grid: from a multiple of the edge, a whole edge long
/// or up to the border.
bool fits(const Range& range, std::uint64_t size, std::uint64_t edge, std::int64_t offset) {
  constexpr std::int64_t kFar = std::int64_t{1} << 61;
  if (range.begin < -kFar || range.begin > kFar) return false;
  const std::int64_t start = range.begin - offset;
  if (start < 0 || static_cast<std::uint64_t>(start) >= size ||
      static_cast<std::uint64_t>(start) % edge != 0)
    return false;
  return range.end == range.begin + static_cast<std::int64_t>(
                                        std::min(edge, size - static_cast<std::uint64_t>(start)));
}

bool fits(const Ranges& ranges, const PrecomputedScale& scale, const Extent& chunk) {
  return fits(ranges[0], scale.size.x, chunk.x, scale.voxel_offset[0]) &&
         fits(ranges[1], scale.size.y, chunk.y, scale.voxel_offset[1]) &&
         fits(ranges[2], scale.size.z, chunk.z, scale.voxel_offset[2]);
}

Box first_chunk(const PrecomputedScale& scale) { return {{0, 0, 0}, scale.chunk}; }

}  // namespace

std::string precomputed_chunk_name(const PrecomputedScale& scale, const Box& box) {
  const auto range = [](std::uint64_t origin, std::uint64_t size, std::int64_t offset) {
    const std::int64_t start = static_cast<std::int64_t>(origin) + offset;
    return fmt::format("{}-{}", start, start + static_cast<std::int64_t>(size));
  };
  return fmt::format("{}_{}_{}", range(box.origin.x, box.size.x, scale.voxel_offset[0]),
                     range(box.origin.y, box.size.y, scale.voxel_offset[1]),
                     range(box.origin.z, box.size.z, scale.voxel_offset[2]));
}

std::string chunk_name_fault(const PrecomputedScale& scale, std::string_view name) {
  const auto parsed = parse_ranges(name);
  if (!parsed) return "a name that is none of a chunk";
  const auto& [ranges, ending] = *parsed;
  bool found = fits(ranges, scale, scale.chunk);
  for (const Extent& chunk : scale.more_chunks) found = found || fits(ranges, scale, chunk);
  if (!found) return "a name that does not fit size, chunk_sizes and voxel_offset of this scale";
  if (ending.empty() || ending == ".gz") return {};
  return fmt::format("the ending '{}': chunks are read plain and gzipped (.gz) only", ending);
}

void check_chunk_names(const std::string& folder, const PrecomputedScale& scale) {
  const std::string first = precomputed_chunk_name(scale, first_chunk(scale));
  bool any = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;
    std::string fault = chunk_name_fault(scale, name);
    if (!fault.empty() && entry.is_directory())
      continue;  // of another scale, whose key goes on from this one's
    if (fault.empty() && !entry.is_regular_file())
      fault = "a folder, device, pipe or socket, or a link to nothing";
    if (!fault.empty()) {
      throw_input_error(
          entry.path().string(), "",
          fmt::format("a chunk file as '{}' of {} voxels at most, the first of this scale", first,
                      to_string(scale.chunk)),
          fault);
    }
    // Chunks of other sizes hold the same voxels once more: they are not the ones that are read.
    any = any || fits(parse_ranges(name)->first, scale, scale.chunk);
  }
  if (!any) {
    throw_input_error(folder, "",
                      fmt::format("at least one chunk file, the first being '{}'", first), "none");
  }
}

}  // namespace cvr::volumes
