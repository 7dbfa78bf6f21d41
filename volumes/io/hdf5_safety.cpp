#include "volumes/io/hdf5_safety.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kCacheBytes = std::uint64_t{256} << 20;
constexpr double kSmallChunk =
    1 << 26;  ///< voxels of a chunk that may be larger than a dataset that can grow
constexpr int kMaximumNesting = 8;
constexpr std::size_t kMaximumSources = 1 << 20;

struct Filter {
  int number;
  std::string_view name;
};
/// The registered filters that writers of volumes use.
constexpr std::array kFilters{
    Filter{1, "gzip"},         Filter{2, "shuffle"},       Filter{3, "fletcher32"},
    Filter{4, "szip"},         Filter{5, "nbit"},          Filter{6, "scaleoffset"},
    Filter{305, "lzo"},        Filter{307, "bzip2"},       Filter{32000, "lzf"},
    Filter{32001, "blosc"},    Filter{32002, "mafisc"},    Filter{32003, "snappy"},
    Filter{32004, "lz4"},      Filter{32007, "jpegxr"},    Filter{32008, "bitshuffle"},
    Filter{32009, "spdp"},     Filter{32012, "jpegls"},    Filter{32013, "zfp"},
    Filter{32014, "fpzip"},    Filter{32015, "zstd"},      Filter{32016, "b3d"},
    Filter{32017, "sz"},       Filter{32018, "fcidecomp"}, Filter{32019, "jpeg"},
    Filter{32022, "bitgroom"}, Filter{32024, "sz3"},       Filter{32026, "blosc2"},
};

/// "lzf (filter 32000)".
std::string filter_name(int filter) {
  const auto known = std::find_if(kFilters.begin(), kFilters.end(),
                                  [&](const Filter& f) { return f.number == filter; });
  return known == kFilters.end() ? fmt::format("filter {}", filter)
                                 : fmt::format("{} (filter {})", known->name, filter);
}

void check_filters(const Hdf5Dataset& dataset, hid_t plist) {
  const int count = H5Pget_nfilters(plist);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0, config = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter = H5Pget_filter2(plist, static_cast<unsigned>(i), &flags, &values,
                                               nullptr, 0, nullptr, &config);
    if (filter < 0)
      throw_input_error(dataset.file, dataset.position(), "a readable list of filters",
                        hdf5_reason());
    if (H5Zfilter_avail(filter) > 0) continue;
    throw_input_error(
        dataset.file, dataset.position(), "filters that this HDF5 library has",
        fmt::format(
            "{}: install its plugin (Debian: hdf5-filter-plugin) where HDF5 looks for plugins, or "
            "rewrite the file "
            "where it can be read, as with h5py and hdf5plugin: g.create_dataset('x', data=f['x'], "
            "compression='gzip')",
            filter_name(filter)));
  }
}

double product(const std::vector<hsize_t>& sizes) {
  double result = 1;  // sizes come from the file and may overflow an integer
  for (const hsize_t size : sizes) result *= static_cast<double>(size);
  return result;
}

std::vector<hsize_t> chunk_of(hid_t plist, std::size_t rank) {
  std::vector<hsize_t> chunk(rank);
  if (H5Pget_layout(plist) != H5D_CHUNKED) return {};
  if (H5Pget_chunk(plist, static_cast<int>(rank), chunk.data()) < 0) return {};
  return chunk;
}

/// The library trusts chunk sizes and would read past a chunk that a damaged header makes larger
/// than the dataset can become.
void check_chunk(const Hdf5Dataset& dataset, hid_t plist) {
  const std::vector<hsize_t> size = hdf5_size(dataset.dataset_id.get());
  const std::vector<hsize_t> chunk = chunk_of(plist, size.size());
  if (chunk.empty()) return;
  const Hdf5Handle space(H5Dget_space(dataset.dataset_id.get()), H5Sclose);
  std::vector<hsize_t> limit(chunk.size());
  H5Sget_simple_extent_dims(space.get(), nullptr, limit.data());
  bool fits = product(chunk) <= std::max(kSmallChunk, 8 * product(size));
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
    fits = fits && chunk[axis] > 0 && chunk[axis] <= limit[axis];
  if (!fits) {
    throw_input_error(dataset.file, dataset.position(), "chunks no larger than the dataset",
                      fmt::format("{} of {}", fmt::join(chunk, "x"), fmt::join(size, "x")));
  }
}

/// Bytes of the dataset in the files outside; each must hold its part.
void check_external(Hdf5Bounds& bounds, const Hdf5Dataset& dataset, hid_t plist) {
  const int count = H5Pget_external_count(plist);
  if (count <= 0) return;
  const Hdf5Handle type(H5Dget_type(dataset.dataset_id.get()), H5Tclose);
  const double bytes =
      product(hdf5_size(dataset.dataset_id.get())) * static_cast<double>(H5Tget_size(type.get()));
  auto left = static_cast<std::uint64_t>(std::min(bytes, 0x1p62));
  for (int i = 0; i < count; ++i) {
    std::string name(4096, '\0');
    off_t offset = 0;
    hsize_t size = 0;
    if (H5Pget_external(plist, static_cast<unsigned>(i), name.size() - 1, name.data(), &offset,
                        &size) < 0) {
      throw_input_error(dataset.file, dataset.position(), "a readable list of external files",
                        hdf5_reason());
    }
    name.resize(name.find('\0'));
    const std::string what = fmt::format("external storage of {}", dataset.position());
    const std::uint64_t there = fs::file_size(bounds.admit(dataset.file, what, name));
    const std::uint64_t part = std::min<std::uint64_t>(size, left);
    const auto start = static_cast<std::uint64_t>(offset);
    if (offset < 0 || there < start || there - start < part) {
      throw_input_error(dataset.file, what,
                        fmt::format("{} bytes from byte {} of '{}'", part, offset, name),
                        fmt::format("a file of {} bytes", there));
    }
    left -= part;
  }
}

class VirtualSources {
 public:
  VirtualSources(Hdf5Bounds& bounds, int nesting) : bounds_(bounds), nesting_(nesting) {}

  void check(const Hdf5Dataset& dataset, hid_t plist);

 private:
  void check_source(const Hdf5Dataset& dataset, hid_t plist, std::size_t index);
  /// Of the dataset `name` of `file`, which is looked at once.
  const std::vector<hsize_t>& checked_size(const Hdf5Dataset& dataset, const std::string& what,
                                           const std::string& file, const std::string& name);

  Hdf5Bounds& bounds_;
  int nesting_;
  std::map<std::pair<std::string, std::string>, std::vector<hsize_t>> sizes_;
};

void check_storage(Hdf5Bounds& bounds, const Hdf5Dataset& dataset, int nesting) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset.dataset_id.get()), H5Pclose);
  check_filters(dataset, plist.get());
  check_chunk(dataset, plist.get());
  check_external(bounds, dataset, plist.get());
  if (H5Pget_layout(plist.get()) == H5D_VIRTUAL)
    VirtualSources(bounds, nesting).check(dataset, plist.get());
}

void VirtualSources::check(const Hdf5Dataset& dataset, hid_t plist) {
  std::size_t count = 0;
  if (H5Pget_virtual_count(plist, &count) < 0 || count > kMaximumSources ||
      nesting_ > kMaximumNesting) {
    throw_input_error(dataset.file, dataset.position(), "a readable virtual dataset",
                      nesting_ > kMaximumNesting ? "virtual datasets within each other, or a circle"
                                                 : hdf5_reason());
  }
  for (std::size_t i = 0; i < count; ++i) check_source(dataset, plist, i);
}

std::string virtual_name(hid_t plist, std::size_t index,
                         ssize_t (*get)(hid_t, std::size_t, char*, std::size_t)) {
  const ssize_t length = get(plist, index, nullptr, 0);
  if (length <= 0) return {};
  std::string name(static_cast<std::size_t>(length) + 1, '\0');
  get(plist, index, name.data(), name.size());
  name.pop_back();
  return name;
}

void VirtualSources::check_source(const Hdf5Dataset& dataset, hid_t plist, std::size_t index) {
  const std::string file_name = virtual_name(plist, index, H5Pget_virtual_filename);
  const std::string name = virtual_name(plist, index, H5Pget_virtual_dsetname);
  const std::string what =
      fmt::format("source '{}:{}' of the virtual {}", file_name, name, dataset.position());
  const Hdf5Handle selection(H5Pget_virtual_srcspace(plist, index), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(selection.get());
  std::vector<hsize_t> first(static_cast<std::size_t>(std::max(rank, 1))), last(first.size());
  const bool pattern =
      file_name.find('%') != std::string::npos || name.find('%') != std::string::npos;
  const bool all = H5Sget_select_type(selection.get()) == H5S_SEL_ALL;
  if (pattern || (!all && H5Sget_select_bounds(selection.get(), first.data(), last.data()) < 0)) {
    throw_input_error(dataset.file, what,
                      "a source with a fixed name and extent (h5repack writes plain datasets)",
                      "a pattern or an unlimited extent");
  }
  const std::string file =
      file_name == "." ? dataset.file : bounds_.admit(dataset.file, what, file_name);
  const std::vector<hsize_t>& size = checked_size(dataset, what, file, name);
  const Hdf5Handle target(H5Pget_virtual_vspace(plist, index), H5Sclose);
  const hssize_t taken = H5Sget_select_npoints(target.get());
  bool inside =
      all ? product(size) == static_cast<double>(taken) : static_cast<int>(size.size()) == rank;
  for (std::size_t axis = 0; inside && !all && axis < size.size(); ++axis)
    inside = last[axis] < size[axis];
  if (!inside) {
    const std::string expected =
        all ? fmt::format("{} voxels", taken)
            : fmt::format("at least the voxels up to {}", fmt::join(last, ","));
    throw_input_error(dataset.file, what, expected,
                      fmt::format("a dataset of {}", fmt::join(size, "x")));
  }
}

const std::vector<hsize_t>& VirtualSources::checked_size(const Hdf5Dataset& dataset,
                                                         const std::string& what,
                                                         const std::string& file,
                                                         const std::string& name) {
  const auto [known, first] = sizes_.try_emplace({file, name});
  if (!first) return known->second;
  // The library itself follows links within sources; where others are not allowed, there must be
  // none.
  Hdf5Bounds within(file, bounds_.allow_external());
  const Hdf5Dataset source = open_hdf5_dataset(within, file, name);
  if (source.file != file) {
    throw_input_error(dataset.file, what, "a dataset of that file itself",
                      fmt::format("a link to {}", source.file));
  }
  check_storage(bounds_, source, nesting_ + 1);
  return known->second = hdf5_size(source.dataset_id.get());
}

}  // namespace

void check_hdf5_storage(Hdf5Bounds& bounds, const Hdf5Dataset& dataset) {
  check_storage(bounds, dataset, 0);
}

std::vector<hsize_t> reopen_hdf5_dataset(Hdf5Dataset& dataset, const std::vector<int>& slow,
                                         std::size_t width) {
  const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  const Hdf5Handle plist(H5Dget_create_plist(dataset.dataset_id.get()), H5Pclose);
  const fs::path folder = fs::absolute(dataset.file).parent_path();
  H5Pset_efile_prefix(access.get(), folder.c_str());
  H5Pset_virtual_prefix(access.get(), folder.c_str());
  const std::vector<hsize_t> size = hdf5_size(dataset.dataset_id.get());
  const std::vector<hsize_t> chunk = chunk_of(plist.get(), size.size());
  if (!chunk.empty()) {
    const double one = product(chunk) * static_cast<double>(width);
    double layer = one;
    for (std::size_t axis = 0; axis < size.size(); ++axis) {
      const hsize_t chunks = (size[axis] + chunk[axis] - 1) / chunk[axis];
      if (std::find(slow.begin(), slow.end(), static_cast<int>(axis)) == slow.end())
        layer *= static_cast<double>(chunks);
    }
    // One chunk must fit in any case, or each of the boxes within it would inflate it again.
    const double bytes = std::max({std::min(layer, static_cast<double>(kCacheBytes)), one, 0x1p20});
    constexpr std::size_t kSlots = 100003;  // a prime well above the number of chunks in a layer
    H5Pset_chunk_cache(access.get(), kSlots, static_cast<std::size_t>(bytes),
                       H5D_CHUNK_CACHE_W0_DEFAULT);
  }
  dataset.dataset_id = {};
  dataset.dataset_id = {H5Dopen2(dataset.file_id.get(), dataset.name.c_str(), access.get()),
                        H5Dclose};
  if (!dataset.dataset_id.valid())
    throw_input_error(dataset.file, dataset.position(), "a readable dataset", hdf5_reason());
  return chunk;
}

}  // namespace cvr::volumes
