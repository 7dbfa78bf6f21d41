// What a worker process is told to do.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/datasets.hpp"
#include "experiments/config/render_choice.hpp"

namespace cvr::experiments {

/// Everything a worker needs; travels as one JSON line.
struct WorkerSpec {
  Location location;
  std::string raw_path;  ///< of the mapped copy; empty: streamed
  std::string codec;
  std::string parameters;  ///< canonical
  std::string stage;       ///< id
  unsigned threads = 1;
  std::uint32_t bytes_per_voxel = 0;
  std::uint64_t memory_limit = 0;  ///< bytes beyond the mapped input; 0: none
  std::string scratch;   ///< folder for encoded files, shared by the stages of a run; empty: none
  std::string pictures;  ///< path that kept images begin with; empty: none are kept
  std::uint64_t seed = 1;
  bool checked = false;                ///< images, by a worker of before: they need not be again
  std::vector<unsigned> lods;          ///< empty: all
  std::optional<RenderChoice> render;  ///< of the render stage
};

std::string to_json_line(const WorkerSpec& spec);
/// Throws std::exception on anything malformed.
WorkerSpec worker_spec_from_json(const std::string& line);

}  // namespace cvr::experiments
