#include "volumes/io/unfinished.hpp"

#include <filesystem>
#include <set>

namespace cvr::volumes {

namespace {

struct Registry {
  std::mutex mutex;
  std::set<std::string> names;
};

/// Never destroyed: threads may wait for it while the program ends.
Registry& registry() {
  static auto* const instance = new Registry;
  return *instance;
}

}  // namespace

UnfinishedOutputs::UnfinishedOutputs() : lock_(registry().mutex) {}

void UnfinishedOutputs::add(const std::string& path) { registry().names.insert(path); }

void UnfinishedOutputs::remove(const std::string& path) { registry().names.erase(path); }

void abandon_outputs() {
  registry().mutex.lock();  // for good
  // A library that opens a file by its name may make it once more between the first pass and its
  // end.
  for (int pass = 0; pass < 2; ++pass) {
    for (const std::string& name : registry().names) {
      std::error_code ignored;
      std::filesystem::remove_all(name, ignored);
    }
  }
}

}  // namespace cvr::volumes
