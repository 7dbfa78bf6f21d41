// rows.jsonl: read, compared with itself, and appended to.
#include "experiments/results/rows.hpp"

#include "experiments/tracking/comparison.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(rows, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("rows.jsonl", input);
  std::vector<cvr::experiments::Result> rows;
  try {
    rows = cvr::experiments::load_rows(path);
    cvr::experiments::latest_by(rows, &cvr::experiments::Result::cell);
    const auto report = cvr::experiments::compare_rows(rows, rows, {});
    cvr::experiments::describe(report, true);
    cvr::experiments::compare_to_rows(report);
  } catch (const cvr::volumes::InputError&) {
  }
  try {
    cvr::experiments::Result row;
    row.cell = row.key = "text";
    row.status = "ok";
    cvr::experiments::RowWriter(path).append(row);
    if (to_json(cvr::experiments::load_rows(path).back()) != to_json(row)) std::abort();
  } catch (const cvr::volumes::InputError&) {
  }
}
