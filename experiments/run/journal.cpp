#include "experiments/run/journal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "experiments/results/samples.hpp"
#include "volumes/error.hpp"
#include "volumes/json_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

constexpr std::size_t kQuoted = 40;  ///< bytes of a line that an error shows

bool is_round(const Row& line) {
  return line.is_object() && line.contains("cell") && line["cell"].is_string() &&
         line.contains("origin") && line["origin"].is_string() && line.contains("samples");
}

}  // namespace

Journal::Journal(const std::string& path, std::string origin, bool anew)
    : path_(path), origin_(std::move(origin)) {
  if (anew) std::filesystem::remove(path_);
  for_each_line(path_, [this](std::size_t number, std::string_view text) {
    const Row line = volumes::parse_json(text, path_, number);
    const auto fail = [&](std::string_view expected) {
      throw volumes::InputError(fmt::format(
          "{}:{}: expected a round ({}), found '{}'; without this file --resume measures the cells "
          "that have no rows from their first round",
          path_, number, expected, volumes::printable(text.substr(0, kQuoted))));
    };
    if (!is_round(line)) fail("a JSON object with cell, origin and samples");
    cells_.insert(line["cell"].get<std::string>());
    if (line["origin"].get_ref<const std::string&>() != origin_) return;
    auto samples = samples_from(line["samples"]);
    if (!samples || !line.contains("seconds") || !line["seconds"].is_number())
      fail("samples of series, seconds, CPU seconds and count; seconds");
    rounds_[line["cell"].get<std::string>()].push_back(
        {std::move(*samples), line["seconds"].get<double>()});
  });
  writer_.emplace(path_);
}

const std::vector<Round>& Journal::rounds_of(const std::string& cell) const {
  static const std::vector<Round> kNone;
  const auto found = rounds_.find(cell);
  return found == rounds_.end() ? kNone : found->second;
}

void Journal::append(const std::string& cell, const Round& round) {
  cells_.insert(cell);
  const Row line{{"cell", cell},
                 {"origin", origin_},
                 {"seconds", round.seconds},
                 {"samples", to_row(round.samples)}};
  writer_->append(line.dump(-1, ' ', false, Row::error_handler_t::replace));
}

void Journal::remove(const std::set<std::string>& ended) {
  const auto has_ended = [&](const std::string& cell) {
    return ended.contains(cell.substr(0, cell.find(' ')));
  };
  if (!std::ranges::all_of(cells_, has_ended)) return;
  writer_.reset();
  std::filesystem::remove(path_);
}

}  // namespace cvr::experiments
