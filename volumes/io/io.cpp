// The table of formats, and how a name picks its line. A new format is one line here and one file beside it.
#include "volumes/io/io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

struct Format {
  std::string_view name;
  std::array<std::string_view, 2>
      endings;  ///< of the file name; none: the precomputed folder, known by other signs
  bool has_datasets;
  bool has_steps;
  std::unique_ptr<VolumeSource> (*open)(const VolumePath&, const OpenOptions&);
  void (*write)(const VolumePath&, const VolumeSource&);

  bool matches(const std::string& file) const {
    return std::any_of(endings.begin(), endings.end(), [&](std::string_view ending) {
      return !ending.empty() && file.size() > ending.size() && has_ending(file, ending);
    });
  }
};

constexpr std::array kFormats{
    Format{"HDF5", {".h5", ".hdf5"}, true, true, open_hdf5, write_hdf5},
    Format{"NRRD", {".nrrd", ".nhdr"}, false, true, open_nrrd, write_nrrd},
    Format{"NIfTI", {".nii", ".nii.gz"}, false, true, open_nifti, write_nifti},
    Format{"raw", {".raw", ""}, false, true, open_raw, write_raw},
};
constexpr Format kPrecomputed{"precomputed", {}, false, false, open_precomputed, write_precomputed};

struct Chosen {
  const Format* format = nullptr;  ///< null: not the name of a volume
  VolumePath path;
};

/// Cuts "[T]" or "[A:B]" off the end.
std::optional<StepRange> cut_steps(std::string& name) {
  const std::size_t open = name.rfind('[');
  if (!name.ends_with(']') || open == std::string::npos) return std::nullopt;
  StepRange steps;
  const char* const end = name.data() + name.size() - 1;
  std::from_chars_result read = std::from_chars(name.data() + open + 1, end, steps.first);
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == ':')
    read = std::from_chars(read.ptr + 1, end, steps.end.emplace());
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  name.resize(open);
  return steps;
}

Chosen choose_file(const std::string& path) {
  for (const Format& format : kFormats) {
    if (format.matches(path)) return {&format, {path, {}, {}}};
    VolumePath cut{path, {}, {}};
    if (format.has_steps) cut.steps = cut_steps(cut.file);
    if (format.matches(cut.file)) return {&format, cut};
    if (!format.has_datasets) continue;
    for (std::size_t colon = cut.file.find(':'); colon != std::string::npos;
         colon = cut.file.find(':', colon + 1)) {
      const std::string file = cut.file.substr(0, colon);
      if (format.matches(file)) return {&format, {file, cut.file.substr(colon + 1), cut.steps}};
    }
  }
  return {};
}

/// A file inside a folder called X.precomputed is a file; a precomputed folder called X.raw is a folder.
Chosen choose(const std::string& path) {
  const Chosen file = choose_file(path);
  std::error_code ignored;
  const bool may_be_folder = file.format == nullptr || std::filesystem::is_directory(path, ignored);
  return may_be_folder && is_precomputed_path(path) ? Chosen{&kPrecomputed, {path, {}, {}}} : file;
}

/// What a name that no format matches looks like, and what to do about it.
std::string describe_name(const std::string& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (path.empty()) return "an empty name";
  if (std::filesystem::is_directory(status)) return "a folder without a file info";
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return "a device, pipe or socket";
  if (path.ends_with(']') && path.find('[') != std::string::npos)
    return fmt::format("'{}' (steps are written [T] or [A:B] with numbers from 0)", path.substr(path.rfind('[')));
  for (const std::string_view pair : {".hdr", ".img", ".hdr.gz", ".img.gz"}) {
    if (has_ending(path, pair)) return fmt::format("'{}', one of a NIfTI or Analyze pair: convert it to one .nii file", pair);
  }
  const std::string ending = std::filesystem::path(path).extension().string();
  return ending.empty() ? "a name without an ending" : fmt::format("the ending '{}'", ending);
}

Chosen choose_or_throw(const std::string& path) {
  Chosen chosen = choose(path);
  if (chosen.format == nullptr) {
    throw_input_error(
        path, "", "a name ending in .h5, .hdf5, .nrrd, .nhdr, .nii, .nii.gz, .raw, or a precomputed folder",
        describe_name(path));
  }
  return chosen;
}

/// The same for a volume to be written: an existing folder becomes a precomputed one only when its name says so.
Chosen choose_output(const std::string& path) {
  std::error_code ignored;
  if (choose(path).format == nullptr && std::filesystem::is_directory(path, ignored)) {
    throw_input_error(path, "", "the name of a file, or of a precomputed folder with a slash at its end",
                      fmt::format("a folder; type {}/ for a precomputed one, or {}/NAME.h5 for a file in it", path, path));
  }
  return choose_or_throw(path);
}

}  // namespace

std::unique_ptr<VolumeSource> open_volume(const std::string& path, std::optional<VolumeKind> kind) {
  return open_volume(path, OpenOptions{.kind = kind, .axes = {}});
}

std::unique_ptr<VolumeSource> open_volume(const std::string& path, const OpenOptions& options) {
  const Chosen chosen = choose_or_throw(path);
  try {
    return chosen.format->open(chosen.path, options);
  } catch (const std::filesystem::filesystem_error& error) {
    throw_input_error(path, "", "a readable file or folder", error.what());
  }
}

void write_volume(const std::string& path, const VolumeSource& source) {
  const Chosen chosen = choose_output(path);
  if (chosen.path.steps) throw_input_error(path, "", "a name without steps: a series is written whole", "[...]");
  const VolumeInfo& info = source.info();
  check_extent(path, "", {info.extent.x, info.extent.y, info.extent.z}, info.type);
  if (info.time_steps > 1 && !chosen.format->has_steps) {
    throw_input_error(path, "", fmt::format("a single volume, since {} has no time axis", chosen.format->name),
                      fmt::format("a series of {} steps", info.time_steps));
  }
  try {
    chosen.format->write(chosen.path, source);
  } catch (const std::filesystem::filesystem_error& error) {
    throw_input_error(path, "", "a name that can be written", error.what());
  }
}

bool is_volume_path(const std::string& path) { return choose(path).format != nullptr; }

}  // namespace cvr::volumes
