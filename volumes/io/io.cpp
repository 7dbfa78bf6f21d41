// The table of formats, and how a name picks its line. A new format is one line here and one file
// beside it.
#include "volumes/io/io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/precomputed.hpp"

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
  std::string_view beside_ending;  ///< files whose names end so are written ...
  std::string_view beside;         ///< ... with a second one, of the same name and this behind it

  bool matches(const std::string& file) const {
    return std::any_of(endings.begin(), endings.end(), [&](std::string_view ending) {
      return !ending.empty() && file.size() > ending.size() && has_ending(file, ending);
    });
  }
};

constexpr std::array kFormats{
    Format{"HDF5", {".h5", ".hdf5"}, true, true, open_hdf5, write_hdf5, "", ""},
    Format{"NRRD", {".nrrd", ".nhdr"}, false, true, open_nrrd, write_nrrd, ".nhdr", ".bin"},
    Format{"NIfTI", {".nii", ".nii.gz"}, false, true, open_nifti, write_nifti, "", ""},
    Format{"raw", {".raw", ""}, false, true, open_raw, write_raw, ".raw", ".yaml"},
};
constexpr Format kPrecomputed{"precomputed",     {}, false, false, open_precomputed,
                              write_precomputed, "", ""};

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

/// A file inside a folder called X.precomputed is a file; a precomputed folder called X.raw is a
/// folder.
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
  if (std::filesystem::is_directory(status)) {
    return fmt::format(
        "a folder without a file info ('{0}/' writes a precomputed volume to it, '{0}/NAME.h5' a "
        "file in it)",
        path);
  }
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return "a device, pipe or socket";
  if (path.ends_with(']') && path.find('[') != std::string::npos)
    return fmt::format("'{}' (steps are written [T] or [A:B] with numbers from 0)",
                       path.substr(path.rfind('[')));
  for (const std::string_view pair : {".hdr", ".img", ".hdr.gz", ".img.gz"}) {
    if (has_ending(path, pair))
      return fmt::format("'{}', one of a NIfTI or Analyze pair: convert it to one .nii file", pair);
  }
  const std::string ending = std::filesystem::path(path).extension().string();
  return ending.empty() ? "a name without an ending" : fmt::format("the ending '{}'", ending);
}

Chosen choose_or_throw(const std::string& path) {
  Chosen chosen = choose(path);
  if (chosen.format == nullptr) {
    throw_input_error(
        path, "",
        "a name ending in .h5, .hdf5, .nrrd, .nhdr, .nii, .nii.gz, .raw, or a precomputed folder",
        describe_name(path));
  }
  return chosen;
}

/// The same for a volume to be written: an existing folder becomes a precomputed one only when its
/// name says so.
Chosen choose_output(const std::string& path) {
  std::error_code ignored;
  if (choose(path).format == nullptr && std::filesystem::is_directory(path, ignored)) {
    throw_input_error(
        path, "", "the name of a file, or of a precomputed folder with a slash at its end",
        fmt::format("a folder; type {}/ for a precomputed one, or {}/NAME.h5 for a file in it",
                    path, path));
  }
  return choose_or_throw(path);
}

}  // namespace

std::unique_ptr<VolumeSource> open_volume(const std::string& path, std::optional<VolumeKind> kind) {
  return open_volume(path, OpenOptions{.kind = kind, .axes = {}});
}

std::unique_ptr<VolumeSource> open_volume(const std::string& path, const OpenOptions& options) {
  // A name below a precomputed folder that is no folder is a wrong key, which the reader explains.
  const bool wrong_key = choose(path).format == nullptr && lies_in_precomputed(path);
  const Chosen chosen = wrong_key ? Chosen{&kPrecomputed, {path, {}, {}}} : choose_or_throw(path);
  try {
    return chosen.format->open(chosen.path, options);
  } catch (const std::filesystem::filesystem_error& error) {
    throw_input_error(path, "", "a readable file or folder", error.what());
  }
}

void write_volume(const std::string& path, const VolumeSource& source) {
  const Chosen chosen = choose_output(path);
  check_volume_output(path, source.files());
  if (chosen.path.steps)
    throw_input_error(path, "", "a name without steps: a series is written whole", "[...]");
  const VolumeInfo& info = source.info();
  check_extent(path, "", {info.extent.x, info.extent.y, info.extent.z}, info.type);
  if (info.time_steps > 1 && !chosen.format->has_steps) {
    throw_input_error(
        path, "", fmt::format("a single volume, since {} has no time axis", chosen.format->name),
        fmt::format("a series of {} steps", info.time_steps));
  }
  try {
    chosen.format->write(chosen.path, source);
  } catch (const std::filesystem::filesystem_error& error) {
    throw_output_error(path, error.what());
  }
}

std::vector<std::string> volume_outputs(const std::string& path) {
  const Chosen chosen = choose_or_throw(path);
  std::vector<std::string> outputs{chosen.path.file};
  const std::string_view ending = chosen.format->beside_ending;
  if (!ending.empty() && has_ending(outputs.front(), ending)) {
    outputs.push_back(outputs.front() + std::string(chosen.format->beside));
  }
  return outputs;
}

void check_volume_output(const std::string& path, const std::vector<std::string>& inputs) {
  const std::vector<std::string> outputs = volume_outputs(path);
  const Chosen chosen = choose(path);
  std::vector<std::string> kept = inputs;
  if (!chosen.path.dataset.empty()) {
    // The rest of the file stays as it is, so it may hold the input: it is copied, changed there,
    // and renamed.
    std::erase_if(kept, [&](const std::string& input) {
      std::error_code ignored;
      return std::filesystem::equivalent(input, chosen.path.file, ignored);
    });
  }
  refuse_to_replace(outputs, kept);
  if (chosen.format == &kPrecomputed) return check_output_folder(path);
  for (const std::string& output : outputs) {
    std::error_code ignored;
    if (outputs.size() > 1 && std::filesystem::is_symlink(output, ignored)) {
      throw_output_error(
          output, "it is a symbolic link, and its header lies beside the file itself: name that");
    }
    check_output(output);
  }
}

bool is_volume_path(const std::string& path) { return choose(path).format != nullptr; }

}  // namespace cvr::volumes
