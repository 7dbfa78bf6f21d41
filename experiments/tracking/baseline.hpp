// Exact figures under version control: sizes by use, checksums of what is encoded, wrong voxels and
// pixels, errors.
//
// results/baseline/NAME.json, NAME that of the configuration; keys in order, so that a change of a
// figure is a change of a line:
//   {"config": NAME, "cells": {KEY: {"size.bytes": 123, "size.checksums.index": "0123456789abcdef",
//   ..}}}
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

struct Baseline {
  std::string config;
  std::map<std::string, std::map<std::string, Row>> cells;  ///< key -> quantity -> number or text
};

/// Of the rows of the configuration's cells; a cell that is not ok has its status alone.
Baseline baseline_of(const Config& config, const std::vector<Result>& rows);

/// FOLDER/NAME.json; the folder is results/baseline beside the folder configs that holds the
/// configuration, unless given.
std::string baseline_path(const std::string& folder, const Config& config);
/// Throws InputError.
Baseline load_baseline(const std::string& path);
void store_baseline(const std::string& path, const Baseline& baseline);

struct BaselineDifference {
  std::string key, quantity, expected, found;
};
struct BaselineReport {
  std::size_t cells = 0, figures = 0;
  std::vector<BaselineDifference> differences;
  std::vector<std::string> missing, added;  ///< keys of cells
  bool differs() const { return !differences.empty() || !missing.empty() || !added.empty(); }
};
BaselineReport compare_baselines(const Baseline& expected, const Baseline& found);
std::string describe(const BaselineReport& report, const std::string& path);

}  // namespace cvr::experiments
