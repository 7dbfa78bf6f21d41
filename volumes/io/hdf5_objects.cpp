#include "volumes/io/hdf5_objects.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <set>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace fs = std::filesystem;

namespace {

constexpr int kMaximumLinks = 64;
constexpr std::size_t kListed = 40;

bool lies_in(const fs::path& folder, const fs::path& path) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

fs::path folder_of(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

std::deque<std::string> components(const std::string& name) {
  std::deque<std::string> parts;
  for (std::size_t start = 0; start < name.size();) {
    const std::size_t end = std::min(name.find('/', start), name.size());
    if (end > start && name.compare(start, end - start, ".") != 0)
      parts.push_back(name.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

void put_before(std::deque<std::string>& rest, const std::string& path) {
  const std::deque<std::string> parts = components(path);
  rest.insert(rest.begin(), parts.begin(), parts.end());
}

std::string link_value(hid_t file, const std::string& path, std::size_t size) {
  std::string value(size + 1, '\0');
  if (H5Lget_val(file, path.c_str(), value.data(), value.size(), H5P_DEFAULT) < 0) return {};
  return value;
}

struct ExternalTarget {
  std::string file, object;
};

ExternalTarget external_target(const std::string& value, std::size_t size) {
  unsigned flags = 0;
  const char *file = nullptr, *object = nullptr;
  if (H5Lunpack_elink_val(value.data(), size, &flags, &file, &object) < 0) return {};
  return {file, object};
}

/// Turns a path into one of hard links alone, opening other files on the way.
class Walk {
 public:
  Walk(Hdf5Bounds& bounds, const std::string& file, const std::string& name)
      : bounds_(bounds), asked_(name), rest_(components(name)) {
    at_.file = file;
    at_.file_id = open_hdf5_file(file, H5F_ACC_RDONLY);
  }

  /// False where nothing has this name.
  bool arrive() {
    while (!rest_.empty()) {
      const std::string path = at_.name + "/" + rest_.front();
      rest_.pop_front();
      H5L_info_t info;
      if (H5Lget_info(at_.file_id.get(), path.c_str(), &info, H5P_DEFAULT) < 0) return false;
      if (info.type == H5L_TYPE_HARD) {
        at_.name = path;
        continue;
      }
      if (++links_ > kMaximumLinks) {
        throw_input_error(bounds_.file(), fmt::format("dataset '{}'", asked_),
                          fmt::format("a way over at most {} links", kMaximumLinks),
                          "a longer one, or a circle");
      }
      follow(path, info);
    }
    return true;
  }

  Hdf5Dataset take() { return std::move(at_); }
  const Hdf5Dataset& at() const { return at_; }

 private:
  void follow(const std::string& path, const H5L_info_t& info) {
    const std::string value = link_value(at_.file_id.get(), path, info.u.val_size);
    if (info.type == H5L_TYPE_SOFT) {
      const std::string target = value.substr(0, value.find('\0'));
      if (target.starts_with('/')) at_.name.clear();
      put_before(rest_, target);
      return;
    }
    if (info.type != H5L_TYPE_EXTERNAL) {
      throw_input_error(at_.file, fmt::format("link '{}'", path), "a hard, soft or external link",
                        "a link of a kind that its writer made");
    }
    const ExternalTarget target = external_target(value, info.u.val_size);
    const std::string file =
        bounds_.admit(at_.file, fmt::format("external link '{}'", path), target.file);
    at_.file = file;
    at_.file_id = open_hdf5_file(file, H5F_ACC_RDONLY);
    at_.name.clear();
    put_before(rest_, target.object);
  }

  Hdf5Bounds& bounds_;
  std::string asked_;
  std::deque<std::string> rest_;
  Hdf5Dataset at_;
  int links_ = 0;
};

Hdf5Entry entry_of(hid_t dataset, std::string name) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const std::vector<hsize_t> size = hdf5_size(dataset);
  Hdf5Entry entry{std::move(name), fmt::format("{}", fmt::join(size, "x")),
                  hdf5_type_name(type.get()), static_cast<int>(size.size()), false};
  entry.voxels = entry.rank >= 3 && entry.rank <= 5 && hdf5_stored(type.get()).width > 0;
  return entry;
}

struct Listing {
  Hdf5Content content;
  std::set<std::pair<unsigned long, haddr_t>> seen;
};

herr_t list_link(hid_t root, const char* name, const H5L_info_t* info, void* data) {
  auto& [content, seen] = *static_cast<Listing*>(data);
  const std::string path = std::string("/") + name;
  if (info->type == H5L_TYPE_EXTERNAL) {
    const ExternalTarget target =
        external_target(link_value(root, path, info->u.val_size), info->u.val_size);
    content.links.push_back(fmt::format("'{}' -> '{}:{}'", path, target.file, target.object));
  }
  if (info->type != H5L_TYPE_HARD) return 0;
  H5O_info_t object;
  if (H5Oget_info_by_name2(root, name, &object, H5O_INFO_BASIC, H5P_DEFAULT) < 0) return 0;
  if (!seen.emplace(object.fileno, object.addr).second) return 0;
  if (object.type == H5O_TYPE_GROUP) content.groups.push_back(path);
  if (object.type != H5O_TYPE_DATASET) return 0;
  const Hdf5Handle dataset(H5Dopen2(root, name, H5P_DEFAULT), H5Dclose);
  if (dataset.valid()) content.datasets.push_back(entry_of(dataset.get(), path));
  return 0;
}

}  // namespace

Hdf5Bounds::Hdf5Bounds(std::string file, bool allow_external)
    : file_(std::move(file)),
      folder_(fs::weakly_canonical(folder_of(file_))),
      allow_external_(allow_external),
      files_{file_} {}

std::string Hdf5Bounds::admit(const std::string& from, const std::string& what,
                              const std::string& target) {
  const fs::path path =
      fs::path(target).is_absolute() ? fs::path(target) : folder_of(from) / target;
  if (!allow_external_ && !lies_in(folder_, fs::weakly_canonical(path))) {
    throw_input_error(
        from, what,
        fmt::format("a file in the volume's own folder {} (others are read with --allow-external, "
                    "in a configuration allow_external: true)",
                    folder_.string()),
        fmt::format("'{}'", target));
  }
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    throw_input_error(from, what, fmt::format("the file '{}' beside it", target),
                      std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) {
    throw_input_error(from, what, fmt::format("a regular file '{}'", target),
                      S_ISDIR(status.st_mode) ? "a folder" : "a device, pipe or socket");
  }
  if (::access(path.c_str(), R_OK) != 0) {
    throw_input_error(from, what, fmt::format("a readable file '{}'", target),
                      std::strerror(errno));
  }
  if (std::find(files_.begin(), files_.end(), path.string()) == files_.end())
    files_.push_back(path.string());
  return path.string();
}

Hdf5Handle open_hdf5_file(const std::string& path, unsigned flags) {
  require_file(path);
  if (H5Fis_hdf5(path.c_str()) <= 0)
    throw_input_error(path, "byte 0", "an HDF5 file", "other content");
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.get(), false, true);
  Hdf5Handle file(H5Fopen(path.c_str(), flags, access.get()), H5Fclose);
  if (!file.valid()) throw_input_error(path, "", "a complete HDF5 file", hdf5_reason());
  return file;
}

std::string Hdf5Dataset::position() const { return fmt::format("dataset '{}'", name); }

Hdf5Dataset open_hdf5_dataset(Hdf5Bounds& bounds, const std::string& file,
                              const std::string& name) {
  Walk walk(bounds, file, name);
  const std::string position = fmt::format("dataset '{}'", name);
  if (!walk.arrive()) {
    throw_input_error(walk.at().file, position, "the name of a dataset",
                      to_string(list_hdf5(walk.at().file_id.get())));
  }
  Hdf5Dataset found = walk.take();
  H5O_info_t object;
  const bool known =
      !found.name.empty() && H5Oget_info_by_name2(found.file_id.get(), found.name.c_str(), &object,
                                                  H5O_INFO_BASIC, H5P_DEFAULT) >= 0;
  if (found.name.empty() || (known && object.type != H5O_TYPE_DATASET)) {
    throw_input_error(found.file, position, "the name of a dataset",
                      "a group or type; there are " + to_string(list_hdf5(found.file_id.get())));
  }
  found.dataset_id = {H5Dopen2(found.file_id.get(), found.name.c_str(), H5P_DEFAULT), H5Dclose};
  if (!found.dataset_id.valid())
    throw_input_error(found.file, position, "a readable dataset", hdf5_reason());
  return found;
}

Hdf5Content list_hdf5(hid_t file) {
  Listing listing;
  H5O_info_t root;
  if (H5Oget_info2(file, &root, H5O_INFO_BASIC) >= 0) listing.seen.emplace(root.fileno, root.addr);
  H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, list_link, &listing);
  return std::move(listing.content);
}

std::string to_string(const Hdf5Content& content) {
  std::vector<std::string> parts;
  for (const Hdf5Entry& entry : content.datasets) {
    parts.push_back(fmt::format("{} (rank {}, {}, {})", entry.name, entry.rank,
                                entry.rank == 0 ? "one value" : entry.shape, entry.type));
  }
  if (parts.empty()) parts.emplace_back("no dataset");
  for (const std::string& link : content.links) parts.push_back("external link " + link);
  if (parts.size() > kListed) {
    const std::size_t more = parts.size() - kListed;
    parts.resize(kListed);
    parts.push_back(fmt::format("and {} more", more));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::vector<hsize_t> hdf5_size(hid_t dataset) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  std::vector<hsize_t> size(static_cast<std::size_t>(std::max(rank, 0)));
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
  return size;
}

}  // namespace cvr::volumes
