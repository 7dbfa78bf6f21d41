#include "experiments/config/block.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <thread>

#include "codecs/registry.hpp"
#include "experiments/config/dataset_keys.hpp"

namespace cvr::experiments {

namespace {

constexpr unsigned kMostThreads = 4096;
constexpr std::uint64_t kMostCells = 100000;
constexpr std::string_view kOfTheBlock = "the block's";

unsigned all_cores() { return std::max(1u, std::thread::hardware_concurrency()); }

CodecChoice with_defaults(const codecs::Codec& codec) {
  return {&codec, codecs::Parameters::parse(codec.parameters(), {}).value(), {}, {}};
}

Shape<const codecs::Codec*> codec_id() {
  return {[](const YamlValue& value) {
            const std::string id = value.text("the id of a codec");
            const codecs::Codec* codec = codecs::find_codec(id);
            if (codec == nullptr) {
              std::vector<std::string> ids;
              for (const codecs::Codec* known : codecs::all_codecs())
                ids.emplace_back(known->traits().id);
              value.expected(fmt::format("a codec of this build ({}){}", fmt::join(ids, ", "),
                                         did_you_mean(id, ids)));
            }
            return codec;
          },
          "the id of a codec", std::string(kTextSchema)};
}

/// The values of one parameter, and where its name stands.
struct ParameterAxis {
  YamlValue place;
  std::string name;
  std::vector<std::string> values;
};

/// "8", or "8,8,1" from [8, 8, 1].
std::string parameter_text(const YamlValue& value) {
  if (!value.is_list()) return value.text("a value");
  std::vector<std::string> parts;
  for (const YamlValue& part : value.list("numbers")) parts.push_back(part.text("a number"));
  return fmt::format("{}", fmt::join(parts, ","));
}

Shape<std::vector<ParameterAxis>> parameter_axes() {
  const std::string numbers = R"({"type": "array", "items": {"type": "number"}, "minItems": 1})";
  const std::string one = schema_of_either(kTextSchema, numbers);
  return {[](const YamlValue& value) {
            std::vector<ParameterAxis> axes;
            for (const auto& [name, values] : value.entries()) {
              ParameterAxis axis{name, name.text(), {}};
              for (const YamlValue& v : values.list_or_one("values"))
                axis.values.push_back(parameter_text(v));
              axes.push_back(std::move(axis));
            }
            return axes;
          },
          "a map of names and values, or lists of values",
          fmt::format(R"({{"type": "object", "additionalProperties": {}}})",
                      schema_of_either(one, schema_of_list(one)))};
}

/// The options of the stage render, as keys of what holds them. `fallback`: what holds without one
/// of them, where that is not the option's own default.
template <class S>
void append_render_keys(const BlockContext& context, RenderBlock S::*member,
                        std::string_view fallback, std::vector<Key<S>>& keys) {
  const std::string folder = std::filesystem::path(context.config_path).parent_path().string();
  for (const RenderOption& option : render_options()) {
    if (option.key.name.empty()) continue;
    KeyInfo info = option.key;
    if (!fallback.empty()) info.fallback = fallback;
    keys.push_back({std::move(info), [&option, folder, member](const YamlValue& value, S& into) {
                      (into.*member).give(option, option.read(value, folder));
                    }});
  }
}

struct CodecDraft {
  const codecs::Codec* codec = nullptr;
  std::vector<ParameterAxis> axes;
  std::vector<std::string> datasets;
  RenderBlock render;
};

std::vector<Key<CodecDraft>> codec_keys(const BlockContext& context) {
  std::vector<Key<CodecDraft>> keys{
      required(key("id", &CodecDraft::codec, codec_id(), "", "`cvrbench list codecs`.")),
      key("parameters", &CodecDraft::axes, parameter_axes(), "the codec's own",
          "A list of values multiplies the cells."),
      key("datasets", &CodecDraft::datasets, list_of(one_text("the name of a data set"), "names"),
          "all of the block", "Names of the data sets of the block that it is measured on.")};
  append_render_keys(context, &CodecDraft::render, kOfTheBlock, keys);
  return keys;
}

/// What a block says of one data set.
struct OwnRender {
  RenderBlock render;
};

std::vector<Key<OwnRender>> own_render_keys(const BlockContext& context) {
  std::vector<Key<OwnRender>> keys;
  append_render_keys(context, &OwnRender::render, kOfTheBlock, keys);
  return keys;
}

Shape<std::vector<std::pair<std::string, RenderBlock>>> per_dataset_shape(
    const BlockContext& context) {
  const auto keys = own_render_keys(context);
  return {[keys](const YamlValue& value) {
            std::vector<std::pair<std::string, RenderBlock>> all;
            for (const auto& [name, own] : value.entries()) {
              OwnRender read;
              read_keys(own, keys, read);
              all.emplace_back(name.text("the name of a data set"), std::move(read.render));
            }
            return all;
          },
          "a map from names of data sets to keys of the stage render",
          fmt::format(R"({{"type": "object", "additionalProperties": {}}})",
                      schema_of_map(infos_of(keys)))};
}

/// The products of the values of all parameters. Each value is checked alone first, so that the
/// error points at it.
void add_products(const YamlValue& value, const CodecDraft& draft,
                  std::vector<CodecChoice>& choices) {
  const codecs::Codec& codec = *draft.codec;
  std::vector<std::vector<std::string>> products{{}};
  for (const ParameterAxis& axis : draft.axes) {
    std::vector<std::vector<std::string>> longer;
    for (const std::string& one : axis.values) {
      const std::string assignment = axis.name + "=" + one;
      const auto checked = codecs::Parameters::parse(codec.parameters(), std::span(&assignment, 1));
      if (!checked)
        axis.place.reject(fmt::format("{}: {}", codec.traits().id, checked.error().message));
    }
    for (const auto& product : products) {
      for (const std::string& one : axis.values) {
        longer.push_back(product);
        longer.back().push_back(axis.name + "=" + one);
      }
    }
    products = std::move(longer);
  }
  for (const auto& product : products) {
    auto parameters = codecs::Parameters::parse(codec.parameters(), product);
    if (!parameters) value.reject(parameters.error().message);
    choices.push_back({&codec, std::move(*parameters), draft.datasets, draft.render});
  }
}

Shape<std::vector<CodecChoice>> codec_choices(const BlockContext& context) {
  const auto by_id = codec_id();
  const auto keys = codec_keys(context);
  const std::string one = schema_of_either(by_id.schema, schema_of_map(infos_of(keys)));
  return {[by_id, keys](const YamlValue& value) {
            std::vector<CodecChoice> choices;
            if (value.is_scalar() &&
                (value.text() == "all" || value.text() == "lossless" || value.text() == "lossy")) {
              for (const codecs::Codec* codec : codecs::all_codecs()) {
                const bool lossless = codec->traits().lossless;
                if (value.text() == "all" || lossless == (value.text() == "lossless"))
                  choices.push_back(with_defaults(*codec));
              }
              return choices;
            }
            for (const YamlValue& v : value.list("codecs, or all, lossless or lossy")) {
              CodecDraft draft;
              if (v.is_map()) {
                read_keys(v, keys, draft);
                add_products(v, draft, choices);
              } else {
                choices.push_back(with_defaults(*by_id.read(v)));
              }
            }
            return choices;
          },
          "all, lossless, lossy, or a list of ids and maps of id and parameters",
          schema_of_either(R"({"enum": ["all", "lossless", "lossy"]})", schema_of_list(one))};
}

Shape<const StageTraits*> stage_shape(StageList stages) {
  std::vector<std::string> ids;
  for (const StageTraits* stage : stages) ids.emplace_back(stage->id);
  const std::string last = ids.empty() ? "" : ids.back();
  const std::vector<std::string> others(ids.begin(), ids.empty() ? ids.end() : ids.end() - 1);
  const auto word = one_word(ids, fmt::format("{} or {}", fmt::join(others, ", "), last));
  return {[read = word.read, stages](const YamlValue& v) { return find_stage(stages, read(v)); },
          word.values, word.schema};
}

Shape<Threads> threads_shape() {
  const auto count = whole_number(1, kMostThreads);
  return {[read = count.read](const YamlValue& value) -> Threads {
            if (value.is_scalar() && value.text() == "all") return {"all", all_cores()};
            const auto threads = static_cast<unsigned>(read(value));
            return {std::to_string(threads), threads};
          },
          "a number of threads or all", schema_of_either(count.schema, R"({"const": "all"})")};
}

Shape<std::vector<std::shared_ptr<const Dataset>>> datasets_shape(const BlockContext& context) {
  const auto all = list_of(dataset_shape(context.catalogue, context.config_path), "data sets");
  return {[read = all.read](const YamlValue& value) {
            std::vector<std::shared_ptr<const Dataset>> shared;
            for (Dataset& dataset : read(value))
              shared.push_back(std::make_shared<Dataset>(std::move(dataset)));
            return shared;
          },
          all.values, all.schema};
}

}  // namespace

std::vector<Key<Block>> block_keys(const BlockContext& context) {
  std::vector<Key<Block>> keys{
      required(key("datasets", &Block::datasets, datasets_shape(context), "",
                   "The volumes: names, choices, files and generated ones.")),
      required(key("codecs", &Block::codecs, codec_choices(context), "", "The codecs.")),
      required(key("stages", &Block::stages, list_of(stage_shape(context.stages), "stages"), "",
                   "What is measured (`cvrbench list stages`).")),
      key("threads", &Block::threads, one_or_list(threads_shape(), "thread counts"), "[1]",
          "Threads of each cell; not of the stage render."),
      key("per_dataset", &Block::per_dataset, per_dataset_shape(context), "",
          "What holds for single data sets in place of the keys below.")};
  append_render_keys(context, &Block::render, "", keys);
  return keys;
}

std::vector<KeyInfo> codec_entry_keys(const BlockContext& context) {
  return infos_of(codec_keys(context));
}

bool Block::goes_with(const CodecChoice& choice, const Dataset& dataset) {
  return choice.datasets.empty() ||
         std::ranges::find(choice.datasets, dataset.name) != choice.datasets.end();
}

RenderBlock Block::render_of(const Dataset& dataset, const CodecChoice& choice) const {
  const auto own =
      std::ranges::find(per_dataset, dataset.name, &std::pair<std::string, RenderBlock>::first);
  return (own == per_dataset.end() ? render : render.with(own->second)).with(choice.render);
}

Block read_block(const YamlValue& value, const BlockContext& context) {
  Block block;
  read_keys(value, block_keys(context), block);
  const auto require_dataset = [&](const std::string& name, std::string_view key) {
    std::vector<std::string> names;
    for (const auto& dataset : block.datasets) names.push_back(dataset->name);
    if (std::ranges::find(names, name) == names.end())
      value.reject(fmt::format("expected under {} a data set of this block ({}), found '{}'{}", key,
                               fmt::join(names, ", "), name, did_you_mean(name, names)));
  };
  for (const auto& own : block.per_dataset) require_dataset(own.first, "per_dataset");
  const bool renders = std::ranges::any_of(block.stages, &StageTraits::renders);
  for (const CodecChoice& choice : block.codecs) {
    for (const std::string& name : choice.datasets) require_dataset(name, "datasets of a codec");
    for (const auto& dataset : block.datasets) {
      if (Block::goes_with(choice, *dataset))
        block.render_of(*dataset, choice).check(value, renders);
    }
  }
  return block;
}

namespace {

/// What the voxels of a data set are made from, at any scale.
std::string voxels_of(const Dataset& dataset) {
  std::string text = fmt::format("{} {} {}", dataset.file, dataset.axes, name_of(dataset.kind));
  if (const auto& made = dataset.generator)
    text += fmt::format(" {} {} {}", made->kind, made->seed, made->parameters);
  return text;
}

class CellList {
 public:
  CellList(std::string device, std::string config_path)
      : device_(std::move(device)), config_path_(std::move(config_path)) {}

  void add_block(const Block& block, std::optional<double> scale) {
    for (auto dataset : block.datasets) {
      require_own_name(*dataset);
      if (scale && dataset->generator) {
        auto scaled = std::make_shared<Dataset>(*dataset);
        scaled->scale = *scale;
        dataset = scaled;
      }
      for (const StageTraits* stage : block.stages) {
        if (stage->renders) {
          for (const CodecChoice& choice : block.codecs) add_render(block, dataset, *stage, choice);
        } else {
          for (const Threads& threads : block.threads) add_all(block, dataset, *stage, threads);
        }
      }
    }
  }

  std::vector<Cell> take() { return std::move(cells_); }

 private:
  /// Cells and lines of tables go by the names of data sets.
  void require_own_name(const Dataset& dataset) {
    const auto& [at, is_new] = by_name_.emplace(dataset.name, voxels_of(dataset));
    if (is_new || at->second == voxels_of(dataset)) return;
    throw InputError(fmt::format(
        "{}: expected different names for different data sets, found two that are called '{}': "
        "give one of them a 'name'",
        config_path_, dataset.name));
  }

  void add(Cell cell) {
    if (seen_.insert(cell.row_key()).second) cells_.push_back(std::move(cell));
    if (cells_.size() > kMostCells)
      throw InputError(fmt::format("{}: expected at most {} cells", config_path_, kMostCells));
  }

  void add_all(const Block& block, const std::shared_ptr<const Dataset>& dataset,
               const StageTraits& stage, const Threads& threads) {
    if (stage.memcpy) add({dataset, std::string(kMemcpy), 1, {}, &stage, threads});
    for (const CodecChoice& choice : block.codecs) {
      if (!Block::goes_with(choice, *dataset)) continue;
      const auto& traits = choice.codec->traits();
      add({dataset, std::string(traits.id), traits.version, choice.parameters, &stage, threads});
    }
  }

  /// The threads of such cells are those that prepare the image, as many as there are cores; no
  /// time depends on them.
  void add_render(const Block& block, const std::shared_ptr<const Dataset>& dataset,
                  const StageTraits& stage, const CodecChoice& choice) {
    if (!Block::goes_with(choice, *dataset)) return;
    const auto& traits = choice.codec->traits();
    const Threads all{"all", all_cores()};
    const RenderBlock options = block.render_of(*dataset, choice);
    for (RenderChoice& render : options.choices(choice.parameters, dataset->kind, device_)) {
      add({dataset, std::string(traits.id), traits.version, choice.parameters, &stage, all,
           std::move(render)});
    }
  }

  std::string device_, config_path_;
  std::map<std::string, std::string> by_name_;  ///< voxels_of each name
  std::vector<Cell> cells_;
  std::set<std::string> seen_;
};

}  // namespace

std::vector<Cell> cells_of(const std::vector<Block>& blocks, std::optional<double> scale,
                           const std::string& device, const std::string& config_path) {
  CellList cells(device, config_path);
  for (const Block& block : blocks) cells.add_block(block, scale);
  return cells.take();
}

}  // namespace cvr::experiments
