// The rows of one table line by the id of their stage, in the order of the configuration.
#pragma once

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// The stages whose rows metrics read.
inline constexpr std::string_view kEncode = "encode", kDecode = "decode",
                                  kRandomAccess = "random-access",
                                  kLabelStatistics = "label-statistics", kRender = "render";

class StageRows {
 public:
  /// nullptr until a row is set; rows that do not exist stay nullptr.
  const Result*& operator[](std::string_view stage) {
    const auto found = std::ranges::find(rows_, stage, &Entry::first);
    return found == rows_.end() ? rows_.emplace_back(stage, nullptr).second : found->second;
  }
  /// nullptr where there is none.
  const Result* find(std::string_view stage) const {
    const auto found = std::ranges::find(rows_, stage, &Entry::first);
    return found == rows_.end() ? nullptr : found->second;
  }
  auto begin() const { return rows_.begin(); }
  auto end() const { return rows_.end(); }

 private:
  using Entry = std::pair<std::string_view, const Result*>;
  std::vector<Entry> rows_;
};

}  // namespace cvr::experiments
