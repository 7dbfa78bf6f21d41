// Published figures to stand beside measured ones (results/published/*.yaml). docs/config.md lists the
// keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/keys.hpp"

namespace cvr::experiments {

struct PublishedFigure {
  std::string dataset, codec;  ///< codec empty: the figure is about the data set
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string access_mode, shading;  ///< of images; empty: the figure is about none
  std::optional<double> rate, seconds, gb_per_s, frame_ms;
  std::optional<double> labels, original_gb;  ///< of the data set
  /// Of its images: what the caches of a cell are put under.
  std::optional<double> bricks, cache_bytes_per_voxel, voxels_per_pixel, frames_per_brick;
  /// Of the authors' own logs.
  std::optional<double> logged_rate, logged_bytes, logged_frame_ms, logged_frame_min_ms,
      logged_frame_max_ms;
};

struct PublishedTable {
  std::string citation, hardware, title;
  std::vector<PublishedFigure> figures;

  /// The figure of a data set (or of the one that a generated volume stands in for), codec and
  /// parameters; all parameters that the figure names must agree, and its access mode and shading.
  const PublishedFigure* find(const Cell& cell) const;
};

/// A file of them.
struct PublishedFile {
  std::string citation, hardware, notes;
  std::vector<std::pair<std::string, PublishedTable>> tables;  ///< by their names
};
std::vector<Key<PublishedFile>> published_file_keys();
std::vector<Key<PublishedTable>> published_table_keys();
std::vector<Key<PublishedFigure>> published_figure_keys();

/// `scaled`: parameters of codecs that its figures then do not name. Throws InputError.
PublishedTable load_published(const std::string& path, const std::string& table,
                              const std::vector<std::string>& scaled = {});

}  // namespace cvr::experiments
