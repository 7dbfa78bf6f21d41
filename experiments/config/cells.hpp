// A cell: data set x codec x parameters x stage x threads, and of the render stage what
// render_choice.hpp lists. Each has an id made of what it is, so that finished work is found again:
// the hash of its canonical text, in which the data set stands with its identity and the codec with
// its version.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codecs/codec.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/config/render_choice.hpp"
#include "experiments/config/vocabulary.hpp"

namespace cvr::experiments {

/// The pseudo codec of the first line of a table: copies the voxels, the speed of light of this
/// machine.
inline constexpr std::string_view kMemcpy = "memcpy";

/// "1", "16" or "all": all is the number of cores here.
struct Threads {
  std::string text;
  unsigned count = 1;
};

struct Cell {
  std::shared_ptr<const Dataset> dataset;
  std::string codec;  ///< an id of the registry, or kMemcpy
  std::uint32_t codec_version = 0;
  codecs::Parameters parameters;
  const StageTraits* stage = nullptr;  ///< of the stage registry; never nullptr in a cell
  Threads threads;
  std::optional<RenderChoice> render = std::nullopt;  ///< of the render stage, and only there

  /// What joins the cells of one table line across stages and runs: data set, extent, codec,
  /// parameters, threads; a cell of the render stage has a line of its own.
  std::string line_key() const;
  /// line_key and stage: finds a cell's row without its data being present.
  std::string row_key() const;
  /// Parameters of the codec that differ from their defaults (Parameters::changes).
  std::string changes() const;
  /// "cells csgvr brick=64 encode, 2 threads".
  std::string describe() const;
};

/// The text whose hash is the id.
std::string canonical_text(const Cell& cell, const std::string& data_identity);
/// 16 hexadecimal digits: XXH3-64 of the canonical text.
std::string cell_id(const Cell& cell, const std::string& data_identity);

/// What a cell is called in tables: the value of dataset, kind, codec, extent, type, parameters,
/// threads, one of render_labels(), or a parameter's name; "" where the cell has no such thing.
std::string label_of(const Cell& cell, const std::string& key);

/// Labels and globs.
using Conditions = std::vector<std::pair<std::string, std::string>>;

/// Keeps a cell: every key of `only` (stage, key, or what label_of knows, threads as a number) has a
/// matching glob.
struct Filter {
  Conditions only;
  bool keeps(const Cell& cell) const;
};

}  // namespace cvr::experiments
