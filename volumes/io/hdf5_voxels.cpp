#include "volumes/io/hdf5_voxels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kTile = 16;  ///< voxels along each axis where the file's order is not ours

struct Target {
  std::string file, position;

  [[noreturn]] void refuse(std::string_view expected, const std::string& value,
                           const Coordinate& at) const {
    throw_input_error(file, position, expected,
                      fmt::format("{} at voxel ({}, {}, {})", value, at.x, at.y, at.z));
  }
};

template <class Stored>
constexpr std::uint64_t largest_exact() {
  return std::uint64_t{1} << std::numeric_limits<Stored>::digits;
}

template <class Stored, class Out>
Out converted(const Target& target, Stored value, const Coordinate& at) {
  if constexpr (std::is_same_v<Stored, Out>) {
    return value;
  } else if constexpr (std::is_floating_point_v<Stored>) {
    constexpr std::uint64_t kLargest = largest_exact<Stored>();
    const bool exact =
        value >= 0 && value <= static_cast<Stored>(kLargest) && std::trunc(value) == value;
    if (!exact) {
      target.refuse(
          fmt::format("labels as whole numbers from 0 to {}, since they are stored as float{}",
                      kLargest, 8 * sizeof(Stored)),
          fmt::format("{}", value), at);
    }
    return static_cast<Out>(value);
  } else {
    if (value < 0) target.refuse("labels, which are not negative", fmt::format("{}", value), at);
    return static_cast<Out>(value);
  }
}

template <class Stored, class Out>
class Placement {
 public:
  Placement(const Target& target, const Hdf5Part& part, const Box& whole, std::byte* out)
      : target_(target), part_(part), whole_(whole), out_(out) {}

  void place() const {
    const Extent& size = part_.box.size;
    if (part_.strides[0] == 1) return place_tile({0, 0, 0}, size);
    for (std::uint64_t z = 0; z < size.z; z += kTile) {
      for (std::uint64_t y = 0; y < size.y; y += kTile) {
        for (std::uint64_t x = 0; x < size.x; x += kTile) {
          place_tile({x, y, z}, {std::min(x + kTile, size.x), std::min(y + kTile, size.y),
                                 std::min(z + kTile, size.z)});
        }
      }
    }
  }

 private:
  void place_tile(const Coordinate& first, const Extent& end) const {
    for (std::uint64_t z = first.z; z < end.z; ++z) {
      for (std::uint64_t y = first.y; y < end.y; ++y) place_row(first.x, end.x, y, z);
    }
  }

  void place_row(std::uint64_t first, std::uint64_t end, std::uint64_t y, std::uint64_t z) const {
    const Coordinate& origin = part_.box.origin;
    const std::uint64_t from =
        part_.strides[0] * first + part_.strides[1] * y + part_.strides[2] * z;
    const std::uint64_t to =
        whole_.size.index({origin.x - whole_.origin.x + first, origin.y - whole_.origin.y + y,
                           origin.z - whole_.origin.z + z});
    const std::byte* in = part_.stored + from * sizeof(Stored);
    std::byte* out = out_ + to * sizeof(Out);
    if (std::is_same_v<Stored, Out> && part_.strides[0] == 1) {
      std::memcpy(out, in, (end - first) * sizeof(Out));
      return;
    }
    for (std::uint64_t x = first; x < end; ++x) {
      Stored value;
      std::memcpy(&value, in, sizeof value);
      const Out label =
          converted<Stored, Out>(target_, value, {origin.x + x, origin.y + y, origin.z + z});
      std::memcpy(out, &label, sizeof label);
      in += part_.strides[0] * sizeof(Stored);
      out += sizeof(Out);
    }
  }

  const Target& target_;
  const Hdf5Part& part_;
  const Box& whole_;
  std::byte* out_;
};

}  // namespace

void place_hdf5_part(const std::string& file, const std::string& position,
                     const Hdf5Conversion& conversion, const Hdf5Part& part, const Box& whole,
                     std::byte* out) {
  const Target target{file, position};
  const auto place = [&]<class Stored, class Out>(Stored, Out) {
    Placement<Stored, Out>(target, part, whole, out).place();
  };
  const bool labels = is_label_type(conversion.type);
  if (conversion.is_float && conversion.width == 8) return place(double{}, std::uint64_t{});
  if (conversion.is_float)
    return labels ? place(float{}, std::uint32_t{}) : place(float{}, float{});
  switch (conversion.width) {
    case 1:
      return conversion.is_signed ? place(std::int8_t{}, std::uint8_t{})
                                  : place(std::uint8_t{}, std::uint8_t{});
    case 2:
      if (!conversion.is_signed) return place(std::uint16_t{}, std::uint16_t{});
      return labels ? place(std::int16_t{}, std::uint16_t{})
                    : place(std::int16_t{}, std::int16_t{});
    case 4:
      return conversion.is_signed ? place(std::int32_t{}, std::uint32_t{})
                                  : place(std::uint32_t{}, std::uint32_t{});
    default:
      return conversion.is_signed ? place(std::int64_t{}, std::uint64_t{})
                                  : place(std::uint64_t{}, std::uint64_t{});
  }
}

}  // namespace cvr::volumes
