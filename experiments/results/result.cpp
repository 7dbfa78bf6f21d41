// The tables of a row around what is measured (part_fields.cpp), and the schema of rows.
#include "experiments/results/result.hpp"

#include "experiments/results/fields.hpp"

namespace cvr::experiments {

namespace {

constexpr const char* kHash = R"({"pattern": "^[0-9a-f]{16}$"})";
constexpr const char* kFrom1 = R"({"minimum": 1})";
constexpr const char* kFrom2 = R"({"minimum": 2})";
constexpr const char* kNotEmpty = R"({"minLength": 1})";

}  // namespace

template <>
FieldTable<Provenance::CpuFeatures> table_of() {
  using S = Provenance::CpuFeatures;
  return FieldTable<S>()
      .required("compiled", &S::compiled, "what the program's own code may use")
      .required("present", &S::present,
                "what the processor has; libraries choose among these at run time");
}

template <>
FieldTable<Provenance> table_of() {
  using S = Provenance;
  return FieldTable<S>()
      .required("harness", &S::harness)
      .required("revision", &S::revision, "git revision, -dirty where the tree had changes")
      .required("compiler", &S::compiler)
      .required("flags", &S::flags)
      .required("build_type", &S::build_type)
      .required("cpu", &S::cpu)
      .required("cores", &S::cores)
      .required("memory_bytes", &S::memory_bytes)
      .required("kernel", &S::kernel)
      .required("os", &S::os)
      .required("machine", &S::machine,
                "fingerprint of cpu, cores and memory: times compare only where it is the same")
      .required("libc", &S::libc, "", R"({"pattern": "^glibc [0-9]"})")
      .required("libraries", &S::libraries, "versions as loaded, by the libraries' names",
                R"({"required": ["zstd", "liblzma", "zlib", "hdf5", "zfp", "astcenc", "xxhash"],
              "additionalProperties": {"type": "string", "minLength": 1}})")
      .required("cpu_features", &S::cpu_features,
                "vector and bit instructions, by the names of /proc/cpuinfo")
      .required("governor", &S::governor,
                "of frequency scaling, of all cores; unknown where the system does not tell",
                kNotEmpty)
      .required("turbo", &S::turbo, "", R"({"enum": ["on", "off", "unknown"]})")
      .required("huge_pages", &S::huge_pages,
                "transparent huge pages: always, madvise, never or unknown", kNotEmpty)
      .required("config_hash", &S::config_hash)
      .required("time", &S::time, "UTC");
}

template <>
FieldTable<Result::Dataset> table_of() {
  using S = Result::Dataset;
  return FieldTable<S>()
      .required("name", &S::name)
      .required("title", &S::title)
      .required("label", &S::label,
                "'stand-in for ...' or 'generated' where the volume is not the original")
      .optional("extent", &S::extent, "x, y, z; of a series of all time steps, stacked along z",
                R"({"items": {"type": "integer", "minimum": 1}})")
      .optional("time_steps", &S::time_steps, "of a series", kFrom2)
      .optional("type", &S::type, "", R"({"enum": ["u8", "u16", "u32", "u64", "i16", "f32"]})")
      .optional("kind", &S::kind, "", R"({"enum": ["labels", "scalars"]})")
      .optional("voxels", &S::voxels, "", kFrom1)
      .optional("original_voxels", &S::original_voxels,
                "of the original, which a smaller volume may stand for", kFrom1)
      .optional("bytes", &S::bytes, "", kFrom1)
      .optional("identity", &S::identity, "", kHash)
      .optional("content_hash", &S::content_hash,
                "XXH3-64 of the voxels; null if they were streamed")
      .optional("labels", &S::labels, "distinct labels, background included; absent if streamed",
                kFrom1)
      .optional("original_labels", &S::original_labels, "of the original, as described", kFrom1)
      .optional("source", &S::source, "streamed: reading or generating is part of the times",
                R"({"enum": ["mapped copy", "streamed"]})");
}

template <>
FieldTable<Result::Codec> table_of() {
  using S = Result::Codec;
  return FieldTable<S>()
      .required("id", &S::id, "of the registry, or memcpy")
      .required("version", &S::version)
      .required("parameters", &S::parameters);
}

template <>
FieldTable<Result> table_of() {
  using S = Result;
  return FieldTable<S>()
      .required("schema", &S::schema, "", R"({"const": 1})")
      .required(
          "cell", &S::cell,
          "XXH3-64 of the cell's canonical text: data identity, codec and version, parameters, "
          "stage, threads; of images also scene, access mode and what else they depend on",
          kHash)
      .required(
          "key", &S::key,
          "data set|extent|codec|parameters|threads|stage as the configuration names them; of "
          "images scene, access mode, shading and so on before the stage")
      .required(
          "status", &S::status, "",
          R"({"enum": ["ok", "failed", "timeout", "out-of-memory", "unsupported", "data-missing"]})")
      .required("reason", &S::reason, "empty when ok")
      .required("dataset", &S::dataset)
      .required("codec", &S::codec)
      .required("stage", &S::stage)
      .required("threads", &S::threads, "", kFrom1)
      .optional("render", &S::render)
      .required("provenance", &S::provenance)
      .all_of<Parts>()
      .optional("interleave_group", &S::interleave_group,
                "with how many cells the rounds alternated, and whether memory cut the group")
      .optional("processes", &S::processes, "worker processes that made the rounds; absent: one")
      .optional("elapsed_seconds", &S::elapsed_seconds, "check and rounds");
}

template Row to_json(const Result&);
template Row to_json(const Provenance&);
template Result from_json(const Row&);

std::string row_schema(const std::vector<std::string>& stages, const Row& render) {
  Row schema{
      {"$schema", "https://json-schema.org/draft/2020-12/schema"},
      {"title", "A row of rows.jsonl: the outcome of one cell"},
      {"description",
       "Rates are percent of the original's bytes, times seconds, sizes bytes. A cell with a "
       "status other than ok has no size and no time. The last row of a cell counts."}};
  schema.update(schema_of_fields<Result>());
  schema["properties"]["stage"] = {{"enum", stages}};
  schema["properties"]["render"] = render;
  schema["$defs"]["statistics"] = schema_of_fields<Repeated>();
  return schema.dump(1) + "\n";
}

std::string Result::access_mode() const { return render ? render->value("cache", "") : ""; }

}  // namespace cvr::experiments
