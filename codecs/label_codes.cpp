#include "codecs/label_codes.hpp"

#include <algorithm>

#include "codecs/radix_sort.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 18;  // voxels that a worker takes at a time
constexpr std::size_t kThinAbove = std::size_t{1}
                                   << 20;  // labels that are kept before the list is thinned

constexpr std::size_t place(std::uint64_t label) { return (label * 0x9e3779b97f4a7c15u) >> 52; }

void sort_and_thin(std::vector<std::uint64_t>& labels) {
  std::vector<std::uint64_t> spare;
  if (!std::ranges::is_sorted(labels)) radix_sort(labels, spare);
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
}

}  // namespace

void DistinctLabels::Worker::note(std::uint64_t label) {
  if (cache.empty()) {
    // No place may begin with a label that belongs there: 0 belongs to place 0 alone, 1 does not.
    static_assert(place(0) == 0 && place(1) != 0);
    cache.assign(kCached, 0);
    cache[0] = 1;
  }
  std::uint64_t& cached = cache[place(label)];
  if (cached == label) return;
  cached = label;
  labels.push_back(label);
  if (labels.size() >= 2 * std::max(thinned, kThinAbove)) thin();
}

void DistinctLabels::Worker::thin() {
  sort_and_thin(labels);
  thinned = labels.size();
}

template <class T>
void DistinctLabels::add(unsigned worker, std::span<const T> labels) {
  if (labels.empty()) return;
  Worker& own = workers_[worker];
  if constexpr (sizeof(T) <= 2) own.seen.resize(std::size_t{1} << (8 * sizeof(T)));
  const auto note = [&own](T label) {
    if constexpr (sizeof(T) <= 2)
      own.seen[label] = 1;
    else
      own.note(label);
  };
  // Many of the same label are skipped at once.
  constexpr std::size_t kAtOnce = 128 / sizeof(T);
  T last = labels[0];
  note(last);
  for (std::size_t i = 0; i < labels.size();) {
    const std::size_t count = std::min(kAtOnce, labels.size() - i);
    const T* here = &labels[i];
    i += count;
    if (count == kAtOnce) {
      T differing = 0;
      for (std::size_t k = 0; k < kAtOnce; ++k) differing |= static_cast<T>(here[k] ^ last);
      if (differing == 0) continue;
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (sizeof(T) > 2 && here[k] == last) continue;
      last = here[k];
      note(last);
    }
  }
}

void DistinctLabels::add(volumes::VoxelType type, std::span<const std::byte> voxels) {
  volumes::with_label_type(type, [&]<class T>() {
    const std::size_t count = voxels.size() / sizeof(T);
    const std::size_t pieces = (count + kPiece - 1) / kPiece;
    volumes::parallel_for(static_cast<unsigned>(workers_.size()), pieces,
                          [&](unsigned worker, std::uint64_t i) {
                            const std::size_t first = i * kPiece;
                            const std::size_t n = std::min(kPiece, count - first);
                            add<T>(worker, {reinterpret_cast<const T*>(voxels.data()) + first, n});
                          });
  });
}

std::vector<std::uint64_t> DistinctLabels::take() {
  std::vector<std::uint64_t> all;
  unsigned lists = 0;
  for (Worker& worker : workers_) {
    for (std::size_t label = 0; label < worker.seen.size(); ++label) {
      if (worker.seen[label] != 0) worker.labels.push_back(label);
    }
    worker.thin();
    lists += worker.labels.empty() ? 0 : 1;
    if (all.empty()) {
      all = std::move(worker.labels);
    } else {
      all.insert(all.end(), worker.labels.begin(), worker.labels.end());
    }
    worker = {};
  }
  if (lists > 1) sort_and_thin(all);
  return all;
}

template void DistinctLabels::add(unsigned, std::span<const std::uint8_t>);
template void DistinctLabels::add(unsigned, std::span<const std::uint16_t>);
template void DistinctLabels::add(unsigned, std::span<const std::uint32_t>);
template void DistinctLabels::add(unsigned, std::span<const std::uint64_t>);

void assign_codes(const std::vector<std::uint64_t>& labels, GpuEncoding& encoding) {
  const bool wide = !labels.empty() && labels.back() > UINT32_MAX;
  encoding.constants.emplace_back("CVR_REMAP_SIZE",
                                  wide ? static_cast<std::uint32_t>(labels.size()) : 0u);
  encoding.codes.resize(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    encoding.codes[i] = static_cast<std::uint32_t>(wide ? i : labels[i]);
  }
  if (!wide) return;
  encoding.cell_loops += 32;  // binary search
  auto remap = std::make_shared<volumes::Buffer>();
  remap->append(labels.data(), labels.size() * sizeof labels[0]);
  encoding.remap = {reinterpret_cast<const std::uint64_t*>(remap->data()), labels.size()};
  encoding.buffers.push_back({"remap", remap->bytes(), remap});
}

bool is_brick_edge(std::uint32_t edge) {
  return std::has_single_bit(edge) && edge >= 2 && edge <= 64;
}

}  // namespace cvr::codecs
