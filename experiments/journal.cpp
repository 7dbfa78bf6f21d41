#include "experiments/journal.hpp"

#include <filesystem>
#include <fstream>

namespace cvr::experiments {

Journal::Journal(const std::string& path, std::string origin, bool anew) : path_(path), origin_(std::move(origin)) {
  if (anew) std::filesystem::remove(path_);
  std::ifstream in(path_);
  for (std::string line; std::getline(in, line);) {
    const Row round = Row::parse(line, nullptr, false);
    // A torn last line is no JSON; a line of another build is none of ours.
    if (!round.is_object() || round.value("origin", "") != origin_ || !round.contains("samples")) continue;
    rounds_[round.value("cell", "")].push_back(round["samples"]);
  }
  writer_.emplace(path_);
}

std::vector<Row> Journal::rounds_of(const std::string& cell) const {
  const auto found = rounds_.find(cell);
  return found == rounds_.end() ? std::vector<Row>() : found->second;
}

void Journal::append(const std::string& cell, const Row& samples) {
  writer_->append({{"cell", cell}, {"origin", origin_}, {"samples", samples}});
}

void Journal::remove() {
  writer_.reset();
  std::filesystem::remove(path_);
}

}  // namespace cvr::experiments
