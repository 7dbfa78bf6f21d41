// render
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <thread>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/config/scene_file.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "experiments/results/statistics.hpp"
#include "experiments/stages/render_parts.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/renderer.hpp"
#include "gpu/scalars/reference.hpp"
#include "gpu/scalars/renderer.hpp"
#include "volumes/io/file.hpp"
#include "volumes/io/io.hpp"
#include "volumes/number_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

struct RenderCommand {
  std::string in, scene, access = "none", codec, shading, size, device, out, ids;
  std::vector<std::string> parameters;
  VolumeChoices volume;
  std::uint32_t frames = 1, brick = 0, samples = 0;
  std::uint64_t cache_mib = 256;
  double part = 0;
  bool json = false;
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
};

/// "WxH".
std::pair<std::uint32_t, std::uint32_t> parse_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  const auto width = volumes::parse_unsigned(text.substr(0, cross));
  const auto height =
      volumes::parse_unsigned(cross == std::string::npos ? "" : text.substr(cross + 1));
  if (!width || !height || std::min(*width, *height) < 1 || std::max(*width, *height) > 16384)
    throw volumes::InputError(
        fmt::format("--size: expected WIDTHxHEIGHT with each 1..16384, found '{}'", text));
  return {static_cast<std::uint32_t>(*width), static_cast<std::uint32_t>(*height)};
}

gpu::Scene scene_for(const RenderCommand& command) {
  gpu::Scene scene = load_scene(find_scene(command.scene));
  if (!command.size.empty()) std::tie(scene.width, scene.height) = parse_size(command.size);
  if (!command.shading.empty()) scene.shading = *gpu::shading_from_name(command.shading);
  if (command.samples > 0) scene.accumulate = command.samples;
  if (scene.shading != gpu::Shading::kAo) scene.accumulate = 1;
  return scene;
}

void check_access(const std::string& access) {
  if (gpu::find_cache(access) != nullptr) return;
  std::vector<std::string> ids;
  for (const gpu::CacheTraits& cache : gpu::all_caches()) ids.emplace_back(cache.id);
  throw volumes::InputError(fmt::format("--access: expected one of {}, found '{}'{}",
                                        fmt::join(ids, ", "), access, did_you_mean(access, ids)));
}

/// Whether the file begins like an encoded one.
bool is_encoded(const std::string& path) {
  return fs::path(path).extension() == ".cvr" && fs::is_regular_file(path);
}

/// "out.png", or "out_0007.png" in a sequence.
std::string numbered(const std::string& path, std::uint32_t frame, std::uint32_t frames) {
  if (frames == 1) return path;
  const fs::path whole(path);
  return (whole.parent_path() /
          fmt::format("{}_{:04}{}", whole.stem().string(), frame, whole.extension().string()))
      .string();
}

std::vector<std::string> outputs_of(const RenderCommand& command) {
  std::vector<std::string> outputs;
  for (std::uint32_t frame = 0; frame < command.frames; ++frame) {
    outputs.push_back(numbered(command.out, frame, command.frames));
    if (!command.ids.empty()) outputs.push_back(numbered(command.ids, frame, command.frames));
  }
  return outputs;
}

volumes::Buffer obtain_file(const RenderCommand& command) {
  if (is_encoded(command.in)) {
    if (!command.codec.empty() || !command.parameters.empty())
      throw volumes::InputError(fmt::format(
          "{}: expected --codec and -p only with a volume, found an encoded file", command.in));
    command.volume.require_none(command.in);
    return read_file(command.in);
  }
  const auto [codec, parameters] =
      parse_codec(command.codec.empty() ? "raw" : command.codec, command.parameters);
  const auto source = volumes::open_volume(command.in, command.volume.options());
  volumes::refuse_to_replace(outputs_of(command), source->files());
  auto encoded = codecs::encode(*codec, *source, parameters, command.threads);
  if (!encoded) fail_on_file(command.in, encoded.error());
  return std::move(encoded->bytes);
}

/// What a row says of an image whatever is drawn.
Row describe_image(const RenderCommand& command, const gpu::Scene& scene, const gpu::Device& device,
                   const codecs::OpenedFile& file, const std::vector<gpu::MemoryUse>& memory) {
  Row row;
  row["device"] = to_json(describe_device(device));
  row["codec"] = file.codec->traits().id;
  row["extent"] = to_string(file.stream.info.extent);
  row["scene"] = scene.name;
  row["cache"] = command.access;
  row["shading"] = gpu::name_of(scene.shading);
  row["size"] = fmt::format("{}x{}", scene.width, scene.height);
  row.update(to_json(describe_memory(memory)));
  return row;
}

struct Drawn {
  std::vector<double> ms;  ///< of settled images: all frames of one view together
  std::vector<std::uint32_t> frames;
  Row files = Row::array();
};

gpu::Camera camera_of(const RenderCommand& command, const gpu::Scene& scene, std::uint32_t frame) {
  return scene.path.at(command.frames == 1 ? command.part
                                           : static_cast<double>(frame) / (command.frames - 1));
}

/// An encoding cannot settle only where its cache is too small for one ray.
Drawn draw(const RenderCommand& command, const gpu::Scene& scene, gpu::Renderer& renderer) {
  Drawn drawn;
  for (std::uint32_t frame = 0; frame < command.frames; ++frame) {
    const gpu::Camera camera = camera_of(command, scene, frame);
    const gpu::FrameResult first = renderer.render(camera);
    drawn.ms.push_back(1e3 * first.gpu_seconds);
    const gpu::Settled settled = renderer.settle(camera, scene.accumulate);
    drawn.frames.push_back(settled.frames);
    if (!settled.complete) {
      throw volumes::InputError(fmt::format(
          "--cache-mib {}: the cache cannot hold what one view needs: {} pixels incomplete",
          command.cache_mib, settled.incomplete));
    }
    const gpu::Image image = renderer.read_image();
    const std::string file = numbered(command.out, frame, command.frames);
    gpu::write_png(file, image.width, image.height, image.rgb8());
    drawn.files.push_back(file);
    if (!command.ids.empty())
      gpu::write_label_image(numbered(command.ids, frame, command.frames), image);
  }
  return drawn;
}

void report(const Row& row) {
  fmt::print("{} ({}, {}): {} {}, access {}, {} {}\n", row["device"]["name"].get<std::string>(),
             row["device"]["type"].get<std::string>(), row["device"]["driver"].get<std::string>(),
             row["codec"].get<std::string>(), row["extent"].get<std::string>(),
             row["cache"].get<std::string>(), row["shading"].get<std::string>(),
             row["size"].get<std::string>());
  fmt::print(
      "{} image{}, {:.3f} ms the median first frame of a view, converged after at most {} frames, "
      "{:.1f} MiB "
      "on the device\n",
      row["files"].size(), row["files"].size() == 1 ? "" : "s", row["median_ms"].get<double>(),
      row["exact_after_frames"].get<std::uint32_t>(), row["gpu_bytes"].get<double>() / (1 << 20));
  for (const auto& [use, bytes] : row["gpu_uses"].items())
    fmt::print("  {:<24} {:>14}\n", use, bytes.get<std::uint64_t>());
}

/// The range is that of the decoded volume: an encoded file alone knows no other.
void render_scalars(const RenderCommand& command, gpu::Scene scene, gpu::Device& device,
                    const codecs::OpenedFile& file, const codecs::Decoder& decoder) {
  if (scene.transfer.empty())
    throw volumes::InputError(
        fmt::format("--scene {}: expected a scene with a transfer function, which scalars need",
                    command.scene));
  if (!command.ids.empty())
    throw volumes::InputError("--ids: expected a label volume, scalars have no labels");
  scene.shading = gpu::Shading::kLocal;
  const codecs::ProgressiveAccess* progressive = decoder.progressive_access();
  const auto samples = decoder.gpu_samples(progressive == nullptr ? 0 : progressive->steps() - 1);
  if (!samples) fail_on_file(command.in, samples.error());
  volumes::VolumeSink sink(file.stream.info);
  if (const auto done = decoder.decode(0, command.threads, sink); !done)
    fail_on_file(command.in, done.error());
  const auto renderer =
      gpu::ScalarRenderer::make(device, *samples, file.stream.info, gpu::value_range(sink.take()),
                                {.access = command.access,
                                 .cache_bytes = command.cache_mib << 20,
                                 .width = scene.width,
                                 .height = scene.height});
  if (!renderer) fail_on_file(command.in, renderer.error());
  if (const auto shown = (*renderer)->set_scene(scene); !shown)
    fail_on_file(command.in, shown.error());
  Drawn drawn;
  for (std::uint32_t frame = 0; frame < command.frames; ++frame) {
    drawn.ms.push_back(1e3 * (*renderer)->render(camera_of(command, scene, frame)).gpu_seconds);
    const gpu::Image image = (*renderer)->read_image();
    drawn.files.push_back(numbered(command.out, frame, command.frames));
    gpu::write_png(drawn.files.back().get<std::string>(), image.width, image.height, image.rgb8());
  }
  Row row = describe_image(command, scene, device, file, (*renderer)->memory());
  row["files"] = drawn.files;
  row["first_frame_ms"] = drawn.ms;
  row["median_ms"] = summarize(drawn.ms).median;
  row["exact_after_frames"] = 1;
  command.json ? print_json(row) : report(row);
}

void render(const RenderCommand& command) {
  const std::vector<std::string> outputs = outputs_of(command);
  volumes::refuse_to_replace(outputs, {command.in, find_scene(command.scene)});
  for (const std::string& output : outputs) volumes::check_output(output);
  const gpu::Scene scene = scene_for(command);
  check_access(command.access);
  gpu::Device device({.choice = command.device});
  const volumes::Buffer bytes = obtain_file(command);
  const auto file = codecs::open_file(bytes.bytes());
  if (!file) fail_on_file(command.in, file.error());
  const auto decoder = codecs::open_decoder(*file);
  if (!decoder) fail_on_file(command.in, decoder.error());
  if (file->stream.info.kind == volumes::VolumeKind::kScalars) {
    render_scalars(command, scene, device, *file, **decoder);
    return;
  }
  if (scene.materials.empty())
    throw volumes::InputError(fmt::format(
        "--scene {}: expected a scene with materials, which labels need", command.scene));
  const auto encoding = (*decoder)->gpu_encoding(command.brick, command.threads);
  if (!encoding) fail_on_file(command.in, encoding.error());
  gpu::RenderOptions options;
  options.access = command.access;
  options.cache_bytes = command.cache_mib << 20;
  options.shading = scene.shading;
  options.width = scene.width;
  options.height = scene.height;
  const auto renderer = gpu::Renderer::make(device, *encoding, file->stream.info, options);
  if (!renderer) fail_on_file(command.in, renderer.error());
  if (const auto shown = (*renderer)->set_scene(scene); !shown)
    fail_on_file(command.in, shown.error());
  const Drawn drawn = draw(command, scene, **renderer);
  Row row = describe_image(command, scene, device, *file, (*renderer)->memory());
  row["samples"] = scene.accumulate;
  row["files"] = drawn.files;
  row["first_frame_ms"] = drawn.ms;
  row["median_ms"] = summarize(drawn.ms).median;
  row["exact_after_frames"] = *std::ranges::max_element(drawn.frames);
  row["start_s"] = (*renderer)->start_seconds();
  command.json ? print_json(row) : report(row);
}

}  // namespace

void add_render_command(CLI::App& app, int& exit_code) {
  auto c = std::make_shared<RenderCommand>();
  auto* drawing = app.add_subcommand(
      "render", "Draws a volume from its encoded form, without decoding it as a whole");
  drawing
      ->add_option("in", c->in,
                   "encoded file (.cvr), or a volume file, which --codec encodes first")
      ->required();
  drawing->add_option("--scene", c->scene, "a scene of configs/scenes, or a scene file")
      ->required();
  drawing->add_option("-o", c->out, "PNG to write; with --frames its name gets a number")
      ->required();
  drawing->add_option("--access,--cache", c->access,
                      "access mode ('list access-modes'; default: none); formerly --cache");
  drawing->add_option("--codec", c->codec, "of a volume file (default: raw)");
  drawing->add_option("-p", c->parameters, "NAME=VALUE, a parameter of the codec")
      ->allow_extra_args(false);
  add_volume_choices(*drawing, c->volume);
  drawing->add_option("--shading", c->shading, "local | shadow | ao (default: the scene's)")
      ->check(one_of({"local", "shadow", "ao"}));
  drawing->add_option("--size", c->size, "WIDTHxHEIGHT in pixels (default: the scene's)");
  drawing->add_option("--frames", c->frames, "images along the camera path")
      ->check(integer_in(1, 1000000));
  drawing->add_option("--part", c->part, "of the camera path, 0 .. 1, for a single image")
      ->check(number_in(0, 1));
  drawing
      ->add_option("--samples", c->samples,
                   "random rays per pixel with the shading ao (default: the scene's)")
      ->check(integer_in(1, 65536));
  drawing->add_option("--brick", c->brick, "brick size of a codec without bricks (default: 32)")
      ->check(integer_in(2, 64));
  drawing->add_option("--cache-mib", c->cache_mib, "size of the cache (default: 256)")
      ->check(integer_in(1, 1 << 20));
  drawing->add_option("--device", c->device, "index, or part of a name or type ('list devices')");
  drawing->add_option("--ids", c->ids,
                      "file for the labels of the pixels: u64 little endian, rows from the top");
  drawing->add_option("--threads", c->threads, "threads that encode")
      ->check(integer_in(1, kMostThreads));
  drawing->add_flag("--json", c->json, "one object on standard output");
  drawing->callback([c, &exit_code] {
    const InterruptWatch watch;
    render(*c);
    exit_code = kExitOk;
  });
}

}  // namespace cvr::experiments::cli
