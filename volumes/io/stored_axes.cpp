#include "volumes/io/stored_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace cvr::volumes {

namespace {

constexpr std::string_view kLetters = "xyztc";

std::string listed(const std::vector<std::uint64_t>& sizes) {
  return fmt::format("{}", fmt::join(sizes, " x "));
}

}  // namespace

std::string letters_of(const std::string& file, std::string_view position,
                       const std::vector<std::uint64_t>& sizes, const OpenOptions& options) {
  const std::string& given = options.axes;
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (kLetters.find(given[i]) == std::string_view::npos || given.find(given[i]) != i) {
      throw_input_error(
          file, position,
          fmt::format("axes {} as letters x, y, z, t and c, x first, each at most once",
                      listed(sizes)),
          fmt::format("'{}'", given));
    }
  }
  if (given.size() == sizes.size()) return given;
  const auto longer = static_cast<std::size_t>(
      std::ranges::count_if(sizes, [](std::uint64_t n) { return n != 1; }));
  if (given.size() != longer) {
    const std::string or_fewer =
        longer == sizes.size() ? "" : fmt::format(" (or {}, without those of length 1)", longer);
    throw_input_error(
        file, position,
        fmt::format("{} letters for the axes {}{}, x first", sizes.size(), listed(sizes), or_fewer),
        fmt::format("{}, '{}'", given.size(), given));
  }
  std::string letters;
  std::size_t next = 0;
  for (const std::uint64_t n : sizes) letters += n == 1 ? '-' : given[next++];
  return letters;
}

StoredAxes resolve_axes(const std::string& file, std::string_view position,
                        const std::vector<std::uint64_t>& sizes, std::string_view letters,
                        VoxelType type) {
  std::array<std::optional<std::size_t>, 4> axis;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const std::size_t letter = std::string_view("xyzt").find(letters[i]);
    if (letter != std::string_view::npos) {
      axis[letter] = i;
    } else if (sizes[i] != 1) {
      const std::string what = letters[i] == 'c' ? "channels" : "entries";
      throw_input_error(
          file, position,
          fmt::format("1 of the {} of axis {}, since a volume has one value per voxel", what,
                      i + 1),
          fmt::format("{} {} (axes {})", sizes[i], what, listed(sizes)));
    }
  }
  const auto size_of_axis = [&](std::size_t letter) {
    return axis[letter] ? sizes[*axis[letter]] : 1;
  };
  StoredAxes result{.axis = {axis[0], axis[1], axis[2]}};
  if (axis[3] && sizes[*axis[3]] == 0)
    throw_input_error(file, position, "at least one time step", "none");
  result.steps = axis[3] ? sizes[*axis[3]] : 0;
  const std::array step{size_of_axis(0), size_of_axis(1), size_of_axis(2)};
  check_extent(file, position, step, size_of_axis(3), type);
  result.step = {step[0], step[1], step[2]};
  std::uint64_t dense = 1;
  for (std::size_t letter = 0; letter < axis.size(); ++letter) {
    result.strides[letter] = dense;  // of an axis of length 1 any stride is right
    dense *= size_of_axis(letter);
    if (size_of_axis(letter) == 1) continue;
    result.strides[letter] = 1;
    for (std::size_t i = 0; i < *axis[letter]; ++i) result.strides[letter] *= sizes[i];
  }
  return result;
}

std::array<double, 3> along_xyz(const StoredAxes& axes, const std::vector<double>& values,
                                double missing) {
  std::array<double, 3> result{missing, missing, missing};
  for (std::size_t i = 0; i < result.size(); ++i)
    if (axes.axis[i] && *axes.axis[i] < values.size()) result[i] = values[*axes.axis[i]];
  return result;
}

void apply_axes(const VolumePath& path, std::string_view position, const StoredAxes& axes,
                VolumeInfo& info, ArrayLayout& layout) {
  const Steps steps = check_steps(path, position, axes.steps);
  info.extent = {axes.step.x, axes.step.y, axes.step.z * steps.count};
  info.time_steps = steps.count;
  layout.stored_bytes = axes.voxels() * size_of(info.type);
  layout.strides = axes.strides;
  layout.first_step = steps.first;
}

}  // namespace cvr::volumes
