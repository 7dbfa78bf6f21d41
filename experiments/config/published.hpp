// Published figures to stand beside measured ones. File layout (results/paper/*.yaml):
//
//   citation: TEXT    hardware: TEXT    notes: TEXT
//   tables:
//     NAME: {title: TEXT, hardware: TEXT in place of the above,
//            figures: [{dataset: NAME, codec: ID, parameters: {brick: 32}, rate: 5.489, seconds:
//            3.211, gb_per_s: 1.2},
//                      {dataset: NAME, codec: ID, cache: ID, shading: NAME, frame_ms: 9.7}]}
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"

namespace cvr::experiments {

struct PublishedFigure {
  std::string dataset, codec;
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string cache, shading;  ///< of pictures; empty: the figure is about none
  std::optional<double> rate, seconds, gb_per_s, frame_ms;
};

struct PublishedTable {
  std::string citation, hardware, title;
  std::vector<PublishedFigure> figures;

  /// The figure of a data set (or of the one that a generated volume stands in for), codec and
  /// parameters; all parameters that the figure names must agree, and its access mode and shading.
  const PublishedFigure* find(const Cell& cell) const;
};

/// Throws InputError.
PublishedTable load_published(const std::string& path, const std::string& table);

}  // namespace cvr::experiments
