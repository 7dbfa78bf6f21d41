#include "experiments/stages/stage.hpp"

#include <cstdlib>
#include <ctime>

#include "experiments/stages/stage_kinds.hpp"
#include "volumes/json_text.hpp"

namespace cvr::experiments {

namespace {

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// How many times as long the laps of a series are made to take:
/// CVRBENCH_TEST_SLOWER=SERIES=FACTOR, for tests of comparisons.
double slowness_of(std::string_view series) {
  static const std::string kSlower =
      std::getenv("CVRBENCH_TEST_SLOWER") == nullptr ? "" : std::getenv("CVRBENCH_TEST_SLOWER");
  const std::size_t equals = kSlower.find('=');
  return equals == std::string::npos || kSlower.substr(0, equals) != series
             ? 1
             : std::stod(kSlower.substr(equals + 1));
}

}  // namespace

// CLOCK_MONOTONIC is what std::chrono::steady_clock reads; CLOCK_PROCESS_CPUTIME_ID sums the
// process's threads.
Stopwatch::Stopwatch()
    : wall_(seconds_of(CLOCK_MONOTONIC)), cpu_(seconds_of(CLOCK_PROCESS_CPUTIME_ID)) {}

Sample Stopwatch::lap(std::string series, std::uint64_t count) const {
  if (const double slowness = slowness_of(series); slowness > 1) {
    const double end = wall_ + slowness * (seconds_of(CLOCK_MONOTONIC) - wall_);
    while (seconds_of(CLOCK_MONOTONIC) < end) continue;
  }
  const double cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  return {std::move(series), seconds_of(CLOCK_MONOTONIC) - wall_, cpu - cpu_, count};
}

void fail_stage(const volumes::Error& error) {
  switch (error.code) {
    case volumes::ErrorCode::kUnsupported:
    case volumes::ErrorCode::kTooLarge:
      throw StageFailure(kUnsupported, error.message);
    case volumes::ErrorCode::kOutOfMemory:
      throw StageFailure(kOutOfMemory, error.message);
    default:
      throw StageFailure(kFailed, error.message);
  }
}

std::unique_ptr<StageRun> make_stage_run(const WorkerSpec& spec,
                                         const volumes::VolumeSource& truth) {
  if (spec.codec == kMemcpy) return make_memcpy_run(spec, truth);
  switch (spec.stage) {
    case Stage::kEncode:
      return make_encode_run(spec, truth);
    case Stage::kDecode:
      return make_decode_run(spec, truth);
    case Stage::kRandomAccess:
      return make_random_access_run(spec, truth);
    case Stage::kRender:
      return truth.info().kind == volumes::VolumeKind::kScalars
                 ? make_scalar_render_run(spec, truth)
                 : make_render_run(spec, truth);
  }
  throw StageFailure(kUnsupported, "unknown stage");
}

std::string to_json_line(const WorkerSpec& spec) {
  const volumes::VolumeInfo& info = spec.location.info;
  Row j;
  j["path"] = spec.location.path;
  if (spec.location.generator) {
    j["generator"]["kind"] = spec.location.generator->kind;
    j["generator"]["seed"] = spec.location.generator->seed;
    j["generator"]["parameters"] = spec.location.generator->parameters;
  }
  j["identity"] = spec.location.identity;
  j["exchanged"] = spec.location.exchanged;
  j["axes"] = spec.location.axes;
  j["allow_external"] = spec.location.allow_external;
  j["extent"] = {info.extent.x, info.extent.y, info.extent.z};
  j["time_steps"] = info.time_steps;
  j["voxel_size"] = info.voxel_size;
  j["voxel_unit"] = info.voxel_unit;
  j["type"] = name_of(info.type);
  j["kind"] = name_of(info.kind);
  j["raw_path"] = spec.raw_path;
  j["codec"] = spec.codec;
  j["parameters"] = spec.parameters;
  j["stage"] = name_of(spec.stage);
  j["threads"] = spec.threads;
  j["bytes_per_voxel"] = spec.bytes_per_voxel;
  j["memory_limit"] = spec.memory_limit;
  j["scratch"] = spec.scratch;
  j["pictures"] = spec.pictures;
  j["seed"] = spec.seed;
  j["lods"] = spec.lods;
  j["fault"] = spec.fault;
  if (spec.render) j["render"] = to_row(*spec.render);
  return j.dump() + "\n";
}

WorkerSpec worker_spec_from_json(const std::string& line) {
  const Row j = volumes::parse_json(line, "worker specification");
  WorkerSpec spec;
  Location& location = spec.location;
  location.present = true;
  location.path = j.at("path").get<std::string>();
  if (j.contains("generator")) {
    const Row& g = j["generator"];
    location.generator =
        GeneratorChoice{g.at("kind").get<std::string>(), g.at("seed").get<std::uint64_t>(),
                        g.at("parameters").get<std::map<std::string, double>>()};
  }
  location.identity = j.at("identity").get<std::string>();
  location.exchanged = j.at("exchanged").get<bool>();
  location.axes = j.at("axes").get<std::string>();
  location.allow_external = j.at("allow_external").get<bool>();
  const auto extent = j.at("extent").get<std::array<std::uint64_t, 3>>();
  location.info.extent = {extent[0], extent[1], extent[2]};
  location.info.time_steps = j.at("time_steps").get<std::uint64_t>();
  location.info.voxel_size = j.at("voxel_size").get<std::array<double, 3>>();
  location.info.voxel_unit = j.at("voxel_unit").get<std::string>();
  location.info.type = volumes::voxel_type_from_name(j.at("type").get<std::string>()).value();
  location.info.kind = volumes::volume_kind_from_name(j.at("kind").get<std::string>()).value();
  spec.raw_path = j.at("raw_path").get<std::string>();
  spec.codec = j.at("codec").get<std::string>();
  spec.parameters = j.at("parameters").get<std::string>();
  spec.stage = stage_from_name(j.at("stage").get<std::string>()).value();
  spec.threads = j.at("threads").get<unsigned>();
  spec.bytes_per_voxel = j.at("bytes_per_voxel").get<std::uint32_t>();
  spec.memory_limit = j.at("memory_limit").get<std::uint64_t>();
  spec.scratch = j.at("scratch").get<std::string>();
  spec.pictures = j.at("pictures").get<std::string>();
  spec.seed = j.at("seed").get<std::uint64_t>();
  spec.lods = j.at("lods").get<std::vector<unsigned>>();
  spec.fault = j.at("fault").get<std::string>();
  if (j.contains("render")) spec.render = render_choice_from_row(j["render"]);
  return spec;
}

}  // namespace cvr::experiments
