// What the axes of an NRRD header mean: x, y, z and time, voxel size, unit and offset; the rules
// are in nrrd.hpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "volumes/io/nrrd.hpp"

namespace cvr::volumes {

namespace {

/// Samples along an axis of this kind by the definition of the format; 0: any number. None: an
/// unknown kind.
std::optional<std::uint64_t> samples_of_kind(std::string_view kind) {
  static const std::map<std::string_view, std::uint64_t> kKinds{{"domain", 0},
                                                                {"space", 0},
                                                                {"time", 0},
                                                                {"list", 0},
                                                                {"point", 0},
                                                                {"vector", 0},
                                                                {"covariant-vector", 0},
                                                                {"normal", 0},
                                                                {"stub", 1},
                                                                {"scalar", 1},
                                                                {"complex", 2},
                                                                {"2-vector", 2},
                                                                {"3-color", 3},
                                                                {"rgb-color", 3},
                                                                {"hsv-color", 3},
                                                                {"xyz-color", 3},
                                                                {"4-color", 4},
                                                                {"rgba-color", 4},
                                                                {"3-vector", 3},
                                                                {"3-gradient", 3},
                                                                {"3-normal", 3},
                                                                {"4-vector", 4},
                                                                {"quaternion", 4},
                                                                {"2d-symmetric-matrix", 3},
                                                                {"2d-masked-symmetric-matrix", 4},
                                                                {"2d-matrix", 4},
                                                                {"2d-masked-matrix", 5},
                                                                {"3d-symmetric-matrix", 6},
                                                                {"3d-masked-symmetric-matrix", 7},
                                                                {"3d-matrix", 9},
                                                                {"3d-masked-matrix", 10},
                                                                {"???", 0},
                                                                {"none", 0}};
  const auto found = kKinds.find(kind);
  return found == kKinds.end() ? std::nullopt : std::optional(found->second);
}

/// Kinds that say no more than that the axis is there.
bool says_nothing(std::string_view kind) { return kind == "???" || kind == "none"; }
bool is_spatial(std::string_view kind) { return kind == "domain" || kind == "space"; }

class Geometry {
 public:
  Geometry(const std::string& file, const NrrdHeader& header) : file_(file), header_(header) {}

  /// A letter per axis, by the header alone.
  std::string letters() const {
    const std::size_t rank = header_.sizes.size();
    std::string letters(rank, '-');
    std::vector<std::size_t> spatial;
    for (std::size_t axis = 0; axis < rank; ++axis) {
      const std::string kind = kind_of(axis);
      check_kind(axis, kind);
      const bool last_list =
          kind == "list" && axis + 1 == rank && rank > 3 && header_.sizes[axis] != 1;
      if (kind == "time" || last_list) {
        letters[axis] = 't';
      } else if (is_spatial(kind) || says_nothing(kind)) {
        spatial.push_back(axis);
      } else if (header_.sizes[axis] != 1) {
        fail("kinds",
             fmt::format("one entry of axis {} of kind {}, since a volume has one value per voxel",
                         axis + 1, kind),
             fmt::format("{} entries", header_.sizes[axis]));
      }
    }
    if (std::ranges::count(letters, 't') > 1) fail("kinds", "one time axis", "several");
    drop_singles(spatial);
    if (spatial.size() > 3) {
      fail(header_.kinds.empty() ? "dimension" : "kinds",
           fmt::format(
               "a volume of 3 axes, or a kind list or time of the fourth (say which is which with "
               "--axes, such as xyzt)"),
           fmt::format("{} axes, {}", spatial.size(), fmt::join(header_.sizes, " x ")));
    }
    for (std::size_t i = 0; i < spatial.size(); ++i) letters[spatial[i]] = "xyz"[i];
    return letters;
  }

  /// One per axis.
  std::vector<double> spacings() const {
    if (header_.directions.empty()) return header_.spacings;
    std::vector<double> lengths;
    for (const std::vector<double>& direction : header_.directions) {
      double squares = 0;
      for (const double part : direction) squares = std::hypot(squares, part);
      if (std::isinf(squares)) fail("space directions", "finite vectors", "a longer one");
      lengths.push_back(std::isnan(squares) || squares == 0 ? 1 : squares);
    }
    return lengths;
  }

  /// One per axis: the coordinate of the first voxel.
  std::vector<double> offsets() const {
    std::vector<double> offsets(header_.sizes.size(), 0.0);
    if (header_.space_origin.empty()) return offsets;
    const std::vector<double>& origin = header_.space_origin;
    const std::vector<std::optional<std::size_t>> aligned = space_axes();
    for (std::size_t axis = 0, next = 0; axis < offsets.size(); ++axis) {
      if (is_none(axis)) continue;
      const std::size_t coordinate = aligned.empty() ? next : *aligned[axis];
      ++next;
      if (coordinate < origin.size() && !std::isnan(origin[coordinate]))
        offsets[axis] = origin[coordinate];
    }
    return offsets;
  }

  std::string unit(const StoredAxes& axes) const {
    std::vector<std::string> units = header_.space_units;
    const char* field = "space units";
    if (units.empty() && !header_.units.empty()) {
      field = "units";
      for (const auto& axis : axes.axis)
        if (axis) units.push_back(header_.units[*axis]);
    }
    if (units.empty()) return "";
    if (header_.space_dimension == 4 && field[0] == 's' && units.size() == 4)
      units.pop_back();  // that of the time
    for (const std::string& unit : units) {
      if (unit != units[0])
        fail(field, "the same unit on all axes", fmt::format("\"{}\"", fmt::join(units, "\" \"")));
    }
    return units[0] == "???" ? "" : units[0];
  }

  /// Fields of which each axis can have only one.
  void check_pairs() const {
    if (!header_.spacings.empty() && !header_.directions.empty())
      fail("space directions", "either spacings or space directions",
           fmt::format("both (spacings are in {})", header_.line_of("spacings")));
    if (!header_.space_origin.empty() && header_.directions.empty())
      fail("space origin", "space directions with the space origin", "none");
    const std::size_t spatial =
        header_.sizes.size() - static_cast<std::size_t>(std::ranges::count_if(
                                   header_.directions, [](const auto& d) { return d.empty(); }));
    if (!header_.directions.empty() && spatial > header_.space_dimension.value_or(spatial)) {
      fail("space directions",
           fmt::format("at most {} axes of the space, the others none", *header_.space_dimension),
           fmt::format("{}", spatial));
    }
  }

 private:
  [[noreturn]] void fail(const std::string& field, std::string_view expected,
                         std::string_view found) const {
    throw_input_error(file_, header_.line_of(field), expected, found);
  }

  bool is_none(std::size_t axis) const {
    return !header_.directions.empty() && header_.directions[axis].empty();
  }

  std::string kind_of(std::size_t axis) const {
    if (!header_.kinds.empty() && !says_nothing(header_.kinds[axis])) return header_.kinds[axis];
    return is_none(axis) ? "list" : "???";  // an axis without a direction does not lie in space
  }

  void check_kind(std::size_t axis, const std::string& kind) const {
    const auto samples = samples_of_kind(kind);
    if (!samples)
      fail("kinds", "a kind that the format defines, such as domain, space, time or list",
           fmt::format("'{}'", kind));
    if (*samples > 1 && header_.sizes[axis] == *samples) {
      fail("kinds",
           "domain or space, or another kind of length 1, since a volume has one value per voxel",
           fmt::format("axis {} of kind {}, {} values per voxel", axis + 1, header_.kinds[axis],
                       *samples));
    }
    // Colours and vectors of one sample are written by programs that keep the kind when they cut an
    // axis.
    if (*samples != 0 && header_.sizes[axis] != *samples && header_.sizes[axis] != 1) {
      fail("kinds",
           fmt::format("{} samples along axis {}, as its kind {} says", *samples, axis + 1, kind),
           fmt::format("{}", header_.sizes[axis]));
    }
  }

  /// Leaves out axes of length 1 of no known kind, from the slowest, until three are left.
  void drop_singles(std::vector<std::size_t>& spatial) const {
    for (std::size_t i = spatial.size(); i-- > 0 && spatial.size() > 3;) {
      if (header_.sizes[spatial[i]] == 1)
        spatial.erase(spatial.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  /// The axis of the space along which each axis runs; empty where one is oblique or two run along
  /// the same.
  std::vector<std::optional<std::size_t>> space_axes() const {
    constexpr double kStraight = 1e-6;  // of the length; what single precision leaves of a zero
    std::vector<std::optional<std::size_t>> axes;
    for (const std::vector<double>& direction : header_.directions) {
      std::optional<std::size_t> along;
      double length = 0;
      for (const double part : direction) length = std::hypot(length, part);
      for (std::size_t i = 0; i < direction.size(); ++i) {
        if (!(std::fabs(direction[i]) > kStraight * length)) continue;
        if (along) return {};
        along = i;
      }
      if (!direction.empty() && (!along || std::ranges::find(axes, along) != axes.end())) return {};
      axes.push_back(along);
    }
    return axes;
  }

  const std::string& file_;
  const NrrdHeader& header_;
};

}  // namespace

NrrdGeometry nrrd_geometry(const std::string& file, const NrrdHeader& header, VoxelType type,
                           const OpenOptions& options) {
  const Geometry geometry(file, header);
  geometry.check_pairs();
  const std::string position = header.line_of("sizes");
  const std::string letters =
      options.axes.empty() ? geometry.letters() : letters_of(file, position, header.sizes, options);
  NrrdGeometry result{.axes = resolve_axes(file, position, header.sizes, letters, type)};
  result.voxel_size = along_xyz(result.axes, geometry.spacings(), 1);
  result.offset = along_xyz(result.axes, geometry.offsets(), 0);
  result.voxel_unit = geometry.unit(result.axes);
  return result;
}

}  // namespace cvr::volumes
