// Tables of curves: lines that agree in their labels are a curve of PSNR over bits per voxel, and
// each is compared with a reference.
#pragma once

#include <vector>

#include "experiments/analysis/table.hpp"
#include "experiments/analysis/table_lines.hpp"
#include "experiments/config/config.hpp"

namespace cvr::experiments {

/// Adds the columns, the lines, and notes on curves that cannot be compared.
void fill_curves(const TableSpec& spec, const std::vector<TableLine>& lines, Table& table);

}  // namespace cvr::experiments
