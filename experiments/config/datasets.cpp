#include "experiments/config/datasets.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/generators/generator.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {

namespace fs = std::filesystem;
using volumes::Box;
using volumes::Extent;
using volumes::InputError;
using volumes::VolumeInfo;
using volumes::VolumeSource;

namespace {

/// Files beyond this are identified by size, time stamp and their first and last bytes: reading
/// them takes minutes.
constexpr std::uint64_t kWholeHashLimit = std::uint64_t{8} << 30;
constexpr std::uint64_t kEdgeBytes = 1 << 20;

class Hash {
 public:
  Hash() : state_(XXH3_createState()) { XXH3_64bits_reset(state_); }
  ~Hash() { XXH3_freeState(state_); }
  Hash(const Hash&) = delete;
  Hash& operator=(const Hash&) = delete;
  void add(const void* data, std::size_t size) { XXH3_64bits_update(state_, data, size); }
  void add(std::string_view text) { add(text.data(), text.size()); }
  std::string digits() const { return fmt::format("{:016x}", XXH3_64bits_digest(state_)); }

 private:
  XXH3_state_t* state_;
};

void hash_range(Hash& hash, std::ifstream& in, std::uint64_t count) {
  std::vector<char> block(kEdgeBytes);
  while (count > 0) {
    const std::uint64_t part = std::min<std::uint64_t>(count, block.size());
    in.read(block.data(), static_cast<std::streamsize>(part));
    hash.add(block.data(), static_cast<std::size_t>(in.gcount()));
    if (static_cast<std::uint64_t>(in.gcount()) < part) return;
    count -= part;
  }
}

std::string hash_file(const fs::path& path) {
  const std::uint64_t size = fs::file_size(path);
  std::ifstream in(path, std::ios::binary);
  Hash hash;
  if (size <= kWholeHashLimit) {
    hash_range(hash, in, size);
    return hash.digits();
  }
  hash.add(fmt::format("{} {}", size, fs::last_write_time(path).time_since_epoch().count()));
  hash_range(hash, in, kEdgeBytes);
  in.seekg(static_cast<std::streamoff>(size - kEdgeBytes));
  hash_range(hash, in, kEdgeBytes);
  return hash.digits();
}

/// A Neuroglancer folder: its `info` and the names and sizes of all chunks.
std::string hash_folder(const fs::path& path) {
  std::vector<std::string> entries;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file())
      entries.push_back(fmt::format("{} {}\n", entry.path().lexically_relative(path).string(),
                                    entry.file_size()));
  }
  std::ranges::sort(entries);
  Hash hash;
  for (const std::string& entry : entries) hash.add(entry);
  if (fs::exists(path / "info")) hash.add(hash_file(path / "info"));
  return hash.digits();
}

std::string hash_probe(const VolumeSource& source) {
  Hash hash;
  const Extent& e = source.info().extent;
  const auto probe = [&](const volumes::Coordinate& origin, std::uint64_t edge) {
    const Box box{origin,
                  {std::min(edge, e.x - origin.x), std::min(edge, e.y - origin.y),
                   std::min(edge, e.z - origin.z)}};
    std::vector<std::byte> voxels(box.size.voxels() * size_of(source.info().type));
    source.read(box, voxels.data());
    hash.add(voxels.data(), voxels.size());
  };
  probe({0, 0, 0}, 8);
  probe({e.x / 2, e.y / 2, e.z / 2}, 16);
  return hash.digits();
}

std::string generator_text(const GeneratorChoice& choice, const Extent& extent) {
  std::string text = fmt::format("{} {} seed={}", choice.kind, to_string(extent), choice.seed);
  for (const auto& [name, value] : choice.parameters) text += fmt::format(" {}={}", name, value);
  return text;
}

std::string identify(std::string_view text) {
  Hash hash;
  hash.add(text);
  return hash.digits();
}

Location locate_generated(const Dataset& dataset) {
  Location location;
  location.generator = dataset.generator;
  const Extent extent = dataset.generated_extent();
  const auto source = volumes::make_generator(
      dataset.generator->kind, extent, dataset.generator->seed, dataset.generator->parameters, 1);
  location.info = source->info();
  location.identity = identify(generator_text(*dataset.generator, extent) + hash_probe(*source));
  location.present = true;
  if (dataset.stand_in_for.empty()) {
    location.label = "generated";
  } else {
    const std::string original = dataset.title.substr(0, dataset.title.find_first_of(":,"));
    location.label = fmt::format("stand-in for {}, {} of {}", original, to_string(extent),
                                 to_string(dataset.full_extent));
  }
  return location;
}

Location missing(std::string reason) {
  Location location;
  location.missing = std::move(reason);
  return location;
}

Location locate_file(const Dataset& dataset, const std::string& path) {
  const std::string file = file_of_volume(path);
  if (!fs::exists(file)) {
    return missing(
        file + " is absent" +
        (dataset.package.empty() ? "" : fmt::format(" (Debian package {})", dataset.package)));
  }
  try {
    const std::string hash = fs::is_directory(file) ? hash_folder(file) : hash_file(file);
    if (!dataset.hash.empty() && dataset.hash != hash) {
      return missing(
          fmt::format("{} has the hash {}, its description says {}", file, hash, dataset.hash));
    }
    Location location;
    location.path = path;
    location.axes = dataset.axes;
    location.allow_external = dataset.allow_external;
    location.info =
        volumes::open_volume(path, {dataset.kind, dataset.axes, dataset.allow_external})->info();
    const auto shape = [](const Extent& step, std::uint64_t steps, volumes::VoxelType type) {
      return fmt::format("{}{} {}", to_string(step),
                         steps == 1 ? "" : fmt::format(" in {} time steps", steps), name_of(type));
    };
    const VolumeInfo& info = location.info;
    const std::string found = shape(info.step_extent(), info.time_steps, info.type);
    const std::string described = shape(dataset.extent, dataset.time_steps, dataset.type);
    if (found != described)
      return missing(fmt::format("{} holds {}, its description says {}", path, found, described));
    location.info.kind = dataset.kind;
    std::string named =
        fmt::format("{} {} {}", hash, path.substr(file.size()), name_of(dataset.kind));
    if (!dataset.axes.empty()) named += " axes=" + dataset.axes;
    if (dataset.allow_external) named += " allow_external";
    location.identity = identify(named);
    location.present = true;
    return location;
  } catch (const std::exception& error) {
    return missing(error.what());
  }
}

Extent exchange(const Extent& e) { return {e.z, e.y, e.x}; }

/// Extent, voxel size and offset, each (z, y, x); what was time lies along x then.
void exchange_axes_of(VolumeInfo& info) {
  info.extent = exchange(info.extent);
  std::swap(info.voxel_size[0], info.voxel_size[2]);
  std::swap(info.offset[0], info.offset[2]);
  info.time_steps = 1;
}

/// Another source whose voxels have another size.
class SizedSource final : public VolumeSource {
 public:
  SizedSource(std::unique_ptr<VolumeSource> source, const VolumeInfo& sized)
      : source_(std::move(source)), info_(source_->info()) {
    info_.voxel_size = sized.voxel_size;
    info_.voxel_unit = sized.voxel_unit;
  }
  const VolumeInfo& info() const override { return info_; }
  void read(const Box& box, std::byte* out) const override { source_->read(box, out); }
  const std::byte* data() const override { return source_->data(); }
  volumes::Provenance provenance() const override { return source_->provenance(); }
  std::vector<std::string> files() const override { return source_->files(); }

 private:
  std::unique_ptr<VolumeSource> source_;
  VolumeInfo info_;
};

/// Gives a volume that says no voxel size that of its description. Only proportions change what is
/// measured (images), so equal edges leave the identity as it is.
void add_voxel_size(const Dataset& dataset, Location& location) {
  VolumeInfo& info = location.info;
  const std::array<double, 3> unsaid{1, 1, 1};
  if (!dataset.voxel_size || info.voxel_size != unsaid || !info.voxel_unit.empty()) return;
  info.voxel_size = *dataset.voxel_size;
  info.voxel_unit = dataset.voxel_unit;
  const auto& [x, y, z] = info.voxel_size;
  if (x == y && y == z) return;
  location.identity = identify(fmt::format("voxel size {} {} {} {}", x, y, z, location.identity));
}

/// The voxels of another source in the same order, said to be of extent (Z, Y, X).
class ExchangedSource final : public VolumeSource {
 public:
  explicit ExchangedSource(const VolumeSource& source)
      : volume_(volumes::read_all(source)),
        provenance_(source.provenance()),
        files_(source.files()) {
    exchange_axes_of(volume_.info());
  }
  const VolumeInfo& info() const override { return volume_.info(); }
  void read(const Box& box, std::byte* out) const override {
    volumes::MemorySource(volume_).read(box, out);
  }
  const std::byte* data() const override { return volume_.data(); }
  volumes::Provenance provenance() const override { return provenance_; }
  std::vector<std::string> files() const override { return files_; }

 private:
  volumes::Volume volume_;
  volumes::Provenance provenance_;
  std::vector<std::string> files_;
};

}  // namespace

std::string file_of_volume(const std::string& volume_path) {
  if (fs::exists(volume_path)) return volume_path;
  const std::size_t colon = volume_path.rfind(":/");
  if (colon != std::string::npos && colon > 0) return volume_path.substr(0, colon);
  return volume_path.substr(0, volume_path.rfind('['));
}

std::string name_of_file(const std::string& volume_path) {
  std::string name = fs::path(file_of_volume(volume_path)).filename().string();
  name = name.substr(0, name.find('.', 1));
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '-';
  }
  return name;
}

bool are_axes(const std::string& text) {
  for (const char required : {'x', 'y', 'z'}) {
    if (text.find(required) == std::string::npos) return false;
  }
  return std::ranges::all_of(text, [&](char c) {
    return std::string_view("tzyxc").find(c) != std::string_view::npos &&
           std::ranges::count(text, c) == 1;
  });
}

bool is_too_large(const Extent& extent, std::uint64_t time_steps) {
  std::uint64_t voxels = 1;
  for (const std::uint64_t factor : {extent.x, extent.y, extent.z, time_steps}) {
    if (__builtin_mul_overflow(voxels, factor, &voxels)) return true;
  }
  return voxels > kMostVoxels;
}

Location locate_in_order(const Dataset& dataset, const Places& places) {
  std::string path = dataset.file;
  std::string reason;
  if (path.starts_with(kDataVariable)) {
    if (places.data.empty()) reason = "the data folder is not named (--data DIR or CVRBENCH_DATA)";
    path = places.data + path.substr(kDataVariable.size());
  }
  if (!path.empty() && reason.empty()) {
    // A file that is there but differs from its description is never replaced by a stand-in in
    // silence.
    if (fs::exists(file_of_volume(path)) || !dataset.generator) return locate_file(dataset, path);
  }
  if (dataset.generator) return locate_generated(dataset);
  return missing(reason);
}

Location locate(const Dataset& dataset, const Places& places) {
  Location location = locate_in_order(dataset, places);
  if (!location.present) return location;
  add_voxel_size(dataset, location);
  if (!dataset.exchange_axes) return location;
  location.exchanged = true;
  exchange_axes_of(location.info);
  location.identity = identify("exchanged axes " + location.identity);
  location.label = location.label.empty() ? "misread (axes exchanged on purpose)"
                                          : location.label + ", axes exchanged on purpose";
  return location;
}

std::unique_ptr<VolumeSource> open_location(const Location& location, unsigned threads) {
  if (location.exchanged) {
    Location in_order = location;
    in_order.exchanged = false;
    exchange_axes_of(in_order.info);
    return std::make_unique<ExchangedSource>(*open_location(in_order, threads));
  }
  auto source = location.path.empty()
                    ? volumes::make_generator(location.generator->kind, location.info.step_extent(),
                                              location.generator->seed,
                                              location.generator->parameters, threads)
                    : volumes::open_volume(location.path, {location.info.kind, location.axes,
                                                           location.allow_external});
  if (source->info().voxel_size == location.info.voxel_size &&
      source->info().voxel_unit == location.info.voxel_unit)
    return source;
  return std::make_unique<SizedSource>(std::move(source), location.info);
}

}  // namespace cvr::experiments
