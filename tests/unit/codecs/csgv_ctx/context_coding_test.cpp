// The parts of csgv-ctx: streams, distributions, trees, label lists, groups.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "codecs/csgv_ctx/label_list.hpp"
#include "codecs/csgv_ctx/model.hpp"
#include "codecs/csgv_ctx/training.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs::csgv_ctx {
namespace {

using Counts = std::array<std::uint64_t, kSymbols>;

Distribution random_distribution(std::mt19937& random, std::uint32_t possible) {
  Counts counts{};
  for (auto& n : counts) n = std::uint64_t{1} << (random() % 20);
  return fit_distribution(counts, possible);
}

struct Coded {
  std::size_t distribution;
  std::uint32_t symbol;  ///< or 12 plain bits with distribution = ~0
};

TEST(ContextStreams, GiveBackWhatWasPutWhateverTheLength) {
  std::mt19937 random(1);
  std::vector<Distribution> distributions;
  for (int i = 0; i < 20; ++i)
    distributions.push_back(random_distribution(random, i % 2 == 0 ? kPossible[0] : kPossible[1]));
  std::vector<std::uint16_t> scratch;
  for (int length = 0; length < 300; ++length) {
    StreamEncoder encoder(scratch, static_cast<std::size_t>(length));
    std::vector<Coded> coded;
    for (int i = 0; i < length; ++i) {
      const std::size_t d = random() % (distributions.size() + 1);
      if (d == distributions.size()) {
        coded.push_back({~std::size_t{0}, static_cast<std::uint32_t>(random() % 4096)});
      } else {
        coded.push_back({d, distributions[d].symbol(random() % kProbabilitySum)});
      }
    }
    for (std::size_t i = coded.size(); i-- > 0;) {
      if (coded[i].distribution == ~std::size_t{0})
        encoder.put_bits(coded[i].symbol, 12);
      else
        encoder.put(distributions[coded[i].distribution], coded[i].symbol);
    }
    std::vector<std::uint8_t> bytes;
    encoder.finish(bytes);
    StreamDecoder decoder(bytes);
    for (const Coded& c : coded) {
      const std::uint32_t read = c.distribution == ~std::size_t{0}
                                     ? decoder.bits(12)
                                     : decoder.next(distributions[c.distribution]);
      ASSERT_EQ(read, c.symbol) << "length " << length;
    }
    EXPECT_TRUE(decoder.at_end()) << "length " << length;
    if (bytes.empty()) continue;
    // A byte less is another stream.
    StreamDecoder cut(std::span<const std::uint8_t>(bytes.data(), bytes.size() - 1));
    bool same = true;
    for (const Coded& c : coded) {
      same &=
          (c.distribution == ~std::size_t{0} ? cut.bits(12)
                                             : cut.next(distributions[c.distribution])) == c.symbol;
    }
    EXPECT_FALSE(same && cut.at_end()) << "length " << length;
  }
}

TEST(ContextStreams, TakeWhatTheSymbolsAreWorthAndNothingForWhatIsCertain) {
  Counts counts{};
  counts[0] = 4000;
  counts[3] = 96;
  const Distribution d = fit_distribution(counts, kPossible[0]);
  std::vector<std::uint16_t> scratch;
  StreamEncoder encoder(scratch, 100050);
  std::vector<std::uint8_t> bytes;
  encoder.finish(bytes);
  EXPECT_TRUE(bytes.empty());
  for (int i = 0; i < 50; ++i) encoder.put(d, 0);  // the first slots: the state stays 0
  encoder.finish(bytes);
  EXPECT_TRUE(bytes.empty());

  std::mt19937 random(2);
  double worth = 0;
  for (int i = 0; i < 100000; ++i) {
    const unsigned symbol = d.symbol(random() % kProbabilitySum);
    encoder.put(d, symbol);
    worth -= std::log2(d.frequency[symbol] / 4096.0);
  }
  encoder.finish(bytes);
  EXPECT_NEAR(static_cast<double>(bytes.size()), worth / 8, 0.001 * worth / 8 + 4);
}

TEST(ContextStreams, DivideExactly) {
  std::mt19937 random(4);
  for (std::uint32_t f = 1; f <= kProbabilitySum; ++f) {
    for (int i = 0; i < 16; ++i) {
      const std::uint32_t multiple = random() % (~0u / f) * f;
      for (const std::uint32_t x :
           {multiple, multiple + f - 1, ~0u, static_cast<std::uint32_t>(random())}) {
        ASSERT_EQ(
            static_cast<std::uint64_t>(static_cast<unsigned __int128>(x) * kReciprocals[f] >> 44),
            x / f)
            << x << " by " << f;
      }
    }
  }
}

TEST(ContextEvents, AreCountedWhateverTheirNumberAndOrder) {
  std::mt19937 random(5);
  std::map<Event, std::uint32_t> expected;
  EventCounts counts, other;
  std::vector<Event> events;
  for (std::size_t brick = 0; brick < 700; ++brick) {  // more than are held before they are counted
    events.resize(random() % 4096);
    for (Event& event : events) event = random() & 0x8c0403c7u;
    for (const Event event : events) ++expected[event];
    (brick % 3 == 0 ? other : counts).add(events);
  }
  counts.merge(other);
  std::vector<std::pair<Event, std::uint32_t>> found;
  for (const auto& [event, count] : counts.entries()) found.emplace_back(event, count);
  EXPECT_EQ(found,
            (std::vector<std::pair<Event, std::uint32_t>>(expected.begin(), expected.end())));
  EXPECT_TRUE(EventCounts().entries().empty());
}

TEST(ContextDistributions, SumTo4096AndLeaveNothingPossibleOut) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t possible = i % 3 == 0 ? 0xffff : kPossible[i % 2];
    Counts counts{};
    for (unsigned s = 0; s < kSymbols; ++s)
      counts[s] = random() % 4 == 0 ? random() % (1u << (random() % 31)) : 0;
    const Distribution d = fit_distribution(counts, possible);
    unsigned sum = 0;
    for (unsigned s = 0; s < kSymbols; ++s) {
      sum += d.frequency[s];
      EXPECT_EQ(d.frequency[s] > 0, (possible >> s & 1) != 0) << "symbol " << s;
    }
    EXPECT_EQ(sum, kProbabilitySum);
  }
}

EventCounts random_counts(unsigned seed, int events) {
  std::mt19937 random(seed);
  EventCounts counts;
  for (int i = 0; i < events; ++i) {
    const std::uint32_t statics = random() & 0x33c7u;
    const std::uint32_t dynamics = random() & 0xc3u;
    const bool finest = statics >> kDepth == 0;
    // What a symbol is depends on some bits, so that there is something to learn.
    const std::uint32_t symbol =
        random() % 8 == 0 ? random() % 7 : (statics >> 1 & 3) + (dynamics & 1);
    counts.add(
        std::vector{make_event(statics, dynamics, symbol | (finest ? 0 : random() % 2 * 8))});
  }
  return counts;
}

std::vector<std::uint32_t> words_of(const ContextModel& model) {
  std::vector<std::uint32_t> words;
  BitWriter out(words);
  model.write(out);
  return words;
}

TEST(ContextModels, ReadAsWritten) {
  const ContextModel model = train(random_counts(4, 200000), {}, {});
  const std::vector<std::uint32_t> words = words_of(model);
  ContextModel read;
  BitReader in(words);
  ASSERT_EQ(ContextModel::read(in, read), nullptr);
  EXPECT_GT(model.rows().size(), 8u) << "nothing was learned";
  for (std::uint32_t statics = 0; statics < 1u << kStaticBits; ++statics) {
    for (const std::uint32_t dynamics : {0u, 1u, 0x3fffu, 0x2a5cu, 0x0381u}) {
      const Distribution& a = model.distribution(model.row(statics, dynamics));
      const Distribution& b = read.distribution(read.row(statics, dynamics));
      ASSERT_EQ(a.frequency, b.frequency) << "static " << statics << " dynamic " << dynamics;
    }
  }
  EXPECT_EQ(words_of(read), words);
}

TEST(ContextModels, DoNotDependOnWhoCountedWhat) {
  EventCounts one = random_counts(5, 30000);
  EventCounts two = random_counts(6, 50000);
  EventCounts forth;
  forth.merge(one);
  forth.merge(two);
  two.merge(one);
  EXPECT_EQ(words_of(train(forth, {}, {})), words_of(train(two, {}, {})));
}

TEST(ContextModels, OfNothingStillCodeEverything) {
  const ContextModel model = train({}, {}, {});
  const Distribution& finest = model.distribution(model.row(0, 0));
  for (unsigned s = 0; s < 7; ++s) EXPECT_GT(finest.frequency[s], 0);
  EXPECT_LE(words_of(model).size(), 16u);
}

TEST(ContextModels, WordsThatAreCutOffAreRefused) {
  const std::vector<std::uint32_t> words = words_of(train(random_counts(7, 50000), {}, {}));
  for (std::size_t kept = 0; kept < words.size(); ++kept) {
    ContextModel read;
    BitReader in(std::span<const std::uint32_t>(words.data(), kept));
    EXPECT_NE(ContextModel::read(in, read), nullptr) << kept << " of " << words.size() << " words";
  }
}

TEST(ContextModels, TreesThatAskForTooMuchAreRefused) {
  const auto read = [](auto&& write_trees) {
    std::vector<std::uint32_t> words;
    BitWriter out(words);
    out.put(0, 7);  // one distribution
    out.put(0, 4);  // the most frequent symbol,
    out.put(0, 6);  // all six others once
    write_trees(out);
    words.resize(words.size() + 4096);
    ContextModel model;
    BitReader in(words);
    return ContextModel::read(in, model);
  };
  const auto split = [](BitWriter& out, std::uint32_t bit) {
    out.put(1, 1);
    out.put(bit, 4);
  };
  EXPECT_NE(read([&](BitWriter& out) { split(out, 13); }), nullptr)
      << "the level, on the finest one";
  EXPECT_NE(read([&](BitWriter& out) {
              split(out, 3);
              split(out, 3);
            }),
            nullptr)
      << "a bit twice";
  EXPECT_NE(read([&](BitWriter& out) {
              out.put(0, 1);
              for (std::uint32_t bit = 0; bit < 8; ++bit) split(out, bit);
            }),
            nullptr)
      << "eight dynamic bits";
}

TEST(LabelLists, ReadAsWritten) {
  const std::vector<std::vector<std::uint32_t>> lists{
      {0}, {~0u}, {0, ~0u}, {5, 6, 7, 8}, {1, 1000, 1000000, 1000000000, 4000000000u}};
  for (const auto& labels : lists) {
    std::vector<std::uint32_t> words;
    BitWriter out(words);
    write_labels(labels, out);
    std::vector<std::uint32_t> read;
    BitReader in(words);
    ASSERT_TRUE(read_labels(in, read));
    EXPECT_EQ(read, labels);
    BitReader cut(std::span<const std::uint32_t>(words.data(), words.size() - 1));
    EXPECT_FALSE(read_labels(cut, read));
  }
  std::vector<std::uint32_t> dense(100000);
  for (std::uint32_t i = 0; i < dense.size(); ++i) dense[i] = i;
  std::vector<std::uint32_t> words;
  BitWriter out(words);
  write_labels(dense, out);
  EXPECT_LE(words.size(), dense.size() / 32 + 3) << "a bit per label";
}

Payload encoded(const volumes::Volume& volume, std::vector<std::string> assignments) {
  const Codec& codec = *find_codec("csgv-ctx");
  const auto parameters = Parameters::parse(codec.parameters(), assignments);
  return codec.encode(volumes::MemorySource(volume), *parameters, 2).value();
}

TEST(ContextGroups, AConstantGroupOf64BricksTakesFiveWords) {
  const volumes::VolumeInfo info{
      .extent = {64, 64, 128}, .type = volumes::VoxelType::kU16, .voxel_unit = {}};
  const Payload payload = encoded(samples::make_labels(info, [](auto&) { return 7; }), {});
  // 28 bits of header, a bit for each of 64 bricks, one for each but the first; one label needs no
  // bits to be named.
  EXPECT_EQ(payload.published_bytes, 4u * (3 + 2 * ((28 + 64 + 63 + 31) / 32)));
}

TEST(ContextGroups, NeighboursAndSiblingsMakeTheFileSmaller) {
  const volumes::Volume volume = samples::sample("odd_sides_65x33x70_u32").volume();
  std::size_t last = ~std::size_t{0};
  for (const char* contexts : {"level", "neighbours", "siblings"}) {
    const std::size_t bytes = encoded(volume, {std::string("contexts=") + contexts}).bytes.size();
    EXPECT_LT(bytes, last) << contexts;
    last = bytes;
  }
}

TEST(ContextEntropy, IsALittleLessThanWhatTheStreamsTake) {
  const volumes::Volume volume = samples::sample("odd_sides_65x33x70_u32").volume();
  const Codec& codec = *find_codec("csgv-ctx");
  std::uint64_t last = ~std::uint64_t{0};
  for (const char* contexts : {"level", "neighbours", "siblings"}) {
    const std::vector<std::string> assignments{"brick=64", std::string("contexts=") + contexts};
    const auto parameters = Parameters::parse(codec.parameters(), assignments);
    const Payload payload = codec.encode(volumes::MemorySource(volume), *parameters, 1).value();
    const auto decoder = codec.open({volume.info(), *parameters, payload.bytes.bytes()}).value();
    const std::uint64_t entropy = decoder->entropy_bytes(1).value().value();
    const std::uint64_t stored = payload.breakdown[ByteClass::kOperations];
    EXPECT_LE(entropy, stored) << contexts;
    EXPECT_GE(entropy, stored - stored / 20) << contexts;
    EXPECT_EQ(decoder->entropy_bytes(3).value().value(), entropy) << contexts;
    EXPECT_LT(entropy, last) << contexts;
    last = entropy;
  }
  EXPECT_FALSE(find_codec("raw")
                   ->open({volume.info(), {}, volume.bytes()})
                   .value()
                   ->entropy_bytes(1)
                   .value()
                   .has_value());
}

}  // namespace
}  // namespace cvr::codecs::csgv_ctx
