#include "experiments/config/render_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <filesystem>

#include "experiments/config/scene_file.hpp"
#include "gpu/caches/cache.hpp"

namespace cvr::experiments {

namespace {

constexpr std::uint64_t kMostMib = std::uint64_t{1} << 20;
constexpr std::uint32_t kMostSide = 16384, kMostFrames = 1000000, kMostSamples = 65536,
                        kMostSteps = 15, kMostJumpFrames = 64, kMostHeldFrames = 1000;

std::vector<std::string> cache_ids() {
  std::vector<std::string> ids;
  for (const gpu::CacheTraits& cache : gpu::all_caches()) ids.emplace_back(cache.id);
  return ids;
}

/// The access modes that serve volumes of a kind.
std::vector<std::string> cache_ids(volumes::VolumeKind kind) {
  std::vector<std::string> ids;
  for (const gpu::CacheTraits& cache : gpu::all_caches()) {
    if (kind == volumes::VolumeKind::kLabels ? cache.labels : cache.scalars)
      ids.emplace_back(cache.id);
  }
  return ids;
}

std::string read_cache(const YamlValue& value) {
  const std::string id = value.text("the id of an access mode");
  if (gpu::find_cache(id) == nullptr) {
    const auto ids = cache_ids();
    value.expected(
        fmt::format("an access mode ({}){}", fmt::join(ids, ", "), did_you_mean(id, ids)));
  }
  return id;
}

gpu::Shading read_shading(const YamlValue& value) {
  std::vector<std::string> names;
  for (const gpu::Shading shading : gpu::kShadings) names.emplace_back(gpu::name_of(shading));
  const std::string name = value.text("a shading");
  const auto shading = gpu::shading_from_name(name);
  if (!shading)
    value.expected(fmt::format("one of {}{}", fmt::join(names, ", "), did_you_mean(name, names)));
  return *shading;
}

std::uint32_t read_count(const YamlValue& value, std::uint32_t minimum, std::uint32_t maximum) {
  return static_cast<std::uint32_t>(value.integer(minimum, maximum));
}

}  // namespace

std::vector<YamlValue::Field> RenderAxes::fields(const std::string& config_path) {
  const std::string folder = std::filesystem::path(config_path).parent_path().string();
  const std::vector<YamlValue::Field> plain{
      {"scenes",
       [this, folder](const YamlValue& v) {
         for (const YamlValue& one : v.list("scenes")) {
           try {
             const std::string path =
                 find_scene(one.text("the name of a scene, or of its file"), folder);
             scenes_.push_back({one.text(), std::filesystem::absolute(path).string(),
                                hash_of_file(path), load_scene(path)});
           } catch (const InputError& error) {
             one.reject(error.what());
           }
         }
       }},
      {"caches",
       [this](const YamlValue& v) {
         if (v.is_scalar() && v.text() == "all") {
           every_cache_ = true;
           return;
         }
         for (const YamlValue& one : v.list("access modes, or all"))
           caches_.push_back(read_cache(one));
       }},
      {"shadings",
       [this](const YamlValue& v) {
         for (const YamlValue& one : v.list("shadings")) shadings_.push_back(read_shading(one));
       }},
      {"cache_mib",
       [this](const YamlValue& v) {
         cache_mib_.clear();
         for (const YamlValue& one : v.list_or_one("sizes in MiB"))
           cache_mib_.push_back(one.integer(1, kMostMib));
       }},
      {"lod_bias",
       [this](const YamlValue& v) {
         for (const YamlValue& one : v.list_or_one("levels"))
           lod_bias_.push_back(one.number(-32, 32));
       }},
      {"ao_samples",
       [this](const YamlValue& v) {
         ao_samples_.clear();
         for (const YamlValue& one : v.list_or_one("numbers of samples"))
           ao_samples_.push_back(read_count(one, 1, kMostSamples));
       }},
      {"size",
       [this](const YamlValue& v) {
         const auto sides = v.list("two sides [WIDTH, HEIGHT]");
         if (sides.size() != 2) v.expected("two sides [WIDTH, HEIGHT]");
         size_ = {read_count(sides[0], 1, kMostSide), read_count(sides[1], 1, kMostSide)};
       }},
      {"frames", [this](const YamlValue& v) { frames_ = read_count(v, 1, kMostFrames); }},
      {"path_parts", [this](const YamlValue& v) { path_parts_ = read_count(v, 0, kMostFrames); }},
      {"count_path", [this](const YamlValue& v) { count_path_ = v.integer(0, 1) == 1; }},
      {"brick",
       [this](const YamlValue& v) {
         brick_ = read_count(v, 2, 64);
         if (!std::has_single_bit(brick_)) v.expected("a power of two from 2 to 64");
       }},
      {"steps",
       [this](const YamlValue& v) {
         for (const YamlValue& one : v.list_or_one("numbers of progressive steps"))
           steps_.push_back(read_count(one, 0, kMostSteps));
       }},
      {"jump_frames",
       [this](const YamlValue& v) { jump_frames_ = read_count(v, 1, kMostJumpFrames); }},
      {"held_frames",
       [this](const YamlValue& v) { held_frames_ = read_count(v, 0, kMostHeldFrames); }},
      {"picture_error", [this](const YamlValue& v) { picture_error_ = v.integer(0, 1) == 1; }},
      {"keep_pictures", [this](const YamlValue& v) { keep_pictures_ = v.integer(0, 1) == 1; }}};
  std::vector<YamlValue::Field> noted;
  for (const YamlValue::Field& field : plain) {
    noted.push_back({field.key, [this, field](const YamlValue& v) {
                       given_.push_back(field.key);
                       field.read(v);
                     }});
  }
  return noted;
}

void RenderAxes::check(const YamlValue& block, bool renders) const {
  if (!renders && !given_.empty())
    block.reject(fmt::format(
        "expected the stage render beside the key {}, found other stages alone", given_.front()));
  if (!renders) return;
  if (scenes_.empty())
    block.reject("expected the key scenes, which the stage render needs, found none");
  if (caches_.empty() && !every_cache_)
    block.reject("expected the key caches, which the stage render needs, found none");
}

RenderChoice RenderAxes::make(const SceneChoice& scene, const std::string& access,
                              gpu::Shading shading, std::uint64_t cache_mib, double lod_bias,
                              std::uint32_t samples) const {
  RenderChoice choice;
  choice.scene = scene.name;
  choice.scene_path = scene.path;
  choice.scene_hash = scene.hash;
  choice.access = access;
  choice.shading = shading;
  choice.cache_mib = gpu::find_cache(access)->sized ? cache_mib : 0;
  choice.width = size_ ? size_->first : scene.scene.width;
  choice.height = size_ ? size_->second : scene.scene.height;
  choice.frames = frames_.value_or(scene.scene.frames);
  choice.lod_bias = lod_bias;
  choice.ao_samples = shading == gpu::Shading::kAo ? samples : 1;
  choice.brick = brick_;
  choice.jump_frames = jump_frames_;
  choice.held_frames = held_frames_;
  choice.path_parts = path_parts_;
  choice.count_path = count_path_;
  choice.picture_error = picture_error_;
  choice.keep_pictures = keep_pictures_;
  return choice;
}

std::vector<RenderChoice> RenderAxes::choices(const codecs::Parameters& parameters,
                                              volumes::VolumeKind kind,
                                              const std::string& device) const {
  std::vector<RenderChoice> all;
  const auto own_brick = parameters.values().find("brick");
  const auto add = [&](RenderChoice choice) {
    if (own_brick != parameters.values().end())
      choice.brick = static_cast<std::uint32_t>(std::stoul(own_brick->second));
    choice.device = device;
    const auto steps = steps_.empty() ? std::vector{choice.step} : steps_;
    for (const auto& step : steps) {
      choice.step = step;
      if (std::ranges::find(all, choice) == all.end()) all.push_back(choice);
    }
  };
  const auto caches = every_cache_ ? cache_ids(kind) : caches_;
  for (const SceneChoice& scene : scenes_) {
    const auto shadings = shadings_.empty() ? std::vector{scene.scene.shading} : shadings_;
    const auto biases = lod_bias_.empty() ? std::vector{scene.scene.lod_bias} : lod_bias_;
    for (const gpu::Shading shading : shadings) {
      for (const double bias : biases) {
        for (const std::uint32_t samples : ao_samples_) {
          for (const std::string& access : caches) {
            for (const std::uint64_t mib : cache_mib_)
              add(make(scene, access, shading, mib, bias, samples));
          }
        }
      }
    }
  }
  return all;
}

}  // namespace cvr::experiments
