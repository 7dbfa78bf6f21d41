// Reads boxes of precomputed folders chunk by chunk; the format facts are in precomputed.hpp.
//
// Decoded chunks are kept, up to one layer in z and 256 MiB, oldest out first, so that slabs
// thinner than a chunk do not decode each chunk again and again.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <filesystem>
#include <unordered_map>

#include "volumes/io/file.hpp"
#include "volumes/io/gzip.hpp"
#include "volumes/io/precomputed.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kCacheBytes = std::uint64_t{256} << 20;

struct Location {
  std::string folder;
  std::string key;  ///< empty: the first scale
};

/// The folder with the `info` file, going up from the path, and what is left of the path as the
/// scale's key.
std::optional<Location> locate(const std::string& path) {
  fs::path folder(path);
  if (!folder.has_filename()) folder = folder.parent_path();
  fs::path key;
  while (!folder.empty()) {
    std::error_code ignored;
    if (fs::is_regular_file(folder / "info", ignored))
      return Location{folder.string(), key.generic_string()};
    if (!folder.has_filename()) break;
    key = key.empty() ? folder.filename() : folder.filename() / key;
    folder = folder.parent_path();
  }
  std::error_code ignored;
  const bool here = !fs::path(path).is_absolute() && fs::is_regular_file("info", ignored);
  return here ? std::optional(Location{".", key.generic_string()}) : std::nullopt;
}

/// Throws unless `path` lies in the folder of the volume once all symbolic links are followed.
void check_inside(const std::string& path, const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::canonical(path, error);
  if (error) throw_input_error(path, "", "a readable file or folder", error.message());
  const fs::path inside = whole.lexically_relative(folder);
  if (inside.empty() || *inside.begin() == "..") {
    throw_input_error(path, "",
                      "a file in the volume's own folder, or --allow-external (allow_external: "
                      "true in a configuration)",
                      fmt::format("a symbolic link to '{}'", whole.string()));
  }
}

/// The axes are those of the format; a caller may say so.
void check_axes(const std::string& file, const std::string& axes) {
  if (axes.empty() || axes == "xyz" || axes == "xyzc") return;
  throw_input_error(file, "axes", "none, xyz or xyzc, since precomputed volumes are stored so",
                    fmt::format("'{}'", axes));
}

/// Only a name that is truly absent counts as missing: a folder that may not be read must not pass
/// for zeros.
bool exists(const std::string& name) {
  std::error_code error;
  const fs::file_type type = fs::status(name, error).type();
  if (type == fs::file_type::none || type == fs::file_type::unknown) {
    throw_input_error(name, "", "a readable chunk or none", error.message());
  }
  return type != fs::file_type::not_found;
}

/// The indices that [origin, origin + count) and [start, start + size) share on one axis.
struct Overlap {
  std::uint64_t begin, end;
};
Overlap overlap(std::uint64_t origin, std::uint64_t count, std::uint64_t start,
                std::uint64_t size) {
  return {std::max(origin, start), std::min(origin + count, start + size)};
}

/// Copies the voxels that two boxes share, from one dense array to the other.
void copy_shared(const Box& from, const std::byte* source, const Box& to, std::byte* target,
                 std::size_t voxel) {
  const Overlap x = overlap(to.origin.x, to.size.x, from.origin.x, from.size.x);
  const Overlap y = overlap(to.origin.y, to.size.y, from.origin.y, from.size.y);
  const Overlap z = overlap(to.origin.z, to.size.z, from.origin.z, from.size.z);
  const auto index = [](const Box& box, const Coordinate& c) {
    return box.size.index({c.x - box.origin.x, c.y - box.origin.y, c.z - box.origin.z});
  };
  const std::size_t row = (x.end - x.begin) * voxel;
  for (std::uint64_t k = z.begin; k < z.end; ++k) {
    for (std::uint64_t j = y.begin; j < y.end; ++j) {
      const Coordinate c{x.begin, j, k};
      std::byte* out = target + index(to, c) * voxel;
      if (source == nullptr) {
        std::memset(out, 0, row);
      } else {
        std::memcpy(out, source + index(from, c) * voxel, row);
      }
    }
  }
}

class PrecomputedSource final : public VolumeSource {
 public:
  PrecomputedSource(const Location& location, const OpenOptions& options)
      : root_(fs::canonical(location.folder)) {
    const std::string file = (fs::path(location.folder) / "info").string();
    check_axes(file, options.axes);
    allow_external_ = options.allow_external;
    if (!allow_external_) check_inside(file, root_);
    const PrecomputedInfo info = read_precomputed_info(file, location.key);
    const Interpretation meaning = interpret(file, info.type, options.kind, info.kind);
    scale_ = info.scale;
    reject_negative_ = meaning.reject_negative;
    info_ = {.extent = scale_.size,
             .type = meaning.type,
             .kind = meaning.kind,
             .voxel_size = scale_.resolution,
             .voxel_unit = "nm"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      info_.offset[axis] = static_cast<double>(scale_.voxel_offset[axis]) * scale_.resolution[axis];
    }
    folder_ = (fs::path(location.folder) / scale_.key).string();
    if (!fs::is_directory(folder_)) {
      throw_input_error(
          folder_, "", "the folder of a scale",
          fmt::format("none; info names the scales {}", describe_precomputed_scales(file)));
    }
    if (!allow_external_) check_inside(folder_, root_);
    check_chunk_names(folder_, scale_);
    const std::uint64_t layer = scale_.size.x * scale_.size.y *
                                std::max<std::uint64_t>(scale_.chunk.z, 1) * size_of(info_.type);
    cache_limit_ = std::min(layer, kCacheBytes);
  }

  const VolumeInfo& info() const override { return info_; }

  std::vector<std::string> files() const override { return {root_.string()}; }

  void read(const Box& box, std::byte* out) const override {
    if (box.size.voxels() == 0) return;
    const Extent& chunk = scale_.chunk;
    const auto last = [](std::uint64_t origin, std::uint64_t size, std::uint64_t edge) {
      return (origin + size - 1) / edge;
    };
    for (std::uint64_t z = box.origin.z / chunk.z; z <= last(box.origin.z, box.size.z, chunk.z);
         ++z) {
      for (std::uint64_t y = box.origin.y / chunk.y; y <= last(box.origin.y, box.size.y, chunk.y);
           ++y) {
        for (std::uint64_t x = box.origin.x / chunk.x; x <= last(box.origin.x, box.size.x, chunk.x);
             ++x) {
          const Box from = chunk_box({x, y, z});
          const Buffer& voxels = chunk_voxels(from);
          copy_shared(from, voxels.empty() ? nullptr : voxels.data(), box, out,
                      size_of(info_.type));
        }
      }
    }
  }

 private:
  Box chunk_box(const Coordinate& chunk) const {
    const Coordinate origin{chunk.x * scale_.chunk.x, chunk.y * scale_.chunk.y,
                            chunk.z * scale_.chunk.z};
    const Extent& size = scale_.size;
    return {
        origin,
        {std::min(scale_.chunk.x, size.x - origin.x), std::min(scale_.chunk.y, size.y - origin.y),
         std::min(scale_.chunk.z, size.z - origin.z)}};
  }

  /// The decoded chunk; empty where it has no file and is all zeros. Valid until the next call.
  const Buffer& chunk_voxels(const Box& box) const {
    const std::uint64_t id = scale_.size.index(box.origin);
    if (const auto found = chunks_.find(id); found != chunks_.end()) return found->second;
    Buffer voxels = decode_chunk(box);
    cached_bytes_ += voxels.size();
    while (cached_bytes_ > cache_limit_ && !order_.empty()) {
      const auto oldest = chunks_.find(order_.front());
      cached_bytes_ -= oldest->second.size();
      chunks_.erase(oldest);
      order_.pop_front();
    }
    order_.push_back(id);
    return chunks_.emplace(id, std::move(voxels)).first->second;
  }

  Buffer decode_chunk(const Box& box) const {
    const std::string plain = (fs::path(folder_) / precomputed_chunk_name(scale_, box)).string();
    const bool there = exists(plain), gzipped = exists(plain + ".gz");
    if (there && gzipped)
      throw_input_error(plain, "", "one file of a chunk",
                        "another one with the ending .gz beside it");
    if (!there && !gzipped) return {};
    const std::string name = gzipped ? plain + ".gz" : plain;
    if (!allow_external_) check_inside(name, root_);
    const MappedFile file(name);
    Buffer voxels = scale_.compressed ? decode_compressed(file, box) : decode_raw(file, box);
    if (reject_negative_) reject_negative_voxels(name, voxels.bytes(), size_of(info_.type));
    return voxels;
  }

  Buffer decode_raw(const MappedFile& file, const Box& box) const {
    const std::uint64_t needed = box.size.voxels() * size_of(info_.type);
    const bool right_size = file.bytes().size() == needed;
    if (is_gzip(file.bytes())) {
      try {
        check_inflatable(file.path(), file.bytes().size(), needed);
        Buffer voxels = inflate_all(file.path(), file.bytes(), needed);
        if (voxels.size() == needed) return voxels;
        throw_input_error(file.path(), "", fmt::format("{} inflated bytes of voxels", needed),
                          fmt::format("{}", voxels.size()));
      } catch (const InputError&) {
        if (!right_size || file.path().ends_with(".gz"))
          throw;  // else: plain voxels that begin like gzip
      }
    }
    if (!right_size) {
      throw_input_error(file.path(), "", fmt::format("{} bytes of voxels", needed),
                        fmt::format("{}", file.bytes().size()));
    }
    Buffer voxels;
    voxels.append(file.bytes());
    return voxels;
  }

  /// The stream begins with the channel offset 1, as encode_compressed_segmentation writes it and
  /// the decoder expects it.
  Buffer decode_compressed(const MappedFile& file, const Box& box) const {
    const BlockSize& block = scale_.block;
    const std::uint64_t blocks = ((box.size.x + block.x - 1) / block.x) *
                                 ((box.size.y + block.y - 1) / block.y) *
                                 ((box.size.z + block.z - 1) / block.z);
    const std::uint64_t longest = 4 + blocks * (8 + block.voxels() * (4 + 8));
    Buffer bytes;
    if (is_gzip(file.bytes())) {
      bytes = inflate_all(file.path(), file.bytes(), longest);
    } else {
      bytes.append(file.bytes());
    }
    if (bytes.size() < 4 + 8 * blocks || bytes.size() % 4 != 0) {
      throw_input_error(file.path(), "",
                        fmt::format("a stream of whole words with {} block headers", blocks),
                        fmt::format("{} bytes", bytes.size()));
    }
    Buffer voxels(box.size.voxels() * size_of(info_.type));
    const std::span words(reinterpret_cast<const std::uint32_t*>(bytes.data()), bytes.size() / 4);
    const auto decode = [&]<class T>() {
      return decode_compressed_segmentation(words, box.size, block,
                                            reinterpret_cast<T*>(voxels.data()));
    };
    const Expected<void> done = info_.type == VoxelType::kU64 ? decode.operator()<std::uint64_t>()
                                                              : decode.operator()<std::uint32_t>();
    if (!done)
      throw_input_error(file.path(), "", "a compressed_segmentation stream", done.error().message);
    return voxels;
  }

  VolumeInfo info_;
  PrecomputedScale scale_;
  std::string folder_;
  fs::path root_;  ///< the folder with `info`, without symbolic links
  bool allow_external_ = false;
  bool reject_negative_ = false;
  std::uint64_t cache_limit_ = 0;
  mutable std::unordered_map<std::uint64_t, Buffer> chunks_;
  mutable std::deque<std::uint64_t> order_;
  mutable std::uint64_t cached_bytes_ = 0;
};

}  // namespace

bool is_precomputed_path(const std::string& path) {
  if (path.empty()) return false;
  if (path.ends_with('/')) return true;
  for (const auto& part : fs::path(path)) {
    if (part.extension() == ".precomputed") return true;
  }
  std::error_code ignored;
  return fs::is_directory(path, ignored) && locate(path).has_value();
}

bool lies_in_precomputed(const std::string& path) { return locate(path).has_value(); }

std::unique_ptr<VolumeSource> open_precomputed(const VolumePath& path, const OpenOptions& options) {
  const auto location = locate(path.file);
  if (!location)
    throw_input_error(path.file, "", "a Neuroglancer precomputed folder",
                      "no file info in it or above it");
  return std::make_unique<PrecomputedSource>(*location, options);
}

}  // namespace cvr::volumes
