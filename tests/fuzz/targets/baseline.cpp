// A file of exact figures, read and compared with itself.
#include "experiments/tracking/baseline.hpp"

#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(baseline, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("baseline.json", input);
  try {
    const auto baseline = cvr::experiments::load_baseline(path);
    const auto report = cvr::experiments::compare_baselines(baseline, baseline);
    if (report.differs()) std::abort();
    cvr::experiments::describe(report, path);
  } catch (const cvr::volumes::InputError&) {
  }
}
