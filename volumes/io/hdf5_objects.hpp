// What lies in an HDF5 file and where its links lead. To be called in the child process of
// Hdf5Process alone.
//
// The library would follow soft and external links by itself; here each link of a path is looked at
// first, so that no file outside the volume's own folder is opened without permission, and no pipe
// or device ever.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

/// Which files may be read for a volume, and which have been asked for.
class Hdf5Bounds {
 public:
  Hdf5Bounds(std::string file, bool allow_external);

  /// The path of `target`, a file that `what` in `from` names; relative names start at the folder
  /// of `from`. Throws InputError if it lies outside the volume's own folder without permission, or
  /// is missing or no regular file.
  std::string admit(const std::string& from, const std::string& what, const std::string& target);

  const std::string& file() const { return file_; }
  bool allow_external() const { return allow_external_; }
  /// The volume's own file first, each once.
  const std::vector<std::string>& files() const { return files_; }

 private:
  std::string file_;
  std::filesystem::path folder_;
  bool allow_external_;
  std::vector<std::string> files_;
};

/// Opens without file locks, which some network file systems refuse. Throws InputError.
Hdf5Handle open_hdf5_file(const std::string& path, unsigned flags);

/// A dataset reached by hard links alone.
struct Hdf5Dataset {
  std::string file;  ///< that it lies in
  std::string name;  ///< absolute path in that file
  Hdf5Handle file_id, dataset_id;

  std::string position() const;
};

/// Follows `name` from the root of `file`. Throws InputError: for a missing dataset with the list
/// of those there are.
Hdf5Dataset open_hdf5_dataset(Hdf5Bounds& bounds, const std::string& file, const std::string& name);

struct Hdf5Entry {
  std::string name;   ///< absolute path
  std::string shape;  ///< "7x5x3"
  std::string type;
  int rank = 0;
  bool voxels = false;  ///< rank 3 to 5 of a type that voxels may have
};

struct Hdf5Content {
  std::vector<Hdf5Entry> datasets;  ///< in the order of their names, each object once
  std::vector<std::string>
      links;  ///< "'/x' -> 'OTHER.h5:/y'": external links, which are not followed
  std::vector<std::string> groups;
};

Hdf5Content list_hdf5(hid_t file);
/// "/a (rank 2, 7x5, i16), /b (...)", or "no dataset".
std::string to_string(const Hdf5Content& content);

/// "u8", "i32", "f32", "f64 (float64)", "a compound of r, g, b", ...
std::string hdf5_type_name(hid_t type);

/// How voxels of a stored type are read.
struct Hdf5Stored {
  std::string name;       ///< of the type, for messages
  bool is_float = false;  ///< widths 4 and 8
  bool is_signed = false;
  unsigned width = 0;  ///< 1, 2, 4 or 8 bytes in memory; 0: no type of voxels
};

/// Enumerations (as h5py stores truth values) count as their integers, odd widths as the next wider
/// one.
Hdf5Stored hdf5_stored(hid_t type);
/// The type in memory.
hid_t hdf5_memory_type(const Hdf5Stored& stored);

/// Slowest axis first.
std::vector<hsize_t> hdf5_size(hid_t dataset);

}  // namespace cvr::volumes
