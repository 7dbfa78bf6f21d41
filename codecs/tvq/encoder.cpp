#include "codecs/tvq/encoder.hpp"

#include <algorithm>

#include "codecs/tvq/random_codes.hpp"
#include "codecs/tvq/sub_volume.hpp"

namespace cvr::codecs::tvq {

namespace {

/// The largest and the mean squared error over all voxels but exceptions, by slabs.
class ErrorSink final : public SlabSink {
 public:
  ErrorSink(const VolumeSource& truth, std::span<const ExceptionRun> exceptions)
      : truth_(truth), reader_(truth), exceptions_(exceptions) {}
  std::uint64_t preferred_depth() const override { return 16; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    const VolumeInfo& info = truth_.info();
    slab_.resize((z1 - z0) * info.extent.x * info.extent.y * size_of(info.type));
    return slab_.data();
  }
  void end(std::uint64_t z0, std::uint64_t z1) override {
    const std::byte* original = reader_.read(z0, z1);
    const std::uint64_t plane = truth_.info().extent.x * truth_.info().extent.y;
    switch (truth_.info().type) {
      case VoxelType::kU16:
        return add<std::uint16_t>(original, z0 * plane, (z1 - z0) * plane);
      case VoxelType::kI16:
        return add<std::int16_t>(original, z0 * plane, (z1 - z0) * plane);
      case VoxelType::kF32:
        return add<float>(original, z0 * plane, (z1 - z0) * plane);
      default:
        return add<std::uint8_t>(original, z0 * plane, (z1 - z0) * plane);
    }
  }
  RecordedError error() const {
    return {largest_, count_ == 0 ? 0 : squares_ / static_cast<double>(count_)};
  }

 private:
  template <class T>
  void add(const std::byte* original, std::uint64_t first, std::uint64_t count) {
    const auto* expected = reinterpret_cast<const T*>(original);
    const auto* found = reinterpret_cast<const T*>(slab_.data());
    for (std::uint64_t i = 0; i < count; ++i) {
      while (next_ < exceptions_.size() &&
             exceptions_[next_].first + exceptions_[next_].count <= first + i)
        ++next_;
      if (next_ < exceptions_.size() && exceptions_[next_].first <= first + i) continue;
      const double difference = static_cast<double>(expected[i]) - static_cast<double>(found[i]);
      largest_ = std::max(largest_, std::abs(difference));
      squares_ += difference * difference;
      ++count_;
    }
  }

  const VolumeSource& truth_;
  volumes::SlabReader reader_;
  std::span<const ExceptionRun> exceptions_;
  Buffer slab_;
  std::size_t next_ = 0;
  double largest_ = 0, squares_ = 0;
  std::uint64_t count_ = 0;
};

/// Books that all time steps share are trained with at most this many blocks: as many as a volume
/// of 256^3 has, or four of those.
std::uint64_t most_sampled(const Options& options) {
  return std::uint64_t{1} << (options.best ? 20 : 18);
}

/// The boxes of a place at all time steps.
class Places {
 public:
  Places(const Extent& step, std::uint64_t time_steps, std::uint32_t edge, const Coordinate& place)
      : depth_(step.z), time_steps_(time_steps), box_(box_of(step, edge, place)) {}
  std::uint64_t time_steps() const { return time_steps_; }
  Extent blocks() const { return ceil_div(box_.size, kBlockEdge); }
  double voxels() const { return static_cast<double>(box_.size.voxels()); }
  volumes::Box at(std::uint64_t time) const {
    volumes::Box box = box_;
    box.origin.z += time * depth_;
    return box;
  }

 private:
  std::uint64_t depth_, time_steps_;
  volumes::Box box_;
};

/// One block of each of most_sampled() equal runs of the blocks of all steps, at a random place in
/// its run, so that no period of the volume is met. One step is in memory at a time.
Blocks sample_blocks(const VolumeSource& source, const Domain& domain, const Places& places,
                     const Options& options) {
  const std::uint64_t each = places.blocks().voxels(), all = each * places.time_steps(),
                      count = std::min(all, most_sampled(options));
  const auto run_begin = [&](std::uint64_t i) {
    return i * (all / count) + std::min(i, all % count);
  };
  std::vector<float> sample;
  sample.reserve(count * kBlockVoxels);
  std::vector<float> samples;
  std::uint64_t begin = 0, end = 0;  // the blocks in `samples`
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t first = run_begin(i);
    const std::uint64_t block = first + mix(options.seed ^ mix(i)) % (run_begin(i + 1) - first);
    if (block >= end) {
      const std::uint64_t time = block / each;
      samples = read_blocks(source, domain, places.at(time));
      begin = time * each, end = begin + each;
    }
    const auto from = samples.begin() + static_cast<std::ptrdiff_t>((block - begin) * kBlockVoxels);
    sample.insert(sample.end(), from, from + kBlockVoxels);
  }
  return Blocks(std::move(sample));
}

}  // namespace

Expected<Payload> encode(const Scheme& scheme, const VolumeSource& source,
                         const EncoderSettings& settings, unsigned threads) {
  const VolumeInfo& info = source.info();
  auto facts = survey(source, settings.zero, settings.mask);
  if (!facts) return tl::unexpected(facts.error());
  Encoding encoding;
  const Domain& domain = encoding.domain = facts->domain;
  encoding.edge = settings.edge;
  encoding.exceptions = std::move(facts->exceptions);
  encoding.exception_bits = std::move(facts->exception_bits);
  const Extent step = info.step_extent(), grid = encoding.grid(step);
  const std::uint64_t parts = grid.voxels() * info.time_steps;
  const bool shared = settings.shared_books && info.time_steps > 1;
  Options options = settings.options;
  std::vector<Trained> trained;  // of the places, where books are shared
  for (std::uint64_t i = 0; i < parts; ++i) {
    const std::uint64_t place = i % grid.voxels(), time = i / grid.voxels();
    const Places places(step, info.time_steps, settings.edge, grid.coordinate(place));
    const auto each = static_cast<double>(places.blocks().voxels());
    const auto steps = static_cast<double>(info.time_steps);
    options.seed = settings.options.seed * 1000003 + (shared ? place : i);
    if (options.random_codes) {
      if (!shared || time == 0) encoding.books.push_back(random_books(scheme, domain, options));
      encoding.parts.push_back(
          random_part(scheme, domain, encoding.books_of(i), places.blocks(), options, i));
      continue;
    }
    if (shared && time == 0) {
      Blocks sample = sample_blocks(source, domain, places, options);
      trained.push_back(train(scheme, domain, sample, each * steps,
                              options.rate * places.voxels() * steps, options, threads));
      encoding.books.push_back(trained.back().set);
    }
    Blocks blocks(read_blocks(source, domain, places.at(time)));
    if (shared) {
      encoding.parts.push_back(code(scheme, domain, trained[place], places.blocks(),
                                    std::move(blocks), options, threads));
      continue;
    }
    Trained own =
        train(scheme, domain, blocks, each, options.rate * places.voxels(), options, threads);
    encoding.parts.push_back(
        code(scheme, domain, own, places.blocks(), std::move(blocks), options, threads));
    encoding.books.push_back(std::move(own.set));
  }
  Payload payload = write_payload(scheme, encoding);
  const auto decoder = make_decoder(scheme, info, encoding, {});
  if (!decoder) return tl::unexpected(decoder.error());
  ErrorSink sink(source, encoding.exceptions);
  if (auto ok = (*decoder)->decode(0, threads, sink); !ok) return tl::unexpected(ok.error());
  const RecordedError error = sink.error();
  std::memcpy(payload.bytes.data() + kErrorOffset, &error.largest, sizeof error.largest);
  std::memcpy(payload.bytes.data() + kErrorOffset + sizeof error.largest, &error.mean_squared,
              sizeof error.mean_squared);
  return payload;
}

}  // namespace cvr::codecs::tvq
