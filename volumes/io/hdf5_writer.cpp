// HDF5 volumes as this project writes them: one dataset `/labels` or `/scalars` (or the name given), axes z y
// x (series: t z y x), chunks of at most 64 a side and one step, gzip level 4 without shuffle, the attributes that hdf5_reader.cpp names,
// and no time stamps, so that equal volumes give equal files. Voxels are drawn in boxes of X * 64 * 64, never
// a whole layer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kChunk = 64;
constexpr unsigned kGzipLevel = 4;

class Hdf5Writer {
 public:
  Hdf5Writer(const OutputFile& output, const std::string& dataset, const VolumeSource& source)
      : path_(output.path()), source_(source), info_(source.info()) {
    file_ = {H5Fcreate(output.partial_path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose};
    check(file_.get());
    create_dataset(dataset);
    for (const hid_t object : {file_.get(), dataset_.get()}) write_attributes(object);
  }

  void write_voxels() {
    for (std::uint64_t step = 0; step < info_.time_steps; ++step) write_step(step);
  }

  void close() {
    dataset_.reset();
    check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
    file_.reset();
  }

 private:
  void check(long long status) const {
    if (status < 0) throw_input_error(path_, "", "to write HDF5", hdf5_reason());
  }

  bool series() const { return info_.time_steps > 1; }

  void write_step(std::uint64_t step) {
    Buffer buffer;
    const Extent extent = info_.step_extent();
    for (std::uint64_t z = 0; z < extent.z; z += kChunk) {
      for (std::uint64_t y = 0; y < extent.y; y += kChunk) {
        const Box box{{0, y, z}, {extent.x, std::min(kChunk, extent.y - y), std::min(kChunk, extent.z - z)}};
        buffer.resize(box.size.voxels() * size_of(info_.type));
        source_.read({{0, y, step * extent.z + z}, box.size}, buffer.data());
        write_box(step, box, buffer);
      }
    }
  }

  void create_dataset(const std::string& name) {
    const Extent extent = info_.step_extent();
    std::vector<hsize_t> size{extent.z, extent.y, extent.x};
    std::vector<hsize_t> chunk;
    for (const hsize_t n : size) chunk.push_back(std::min<hsize_t>(n, kChunk));
    if (series()) {
      size.insert(size.begin(), info_.time_steps);
      chunk.insert(chunk.begin(), 1);
    }
    const int rank = static_cast<int>(size.size());
    const Hdf5Handle space(H5Screate_simple(rank, size.data(), nullptr), H5Sclose);
    const Hdf5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_create_intermediate_group(links.get(), 1));
    check(H5Pset_chunk(layout.get(), rank, chunk.data()));
    check(H5Pset_deflate(layout.get(), kGzipLevel));
    check(H5Pset_obj_track_times(layout.get(), false));
    dataset_ = {H5Dcreate2(file_.get(), name.c_str(), hdf5_file_type(info_.type), space.get(), links.get(),
                           layout.get(), H5P_DEFAULT),
                H5Dclose};
    check(dataset_.get());
  }

  void write_attributes(hid_t object) const {
    const std::array<double, 3> zyx{info_.voxel_size[2], info_.voxel_size[1], info_.voxel_size[0]};
    const hsize_t three = 3;
    const Hdf5Handle space(H5Screate_simple(1, &three, nullptr), H5Sclose);
    const Hdf5Handle size(
        H5Acreate2(object, "voxel_size", H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(size.get(), H5T_NATIVE_DOUBLE, zyx.data()));
    const Provenance provenance = source_.provenance();
    write_text(object, "voxel_unit", info_.voxel_unit);
    write_text(object, "kind", std::string(name_of(info_.kind)));
    write_text(object, "name", provenance.name);
    write_text(object, "source", provenance.source);
    write_text(object, "licence", provenance.licence);
  }

  void write_text(hid_t object, const char* name, const std::string& text) const {
    if (text.empty()) return;
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type.get(), H5T_VARIABLE));
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
    const Hdf5Handle attribute(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                               H5Aclose);
    const char* value = text.c_str();
    check(H5Awrite(attribute.get(), type.get(), &value));
  }

  void write_box(std::uint64_t step, const Box& box, const Buffer& voxels) const {
    std::vector<hsize_t> start{box.origin.z, box.origin.y, box.origin.x};
    std::vector<hsize_t> count{box.size.z, box.size.y, box.size.x};
    if (series()) {
      start.insert(start.begin(), step);
      count.insert(count.begin(), 1);
    }
    const Hdf5Handle to(H5Dget_space(dataset_.get()), H5Sclose);
    const Hdf5Handle from(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    check(H5Sselect_hyperslab(to.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
    check(H5Dwrite(dataset_.get(), hdf5_file_type(info_.type), from.get(), to.get(), H5P_DEFAULT, voxels.data()));
  }

  std::string path_;
  const VolumeSource& source_;
  VolumeInfo info_;
  Hdf5Handle file_, dataset_;
};

}  // namespace

void write_hdf5(const VolumePath& path, const VolumeSource& source) {
  OutputFile output(path.file);
  output.close();
  {
    const Hdf5Session session;
    const std::string name =
        path.dataset.empty() ? fmt::format("/{}", name_of(source.info().kind)) : path.dataset;
    Hdf5Writer writer(output, name, source);
    writer.write_voxels();
    writer.close();
  }
  output.commit();
}

}  // namespace cvr::volumes
