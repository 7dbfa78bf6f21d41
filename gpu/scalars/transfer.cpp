#include "gpu/scalars/transfer.hpp"

#include <algorithm>

#include "gpu/reference/vector.hpp"

namespace cvr::gpu {

std::vector<TransferEntry> transfer_table(const std::vector<TransferPoint>& points) {
  const auto entry_of = [](const TransferPoint& p) {
    return TransferEntry{p.colour[0] / 255.0, p.colour[1] / 255.0, p.colour[2] / 255.0, p.density};
  };
  std::vector<TransferEntry> table(kTransferEntries, TransferEntry{});
  if (points.empty()) return table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double value = static_cast<double>(i) / (kTransferEntries - 1);
    const auto above =
        std::ranges::find_if(points, [&](const TransferPoint& p) { return p.value > value; });
    if (above == points.begin() || above == points.end()) {
      table[i] = entry_of(above == points.begin() ? points.front() : points.back());
      continue;
    }
    const TransferEntry low = entry_of(*(above - 1)), high = entry_of(*above);
    const double part = (value - (above - 1)->value) / (above->value - (above - 1)->value);
    for (std::size_t c = 0; c < low.size(); ++c) table[i][c] = low[c] + part * (high[c] - low[c]);
  }
  return table;
}

SliceOrder slice_order(const volumes::VolumeInfo& info, const Camera& camera) {
  const Vector3 view = normalize(camera.target - camera.eye) / world_scale(info);
  const std::size_t axis = longest_axis(view);
  return {axis, view[axis] < 0};
}

}  // namespace cvr::gpu
