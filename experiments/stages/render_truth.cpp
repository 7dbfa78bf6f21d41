#include "experiments/stages/render_truth.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <fstream>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "experiments/stages/encoded_volume.hpp"

namespace cvr::experiments {

namespace fs = std::filesystem;

namespace {

template <class T>
void put(std::string& out, const std::vector<T>& values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

template <class T>
bool get(std::ifstream& in, std::vector<T>& values, std::size_t count) {
  values.resize(count);
  return static_cast<bool>(in.read(reinterpret_cast<char*>(values.data()),
                                   static_cast<std::streamsize>(count * sizeof(T))));
}

}  // namespace

RenderTruth::RenderTruth(const WorkerSpec& spec, const volumes::VolumeSource& truth,
                         const gpu::Scene& scene, gpu::Device& device)
    : spec_(spec), truth_(truth), scene_(scene), device_(device) {}

gpu::Scene RenderTruth::scene_at(const Shot& shot) const {
  gpu::Scene scene = scene_;
  scene.lod_bias = shot.lod_bias;
  return scene;
}

const gpu::ReferenceRenderer& RenderTruth::renderer() {
  if (!reference_) {
    volume_.emplace(volumes::read_all(truth_));
    reference_ = std::make_unique<gpu::ReferenceRenderer>(*volume_, spec_.render->brick, cores());
  }
  return *reference_;
}

std::string RenderTruth::file_of(const Shot& shot, const std::string& kind) const {
  const RenderChoice& choice = *spec_.render;
  const std::string text = fmt::format(
      "{}|{}|{}|{}|{}|{}x{}|{}|{}|{}|{}|{}", kind, spec_.location.identity, choice.scene_hash,
      gpu::name_of(choice.shading), choice.ao_roulette, choice.width, choice.height, choice.brick,
      shot.part, shot.samples, shot.lod_bias, choice.device);
  return fmt::format("{:016x}.picture", XXH3_64bits(text.data(), text.size()));
}

std::optional<RenderTruth::Drawn> RenderTruth::load(const std::string& file) const {
  if (file == last_file_) return last_;
  if (spec_.scratch.empty()) return std::nullopt;
  std::ifstream in(fs::path(spec_.scratch) / file, std::ios::binary);
  if (!in) return std::nullopt;
  Drawn drawn;
  gpu::Image& image = drawn.image;
  image.width = spec_.render->width;
  image.height = spec_.render->height;
  std::vector<std::uint64_t> needed;
  if (!get(in, image.colour, 3 * image.pixels()) || !get(in, image.labels, image.pixels()) ||
      !get(in, image.complete, image.pixels()) || !get(in, needed, 3))
    return std::nullopt;
  drawn.needed = {needed[0], needed[1], needed[2]};
  return drawn;
}

void RenderTruth::save(const std::string& file, const Drawn& drawn) const {
  if (spec_.scratch.empty()) return;
  std::string content;
  put(content, drawn.image.colour);
  put(content, drawn.image.labels);
  put(content, drawn.image.complete);
  put(content,
      std::vector{drawn.needed.visits, drawn.needed.distinct_cells, drawn.needed.distinct_bricks});
  keep_in_scratch(fs::path(spec_.scratch) / file, content);
}

void RenderTruth::make_reference(const Shot& shot) {
  const std::string file = file_of(shot, "reference");
  if (auto there = load(file)) {
    last_ = std::move(*there);
  } else {
    const gpu::Scene scene = scene_at(shot);
    const gpu::Camera camera = scene.path.at(shot.part);
    if (shot.samples == 1) {
      last_.image = renderer().render(scene, camera, last_.needed);
    } else {
      last_ = {renderer().render(scene, camera, 0, shot.samples), {}};
    }
    save(file, last_);
  }
  last_file_ = file;
}

gpu::Image RenderTruth::reference(const Shot& shot) {
  make_reference(shot);
  return last_.image;
}

gpu::NeededWork RenderTruth::needed(const Shot& shot) {
  make_reference({shot.part, 1, shot.lod_bias});
  return last_.needed;
}

/// Whether all levels of the volume fit into one allocation of the device, as `raw` needs it. What is
/// too large for that is what compressed volumes are for; its images are held to the reference alone.
bool RenderTruth::has_room_for_raw() const {
  const std::uint64_t bytes = truth_.info().bytes() / 7 * 8;
  return bytes <= std::min(device_.limits().largest_allocation, device_.limits().memory);
}

void RenderTruth::make_raw_renderer() {
  const codecs::Codec& codec = *codecs::find_codec("raw");
  const auto parameters = checked(codecs::Parameters::parse(codec.parameters(), {}));
  const auto encoded = checked(codecs::encode(codec, truth_, parameters, cores()));
  const auto file = checked(codecs::open_file(encoded.bytes.bytes()));
  const auto decoder = checked(codecs::open_decoder(file));
  const auto encoding = checked(decoder->gpu_encoding(spec_.render->brick, cores()));
  gpu::RenderOptions options;
  options.shading = scene_.shading;
  options.width = scene_.width;
  options.height = scene_.height;
  raw_ = checked(gpu::Renderer::make(device_, encoding, truth_.info(), options));
}

std::optional<gpu::Image> RenderTruth::raw(const Shot& shot) {
  if (!has_room_for_raw()) return std::nullopt;
  const std::string file = file_of(shot, "raw");
  if (auto there = load(file)) return std::move(there->image);
  if (!raw_) make_raw_renderer();
  const gpu::Scene scene = scene_at(shot);
  checked(raw_->set_scene(scene));
  if (!raw_->settle(scene.path.at(shot.part), shot.samples).complete)
    throw StageFailure(kFailed, "codec raw without a cache did not complete its image");
  Drawn drawn{raw_->read_image(), {}};
  save(file, drawn);
  return std::move(drawn.image);
}

ImageErrors RenderTruth::errors_of_image(const Shot& shot, const gpu::Image& found) {
  const gpu::Image expected = reference(shot);
  ImageErrors errors = errors_of(expected, found);
  if (errors.labels == 0) return errors;
  const gpu::Scene scene = scene_at(shot);
  const gpu::LabelCheck labels =
      gpu::check_labels(renderer(), scene, scene.path.at(shot.part), expected, found);
  errors.labels = labels.differing;
  errors.near_ties = labels.near_ties;
  return errors;
}

ImageErrors RenderTruth::errors_of_raw(const Shot& shot) {
  const auto path = fs::path(spec_.scratch) / file_of(shot, "errors");
  ImageErrors errors;
  const auto bytes = reinterpret_cast<char*>(&errors);
  if (std::ifstream in(path, std::ios::binary);
      !spec_.scratch.empty() && in.read(bytes, sizeof errors))
    return errors;
  errors = errors_of_image(shot, *raw(shot));
  if (spec_.scratch.empty()) return errors;
  keep_in_scratch(path, {bytes, sizeof errors});
  return errors;
}

}  // namespace cvr::experiments
