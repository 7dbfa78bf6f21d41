#include "codecs/csgv_ctx/events.hpp"

#include <array>
#include <utility>

namespace cvr::codecs::csgv_ctx {

namespace {

using Entry = EventCounts::Entry;

constexpr std::size_t kPending = std::size_t{1} << 20;  ///< events, counted when there are more

/// Ascending, by three passes over 11 bits each.
void sort(std::vector<Event>& events) {
  constexpr unsigned kDigitBits = 11;
  constexpr unsigned kDigits = 3;
  constexpr std::uint32_t kMask = (1u << kDigitBits) - 1;
  std::array<std::array<std::uint32_t, kMask + 1>, kDigits> places{};
  for (const Event event : events) {
    for (unsigned d = 0; d < kDigits; ++d) ++places[d][event >> (kDigitBits * d) & kMask];
  }
  std::vector<Event> other(events.size());
  for (unsigned d = 0; d < kDigits; ++d) {
    std::uint32_t sum = 0;
    for (std::uint32_t& place : places[d]) sum += std::exchange(place, sum);
    for (const Event event : events) other[places[d][event >> (kDigitBits * d) & kMask]++] = event;
    std::swap(events, other);
  }
}

std::vector<Entry> merged(const std::vector<Entry>& a, const std::vector<Entry>& b) {
  std::vector<Entry> all;
  all.reserve(a.size() + b.size());
  auto i = a.begin();
  auto k = b.begin();
  while (i != a.end() && k != b.end()) {
    if (i->event < k->event) {
      all.push_back(*i++);
    } else if (k->event < i->event) {
      all.push_back(*k++);
    } else {
      all.push_back({i->event, i->count + k->count});
      ++i;
      ++k;
    }
  }
  all.insert(all.end(), i, a.end());
  all.insert(all.end(), k, b.end());
  return all;
}

}  // namespace

void EventCounts::count_pending() {
  sort(pending_);
  std::vector<Entry> runs;
  for (const Event event : pending_) {
    if (runs.empty() || runs.back().event != event) runs.push_back({event, 0});
    ++runs.back().count;
  }
  counted_ = counted_.empty() ? std::move(runs) : merged(counted_, runs);
  pending_.clear();
}

void EventCounts::add(std::span<const Event> events) {
  if (pending_.size() + events.size() > kPending) count_pending();
  pending_.insert(pending_.end(), events.begin(), events.end());
}

void EventCounts::merge(const EventCounts& other) {
  add(other.pending_);
  counted_ = merged(counted_, other.counted_);
}

std::vector<Entry> EventCounts::entries() const {
  EventCounts all = *this;
  all.count_pending();
  return std::move(all.counted_);
}

}  // namespace cvr::codecs::csgv_ctx
