// journal.jsonl: read as a run that goes on would, and appended to.
#include "experiments/run/journal.hpp"

#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(journal, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("journal.jsonl", input);
  try {
    std::size_t before = 0;
    {
      cvr::experiments::Journal journal(path, "origin", false);
      before = journal.rounds_of("c").size();
      journal.append("c", {});
    }
    cvr::experiments::Journal journal(path, "origin", false);
    if (journal.rounds_of("c").size() != before + 1) std::abort();
  } catch (const cvr::volumes::InputError&) {
  }
}
