// HDF5 volumes: one dataset whose axes are at most z, y, x and time (hdf5_axes.hpp), which is given
// x fastest.
//
// Sources: the HDF5 1.10 reference manual. What is read besides the voxels stands in
// hdf5_attributes.hpp. The kind follows from the caller's hint, else the attribute, else a dataset
// called `labels` or `scalars`, else the type. Labels may be stored as signed integers and as whole
// numbers in floating point; each is checked.
//
// A child process calls the library (hdf5_process.hpp): it opens the dataset, says what it found as
// plain values, and then reads boxes as hyperslabs into shared memory, at most kShared bytes and
// whole chunks at a time. Its chunk cache holds one layer of chunks in z, up to a limit, so that
// slabs thinner than a chunk do not inflate each chunk again and again.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/hdf5_attributes.hpp"
#include "volumes/io/hdf5_axes.hpp"
#include "volumes/io/hdf5_parts.hpp"
#include "volumes/io/hdf5_process.hpp"
#include "volumes/io/hdf5_safety.hpp"
#include "volumes/io/hdf5_voxels.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;
using Sizes = std::vector<std::uint64_t>;

constexpr std::size_t kShared = std::size_t{32} << 20;
constexpr unsigned kOpenSeconds = 5;   ///< of computing; listing 10^5 datasets takes one
constexpr unsigned kReadSeconds = 60;  ///< a chunk of 4 GiB inflates in half of it

/// What the child does.
class DatasetServer {
 public:
  DatasetServer(const VolumePath& path, bool allow_external)
      : dataset_name_(path.dataset), bounds_(path.file, allow_external) {}

  Json serve(const Json& request, std::span<std::byte> shared) {
    if (request.contains("slow")) {
      return reopen_hdf5_dataset(dataset_, request["slow"].get<std::vector<int>>(), stored_.width);
    }
    if (!request.contains("start")) return open();
    read(request["start"].get<std::vector<hsize_t>>(), request["count"].get<std::vector<hsize_t>>(),
         shared);
    return nullptr;
  }

 private:
  Json open() {
    if (dataset_name_.empty()) dataset_name_ = only_volume();
    dataset_ = open_hdf5_dataset(bounds_, bounds_.file(), dataset_name_);
    const Hdf5Handle type(H5Dget_type(dataset_.dataset_id.get()), H5Tclose);
    stored_ = hdf5_stored(type.get());
    bits_ = H5Tget_class(type.get()) == H5T_BITFIELD;
    if (stored_.width == 0) {
      throw_input_error(bounds_.file(), dataset_.position(),
                        "voxels that are integers or floating point numbers", stored_.name);
    }
    check_hdf5_storage(bounds_, dataset_);
    const Hdf5Handle root(H5Oopen(dataset_.file_id.get(), "/", H5P_DEFAULT), H5Oclose);
    return {{"name", dataset_name_},
            {"size", hdf5_size(dataset_.dataset_id.get())},
            {"type", stored_.name},
            {"is_float", stored_.is_float},
            {"is_signed", stored_.is_signed},
            {"width", stored_.width},
            {"attributes", read_hdf5_attributes(dataset_.dataset_id.get())},
            {"root", read_hdf5_attributes(root.get())},
            {"files", bounds_.files()}};
  }

  std::string only_volume() const {
    const Hdf5Content content = list_hdf5(open_hdf5_file(bounds_.file(), H5F_ACC_RDONLY).get());
    const auto is_volume = [](const Hdf5Entry& entry) { return entry.voxels; };
    const auto first = std::find_if(content.datasets.begin(), content.datasets.end(), is_volume);
    if (std::count_if(content.datasets.begin(), content.datasets.end(), is_volume) != 1) {
      throw_input_error(bounds_.file(), "", "exactly one volume, or its name as FILE:/DATASET",
                        to_string(content));
    }
    return first->name;
  }

  void read(const std::vector<hsize_t>& start, const std::vector<hsize_t>& count,
            std::span<std::byte> shared) const {
    const Hdf5Handle from(H5Dget_space(dataset_.dataset_id.get()), H5Sclose);
    const Hdf5Handle to(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                        H5Sclose);
    const bool fits = static_cast<std::size_t>(H5Sget_simple_extent_npoints(to.get())) <=
                      shared.size() / stored_.width;
    const hid_t type = bits_ ? H5T_NATIVE_B8 : hdf5_memory_type(stored_);
    const bool done = fits &&
                      H5Sselect_hyperslab(from.get(), H5S_SELECT_SET, start.data(), nullptr,
                                          count.data(), nullptr) >= 0 &&
                      H5Dread(dataset_.dataset_id.get(), type, to.get(), from.get(), H5P_DEFAULT,
                              shared.data()) >= 0;
    if (!done)
      throw_input_error(bounds_.file(), dataset_.position(), "readable voxels", hdf5_reason());
  }

  std::string dataset_name_;
  Hdf5Bounds bounds_;
  Hdf5Dataset dataset_;
  Hdf5Stored stored_;
  bool bits_ = false;
};

Hdf5Process::Serve server(const VolumePath& path, bool allow_external) {
  // Made in the child, by the first request.
  return [path, allow_external, made = std::shared_ptr<DatasetServer>()](
             const Json& request, std::span<std::byte> shared) mutable {
    if (!made) made = std::make_shared<DatasetServer>(path, allow_external);
    return made->serve(request, shared);
  };
}

class Hdf5Source final : public VolumeSource {
 public:
  Hdf5Source(const VolumePath& path, const OpenOptions& options) : file_(path.file) {
    require_file(file_);
    try {
      process_ = std::make_unique<Hdf5Process>(kShared, server(path, options.allow_external));
    } catch (const Hdf5Failure& failure) {
      throw_input_error(file_, "", "room for a process that reads it", failure.what());
    }
    const Json found = call(Json::object(), kOpenSeconds);
    const Hdf5Attributes attributes(found.at("attributes")), root(found.at("root"));
    const auto name = found.at("name").get<std::string>();
    position_ = fmt::format("dataset '{}'", name);
    size_ = found.at("size").get<Sizes>();
    files_ = found.at("files").get<std::vector<std::string>>();
    order_ = settle_hdf5_axes(file_, position_, size_, options.axes, attributes);
    const Hdf5Meaning meaning = understand_hdf5(attributes, root, size_.size(), order_.axis);
    provenance_ = meaning.provenance;
    const auto by_name = volume_kind_from_name(name.substr(name.rfind('/') + 1));
    settle_type(found, options.kind, meaning.kind ? meaning.kind : by_name);
    settle_extent(path);
    info_.voxel_size = meaning.voxel_size;
    info_.voxel_unit = meaning.voxel_unit;
    info_.offset = meaning.offset;
    const auto chunk =
        call({{"slow", std::array{order_.axis[2], order_.time}}}, kOpenSeconds).get<Sizes>();
    for (std::size_t i = 0; i < 3 && !chunk.empty(); ++i) {
      if (order_.axis[i] >= 0)
        chunk_[i] = std::clamp<std::uint64_t>(chunk[static_cast<std::size_t>(order_.axis[i])], 1,
                                              order_.length(i, size_));
    }
  }

  const VolumeInfo& info() const override { return info_; }
  Provenance provenance() const override { return provenance_; }
  std::vector<std::string> files() const override { return files_; }

  void read(const Box& box, std::byte* out) const override {
    const std::uint64_t depth = info_.step_extent().z;
    for (std::uint64_t z = box.origin.z; z < box.origin.z + box.size.z;) {
      const std::uint64_t step = z / depth,
                          end = std::min((step + 1) * depth, box.origin.z + box.size.z);
      read_step(step, {{box.origin.x, box.origin.y, z}, {box.size.x, box.size.y, end - z}}, box,
                out);
      z = end;
    }
  }

 private:
  Json call(const Json& request, unsigned seconds) const {
    try {
      return process_->call(request, seconds);
    } catch (const Hdf5Failure& failure) {
      throw_input_error(file_, position_,
                        "HDF5 that its library can read (h5dump and h5debug show where it ends)",
                        fmt::format("damage: {}", failure.what()));
    }
  }

  void settle_type(const Json& found, std::optional<VolumeKind> hint,
                   std::optional<VolumeKind> stated) {
    conversion_ = {found.at("is_float").get<bool>(), found.at("is_signed").get<bool>(),
                   found.at("width").get<unsigned>(), VoxelType::kF32};
    const std::optional<VolumeKind> kind = hint ? hint : stated;
    if (conversion_.is_float && kind == VolumeKind::kLabels) {
      conversion_.type = conversion_.width == 4 ? VoxelType::kU32 : VoxelType::kU64;
      info_.kind = VolumeKind::kLabels;
    } else if (conversion_.is_float && conversion_.width == 8) {
      throw_input_error(file_, position_,
                        "scalars of type u8, u16, i16 or f32 (h5py: f['x32'] = "
                        "f['x'][...].astype('float32')), or "
                        "--kind labels where these are whole numbers that name segments",
                        found.at("type").get<std::string>());
    } else if (conversion_.is_float) {
      info_.kind = VolumeKind::kScalars;
    } else {
      constexpr std::array kUnsigned{VoxelType::kU8, VoxelType::kU16, VoxelType::kU32,
                                     VoxelType::kU64};
      const auto at = static_cast<std::size_t>(std::countr_zero(conversion_.width));
      const bool i16 = conversion_.is_signed && at == 1;
      const Interpretation meaning = interpret(
          file_, {i16 ? VoxelType::kI16 : kUnsigned[at], conversion_.is_signed}, hint, stated);
      conversion_.type = meaning.type;
      info_.kind = meaning.kind;
    }
    info_.type = conversion_.type;
  }

  void settle_extent(const VolumePath& path) {
    const std::uint64_t stored = order_.time < 0 ? 0 : size_[static_cast<std::size_t>(order_.time)];
    if (order_.time >= 0 && stored == 0) {
      throw_input_error(file_, position_, "a series of at least one step", "an empty one");
    }
    const Steps steps = check_steps(path, position_, stored);
    info_.extent =
        check_extent(file_, position_,
                     {order_.length(0, size_), order_.length(1, size_), order_.length(2, size_)},
                     steps.count, info_.type);
    info_.time_steps = steps.count;
    first_step_ = steps.first;
  }

  /// Voxels of one time step, in parts that fit into the shared memory.
  void read_step(std::uint64_t step, const Box& box, const Box& whole, std::byte* out) const {
    std::array<std::size_t, 3> slowest_first{2, 1, 0};
    std::stable_sort(slowest_first.begin(), slowest_first.end(),
                     [&](std::size_t a, std::size_t b) { return order_.axis[a] < order_.axis[b]; });
    const std::uint64_t step_begin = step * info_.step_extent().z;
    Box in_step = box;
    in_step.origin.z -= step_begin;
    for (Box part : plan_parts(in_step, {chunk_, slowest_first, conversion_.width}, kShared)) {
      part.origin.z += step_begin;
      read_part(step, part, whole, out);
    }
  }

  void read_part(std::uint64_t step, const Box& box, const Box& whole, std::byte* out) const {
    Sizes start(size_.size(), 0), count(size_.size(), 1);
    if (order_.time >= 0) start[static_cast<std::size_t>(order_.time)] = first_step_ + step;
    const std::array<std::uint64_t, 3> origin{box.origin.x, box.origin.y,
                                              box.origin.z % info_.step_extent().z};
    const std::array<std::uint64_t, 3> extent{box.size.x, box.size.y, box.size.z};
    for (std::size_t i = 0; i < 3; ++i) {
      if (order_.axis[i] < 0) continue;
      start[static_cast<std::size_t>(order_.axis[i])] = origin[i];
      count[static_cast<std::size_t>(order_.axis[i])] = extent[i];
    }
    call({{"start", start}, {"count", count}}, kReadSeconds);
    Hdf5Part part{process_->shared().data(), {1, 1, 1}, box};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t after = static_cast<std::size_t>(order_.axis[i]) + 1;
           order_.axis[i] >= 0 && after < count.size(); ++after) {
        part.strides[i] *= count[after];
      }
    }
    place_hdf5_part(file_, position_, conversion_, part, whole, out);
  }

  std::string file_, position_;
  std::unique_ptr<Hdf5Process> process_;
  Sizes size_;  ///< of the dataset, in the order of the file
  Hdf5AxisOrder order_;
  std::array<std::uint64_t, 3> chunk_{1, 1, 1};  ///< voxels along x, y, z
  Hdf5Conversion conversion_;
  VolumeInfo info_;
  Provenance provenance_;
  std::vector<std::string> files_;
  std::uint64_t first_step_ = 0;
};

}  // namespace

std::unique_ptr<VolumeSource> open_hdf5(const VolumePath& path, const OpenOptions& options) {
  return std::make_unique<Hdf5Source>(path, options);
}

}  // namespace cvr::volumes
