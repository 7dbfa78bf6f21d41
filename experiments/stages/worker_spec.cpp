#include "experiments/stages/worker_spec.hpp"

#include <functional>

#include "volumes/json_text.hpp"

namespace cvr::experiments {

namespace {

// How the values of a specification are carried as JSON.

template <class T>
Row json_of(const T& value) {
  return value;
}
Row json_of(volumes::VoxelType type) { return name_of(type); }
Row json_of(volumes::VolumeKind kind) { return name_of(kind); }
Row json_of(const volumes::Extent& e) { return {e.x, e.y, e.z}; }
Row json_of(const std::optional<GeneratorChoice>& choice) {
  if (!choice) return nullptr;
  return {{"kind", choice->kind}, {"seed", choice->seed}, {"parameters", choice->parameters}};
}
Row json_of(const std::optional<RenderChoice>& choice) {
  return choice ? to_row(*choice) : Row(nullptr);
}

template <class T>
void take(const Row& json, T& into) {
  into = json.get<T>();
}
void take(const Row& json, volumes::VoxelType& into) {
  into = volumes::voxel_type_from_name(json.get<std::string>()).value();
}
void take(const Row& json, volumes::VolumeKind& into) {
  into = volumes::volume_kind_from_name(json.get<std::string>()).value();
}
void take(const Row& json, volumes::Extent& into) {
  const auto axes = json.get<std::array<std::uint64_t, 3>>();
  into = {axes[0], axes[1], axes[2]};
}
void take(const Row& json, std::optional<GeneratorChoice>& into) {
  into = GeneratorChoice{json.at("kind").get<std::string>(), json.at("seed").get<std::uint64_t>(),
                         json.at("parameters").get<std::map<std::string, double>>()};
}
void take(const Row& json, std::optional<RenderChoice>& into) {
  into = render_choice_from_row(json);
}

struct Field {
  const char* name;
  std::function<Row(const WorkerSpec&)> get;
  std::function<void(WorkerSpec&, const Row&)> set;
};

/// `of`: the place of the value in a specification.
template <class Of>
Field field(const char* name, Of of) {
  return {name, [of](const WorkerSpec& spec) { return json_of(of(spec)); },
          [of](WorkerSpec& spec, const Row& json) { take(json, of(spec)); }};
}

/// Everything that travels. `ab` measures programs of several revisions, so a name keeps its meaning,
/// and what a specification lacks has its default.
const std::vector<Field>& all_fields() {
  // clang-format off
  static const std::vector<Field> kFields{
      field("path", [](auto& s) -> auto& { return s.location.path; }),
      field("generator", [](auto& s) -> auto& { return s.location.generator; }),
      field("identity", [](auto& s) -> auto& { return s.location.identity; }),
      field("exchanged", [](auto& s) -> auto& { return s.location.exchanged; }),
      field("axes", [](auto& s) -> auto& { return s.location.axes; }),
      field("allow_external", [](auto& s) -> auto& { return s.location.allow_external; }),
      field("extent", [](auto& s) -> auto& { return s.location.info.extent; }),
      field("time_steps", [](auto& s) -> auto& { return s.location.info.time_steps; }),
      field("voxel_size", [](auto& s) -> auto& { return s.location.info.voxel_size; }),
      field("voxel_unit", [](auto& s) -> auto& { return s.location.info.voxel_unit; }),
      field("type", [](auto& s) -> auto& { return s.location.info.type; }),
      field("kind", [](auto& s) -> auto& { return s.location.info.kind; }),
      field("raw_path", [](auto& s) -> auto& { return s.raw_path; }),
      field("codec", [](auto& s) -> auto& { return s.codec; }),
      field("parameters", [](auto& s) -> auto& { return s.parameters; }),
      field("stage", [](auto& s) -> auto& { return s.stage; }),
      field("threads", [](auto& s) -> auto& { return s.threads; }),
      field("bytes_per_voxel", [](auto& s) -> auto& { return s.bytes_per_voxel; }),
      field("memory_limit", [](auto& s) -> auto& { return s.memory_limit; }),
      field("scratch", [](auto& s) -> auto& { return s.scratch; }),
      field("pictures", [](auto& s) -> auto& { return s.pictures; }),
      field("seed", [](auto& s) -> auto& { return s.seed; }),
      field("checked", [](auto& s) -> auto& { return s.checked; }),
      field("lods", [](auto& s) -> auto& { return s.lods; }),
      field("render", [](auto& s) -> auto& { return s.render; }),
  };
  // clang-format on
  return kFields;
}

}  // namespace

std::string to_json_line(const WorkerSpec& spec) {
  Row json;
  for (const Field& one : all_fields()) {
    Row value = one.get(spec);
    if (!value.is_null()) json[one.name] = std::move(value);
  }
  json["fault"] = "";  // workers of before the first release ask for it
  return json.dump() + "\n";
}

WorkerSpec worker_spec_from_json(const std::string& line) {
  const Row json = volumes::parse_json(line, "worker specification");
  WorkerSpec spec;
  spec.location.present = true;
  for (const Field& one : all_fields()) {
    if (const auto found = json.find(one.name); found != json.end()) one.set(spec, *found);
  }
  return spec;
}

}  // namespace cvr::experiments
