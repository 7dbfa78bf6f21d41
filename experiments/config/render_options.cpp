#include "experiments/config/render_options.hpp"

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
                        kMostSteps = 15, kMostJumpFrames = 64, kMostWarmFrames = 1000;

// How the values of the options are written and read.

std::string text_of(const std::string& value) { return value; }
std::string text_of(bool value) { return value ? "1" : "0"; }
std::string text_of(gpu::Shading value) { return std::string(gpu::name_of(value)); }
template <class T>
requires std::is_arithmetic_v<T> std::string text_of(T value) { return fmt::format("{}", value); }
std::string text_of(const std::optional<std::uint32_t>& value) {
  return value ? std::to_string(*value) : "";
}

template <class T>
void put(Row& row, const std::string& name, const T& value) {
  row[name] = value;
}
void put(Row& row, const std::string& name, gpu::Shading value) { row[name] = text_of(value); }
void put(Row& row, const std::string& name, const std::optional<std::uint32_t>& value) {
  if (value) row[name] = *value;
}

template <class T>
void take(const Row& value, T& into) {
  into = value.get<T>();
}
void take(const Row& value, gpu::Shading& into) {
  into = gpu::shading_from_name(value.get<std::string>()).value();
}
void take(const Row& value, std::optional<std::uint32_t>& into) {
  into = value.get<std::uint32_t>();
}

Row schema_of(const std::string&) { return {{"type", "string"}}; }
Row schema_of(bool) { return {{"type", "boolean"}}; }
Row schema_of(gpu::Shading) { return {{"enum", {"local", "shadow", "ao"}}}; }
Row schema_of(double) { return {{"type", "number"}}; }
template <class T>
Row schema_of(const T&) {
  return {{"type", "integer"}, {"minimum", 0}};
}

/// What tells an option from the others, but for its member.
struct Facts {
  std::string key, name;
  std::string prefix;  ///< before the value in a cell's key
  bool later = false;  ///< in a cell's key only where it is not the default
  std::string label;
  unsigned axis = 0;
  std::string what;  ///< the values of an axis are, in errors
  std::string fallback, sentence;
  std::string row_facts;  ///< what the schema of rows says beyond the member's type, as JSON
  bool in_every_row = true;
};

/// How a member is carried in rows and keys.
template <class M>
RenderOption carried(M RenderChoice::*member, const Facts& facts) {
  RenderOption option;
  option.name = facts.name;
  option.label = facts.label;
  option.axis = facts.axis;
  option.row_schema = schema_of(M{});
  if (!facts.row_facts.empty()) option.row_schema.update(Row::parse(facts.row_facts));
  option.in_every_row = facts.in_every_row;
  option.text = [member](const RenderChoice& c) { return text_of(c.*member); };
  option.in_cell_key = [member, facts](const RenderChoice& c) -> std::string {
    if (facts.later && c.*member == RenderChoice{}.*member) return "";
    return "|" + facts.prefix + text_of(c.*member);
  };
  option.to_row = [member, name = facts.name](const RenderChoice& c, Row& row) {
    put(row, name, c.*member);
  };
  option.from_row = [member, name = facts.name](const Row& row, RenderChoice& c) {
    if (const auto found = row.find(name); found != row.end()) take(*found, c.*member);
  };
  return option;
}

/// One that a key of a block sets.
template <class M, class T>
RenderOption option(M RenderChoice::*member, const Shape<T>& shape, const Facts& facts) {
  RenderOption made = carried(member, facts);
  const auto many = one_or_list(shape, facts.what);
  made.key = {facts.key, facts.axis > 0 ? many.values : shape.values,
              facts.axis > 0 ? many.schema : shape.schema, facts.fallback, facts.sentence};
  const auto set = [member](const T& value) -> RenderSetter {
    return [member, value](RenderChoice& c) { c.*member = static_cast<M>(value); };
  };
  made.read = [shape, many, set, axis = facts.axis](const YamlValue& value,
                                                    const std::string&) -> RenderValues {
    std::vector<RenderSetter> setters;
    if (axis == 0)
      setters.push_back(set(shape.read(value)));
    else
      for (auto&& one : many.read(value)) setters.push_back(set(one));
    return [setters](volumes::VolumeKind) { return setters; };
  };
  return made;
}

/// One that is told in rows alone.
RenderOption carried_in_rows(std::string RenderChoice::*member, const std::string& name,
                             const std::string& row_facts = "") {
  RenderOption made = carried(member, {.name = name, .row_facts = row_facts});
  made.in_cell_key = [](const RenderChoice&) { return std::string(); };
  return made;
}

// The options that are more than a member with a range.

/// The scene also gives what a block leaves out.
RenderSetter set_scene(const std::string& name, const std::string& path) {
  const gpu::Scene scene = load_scene(path);
  RenderChoice own;
  own.scene = name;
  own.scene_path = std::filesystem::absolute(path).string();
  own.scene_hash = hash_of_file(path);
  own.shading = scene.shading;
  own.width = scene.width;
  own.height = scene.height;
  own.frames = scene.frames;
  own.lod_bias = scene.lod_bias;
  own.ao_roulette = scene.ao_roulette;
  return [own](RenderChoice& c) { c = own; };
}

RenderOption scene_option() {
  RenderOption made = carried(&RenderChoice::scene,
                              {.key = "scenes", .name = "scene", .label = "scene", .axis = 1});
  made.in_cell_key = [](const RenderChoice& c) { return c.scene; };
  const auto names = list_of(one_text("the name of a scene, or of its file"), "scenes");
  made.is_needed = true;
  made.key = {"scenes", names.values, names.schema, "",
              "Scenes of configs/scenes, or paths of scene files from this file."};
  made.read = [](const YamlValue& value, const std::string& folder) -> RenderValues {
    std::vector<RenderSetter> setters;
    for (const YamlValue& one : value.list("scenes")) {
      try {
        const std::string name = one.text("the name of a scene, or of its file");
        setters.push_back(set_scene(name, find_scene(name, folder)));
      } catch (const InputError& error) {
        one.reject(error.what());
      }
    }
    return [setters](volumes::VolumeKind) { return setters; };
  };
  return made;
}

std::vector<RenderSetter> set_access(const std::vector<std::string>& ids) {
  std::vector<RenderSetter> setters;
  for (const std::string& id : ids) setters.push_back([id](RenderChoice& c) { c.access = id; });
  return setters;
}

/// The access modes that serve volumes of a kind and draw exact images.
std::vector<std::string> access_modes(volumes::VolumeKind kind) {
  std::vector<std::string> ids;
  for (const gpu::CacheTraits& mode : gpu::all_caches()) {
    if (!mode.exact) continue;
    if (kind == volumes::VolumeKind::kLabels ? mode.labels : mode.scalars)
      ids.emplace_back(mode.id);
  }
  return ids;
}

RenderOption access_option() {
  RenderOption made =
      carried(&RenderChoice::access, {.key = "access_modes",
                                      .name = "cache",
                                      .label = "access_mode",
                                      .axis = 5,
                                      .row_facts = R"({"description": "id of the access mode"})"});
  std::vector<std::string> ids;
  for (const gpu::CacheTraits& mode : gpu::all_caches()) ids.emplace_back(mode.id);
  const auto names =
      list_of(one_word(ids, fmt::format("an access mode ({})", fmt::join(ids, ", "))),
              "access modes, or all");
  made.is_needed = true;
  made.key = {"access_modes", "all, or a list of access modes",
              schema_of_either(R"({"const": "all"})", names.schema), "",
              "Access modes (`cvrbench list access-modes`); all: those that serve the "
              "volume and draw exact images."};
  made.read = [names](const YamlValue& value, const std::string&) -> RenderValues {
    if (value.is_scalar() && value.text() == "all")
      return [](volumes::VolumeKind kind) { return set_access(access_modes(kind)); };
    return [setters = set_access(names.read(value))](volumes::VolumeKind) { return setters; };
  };
  return made;
}

RenderOption cache_mib_option() {
  RenderOption made = option(&RenderChoice::cache_mib, whole_number(1, kMostMib),
                             {.key = "cache_mib",
                              .name = "cache_mib",
                              .label = "cache_mib",
                              .axis = 6,
                              .what = "sizes in MiB",
                              .fallback = "256",
                              .sentence = "MiB of the cache of the access modes that have one.",
                              .row_facts = R"({"description": "0: the mode has no cache"})"});
  made.text = [](const RenderChoice& c) {
    return c.cache_mib == 0 ? "" : std::to_string(c.cache_mib);
  };
  made.in_cell_key = [text = made.text](const RenderChoice& c) { return "|cache=" + text(c); };
  return made;
}

RenderOption size_option() {
  RenderOption made;
  made.name = "size";
  made.label = "size";
  const auto sides = exactly<2>(whole_number(1, kMostSide), "two sides [WIDTH, HEIGHT]");
  made.row_schema = Row::parse(sides.schema);
  made.key = {"size", sides.values, sides.schema, "the scene's own", "Of the image, in pixels."};
  made.text = [](const RenderChoice& c) { return fmt::format("{}x{}", c.width, c.height); };
  made.in_cell_key = [text = made.text](const RenderChoice& c) { return "|" + text(c); };
  made.to_row = [](const RenderChoice& c, Row& row) { row["size"] = {c.width, c.height}; };
  made.from_row = [](const Row& row, RenderChoice& c) {
    c.width = row.at("size").at(0).get<std::uint32_t>();
    c.height = row.at("size").at(1).get<std::uint32_t>();
  };
  made.read = [sides](const YamlValue& value, const std::string&) -> RenderValues {
    const auto read = sides.read(value);
    const std::vector<RenderSetter> setters{[read](RenderChoice& c) {
      c.width = static_cast<std::uint32_t>(read[0]);
      c.height = static_cast<std::uint32_t>(read[1]);
    }};
    return [setters](volumes::VolumeKind) { return setters; };
  };
  return made;
}

Shape<std::uint64_t> brick_size() {
  const auto any = whole_number(2, 64);
  return {[read = any.read](const YamlValue& value) {
            const std::uint64_t size = read(value);
            if (!std::has_single_bit(size)) value.expected("a power of two from 2 to 64");
            return size;
          },
          "a power of two, 2 to 64", R"({"enum": [2, 4, 8, 16, 32, 64]})"};
}

/// In the order of a cell's key.
std::vector<RenderOption> make_options() {
  using C = RenderChoice;
  return {
      scene_option(),
      carried_in_rows(&C::scene_path, "scene_path"),
      carried_in_rows(
          &C::scene_hash, "scene_hash",
          R"({"pattern": "^[0-9a-f]{16}$", "description": "XXH3-64 of the scene's file"})"),
      access_option(),
      option(&C::shading, shading_shape("one of local, shadow, ao"),
             {.key = "shadings",
              .name = "shading",
              .label = "shading",
              .axis = 2,
              .what = "shadings",
              .fallback = "the scene's own",
              .sentence = "How labels are shaded; scalars are always shaded locally."}),
      cache_mib_option(),
      size_option(),
      option(&C::frames, whole_number(1, kMostFrames),
             {.key = "frames",
              .name = "frames",
              .prefix = "frames=",
              .label = "frames",
              .fallback = "the scene's own",
              .sentence = "Frames of the camera path that are drawn.",
              .row_facts = R"({"minimum": 1, "description": "cameras of the path"})"}),
      option(&C::lod_bias, real_number(-32, 32),
             {.key = "lod_bias",
              .name = "lod_bias",
              .prefix = "lod_bias=",
              .label = "lod_bias",
              .axis = 3,
              .what = "levels",
              .fallback = "the scene's own",
              .sentence = "Added to each level of detail; positive is coarser.",
              .row_facts = R"({"description": "levels; positive is coarser"})"}),
      option(&C::ao_samples, whole_number(1, kMostSamples),
             {.key = "ao_samples",
              .name = "ao_samples",
              .prefix = "ao_samples=",
              .label = "ao_samples",
              .axis = 4,
              .what = "numbers of samples",
              .fallback = "1",
              .sentence = "Frames drawn of each camera and averaged, with the shading ao.",
              .row_facts =
                  R"({"minimum": 1, "description": "frames drawn of each camera and averaged"})"}),
      option(&C::brick, brick_size(),
             {.key = "brick",
              .name = "brick",
              .prefix = "brick=",
              .fallback = "32",
              .sentence = "Brick size of codecs that have no bricks of their own.",
              .row_facts = R"({"description": "edge of a brick in voxels"})"}),
      option(&C::jump_frames, whole_number(1, kMostJumpFrames),
             {.key = "jump_frames",
              .name = "jump_frames",
              .prefix = "jump=",
              .fallback = "none",
              .sentence = "Frames that are compared with the reference after a camera jump."}),
      option(&C::warm_frames, whole_number(0, kMostWarmFrames),
             {.key = "warm_frames",
              .name = "held_frames",
              .prefix = "held=",
              .fallback = "0",
              .sentence =
                  "Warm frames: of the scene's fixed view, timed in each round after the path once "
                  "the image is exact and the cache filled, each drawn anew as a first frame is.",
              .row_facts = R"({"maximum": 1000})"}),
      option(&C::image_error, zero_or_one(),
             {.key = "image_error",
              .name = "picture_error",
              .prefix = "error=",
              .fallback = "0",
              .sentence = "1 compares images with those of level bias 0 and 256 samples."}),
      option(
          &C::step, whole_number(0, kMostSteps),
          {.key = "steps",
           .name = "step",
           .prefix = "step=",
           .later = true,
           .label = "step",
           .axis = 7,
           .what = "numbers of progressive steps",
           .fallback = "the whole",
           .sentence =
               "Progressive steps of lossy codecs that are drawn; the last of them is the whole.",
           .row_facts =
               R"({"description": "progressive step that is drawn; absent: the whole encoding"})",
           .in_every_row = false}),
      option(&C::keep_images, zero_or_one(),
             {.key = "keep_images",
              .name = "keep_pictures",
              .prefix = "pictures=",
              .later = true,
              .fallback = "0",
              .sentence =
                  "1 leaves the image of the fixed view, and eight times its difference to that of "
                  "the original volume by the reference renderer, as PNG in OUT/pictures."}),
      option(
          &C::path_parts, whole_number(0, kMostFrames),
          {.key = "path_parts",
           .name = "path_parts",
           .prefix = "parts=",
           .later = true,
           .fallback = "0",
           .sentence =
               "Draws so many evenly spaced parts of consecutive frames of the scene's own path, "
               "`frames` together, so that a short run moves as slowly as a long one; 0 spreads "
               "`frames` over the whole path.",
           .row_facts =
               R"({"description": "parts of consecutive frames; 0 or absent: spread over the path"})",
           .in_every_row = false}),
      option(&C::count_path, zero_or_one(),
             {.key = "count_path",
              .name = "count_path",
              .prefix = "count=",
              .later = true,
              .fallback = "1",
              .sentence = "1 draws the path once more by kernels that count.",
              .row_facts = R"({"description": "false: no counters of the path; absent: true"})",
              .in_every_row = false}),
      option(
          &C::ao_roulette, zero_or_one(),
          {.key = "ao_roulette",
           .name = "ao_roulette",
           .prefix = "roulette=",
           .later = true,
           .label = "ao_roulette",
           .axis = 8,
           .what = "zeros and ones",
           .fallback = "the scene's own",
           .sentence = "1 casts rays of ambient occlusion by Russian roulette (gpu/IMAGE.md), as "
                       "the authors of the CSGV-R paper do.",
           .row_facts = R"({"description": "absent: false"})",
           .in_every_row = false}),
      carried_in_rows(&C::device, "device",
                      R"({"description": "as asked for; empty: the renderer's choice"})"),
  };
}

}  // namespace

std::span<const RenderOption> render_options() {
  static const std::vector<RenderOption> kOptions = make_options();
  return kOptions;
}

Row render_schema() {
  Row schema{{"type", "object"},
             {"required", Row::array()},
             {"additionalProperties", false},
             {"properties", Row::object()},
             {"description", "what an image depends on besides volume and codec"}};
  for (const RenderOption& option : render_options()) {
    if (option.name == "scene_path") continue;  // of one machine alone
    schema["properties"][option.name] = option.row_schema;
    if (option.in_every_row) schema["required"].push_back(option.name);
  }
  return schema;
}

std::vector<std::string> render_labels() {
  std::vector<std::string> labels;
  for (const RenderOption& option : render_options()) {
    if (!option.label.empty()) labels.push_back(option.label);
  }
  return labels;
}

bool is_render_label(std::string_view name) {
  return std::ranges::any_of(render_options(), [&](const RenderOption& option) {
    return !option.label.empty() && option.label == name;
  });
}

RenderBlock RenderBlock::with(const RenderBlock& other) const {
  RenderBlock all = *this;
  for (const Given& given : other.given_) {
    std::erase_if(all.given_, [&](const Given& one) { return one.option == given.option; });
    all.given_.push_back(given);
  }
  return all;
}

void RenderBlock::check(const YamlValue& block, bool renders) const {
  if (!renders && !given_.empty()) {
    block.reject(
        fmt::format("expected the stage render beside the key {}, found other stages alone",
                    given_.front().option->key.name));
  }
  if (!renders) return;
  for (const RenderOption& option : render_options()) {
    const bool missing =
        std::ranges::none_of(given_, [&](const Given& given) { return given.option == &option; });
    if (option.is_needed && missing) {
      block.reject(fmt::format("expected the key {}, which the stage render needs, found none",
                               option.key.name));
    }
  }
}

std::vector<RenderChoice> RenderBlock::choices(const codecs::Parameters& parameters,
                                               volumes::VolumeKind kind,
                                               const std::string& device) const {
  std::vector<const Given*> axes;
  for (const Given& given : given_) {
    if (given.option->axis > 0) axes.push_back(&given);
  }
  std::ranges::sort(axes, {}, [](const Given* given) { return given->option->axis; });
  std::vector<RenderChoice> products{RenderChoice{}};
  for (const Given* axis : axes) {
    std::vector<RenderChoice> longer;
    for (const RenderChoice& product : products) {
      for (const RenderSetter& set : axis->values(kind)) set(longer.emplace_back(product));
    }
    products = std::move(longer);
  }
  const auto own_brick = parameters.values().find("brick");
  std::vector<RenderChoice> all;
  for (RenderChoice& choice : products) {
    for (const Given& given : given_) {
      if (given.option->axis == 0) given.values(kind).front()(choice);
    }
    if (!gpu::find_cache(choice.access)->sized) choice.cache_mib = 0;
    if (choice.shading != gpu::Shading::kAo) {
      choice.ao_samples = 1;
      choice.ao_roulette = false;
    }
    if (own_brick != parameters.values().end())
      choice.brick = static_cast<std::uint32_t>(std::stoul(own_brick->second));
    choice.device = device;
    if (std::ranges::find(all, choice) == all.end()) all.push_back(choice);
  }
  return all;
}

}  // namespace cvr::experiments
