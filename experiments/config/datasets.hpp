// What is measured on: the catalogue of data sets (configs/datasets/*.yaml, keys explained in
// paper.yaml there), and where their voxels are on this machine.
//
// A data set has a file, a generator, or a file with a generator that stands in for it where the
// file is absent. Its identity is known without its voxels: of a file the hash of its bytes; of a
// generated volume kind, extent, seed and parameters plus the hash of two small boxes, so that a
// retuned generator never passes for the old one. Cell ids and cached copies are named by it.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/source.hpp"

namespace cvr::experiments {

inline constexpr std::string_view kDataVariable =
    "${CVRBENCH_DATA}";  ///< stands for Places::data at the beginning of Dataset::file

struct GeneratorChoice {
  std::string kind;
  std::uint64_t seed = 1;
  std::map<std::string, double> parameters;
};

struct Dataset {
  std::string name, title, citation, licence, origin;
  volumes::VolumeKind kind = volumes::VolumeKind::kLabels;
  volumes::VoxelType type = volumes::VoxelType::kU8;
  volumes::Extent full_extent;  ///< of the original; of a series of one time step
  volumes::Extent
      extent;  ///< full_extent unless the configuration names another; times scale = generated_extent()
  std::uint64_t time_steps = 1;
  std::uint64_t labels = 0;
  std::string file;  ///< empty if only generated; may begin with ${CVRBENCH_DATA}
  std::optional<std::array<double, 3>> voxel_size;  ///< along x, y, z, where the volume says none
  std::string voxel_unit;                           ///< of voxel_size; empty: ratios alone count
  std::string package;                              ///< the Debian package that the file comes from
  std::string hash;  ///< XXH3-64 of the file, 16 hexadecimal digits; empty when unknown
  std::optional<GeneratorChoice> generator;
  std::string stand_in_for;           ///< the data set that the generated volume stands in for
  double scale = 1;                   ///< edge of the generated volume / edge in full
  std::uint32_t bytes_per_voxel = 0;  ///< of the published accounting; 0: that of the stored type
  bool exchange_axes =
      false;         ///< read the voxels as if x and z were exchanged, a mistake made on purpose
  std::string axes;  ///< of the file, as volumes::OpenOptions has them; empty: as the file says
  bool allow_external = false;  ///< read files that the volume names outside its own folder

  /// max(1, round(extent * scale)).
  volumes::Extent generated_extent() const;
};

/// The file of "FILE.h5:/path[T]" and the like.
std::string file_of_volume(const std::string& volume_path);
/// What tables call a volume without a description: the name of its file without folder and endings,
/// in letters that fit into file names.
std::string name_of_file(const std::string& volume_path);

/// Whether a text names axes in an order: x, y and z, perhaps t and c, each once.
bool are_axes(const std::string& text);
inline constexpr const char* kAxesExplained =
    "the letters x, y, z and where there are such axes t and c, each once, for instance zyx";

/// Whether an extent and what lies on top of it has more voxels than kMostVoxels, without overflow.
bool is_too_large(const volumes::Extent& extent, std::uint64_t time_steps = 1);
inline constexpr std::uint64_t kMostVoxels = std::uint64_t{1} << 48;

class Catalogue {
 public:
  /// Reads every .yaml of a folder, in the order of the names. Throws InputError.
  static Catalogue from_folder(const std::string& folder);
  /// Adds the descriptions of one file.
  void add_file(const std::string& path);
  const Dataset* find(const std::string& name) const;
  const std::vector<Dataset>& all() const { return datasets_; }
  std::vector<std::string> names() const;

 private:
  std::vector<Dataset> datasets_;
};

/// Folders of this machine.
struct Places {
  std::string data;   ///< replaces ${CVRBENCH_DATA}; empty if not named
  std::string cache;  ///< raw copies of data sets
};

/// Where the voxels of a data set are. Plain facts: a worker process receives them as text.
struct Location {
  bool present = false;
  std::string missing;  ///< the reason if not present
  std::string path;     ///< volume file; empty: generated
  std::string axes;     ///< of the file, as the data set has them
  bool allow_external = false;
  std::optional<GeneratorChoice> generator;
  volumes::VolumeInfo info;
  bool exchanged =
      false;  ///< info.extent is (Z, Y, X) of the source; the voxels lie in memory as before
  std::string identity;  ///< 16 hexadecimal digits
  std::string
      label;  ///< "stand-in for CELLS, 300x300x300 of 1000x1000x1000" (its title up to the first colon or comma), "generated" or ""
};

/// Never throws for data that is absent or differs from its description: that is a reason. Throws
/// InputError for a generator's bad parameters: that is the configuration's fault.
Location locate(const Dataset& dataset, const Places& places);

std::unique_ptr<volumes::VolumeSource> open_location(const Location& location, unsigned threads);

}  // namespace cvr::experiments
