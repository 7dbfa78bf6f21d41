// inspect, at, error
#include <fmt/format.h>

#include <cstring>

#include "codecs/container.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/results/error_row.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "volumes/io/io.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

void add_volume_facts(const volumes::VolumeInfo& info, Row& report) {
  report["extent"] = {info.extent.x, info.extent.y, info.extent.z};
  if (info.time_steps > 1) {
    report["time_steps"] = info.time_steps;
    report["step_extent"] = {info.step_extent().x, info.step_extent().y, info.step_extent().z};
  }
  report["type"] = name_of(info.type);
  report["kind"] = name_of(info.kind);
  report["voxel_size"] = info.voxel_size;
  report["voxel_unit"] = info.voxel_unit;
  report["offset"] = info.offset;
  report["original_bytes"] = info.bytes();
}

void print_plain(const Row& report, const std::string& indent = "") {
  for (const auto& [key, value] : report.items()) {
    if (value.is_object()) {
      fmt::print("{}{}:\n", indent, key);
      print_plain(value, indent + "  ");
      continue;
    }
    if (value.is_string() && value.get_ref<const std::string&>().empty()) continue;
    fmt::print("{}{}: {}\n", indent, key,
               value.is_string() ? volumes::printable(value.get<std::string>()) : value.dump());
  }
}

codecs::OpenedFile open_encoded(const std::string& path, const volumes::Buffer& bytes) {
  auto file = codecs::open_file(bytes.bytes());
  if (!file) fail_on_file(path, file.error());
  return std::move(*file);
}

void inspect(const std::string& path, const VolumeChoices& choices, bool json) {
  Row report;
  report["file"] = path;
  if (volumes::is_volume_path(path)) {
    add_volume_facts(volumes::open_volume(path, choices.options())->info(), report);
  } else {
    choices.require_none(path);
    const volumes::Buffer bytes = read_file(path);
    const auto file = open_encoded(path, bytes);
    const auto decoder = codecs::open_decoder(file);
    if (!decoder) fail_on_file(path, decoder.error());
    report["codec"] = file.codec->traits().id;
    report["version"] = file.codec->traits().version;
    report["parameters"] = file.stream.parameters.values();
    add_volume_facts(file.stream.info, report);
    report["levels"] = (*decoder)->levels();
    if (const auto recorded = (*decoder)->recorded_error())
      report["recorded_error"] = to_json(describe_recorded(*recorded));
    report.update(to_json(describe_size(file, bytes.size(), 0)));
  }
  json ? print_json(report) : print_plain(report);
}

/// Keeps one voxel of the slabs that pass.
class PickSink final : public volumes::SlabSink {
 public:
  PickSink(const volumes::VolumeInfo& info, const volumes::Coordinate& where)
      : info_(info), where_(where) {}
  std::uint64_t preferred_depth() const override { return 64; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    slab_.resize((z1 - z0) * info_.extent.x * info_.extent.y * size_of(info_.type));
    return slab_.data();
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    if (where_.z < z0 || where_.z >= z1) return;
    const std::size_t voxel = size_of(info_.type);
    std::memcpy(value_.data(),
                slab_.data() + info_.extent.index({where_.x, where_.y, where_.z - z0}) * voxel,
                voxel);
  }
  const std::byte* value() const { return value_.data(); }

 private:
  volumes::VolumeInfo info_;
  volumes::Coordinate where_;
  volumes::Buffer slab_;
  std::array<std::byte, 8> value_{};
};

std::string voxel_text(volumes::VoxelType type, const std::byte* voxel) {
  if (type == volumes::VoxelType::kF32) {
    float value;
    std::memcpy(&value, voxel, sizeof value);
    return fmt::format("{}", value);
  }
  if (type == volumes::VoxelType::kI16) {
    std::int16_t value;
    std::memcpy(&value, voxel, sizeof value);
    return fmt::format("{}", value);
  }
  std::uint64_t value = 0;
  std::memcpy(&value, voxel, size_of(type));
  return fmt::format("{}", value);
}

struct AtOptions {
  std::string file;
  std::int64_t x = 0, y = 0, z = 0;
  VolumeChoices volume;
  unsigned lod = 0;
};

/// The voxel that is asked for. Throws InputError that names the axis.
volumes::Coordinate require_inside(const AtOptions& options, const volumes::Extent& extent) {
  const auto one = [&](const char* axis, std::int64_t found, std::uint64_t size) {
    const auto index = static_cast<std::uint64_t>(found);
    if (found >= 0 && index < size) return index;
    throw volumes::InputError(
        fmt::format("{}: expected {} in 0..{}, since the extent is {}, found {}", options.file,
                    axis, size - 1, to_string(extent), found));
  };
  return {one("x", options.x, extent.x), one("y", options.y, extent.y),
          one("z", options.z, extent.z)};
}

void at(const AtOptions& options) {
  if (volumes::is_volume_path(options.file)) {
    const auto source = volumes::open_volume(options.file, options.volume.options());
    if (options.lod != 0)
      throw volumes::InputError(
          fmt::format("--lod: expected 0, a volume file has one level, found {}", options.lod));
    const volumes::Coordinate where = require_inside(options, source->info().extent);
    std::array<std::byte, 8> voxel{};
    source->read({where, {1, 1, 1}}, voxel.data());
    return fmt::print("{}\n", voxel_text(source->info().type, voxel.data()));
  }
  options.volume.require_none(options.file);
  const volumes::Buffer bytes = read_file(options.file);
  const auto file = open_encoded(options.file, bytes);
  const auto decoder = codecs::open_decoder(file);
  if (!decoder) fail_on_file(options.file, decoder.error());
  const volumes::Coordinate where = require_inside(options, file.stream.info.extent);
  if (options.lod >= (*decoder)->levels()) {
    throw volumes::InputError(
        fmt::format("--lod: expected 0..{}, found {}", (*decoder)->levels() - 1, options.lod));
  }
  if (const codecs::VoxelAccess* access = (*decoder)->voxel_access(); access != nullptr) {
    std::uint64_t bits = 0;
    const auto found = access->at({&where, 1}, options.lod, {&bits, 1});
    if (!found) fail_on_file(options.file, found.error());
    return fmt::print("{}\n",
                      voxel_text(file.stream.info.type, std::as_bytes(std::span(&bits, 1)).data()));
  }
  const volumes::VolumeInfo level = codecs::level_info(file.stream.info, options.lod);
  PickSink sink(level, {where.x >> options.lod, where.y >> options.lod, where.z >> options.lod});
  if (const auto done = (*decoder)->decode(options.lod, 1, sink); !done)
    fail_on_file(options.file, done.error());
  fmt::print("{}\n", voxel_text(level.type, sink.value()));
}

/// Feeds the slabs of `source` to the sink.
void pass_on(const volumes::VolumeSource& source, volumes::SlabSink& sink) {
  const volumes::Extent& extent = source.info().extent;
  for (std::uint64_t z = 0; z < extent.z; z += sink.preferred_depth()) {
    const std::uint64_t end = std::min(extent.z, z + sink.preferred_depth());
    source.read({{0, 0, z}, {extent.x, extent.y, end - z}}, sink.begin(z, end));
    sink.end(z, end);
  }
}

struct ErrorOptions {
  std::string original, file, file_axes;
  VolumeChoices volume;
  unsigned threads = 1;
  bool json = false;
};

int measure_error(const ErrorOptions& options) {
  const std::string &original = options.original, &path = options.file;
  const auto truth = volumes::open_volume(original, options.volume.options());
  const auto require_same_shape = [&](const volumes::VolumeInfo& other) {
    const volumes::VolumeInfo& info = truth->info();
    const auto shape = [](const volumes::VolumeInfo& of) {
      const std::string steps =
          of.time_steps > 1 ? fmt::format(" in {} time steps", of.time_steps) : "";
      return fmt::format("{} {}{}", to_string(of.extent), name_of(of.type), steps);
    };
    if (shape(other) == shape(info)) return;
    throw volumes::InputError(fmt::format("{}: expected {} as in {}, found {}", path, shape(info),
                                          original, shape(other)));
  };
  volumes::ErrorSink sink(*truth, options.threads);
  bool lossless = truth->info().kind == volumes::VolumeKind::kLabels;
  if (volumes::is_volume_path(path)) {
    volumes::OpenOptions how = options.volume.options();
    how.axes = options.file_axes;
    if (!how.kind) how.kind = truth->info().kind;
    const auto other = volumes::open_volume(path, how);
    require_same_shape(other->info());
    pass_on(*other, sink);
  } else {
    const volumes::Buffer bytes = read_file(path);
    const auto file = open_encoded(path, bytes);
    require_same_shape(file.stream.info);
    lossless = file.codec->traits().lossless;
    const auto decoder = codecs::open_decoder(file);
    if (!decoder) fail_on_file(path, decoder.error());
    if (const auto done = (*decoder)->decode(0, options.threads, sink); !done)
      fail_on_file(path, done.error());
  }
  Row report;
  report["voxels_compared"] = sink.compared();
  report["mismatches"] = sink.mismatches();
  report["exact"] = sink.mismatches() == 0;
  if (truth->info().kind == volumes::VolumeKind::kScalars)
    report.update(to_json(describe_errors(sink)));
  options.json ? print_json(report) : print_plain(report);
  return lossless && sink.mismatches() > 0 ? kExitCheckFailed : kExitOk;
}

struct InspectOptions {
  std::string file;
  VolumeChoices volume;
  bool json = false;
};

}  // namespace

void add_inspection_commands(CLI::App& app, int& exit_code) {
  auto i = std::make_shared<InspectOptions>();
  auto* inspecting =
      app.add_subcommand("inspect", "Tells what an encoded file (or a volume file) is");
  inspecting->add_option("file", i->file, "encoded or volume file")->required();
  add_volume_choices(*inspecting, i->volume);
  inspecting->add_flag("--json", i->json,
                       "one object: codec, version, parameters, extent, type, bytes, rate in "
                       "percent, breakdown, ...");
  inspecting->callback([i, &exit_code] {
    inspect(i->file, i->volume, i->json);
    exit_code = kExitOk;
  });

  auto a = std::make_shared<AtOptions>();
  auto* single =
      app.add_subcommand("at", "Prints one voxel; coordinates are those of the finest level");
  single->add_option("file", a->file, "encoded or volume file")->required();
  single->add_option("x", a->x, "x")->required()->check(signed_integer());
  single->add_option("y", a->y, "y")->required()->check(signed_integer());
  single->add_option("z", a->z, "z")->required()->check(signed_integer());
  single->add_option("--lod", a->lod, "level of detail, 0 is the finest")->check(integer_in(0, 63));
  add_volume_choices(*single, a->volume);
  single->callback([a, &exit_code] {
    at(*a);
    exit_code = kExitOk;
  });

  auto e = std::make_shared<ErrorOptions>();
  auto* error = app.add_subcommand(
      "error",
      "Compares an encoded or volume file with the original: mismatching voxels; of scalars also "
      "PSNR and errors, over all voxels and over the 5 % of steepest gradient. 1 where labels or a "
      "lossless codec's voxels differ");
  error->add_option("in", e->original, "the original, a volume file")->required();
  error->add_option("file", e->file, "encoded or volume file")->required();
  error->add_option("--threads", e->threads, "threads")->check(integer_in(1, kMostThreads));
  add_volume_choices(*error, e->volume);
  add_axes_option(*error, "--file-axes", e->file_axes,
                  "as --axes, of the second volume; --axes is about the original");
  error->add_flag("--json", e->json, "one object");
  error->callback([e, &exit_code] { exit_code = measure_error(*e); });
}

}  // namespace cvr::experiments::cli
