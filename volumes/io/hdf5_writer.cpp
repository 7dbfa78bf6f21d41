// HDF5 volumes as this project writes them: one dataset `/labels` or `/scalars` (or the name
// given), axes z y x (series: t z y x), chunks of at most 64 a side and one step, gzip level 4
// without shuffle, the attributes that hdf5_attributes.hpp names, texts of fixed length, and no
// time stamps, so that equal volumes give equal files.
//
// A named dataset of a file that exists is added to a copy of the file, or replaced in it, and the
// copy takes the file's place when it is complete. A file that exists and no name: only a file with
// nothing but the volume is replaced.
//
// A child process calls the library (hdf5_process.hpp). After a failed write libhdf5 1.10 crashes
// when its handles close, at the latest when the process ends; the child is killed before that.
// Voxels are drawn in boxes of at most kRow chunks along x, never a whole layer, into the memory
// that both share.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/hdf5_existing.hpp"
#include "volumes/io/hdf5_objects.hpp"
#include "volumes/io/hdf5_process.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kChunk = 64;
constexpr std::uint64_t kRow = 16;  ///< chunks along x that are written at once
constexpr unsigned kGzipLevel = 4;
constexpr unsigned kWriteSeconds = 120;  ///< of computing for 32 MiB

/// What is written, as the child needs it.
struct Hdf5Plan {
  std::string path, partial;  ///< the final name for messages, and where the bytes go
  std::string dataset;
  bool into_existing = false;
  VolumeInfo info;
  Provenance provenance;
};

/// What the child does. Its handles are closed by finish() alone: after a failure they must not be.
class DatasetWriter {
 public:
  explicit DatasetWriter(Hdf5Plan plan) : plan_(std::move(plan)) {}

  Json serve(const Json& request, std::span<std::byte> shared) {
    if (request.contains("start")) {
      write_box(request["start"].get<std::vector<hsize_t>>(),
                request["count"].get<std::vector<hsize_t>>(), shared);
    } else if (request.contains("finish")) {
      finish();
    } else {
      begin();
    }
    return nullptr;
  }

 private:
  void check(long long status) const {
    if (status < 0) throw_output_error(plan_.path, hdf5_reason());
  }

  void begin() {
    const char* const partial = plan_.partial.c_str();
    if (plan_.into_existing) {
      const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
      check(H5Pset_file_locking(access.get(), false, true));
      file_ = H5Fopen(partial, H5F_ACC_RDWR, access.get());
      check(file_);
      remove_hdf5_dataset(plan_.path, file_, plan_.dataset);
    } else {
      file_ = H5Fcreate(partial, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
      check(file_);
    }
    create_dataset();
    write_attributes();
  }

  void create_dataset() {
    const Extent extent = plan_.info.step_extent();
    std::vector<hsize_t> size{extent.z, extent.y, extent.x};
    std::vector<hsize_t> chunk;
    for (const hsize_t n : size) chunk.push_back(std::min<hsize_t>(n, kChunk));
    if (plan_.info.time_steps > 1) {
      size.insert(size.begin(), plan_.info.time_steps);
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
    dataset_ = H5Dcreate2(file_, plan_.dataset.c_str(), hdf5_file_type(plan_.info.type),
                          space.get(), links.get(), layout.get(), H5P_DEFAULT);
    check(dataset_);
  }

  void write_attributes() const {
    const VolumeInfo& info = plan_.info;
    write_triple("voxel_size", info.voxel_size);
    write_triple("offset", info.offset);
    write_text("voxel_unit", info.voxel_unit);
    write_text("kind", std::string(name_of(info.kind)));
    write_text("axes", info.time_steps > 1 ? "tzyx" : "zyx");
    write_text("name", plan_.provenance.name);
    write_text("source", plan_.provenance.source);
    write_text("licence", plan_.provenance.licence);
  }

  void write_triple(const char* name, const std::array<double, 3>& xyz) const {
    const std::array<double, 3> zyx{xyz[2], xyz[1], xyz[0]};
    const hsize_t three = 3;
    const Hdf5Handle space(H5Screate_simple(1, &three, nullptr), H5Sclose);
    write_attribute(name, H5T_IEEE_F64LE, space.get(), zyx.data());
  }

  /// Of fixed length: the library crashes on damaged texts of variable length.
  void write_text(const char* name, const std::string& text) const {
    if (text.empty()) return;
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type.get(), text.size()));
    check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD));
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
    write_attribute(name, type.get(), space.get(), text.data());
  }

  void write_attribute(const char* name, hid_t type, hid_t space, const void* value) const {
    const hid_t attribute = H5Acreate2(dataset_, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    check(attribute);
    check(H5Awrite(attribute, type, value));
    check(H5Aclose(attribute));
  }

  void write_box(const std::vector<hsize_t>& start, const std::vector<hsize_t>& count,
                 std::span<const std::byte> voxels) const {
    const Hdf5Handle to(H5Dget_space(dataset_), H5Sclose);
    const Hdf5Handle from(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                          H5Sclose);
    check(H5Sselect_hyperslab(to.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                              nullptr));
    check(H5Dwrite(dataset_, hdf5_file_type(plan_.info.type), from.get(), to.get(), H5P_DEFAULT,
                   voxels.data()));
  }

  void finish() {
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
    check(H5Dclose(dataset_));
    check(H5Fclose(file_));
  }

  Hdf5Plan plan_;
  hid_t file_ = H5I_INVALID_HID, dataset_ = H5I_INVALID_HID;
};

Hdf5Process::Serve writer(const Hdf5Plan& plan) {
  return [made = std::make_shared<DatasetWriter>(plan)](const Json& request,
                                                        std::span<std::byte> shared) {
    return made->serve(request, shared);
  };
}

std::size_t box_bytes(const VolumeInfo& info) {
  return std::min(info.extent.x, kRow * kChunk) * kChunk * kChunk * size_of(info.type);
}

void write_voxels(const Hdf5Process& process, const VolumeSource& source) {
  const VolumeInfo& info = source.info();
  const Extent extent = info.step_extent();
  constexpr std::uint64_t kWidth = kRow * kChunk;
  const auto write = [&](std::uint64_t step, const Coordinate& at) {
    const Extent size{std::min(kWidth, extent.x - at.x), std::min(kChunk, extent.y - at.y),
                      std::min(kChunk, extent.z - at.z)};
    source.read({{at.x, at.y, step * extent.z + at.z}, size}, process.shared().data());
    std::vector<std::uint64_t> start{at.z, at.y, at.x}, count{size.z, size.y, size.x};
    if (info.time_steps > 1) {
      start.insert(start.begin(), step);
      count.insert(count.begin(), 1);
    }
    process.call({{"start", start}, {"count", count}}, kWriteSeconds);
  };
  for (std::uint64_t step = 0; step < info.time_steps; ++step) {
    for (std::uint64_t z = 0; z < extent.z; z += kChunk) {
      for (std::uint64_t y = 0; y < extent.y; y += kChunk) {
        for (std::uint64_t x = 0; x < extent.x; x += kWidth) write(step, {x, y, z});
      }
    }
  }
}

void copy_existing(const std::string& path, const std::string& partial) {
  std::error_code error;
  std::filesystem::copy_file(path, partial, std::filesystem::copy_options::overwrite_existing,
                             error);
  if (error) throw_output_error(path, error.message());
}

}  // namespace

void write_hdf5(const VolumePath& path, const VolumeSource& source) {
  std::string dataset =
      path.dataset.empty() ? std::string(name_of(source.info().kind)) : path.dataset;
  if (!dataset.starts_with('/')) dataset = fmt::format("/{}", dataset);
  const bool into_existing = keeps_existing_hdf5(path.file, path.dataset, dataset);
  OutputFile output(path.file);
  output.close();
  if (into_existing) copy_existing(path.file, output.partial_path());
  try {
    const Hdf5Process process(box_bytes(source.info()),
                              writer({path.file, output.partial_path(), dataset, into_existing,
                                      source.info(), source.provenance()}));
    process.call(Json::object(), kWriteSeconds);
    write_voxels(process, source);
    process.call({{"finish", true}}, kWriteSeconds);
  } catch (const Hdf5Failure& failure) {
    throw_output_error(path.file, failure.what());
  }
  output.commit();
}

}  // namespace cvr::volumes
