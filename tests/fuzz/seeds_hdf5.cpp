#include "tests/fuzz/seeds_hdf5.hpp"

#include <hdf5.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace cvr::fuzz {

namespace {

constexpr hsize_t kSides[] = {3, 4, 5, 1, 1};  ///< slowest first

void write_attributes(hid_t dataset, bool variable_length) {
  const hsize_t three = 3;
  const double sizes[] = {40, 4, 4};
  const hid_t vector = H5Screate_simple(1, &three, nullptr), scalar = H5Screate(H5S_SCALAR),
              text = H5Tcopy(H5T_C_S1);
  for (const char* name : {"voxel_size", "resolution", "offset"}) {
    const hid_t attribute =
        H5Acreate2(dataset, name, H5T_IEEE_F64LE, vector, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, sizes);
    H5Aclose(attribute);
  }
  H5Tset_size(text, variable_length ? H5T_VARIABLE : 6);
  const hid_t attribute = H5Acreate2(dataset, "kind", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
  const char* kind = "labels";
  H5Awrite(attribute, text, variable_length ? static_cast<const void*>(&kind) : kind);
  H5Aclose(attribute);
  H5Tclose(text);
  H5Sclose(scalar);
  H5Sclose(vector);
}

}  // namespace

void write_hdf5_seed(const std::string& path, const Hdf5Seed& seed) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (seed.latest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const hid_t space = H5Screate_simple(seed.rank, kSides, nullptr),
              create = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(create, false);  // the same bytes in every run
  if (seed.layout == Hdf5Seed::kCompact) H5Pset_layout(create, H5D_COMPACT);
  if (seed.layout == Hdf5Seed::kChunked) {
    const hsize_t chunk[] = {2, 4, 3, 1, 1};
    H5Pset_chunk(create, seed.rank, chunk);
    H5Pset_shuffle(create);
    H5Pset_deflate(create, 4);
  }
  const hid_t types[] = {H5T_STD_U8LE,  H5T_STD_U32LE,  H5T_STD_I64LE,
                         H5T_STD_U16BE, H5T_IEEE_F32LE, H5T_IEEE_F64LE};
  const hid_t dataset = H5Dcreate2(file, "labels", types[seed.type % std::size(types)], space,
                                   H5P_DEFAULT, create, H5P_DEFAULT);
  std::vector<std::uint8_t> voxels(H5Sget_simple_extent_npoints(space));
  std::iota(voxels.begin(), voxels.end(), std::uint8_t{0});
  H5Dwrite(dataset, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, voxels.data());
  if (seed.attributes) write_attributes(dataset, seed.variable_length);
  H5Dclose(dataset);
  H5Pclose(create);
  H5Sclose(space);
  H5Fclose(file);
  H5Pclose(access);
}

}  // namespace cvr::fuzz
