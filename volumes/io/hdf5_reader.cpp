// HDF5 volumes: one dataset of rank 3 (z y x in the file, which is x fastest in memory) or 4 (t z y x, a
// series).
//
// Sources: the HDF5 1.10 reference manual. Attributes, on the dataset or else on the file: `voxel_size`
// (three numbers, z y x), `voxel_unit`, `kind` ("labels" or "scalars"), `name`, `source`, `licence`. The kind
// follows from the caller's hint, else the attribute, else a dataset called `labels` or `scalars`, else the
// type.
//
// Boxes are hyperslabs. The chunk cache holds one layer of chunks in z, up to 256 MiB, so that slabs thinner
// than a chunk do not inflate each chunk again and again.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kCacheBytes = std::uint64_t{256} << 20;
constexpr std::size_t kMaximumText = 1 << 16;

struct OpenDataset {
  std::string file;
  std::string name;  ///< absolute path of the dataset
  Hdf5Handle file_id, dataset_id;

  std::string position() const { return fmt::format("dataset '{}'", name); }
};

/// Absolute paths of the datasets that can be volumes (rank 3 or 4), in the order of their names.
std::vector<std::string> volume_datasets(hid_t file) {
  std::vector<std::string> names;
  const H5O_iterate_t collect = [](hid_t root, const char* name, const H5O_info_t* object,
                                   void* data) -> herr_t {
    if (object->type != H5O_TYPE_DATASET) return 0;
    const Hdf5Handle dataset(H5Dopen2(root, name, H5P_DEFAULT), H5Dclose);
    if (!dataset.valid()) return 0;
    const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank == 3 || rank == 4)
      static_cast<std::vector<std::string>*>(data)->push_back(std::string("/") + name);
    return 0;
  };
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, collect, &names, H5O_INFO_BASIC);
  return names;
}

std::string listed(const std::vector<std::string>& names) {
  return names.empty() ? "no dataset of rank 3 or 4" : fmt::format("{}", fmt::join(names, ", "));
}

OpenDataset open_dataset(const VolumePath& path) {
  require_file(path.file);
  if (H5Fis_hdf5(path.file.c_str()) <= 0)
    throw_input_error(path.file, "byte 0", "an HDF5 file", "other content");
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.get(), false, true);
  OpenDataset opened{
      path.file, path.dataset, {H5Fopen(path.file.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose}, {}};
  if (!opened.file_id.valid()) throw_input_error(path.file, "", "a complete HDF5 file", hdf5_reason());

  if (opened.name.empty()) {
    const std::vector<std::string> names = volume_datasets(opened.file_id.get());
    if (names.size() != 1) {
      throw_input_error(path.file, "", "exactly one volume, or its name as FILE:/DATASET", listed(names));
    }
    opened.name = names.front();
  }
  opened.dataset_id = {H5Dopen2(opened.file_id.get(), opened.name.c_str(), H5P_DEFAULT), H5Dclose};
  if (!opened.dataset_id.valid()) {
    throw_input_error(path.file, opened.position(), "an existing dataset",
                      listed(volume_datasets(opened.file_id.get())));
  }
  return opened;
}

StoredType stored_type(const OpenDataset& dataset) {
  const Hdf5Handle type(H5Dget_type(dataset.dataset_id.get()), H5Tclose);
  const H5T_class_t type_class = H5Tget_class(type.get());
  const std::size_t bits = 8 * H5Tget_size(type.get());
  const bool is_signed = type_class == H5T_INTEGER && H5Tget_sign(type.get()) == H5T_SGN_2;
  const char* letter = type_class == H5T_FLOAT     ? "f"
                       : type_class == H5T_INTEGER ? (is_signed ? "i" : "u")
                                                   : nullptr;
  const std::string name = letter != nullptr ? fmt::format("{}{}", letter, bits)
                                             : fmt::format("type class {}", static_cast<int>(type_class));
  const std::optional<VoxelType> known = voxel_type_from_name(name);
  if (!known)
    throw_input_error(dataset.file, dataset.position(), "a voxel type of u8, u16, u32, u64, i16, f32", name);
  return {*known, is_signed};
}

/// An attribute of the dataset, or else of the file.
Hdf5Handle open_attribute(const OpenDataset& dataset, const char* name) {
  for (const hid_t object : {dataset.dataset_id.get(), dataset.file_id.get()}) {
    if (H5Aexists(object, name) > 0) return {H5Aopen(object, name, H5P_DEFAULT), H5Aclose};
  }
  return {};
}

/// The text of an attribute; empty where there is none.
std::string text_attribute(const OpenDataset& dataset, const char* name) {
  const Hdf5Handle attribute = open_attribute(dataset, name);
  if (!attribute.valid()) return {};
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose);
  const bool text = H5Tget_class(type.get()) == H5T_STRING && H5Sget_simple_extent_npoints(space.get()) == 1;
  const std::size_t size = H5Tget_size(type.get());
  if (!text || size > kMaximumText) {
    throw_input_error(dataset.file, fmt::format("attribute '{}'", name), "one text",
                      "another type or length");
  }
  if (H5Tis_variable_str(type.get()) > 0) {
    char* value = nullptr;
    if (H5Aread(attribute.get(), type.get(), &value) < 0 || value == nullptr) return {};
    std::string result(value);
    H5free_memory(value);
    return result;
  }
  std::string value(size, '\0');
  if (H5Aread(attribute.get(), type.get(), value.data()) < 0) return {};
  value.resize(std::strlen(value.c_str()));
  return value;
}

void read_voxel_size(const OpenDataset& dataset, VolumeInfo& info) {
  info.voxel_unit = text_attribute(dataset, "voxel_unit");
  const Hdf5Handle attribute = open_attribute(dataset, "voxel_size");
  if (!attribute.valid()) return;
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose);
  const H5T_class_t type_class = H5Tget_class(type.get());
  const bool numbers = type_class == H5T_FLOAT || type_class == H5T_INTEGER;
  std::array<double, 3> zyx{};
  const bool read = numbers && H5Sget_simple_extent_npoints(space.get()) == 3 &&
                    H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, zyx.data()) >= 0;
  if (!read || !std::all_of(zyx.begin(), zyx.end(), [](double v) { return std::isfinite(v) && v > 0; })) {
    throw_input_error(dataset.file, "attribute 'voxel_size'", "three positive numbers (z y x)",
                      read ? fmt::format("{}", fmt::join(zyx, " ")) : "another type or length");
  }
  info.voxel_size = {zyx[2], zyx[1], zyx[0]};
}

std::optional<VolumeKind> stated_kind(const OpenDataset& dataset) {
  const std::string text = text_attribute(dataset, "kind");
  if (text.empty()) return volume_kind_from_name(dataset.name.substr(dataset.name.rfind('/') + 1));
  const auto kind = volume_kind_from_name(text);
  if (!kind)
    throw_input_error(dataset.file, "attribute 'kind'", "labels or scalars", fmt::format("'{}'", text));
  return kind;
}

/// The extent of the dataset in file order; checks the rank.
std::vector<hsize_t> dataset_size(const OpenDataset& dataset) {
  const Hdf5Handle space(H5Dget_space(dataset.dataset_id.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank != 3 && rank != 4) {
    throw_input_error(dataset.file, dataset.position(), "rank 3 (z y x) or 4 (t z y x)",
                      fmt::format("rank {}", rank));
  }
  std::vector<hsize_t> size(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
  if (rank == 4 && size[0] == 0)
    throw_input_error(dataset.file, dataset.position(), "a series of at least one step", "an empty one");
  return size;
}

/// The library trusts chunk sizes and would read past a chunk that a damaged header makes larger than the
/// dataset.
void check_chunk(const OpenDataset& dataset, const std::vector<hsize_t>& chunk) {
  const Hdf5Handle space(H5Dget_space(dataset.dataset_id.get()), H5Sclose);
  std::vector<hsize_t> limit(chunk.size());
  H5Sget_simple_extent_dims(space.get(), nullptr, limit.data());
  for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
    if (chunk[axis] == 0 || chunk[axis] > limit[axis]) {
      throw_input_error(dataset.file, dataset.position(), "chunks no larger than the dataset",
                        fmt::format("{} of {}", fmt::join(chunk, "x"), fmt::join(limit, "x")));
    }
  }
}

/// Reopens the dataset with a chunk cache of one layer of chunks in z.
void enlarge_chunk_cache(OpenDataset& dataset, const std::vector<hsize_t>& size, std::size_t voxel) {
  const Hdf5Handle layout(H5Dget_create_plist(dataset.dataset_id.get()), H5Pclose);
  if (H5Pget_layout(layout.get()) != H5D_CHUNKED) return;
  std::vector<hsize_t> chunk(size.size());
  if (H5Pget_chunk(layout.get(), static_cast<int>(chunk.size()), chunk.data()) < 0) return;
  check_chunk(dataset, chunk);
  const std::size_t rank = size.size();
  double layer = static_cast<double>(voxel);  // a double: chunk sizes come from the file and may overflow
  for (std::size_t axis = 0; axis < rank; ++axis) {
    const auto count = axis + 2 >= rank ? (size[axis] + chunk[axis] - 1) / chunk[axis] : 1;
    layer *= static_cast<double>(chunk[axis]) * static_cast<double>(count);
  }
  const auto bytes = static_cast<std::size_t>(std::min(layer, static_cast<double>(kCacheBytes)));
  const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  constexpr std::size_t kSlots = 100003;  // a prime well above the number of chunks in a layer
  H5Pset_chunk_cache(access.get(), kSlots, std::max<std::size_t>(bytes, 1 << 20), H5D_CHUNK_CACHE_W0_DEFAULT);
  dataset.dataset_id = {};
  dataset.dataset_id = {H5Dopen2(dataset.file_id.get(), dataset.name.c_str(), access.get()), H5Dclose};
}

hid_t native_type(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return H5T_NATIVE_UINT8;
    case VoxelType::kU16:
      return H5T_NATIVE_UINT16;
    case VoxelType::kU32:
      return H5T_NATIVE_UINT32;
    case VoxelType::kU64:
      return H5T_NATIVE_UINT64;
    case VoxelType::kI16:
      return H5T_NATIVE_INT16;
    case VoxelType::kF32:
      return H5T_NATIVE_FLOAT;
  }
  return H5I_INVALID_HID;
}

class Hdf5Source final : public VolumeSource {
 public:
  Hdf5Source(const VolumePath& path, std::optional<VolumeKind> hint) {
    const Hdf5Session session;
    OpenDataset dataset = open_dataset(path);
    const StoredType stored = stored_type(dataset);
    const Interpretation meaning = interpret(path.file, stored, hint, stated_kind(dataset));
    const std::vector<hsize_t> size = dataset_size(dataset);
    series_ = size.size() == 4;
    const Steps steps = check_steps(path, dataset.position(), series_ ? size[0] : 0);
    const std::size_t z = size.size() - 3;
    info_.extent = check_extent(path.file, dataset.position(), {size[z + 2], size[z + 1], size[z]},
                                steps.count, meaning.type);
    info_.time_steps = steps.count;
    first_step_ = steps.first;
    info_.type = meaning.type;
    info_.kind = meaning.kind;
    read_voxel_size(dataset, info_);
    provenance_ = {text_attribute(dataset, "name"), text_attribute(dataset, "source"),
                   text_attribute(dataset, "licence")};
    stored_ = stored.type;
    reject_negative_ = meaning.reject_negative;
    enlarge_chunk_cache(dataset, size, size_of(stored_));
    dataset_ = std::move(dataset);
  }
  ~Hdf5Source() override {
    const Hdf5Session session;
    dataset_.dataset_id.reset();
    dataset_.file_id.reset();
  }

  const VolumeInfo& info() const override { return info_; }
  Provenance provenance() const override { return provenance_; }

  void read(const Box& box, std::byte* out) const override {
    if (box.size.voxels() == 0) return;
    const Hdf5Session session;
    const std::uint64_t depth = info_.step_extent().z, end = box.origin.z + box.size.z;
    for (std::uint64_t z = box.origin.z; z < end;) {
      const std::uint64_t next = std::min(end, (z / depth + 1) * depth);
      const Box part{{box.origin.x, box.origin.y, z % depth}, {box.size.x, box.size.y, next - z}};
      read_step(first_step_ + z / depth, part, out);
      out += part.size.voxels() * size_of(stored_);
      z = next;
    }
  }

 private:
  /// Voxels of one time step, or of a single volume.
  void read_step(std::uint64_t step, const Box& box, std::byte* out) const {
    std::vector<hsize_t> start{box.origin.z, box.origin.y, box.origin.x};
    std::vector<hsize_t> count{box.size.z, box.size.y, box.size.x};
    if (series_) {
      start.insert(start.begin(), step);
      count.insert(count.begin(), 1);
    }
    const Hdf5Handle from(H5Dget_space(dataset_.dataset_id.get()), H5Sclose);
    const Hdf5Handle to(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    const bool done =
        H5Sselect_hyperslab(from.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0 &&
        H5Dread(dataset_.dataset_id.get(), native_type(stored_), to.get(), from.get(), H5P_DEFAULT, out) >= 0;
    if (!done) throw_input_error(dataset_.file, dataset_.position(), "readable voxels", hdf5_reason());
    const std::size_t width = size_of(stored_);
    if (reject_negative_) reject_negative_voxels(dataset_.file, {out, box.size.voxels() * width}, width);
  }

  OpenDataset dataset_;
  VolumeInfo info_;
  Provenance provenance_;
  VoxelType stored_ = VoxelType::kU8;
  bool reject_negative_ = false;
  bool series_ = false;           ///< of rank 4
  std::uint64_t first_step_ = 0;  ///< of the dataset
};

}  // namespace

std::unique_ptr<VolumeSource> open_hdf5(const VolumePath& path, const OpenOptions& options) {
  return std::make_unique<Hdf5Source>(path, options.kind);
}

}  // namespace cvr::volumes
