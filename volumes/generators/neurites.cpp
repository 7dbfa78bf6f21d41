// neurites: tortuous processes of very different calibres, interleaved and dense, as in a
// segmentation of brain tissue from electron microscopy. A stand-in for H01 of the CSGV-R paper.
//
// Eight families of tubes, each with a direction and a calibre of its own, thin ones being common,
// compete for every voxel. In the plane across its direction a family is a jittered grid of tube
// centres; the two coordinates of that plane are warped by value noise at three scales, which makes
// the tubes tortuous. A tube's claim on a voxel is its squared distance in units of its own radius;
// the smallest claim of all families wins, so thin processes squeeze through between thick ones.
// Claims above `gap` lose to the background, label 0: the extracellular space and membranes where
// no process is near. Each z slice is shifted by up to `slip` voxels, as sections of tissue are.
//
// Tubes are cut into pieces along their length, each a label. Ids are hashed into 1 .. `ids`, as a
// crop of a larger volume has them: not consecutive, and without any order in space; two pieces
// share one now and then.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "volumes/generators/kinds.hpp"
#include "volumes/generators/noise.hpp"
#include "volumes/generators/random.hpp"

namespace cvr::volumes {

namespace {

constexpr std::array kParameters{
    GeneratorParameter{"calibre", 72, 4, 200,
                       "distance of neighbouring tubes of the middle family in voxels"},
    GeneratorParameter{"tortuosity", 1, 0, 4, "factor on the amplitude of the warp"},
    GeneratorParameter{"roughness", 2.5, 0, 8, "amplitude of the finest warp in voxels"},
    GeneratorParameter{"gap", 0.16, 0.01, 10, "claim above which a voxel is background"},
    GeneratorParameter{"slip", 0.6, 0, 8, "largest shift of a slice in voxels"},
    GeneratorParameter{"length", 600, 50, 1e6, "of a tube in voxels"},
    GeneratorParameter{"ids", 1296889, 1, 4294967295.0, "largest label", true},
};

constexpr Extent kTile{128, 32, 32};
constexpr std::array<float, 8> kCalibres{0.7F, 0.75F, 0.85F, 0.95F, 1.1F, 1.4F, 2.0F, 3.6F};
constexpr std::array<std::uint32_t, 3> kWarpSpacing{192, 56, 7};
constexpr float kJitter = 0.7F;

using Vector = std::array<double, 3>;

struct Family {
  std::array<float, 3> u, v, w;  ///< an orthonormal frame; tubes run along w
  float spacing;                 ///< of the grid of tubes in voxels
  std::vector<ValueNoise> warp_u, warp_v;
  std::array<float, 3> amplitude;  ///< of the warp at each scale in voxels
  float total_amplitude;
  std::uint64_t seed;
};

struct Tube {
  float u, v;       ///< centre in the family's plane
  float sharpness;  ///< 1 / radius^2
  std::int64_t column, row;
};

/// The tubes of a family that a tile can meet, by grid position.
struct TubeTable {
  std::int64_t column0, row0, columns;
  std::vector<Tube> tubes;
};

/// A random direction and two more that make an orthonormal frame.
std::array<Vector, 3> random_frame(RandomSequence& random) {
  std::array<Vector, 3> frame{};
  for (std::size_t i = 0; i < 3; ++i) {
    double length = 0;
    while (length < 0.1) {
      for (double& c : frame[i]) c = random.between(-1, 1);
      for (std::size_t j = 0; j < i; ++j) {
        const double along =
            frame[i][0] * frame[j][0] + frame[i][1] * frame[j][1] + frame[i][2] * frame[j][2];
        for (std::size_t k = 0; k < 3; ++k) frame[i][k] -= along * frame[j][k];
      }
      length = std::sqrt(frame[i][0] * frame[i][0] + frame[i][1] * frame[i][1] +
                         frame[i][2] * frame[i][2]);
      if (length > 1.0) length = 0;
    }
    for (double& c : frame[i]) c /= length;
  }
  return frame;
}

class NeuritesSource final : public TiledSource {
 public:
  explicit NeuritesSource(const GeneratorRequest& request);

 protected:
  void fill(const Box& box, std::uint32_t* labels) const override;

 private:
  struct Row;
  TubeTable tubes_near(const Family& family, const Box& box) const;
  Tube tube(const Family& family, std::int64_t column, std::int64_t row) const;
  void compete(std::size_t number, const TubeTable& table, const Coordinate& start, Row& row) const;
  std::uint32_t label(std::size_t family, const Tube& tube, float along) const;

  std::uint64_t seed_;
  std::vector<Family> families_;
  float gap_, slip_;
  double length_;
  std::uint64_t ids_;
};

/// One row of voxels on its way through the families.
struct NeuritesSource::Row {
  explicit Row(std::size_t count)
      : count(count), u(count), v(count), claim(count), family(count), tube(count) {}
  std::size_t count;
  std::vector<float> u, v, claim;
  std::vector<std::uint32_t> family, tube;  ///< of the smallest claim so far
  float shift_x = 0, shift_y = 0;
};

NeuritesSource::NeuritesSource(const GeneratorRequest& request)
    : TiledSource(request, VoxelType::kU32, kTile),
      seed_(mix64(request.seed ^ 0x4E04)),
      gap_(static_cast<float>(request["gap"])),
      slip_(static_cast<float>(request["slip"])),
      length_(request["length"]),
      ids_(static_cast<std::uint64_t>(request["ids"])) {
  const auto tortuosity = static_cast<float>(request["tortuosity"]);
  for (std::size_t f = 0; f < kCalibres.size(); ++f) {
    Family family;
    family.seed = hash(seed_, static_cast<std::int64_t>(f));
    RandomSequence random(family.seed);
    const auto frame = random_frame(random);
    for (std::size_t k = 0; k < 3; ++k) {
      family.w[k] = static_cast<float>(frame[0][k]);
      family.u[k] = static_cast<float>(frame[1][k]);
      family.v[k] = static_cast<float>(frame[2][k]);
    }
    family.spacing = kCalibres[f] * static_cast<float>(request["calibre"]);
    family.amplitude = {48 * tortuosity, 12 * tortuosity, static_cast<float>(request["roughness"])};
    family.total_amplitude = family.amplitude[0] + family.amplitude[1] + family.amplitude[2];
    for (std::size_t scale = 0; scale < kWarpSpacing.size(); ++scale) {
      family.warp_u.emplace_back(random.next(), kWarpSpacing[scale]);
      family.warp_v.emplace_back(random.next(), kWarpSpacing[scale]);
    }
    families_.push_back(std::move(family));
  }
}

Tube NeuritesSource::tube(const Family& family, std::int64_t column, std::int64_t row) const {
  const std::uint64_t random = hash(family.seed, column, row, 1);
  const auto part = [&](unsigned shift) {
    return static_cast<float>(random >> shift & 0xFFFF) * 0x1p-16F;
  };
  Tube tube{.column = column, .row = row};
  tube.u = (static_cast<float>(column) + 0.5F + kJitter * (part(0) - 0.5F)) * family.spacing;
  tube.v = (static_cast<float>(row) + 0.5F + kJitter * (part(16) - 0.5F)) * family.spacing;
  const float size = part(32);
  const float radius = family.spacing * (0.7F + 0.6F * size * size);
  tube.sharpness = 1.0F / (radius * radius);
  return tube;
}

TubeTable NeuritesSource::tubes_near(const Family& family, const Box& box) const {
  const auto range = [&](const std::array<float, 3>& axis, std::int64_t& first,
                         std::int64_t& count) {
    double low = 0, high = 0;
    const std::array<std::uint64_t, 3> origin{box.origin.x, box.origin.y, box.origin.z};
    const std::array<std::uint64_t, 3> size{box.size.x, box.size.y, box.size.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = static_cast<double>(axis[k]) * static_cast<double>(origin[k]);
      const double b = static_cast<double>(axis[k]) * static_cast<double>(origin[k] + size[k]);
      low += std::min(a, b);
      high += std::max(a, b);
    }
    const double spread = static_cast<double>(family.total_amplitude + 2 * slip_ + 1),
                 spacing = static_cast<double>(family.spacing);
    first = static_cast<std::int64_t>(std::floor((low - spread) / spacing)) - 1;
    count = static_cast<std::int64_t>(std::floor((high + spread) / spacing)) + 2 - first;
  };
  TubeTable table;
  std::int64_t rows = 0;
  range(family.u, table.column0, table.columns);
  range(family.v, table.row0, rows);
  for (std::int64_t row = 0; row < rows; ++row) {
    for (std::int64_t column = 0; column < table.columns; ++column) {
      table.tubes.push_back(tube(family, table.column0 + column, table.row0 + row));
    }
  }
  return table;
}

/// Lets one family claim the voxels of a row: the four tubes whose grid boxes are nearest to the
/// voxel.
void NeuritesSource::compete(std::size_t number, const TubeTable& table, const Coordinate& start,
                             Row& row) const {
  const Family& family = families_[number];
  const float y = static_cast<float>(start.y) + row.shift_y, z = static_cast<float>(start.z);
  const float base_u = family.u[1] * y + family.u[2] * z,
              base_v = family.v[1] * y + family.v[2] * z;
  for (std::size_t i = 0; i < row.count; ++i) {
    const float x = static_cast<float>(start.x + i) + row.shift_x;
    row.u[i] = base_u + family.u[0] * x;
    row.v[i] = base_v + family.v[0] * x;
  }
  const auto x0 = static_cast<std::int64_t>(start.x), y0 = static_cast<std::int64_t>(start.y),
             z0 = static_cast<std::int64_t>(start.z);
  for (std::size_t scale = 0; scale < kWarpSpacing.size(); ++scale) {
    family.warp_u[scale].add_row(x0, row.count, y0, z0, family.amplitude[scale], row.u.data());
    family.warp_v[scale].add_row(x0, row.count, y0, z0, family.amplitude[scale], row.v.data());
  }
  const float per_box = 1.0F / family.spacing;
  const auto columns = static_cast<std::int32_t>(table.columns);
  const auto column0 = static_cast<std::int32_t>(table.column0),
             row0 = static_cast<std::int32_t>(table.row0);
  const auto rounded_down = [](float value) {
    const auto truncated = static_cast<std::int32_t>(value);
    return truncated - static_cast<std::int32_t>(static_cast<float>(truncated) > value);
  };
  const Tube* tubes = table.tubes.data();
  for (std::size_t i = 0; i < row.count; ++i) {
    const float u = row.u[i], v = row.v[i];
    // Minus one half: from the own grid box to the nearer one of its two neighbours along each
    // axis.
    const std::int32_t column = rounded_down(u * per_box - 0.5F) - column0;
    const std::int32_t line = rounded_down(v * per_box - 0.5F) - row0;
    const std::int32_t first = column + columns * line;
    float best = row.claim[i];
    std::int32_t winner = -1;
    for (const std::int32_t candidate : {first, first + 1, first + columns, first + columns + 1}) {
      const Tube& t = tubes[candidate];
      const float du = u - t.u, dv = v - t.v;
      const float claim = (du * du + dv * dv) * t.sharpness;
      winner = claim < best ? candidate : winner;
      best = claim < best ? claim : best;
    }
    row.claim[i] = best;
    row.family[i] = winner >= 0 ? static_cast<std::uint32_t>(number) : row.family[i];
    row.tube[i] = winner >= 0 ? static_cast<std::uint32_t>(winner) : row.tube[i];
  }
}

std::uint32_t NeuritesSource::label(std::size_t family, const Tube& tube, float along) const {
  const std::uint64_t own = hash(families_[family].seed, tube.column, tube.row, 2);
  const double offset = static_cast<double>(unit_float(own)) * length_;
  const auto piece =
      static_cast<std::int64_t>(std::floor((static_cast<double>(along) + offset) / length_));
  return static_cast<std::uint32_t>(1 + hash(own, piece) % ids_);
}

void NeuritesSource::fill(const Box& box, std::uint32_t* labels) const {
  std::vector<TubeTable> tables;
  for (const Family& family : families_) tables.push_back(tubes_near(family, box));
  Row row(box.size.x);
  for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z; ++z) {
    RandomSequence slice(hash(seed_, 0x511, static_cast<std::int64_t>(z)));
    row.shift_x = slip_ * static_cast<float>(slice.between(-1, 1));
    row.shift_y = slip_ * static_cast<float>(slice.between(-1, 1));
    for (std::uint64_t y = box.origin.y; y < box.origin.y + box.size.y; ++y, labels += box.size.x) {
      std::fill(row.claim.begin(), row.claim.end(), gap_);
      std::fill(row.family.begin(), row.family.end(), std::numeric_limits<std::uint32_t>::max());
      for (std::size_t f = 0; f < families_.size(); ++f)
        compete(f, tables[f], {box.origin.x, y, z}, row);
      // A label changes along a tube only at a cut, so a run of one tube asks for its label where
      // `along` enters another piece; asking once a voxel keeps it simple and costs little beside
      // the competition.
      for (std::size_t i = 0; i < box.size.x; ++i) {
        if (row.family[i] == std::numeric_limits<std::uint32_t>::max()) {
          labels[i] = 0;
          continue;
        }
        const Family& family = families_[row.family[i]];
        const Tube& tube = tables[row.family[i]].tubes[row.tube[i]];
        const float along = family.w[0] * static_cast<float>(box.origin.x + i) +
                            family.w[1] * static_cast<float>(y) +
                            family.w[2] * static_cast<float>(z);
        labels[i] = label(row.family[i], tube, along);
      }
    }
  }
}

}  // namespace

constinit const GeneratorInfo kNeuritesInfo{
    .kind = "neurites",
    .summary = "tortuous interleaved processes of very different calibres; stands in for H01",
    .volume_kind = VolumeKind::kLabels,
    .default_extent = {256, 240, 224},
    .paper_extent = {5120, 6144, 6144},
    .parameters = kParameters,
};

std::unique_ptr<VolumeSource> make_neurites(const GeneratorRequest& request) {
  return std::make_unique<NeuritesSource>(request);
}

}  // namespace cvr::volumes
