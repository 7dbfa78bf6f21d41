#include "tests/fuzz/target.hpp"

#include <algorithm>
#include <utility>

namespace cvr::fuzz {

namespace {

struct Registered {
  std::string name;
  std::vector<std::string> (*variants)();
  detail::Run run;
};

std::vector<Registered>& registered() {
  static std::vector<Registered> all;
  return all;
}

}  // namespace

namespace detail {

bool add_target(std::string name, std::vector<std::string> (*variants)(), Run run) {
  registered().push_back({std::move(name), variants, run});
  return true;
}

}  // namespace detail

std::vector<Target> targets() {
  std::vector<Target> sorted;
  for (const Registered& target : registered()) {
    if (target.variants == nullptr) {
      sorted.push_back({target.name, [run = target.run](Input input) { run({}, input); }});
      continue;
    }
    for (const std::string& variant : target.variants()) {
      sorted.push_back({target.name + '-' + variant,
                        [run = target.run, variant](Input input) { run(variant, input); }});
    }
  }
  std::ranges::sort(sorted, {}, &Target::name);
  return sorted;
}

}  // namespace cvr::fuzz
