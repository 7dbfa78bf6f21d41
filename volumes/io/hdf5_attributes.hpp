// Attributes of HDF5 volumes: read as plain values in the child process, understood in this one.
//
// Ours, on the dataset: `voxel_size` and `offset` (three numbers, z y x), `voxel_unit`, `kind`
// ("labels" or "scalars"), `axes` ("zyx", "tzyx"), `name`, `source`, `licence`. A dataset that
// lacks them takes those of the file's root. Other people's:
//   resolution, offset  three numbers, z y x, in nm (CREMI and the tools around it)
//   element_size_um     z y x in micrometres, or one number for each axis of the dataset (Fiji, PlantSeg)
//   axistags            JSON of vigra and ilastik: the key and the resolution of each axis, slowest first
//   axes                letters or a list of names; DIMENSION_LABELS, the names that the dimension scales hold
// An attribute of one of these names with another type, length or value belongs to somebody else
// and is passed over.
#pragma once

#include <hdf5.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volumes/source.hpp"

namespace cvr::volumes {

/// The attributes that mean something here, as {name: value}: text, a number, or a list of either;
/// what is none of these is left out. Texts of variable length crash the library where a file is
/// damaged: for the child process alone.
nlohmann::json read_hdf5_attributes(hid_t object);

class Hdf5Attributes {
 public:
  Hdf5Attributes() = default;
  explicit Hdf5Attributes(nlohmann::json values) : values_(std::move(values)) {}

  /// One text in UTF-8, control characters as spaces.
  std::optional<std::string> text(const char* name) const;
  /// Several texts.
  std::optional<std::vector<std::string>> texts(const char* name) const;
  /// Exactly `count` finite numbers.
  std::optional<std::vector<double>> numbers(const char* name, std::size_t count) const;
  /// Three numbers z y x as x y z; `positive`: all above 0.
  std::optional<std::array<double, 3>> triple(const char* name, bool positive) const;
  std::optional<VolumeKind> kind() const;
  /// Written by this project: a kind and a voxel size that can only be ours.
  bool ours() const { return kind() && triple("voxel_size", true); }

 private:
  nlohmann::json values_ = nlohmann::json::object();
};

/// One axis of a stored array: what it is ('x', 'y', 'z', 't', 'c', or a name that is none of
/// these) and its resolution, 0 where unknown.
struct Hdf5Axis {
  std::string name;
  double resolution = 0;
};

/// The axes that `axistags` states; nothing where the text is not vigra's.
std::optional<std::vector<Hdf5Axis>> hdf5_axistags(const std::string& text);

/// Voxel size, unit, offset, kind and provenance.
struct Hdf5Meaning {
  std::array<double, 3> voxel_size{1, 1, 1};
  std::array<double, 3> offset{0, 0, 0};
  std::string voxel_unit;
  std::optional<VolumeKind> kind;
  Provenance provenance;
};

/// `axis` holds the place of x, y and z among the axes of the dataset of the given rank, -1 where
/// there is none.
Hdf5Meaning understand_hdf5(const Hdf5Attributes& dataset, const Hdf5Attributes& root,
                            std::size_t rank, const std::array<int, 3>& axis);

}  // namespace cvr::volumes
