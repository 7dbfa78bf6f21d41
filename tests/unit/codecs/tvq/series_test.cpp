// Time series: stacks of steps with books of their own or shared ones.
#include <algorithm>
#include <limits>
#include <map>

#include "codecs/gpu_samples.hpp"
#include "codecs/tvq/decoder.hpp"
#include "shaders/shared/shared.hpp"
#include "tests/unit/codecs/tvq/coded.hpp"

namespace cvr::codecs::tvq {
namespace {

const std::array<std::string, 2> kBooks{"books=step", "books=shared"};

/// Rings that move on by a voxel and a half each step.
template <class T>
Volume moving_rings(const Extent& step, std::uint64_t steps, VoxelType type, double scale = 1) {
  Volume volume = make_scalars<T>({step.x, step.y, step.z * steps}, type, [&](const Coordinate& c) {
    const std::uint64_t t = c.z / step.z;
    return static_cast<T>(
        (rings({c.x + t, c.y + t / 2, c.z % step.z}) + 5 * static_cast<double>(t % 3)) * scale);
  });
  volume.info().time_steps = steps;
  return volume;
}

Volume step_of(const Volume& series, std::uint64_t t) {
  VolumeInfo info = series.info();
  info.extent = info.step_extent();
  info.time_steps = 1;
  Volume step(info);
  std::memcpy(step.data(), series.data() + t * step.info().bytes(), step.info().bytes());
  return step;
}

TEST(Series, KeepTheirStepsAndTheErrorThatTheyRecord) {
  for (const std::string_view id : kIds) {
    for (const std::string& books : kBooks) {
      for (const std::string edge : {"edge=0", "edge=32"}) {
        SCOPED_TRACE(std::string(id) + ' ' + books + ' ' + edge);
        const Volume volume = moving_rings<std::uint8_t>({37, 22, 35}, 4, VoxelType::kU8);
        const Coded coded = code(id, volume, {books, edge, "rate=900"});
        EXPECT_EQ(coded.opened.stream.info.time_steps, 4u);
        EXPECT_EQ(coded.decoded.info().time_steps, 4u);
        const RecordedError measured = error_of<std::uint8_t>(volume, coded.decoded),
                            promised = coded.decoder->recorded_error().value();
        EXPECT_EQ(promised.largest, measured.largest);
        EXPECT_NEAR(promised.mean_squared, measured.mean_squared, 1e-6 * measured.mean_squared);
        EXPECT_EQ(coded.file.breakdown.total(), coded.file.bytes.size());
        expect_single_voxels_agree<std::uint8_t>(coded);
      }
    }
    for (const std::string& books : kBooks) {
      expect_single_voxels_agree<std::uint32_t>(code(
          id, moving_rings<float>({13, 9, 6}, 3, VoxelType::kF32, 0.37), {books, "rate=1500"}));
      expect_single_voxels_agree<std::uint16_t>(
          code(id, moving_rings<std::int16_t>({13, 9, 6}, 3, VoxelType::kI16, 90),
               {books, "rate=1500"}));
    }
  }
}

/// A step with books of its own is coded as it would be alone, where its range is that of the
/// series.
TEST(Series, StepsOfTheirOwnAreWhatTheyAreAlone) {
  Volume series = moving_rings<std::uint8_t>({37, 22, 11}, 3, VoxelType::kU8);
  for (std::uint64_t t = 0; t < 3; ++t)
    series.voxels<std::uint8_t>()[t * 37 * 22 * 11] = 0,
                                                series
                                                    .voxels<std::uint8_t>()[t * 37 * 22 * 11 + 1] =
                                                    255;
  for (const std::string_view id : kIds) {
    for (const std::string rate : {"rate=0", "rate=900"}) {
      const Coded whole = code(id, series, {"books=step", rate});
      for (std::uint64_t t = 0; t < 3; ++t) {
        EXPECT_TRUE(
            same_voxels(code(id, step_of(series, t), {rate}).decoded, step_of(whole.decoded, t)))
            << id << ' ' << rate << ' ' << t;
      }
    }
  }
}

TEST(Series, OfOneStepAreVolumes) {
  const Volume volume = rings_u8({37, 22, 29});
  for (const std::string_view id : kIds) {
    const Coded step = code(id, volume, {"books=step", "rate=500"}),
                shared = code(id, volume, {"books=shared", "rate=500"});
    ASSERT_EQ(step.opened.stream.payload.size(), shared.opened.stream.payload.size());
    EXPECT_EQ(std::memcmp(step.opened.stream.payload.data(), shared.opened.stream.payload.data(),
                          step.opened.stream.payload.size()),
              0);
  }
}

TEST(Series, WriteTheSameBytesForAnyThreads) {
  const Volume volume = moving_rings<std::uint8_t>({41, 29, 10}, 3, VoxelType::kU8);
  for (const std::string_view id : kIds) {
    for (const std::string& books : kBooks) {
      for (const std::string how : {"effort=fast", "effort=best", "edge=32"}) {
        const auto one = try_encode(id, volume, {books, how, "rate=700"}, 1).value();
        for (const unsigned threads : {2u, 3u, 7u}) {
          const auto more = try_encode(id, volume, {books, how, "rate=700"}, threads).value();
          ASSERT_EQ(one.bytes.size(), more.bytes.size()) << id << ' ' << books << ' ' << how;
          ASSERT_EQ(std::memcmp(one.bytes.data(), more.bytes.data(), one.bytes.size()), 0)
              << id << ' ' << books << ' ' << how << ' ' << threads;
        }
      }
    }
  }
}

TEST(Series, SharedBooksAreStoredAndCountedOnce) {
  // Books of full size and codes of whole bytes: 8 steps of 16x16x16 blocks.
  const Volume volume = moving_rings<std::uint8_t>({64, 64, 64}, 8, VoxelType::kU8);
  const std::uint64_t blocks = 8 * 4096;
  for (const auto& [id, bits, planes, entries] :
       {std::tuple{"hvq", std::vector<std::string>{"octants=8", "voxels=8", "dc=8"},
                   std::uint64_t{3}, std::uint64_t{256 * (8 + 64)}},
        {"tvq", std::vector<std::string>{"bits=8,8,8", "dc=8", "book=assoc", "transform=dct"},
         std::uint64_t{4}, std::uint64_t{3 * 256 * 64}}}) {
    std::vector<std::string> assignments = bits;
    assignments.insert(assignments.end(), {"rate=0", "books=shared"});
    const Coded coded = code(id, volume, assignments, 2);
    EXPECT_EQ(coded.file.published_bytes, blocks * planes + entries) << id;
    EXPECT_EQ(coded.file.breakdown[ByteClass::kOperations], blocks * planes) << id;
    // The zero vectors are not in the file.
    EXPECT_EQ(coded.file.breakdown[ByteClass::kTables], entries - entries / 256) << id;
    const auto samples = coded.decoder->gpu_samples(static_cast<unsigned>(planes) - 1);
    ASSERT_TRUE(samples) << samples.error().message;
    EXPECT_EQ(samples->buffers[0].bytes.size(),
              coded.file.published_bytes + 4 * (8 * CVR_TVQ_ROW + 2))
        << id;
    assignments.back() = "books=step";
    EXPECT_GT(code(id, volume, assignments, 2).file.published_bytes, blocks * planes + 6 * entries)
        << id;
  }
}

TEST(Series, TakeTheRateThatIsAskedFor) {
  const Volume volume = moving_rings<std::uint8_t>({40, 36, 32}, 8, VoxelType::kU8);
  const auto voxels = static_cast<double>(volume.extent().voxels());
  for (const std::string_view id : kIds) {
    std::map<std::string, double> errors;
    for (const std::string& books : kBooks) {
      for (const std::string how : {"count=file", "count=device"}) {
        const Coded coded = code(id, volume, {books, how, "rate=500"});
        const double bytes = how == "count=device"
                                 ? static_cast<double>(coded.file.published_bytes)
                                 : static_cast<double>(coded.opened.stream.payload.size());
        EXPECT_LT(8 * bytes / voxels, 0.525 + 8 * 8 * 200 / voxels)
            << id << ' ' << books << ' ' << how;
        errors[books + how] = coded.decoder->recorded_error()->mean_squared;
      }
    }
    // Books of eight steps cost an eighth where they are shared, and the codes get what is saved.
    EXPECT_LT(errors["books=sharedcount=file"], errors["books=stepcount=file"]) << id;
    EXPECT_LT(errors["books=sharedcount=device"], errors["books=stepcount=device"]) << id;
  }
}

TEST(Series, ProgressiveStepsArePrefixes) {
  const Volume volume = moving_rings<std::uint8_t>({45, 39, 22}, 3, VoxelType::kU8);
  for (const std::string_view id : {"hvq", "tvq"}) {
    for (const std::string& books : kBooks) {
      const Coded coded = code(id, volume, {"rate=0", books, "edge=32"});
      const ProgressiveAccess& steps = *coded.decoder->progressive_access();
      double last = 1e300;
      std::uint64_t bytes = 0;
      for (unsigned step = 0; step < steps.steps(); ++step) {
        volumes::VolumeSink sink(volume.info());
        ASSERT_TRUE(steps.decode_step(step, 3, sink));
        const Volume found = sink.take();
        const double error = error_of<std::uint8_t>(volume, found).mean_squared;
        EXPECT_LT(error, last) << id << ' ' << books << ' ' << step;
        EXPECT_GT(steps.step_bytes(step), bytes);
        last = error, bytes = steps.step_bytes(step);
        if (step + 1 == steps.steps()) {
          EXPECT_TRUE(same_voxels(found, coded.decoded));
        }
      }
      EXPECT_EQ(bytes, coded.opened.stream.payload.size());
    }
  }
}

/// Slabs may begin and end anywhere in a series; every plane comes once and in order.
TEST(Series, ComeInSlabsOfAnyDepth) {
  class Slabs final : public volumes::SlabSink {
   public:
    Slabs(const VolumeInfo& info, std::uint64_t depth) : volume_(info), depth_(depth) {}
    std::uint64_t preferred_depth() const override { return depth_; }
    std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
      EXPECT_EQ(z0, next_);
      EXPECT_LE(z1 - z0, std::max<std::uint64_t>(depth_, kBlockEdge));
      next_ = z1;
      return volume_.data() + z0 * volume_.extent().x * volume_.extent().y;
    }
    void end(std::uint64_t, std::uint64_t) override {}
    Volume volume_;
    std::uint64_t depth_, next_ = 0;
  };
  for (const std::uint64_t depth : {1u, 2u, 5u, 8u}) {
    const Coded coded = code("tvq", moving_rings<std::uint8_t>({21, 13, depth}, 7, VoxelType::kU8),
                             {"books=shared", "rate=0"});
    for (const std::uint64_t planes : {1u, 3u, 4u, 9u, 1000u}) {
      Slabs sink(coded.decoded.info(), planes);
      ASSERT_TRUE(coded.decoder->decode(0, 2, sink));
      EXPECT_EQ(sink.next_, coded.decoded.extent().z);
      EXPECT_TRUE(same_voxels(sink.volume_, coded.decoded)) << depth << ' ' << planes;
    }
  }
}

TEST(Series, KeepAConstantStepExact) {
  for (const std::string_view id : {"hvq", "tvq"}) {
    for (const std::string& books : kBooks) {
      Volume volume = moving_rings<std::uint8_t>({40, 35, 9}, 4, VoxelType::kU8);
      const std::size_t bytes = 40 * 35 * 9;
      std::memset(volume.data() + 2 * bytes, 77, bytes);
      const Coded coded = code(id, volume, {books, "rate=400"});
      EXPECT_EQ(std::memcmp(coded.decoded.data() + 2 * bytes, volume.data() + 2 * bytes, bytes), 0)
          << id << ' ' << books;
      EXPECT_GT(coded.decoder->recorded_error()->largest, 0);
    }
  }
  // All steps constant, each another value.
  Volume steps = make_scalars<std::uint8_t>({9, 6, 12}, VoxelType::kU8, [](const Coordinate& c) {
    return static_cast<std::uint8_t>(40 + c.z / 3 * 50);
  });
  steps.info().time_steps = 4;
  for (const std::string_view id : {"hvq", "tvq"}) {
    for (const std::string& books : kBooks)
      EXPECT_TRUE(same_voxels(code(id, steps, {books}).decoded, steps)) << id << ' ' << books;
  }
}

TEST(Series, KeepNonFiniteVoxelsOfOneStep) {
  Volume volume = moving_rings<float>({14, 11, 7}, 3, VoxelType::kF32, 0.5);
  const std::uint64_t step = 14 * 11 * 7;
  auto voxels = volume.voxels<float>();
  for (std::uint64_t i = 5; i < 300; ++i)
    voxels[step + i] = std::numeric_limits<float>::quiet_NaN();
  voxels[step + 400] = -std::numeric_limits<float>::infinity();
  for (const std::string_view id : kIds) {
    for (const std::string& books : kBooks) {
      const auto refused = try_encode(id, volume, {books});
      ASSERT_FALSE(refused);
      EXPECT_NE(refused.error().message.find("(5, 0, 7)"), std::string::npos)
          << refused.error().message;
      const Coded coded = code(id, volume, {books, "nonfinite=mask"});
      for (std::uint64_t i = 0; i < 3 * step; ++i) {
        const float a = voxels[i], b = coded.decoded.voxels<float>()[i];
        ASSERT_TRUE(std::isfinite(a) ? std::isfinite(b) : std::memcmp(&a, &b, 4) == 0)
            << id << ' ' << i;
      }
      expect_single_voxels_agree<std::uint32_t>(coded);
      EXPECT_TRUE(std::isfinite(coded.decoder->recorded_error()->mean_squared));
    }
  }
}

TEST(Series, ScaledByPowersOfTwoHaveTheSameCodes) {
  const Volume volume = moving_rings<float>({21, 18, 13}, 3, VoxelType::kF32, 0.37);
  for (const std::string_view id : kIds) {
    for (const std::string& books : kBooks) {
      const Coded plain = code(id, volume, {books, "rate=1200"});
      for (const int power : {-90, -20, 100}) {
        Volume scaled = volume;
        for (float& v : scaled.voxels<float>()) v = std::ldexp(v, power);
        const Coded other = code(id, scaled, {books, "rate=1200"});
        const auto a = plain.opened.stream.payload, b = other.opened.stream.payload;
        ASSERT_EQ(a.size(), b.size()) << id << ' ' << power;
        EXPECT_EQ(std::memcmp(a.data() + 40, b.data() + 40, a.size() - 40), 0)
            << id << ' ' << books << ' ' << power;
      }
    }
  }
}

/// A device gets the stack where cubes cut it into its sub-volumes, by the rule that the text
/// follows.
TEST(Series, GoToDevicesWhereTheirStepsAreCubes) {
  const auto constant = [](const GpuSamples& samples, std::string_view name) {
    const auto found = std::ranges::find(
        samples.constants, name, [](const auto& entry) { return std::string_view(entry.first); });
    return found == samples.constants.end() ? 0u : found->second;
  };
  struct Shape {
    Extent step;
    std::string edge;
    std::uint32_t expected;  ///< 0: refused
  };
  for (const Shape& shape : {Shape{{20, 16, 20}, "edge=0", 20},
                             {{40, 36, 32}, "edge=32", 32},
                             {{33, 9, 64}, "edge=32", 32},
                             {{20, 16, 18}, "edge=0", 0},
                             {{24, 16, 20}, "edge=0", 0},
                             {{40, 36, 20}, "edge=32", 0}}) {
    for (const std::string& books : kBooks) {
      SCOPED_TRACE(to_string(shape.step) + ' ' + shape.edge + ' ' + books);
      const Coded coded = code("tvq", moving_rings<std::uint8_t>(shape.step, 3, VoxelType::kU8),
                               {books, shape.edge, "rate=0"});
      const auto samples = coded.decoder->gpu_samples(3);
      ASSERT_EQ(samples.has_value(), shape.expected != 0);
      if (!samples) {
        EXPECT_EQ(samples.error().code, ErrorCode::kUnsupported);
        EXPECT_NE(samples.error().message.find("time steps of " + to_string(shape.step)),
                  std::string::npos)
            << samples.error().message;
        continue;
      }
      EXPECT_EQ(constant(*samples, "CVR_TVQ_EDGE"), shape.expected);
      // The address of the text in shaders/scalars/tvq.glsl, with the stack's extent and that edge.
      const std::uint64_t edge = shape.expected;
      const Extent& e = coded.decoded.extent();
      const Extent grid = volumes::ceil_div(e, edge);
      const shaders::Words words{
          reinterpret_cast<const std::uint32_t*>(samples->buffers[0].bytes.data())};
      const auto number = [&](std::string_view name) {
        return static_cast<int>(constant(*samples, name));
      };
      const shaders::TvqDomain domain{
          5, number("CVR_TVQ_ZERO"), number("CVR_TVQ_LOW"), number("CVR_TVQ_HIGH"), 0, 1, 1};
      for (std::uint64_t n = 0; n < e.voxels(); ++n) {
        const Coordinate c = e.coordinate(n), at{c.x / edge, c.y / edge, c.z / edge};
        const Coordinate inside{c.x - at.x * edge, c.y - at.y * edge, c.z - at.z * edge};
        const Extent part{std::min(edge, e.x - at.x * edge), std::min(edge, e.y - at.y * edge),
                          edge};
        const std::uint64_t block =
            volumes::ceil_div(part, 4).index({inside.x / 4, inside.y / 4, inside.z / 4});
        const auto i =
            static_cast<std::uint32_t>((inside.x & 3) + 4 * (inside.y & 3) + 16 * (inside.z & 3));
        const auto row =
            shaders::cvr_tvq_row(words, static_cast<std::uint32_t>(grid.index(at) * CVR_TVQ_ROW));
        ASSERT_EQ(shaders::cvr_tvq_integer(domain, shaders::cvr_tvq_sum(words, row, block, i, 3)),
                  coded.decoded.voxels<std::uint8_t>()[n])
            << n;
      }
    }
  }
}

TEST(Series, RefuseFalseFlagsAndShortPayloads) {
  const Volume series = moving_rings<std::uint8_t>({14, 11, 7}, 3, VoxelType::kU8);
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, series, {"books=shared", "rate=0"});
    const auto payload = coded.opened.stream.payload;
    const auto open_with = [&](std::size_t size, std::uint64_t steps,
                               std::optional<std::byte> flags) {
      Buffer bytes;
      bytes.append(payload.first(size));
      if (flags) bytes.data()[40] = *flags;
      VolumeInfo info = coded.opened.stream.info;
      info.time_steps = steps;
      const auto opened =
          coded.opened.codec->open({info, coded.opened.stream.parameters, bytes.bytes()});
      return opened ? std::string() : opened.error().message;
    };
    EXPECT_EQ(open_with(payload.size(), 3, {}), "");
    EXPECT_NE(open_with(payload.size(), 1, {}).find("no books shared"), std::string::npos);
    EXPECT_NE(open_with(payload.size(), 3, payload[40] | std::byte{8}).find("offset 40"),
              std::string::npos);
    EXPECT_NE(open_with(payload.size(), 3, payload[40] & std::byte{3}), "");
    EXPECT_NE(open_with(payload.size(), 21, {}), "");
    for (std::size_t size = 0; size < payload.size(); size += 1 + size / 9)
      EXPECT_NE(open_with(size, 3, {}), "") << id << ' ' << size;
  }
}

/// Planes of alternating value: all frequency along z, in every step.
TEST(Series, OfAlternatingSlicesHaveChaptersAlongZAlone) {
  Volume volume = make_scalars<std::uint8_t>({32, 32, 64}, VoxelType::kU8, [](const Coordinate& c) {
    return static_cast<std::uint8_t>(
        c.z % 2 * (40 + samples::random_at(2, c.x / 4 + 100 * (c.y / 4) + 10000 * (c.z / 4)) % 80) +
        60);
  });
  volume.info().time_steps = 2;
  for (const std::string& books : kBooks) {
    const Coded coded = code(
        "tvq", volume, {"rate=0", "assign=chapter", "tau=20", "psnr=40", "transform=dct", books});
    StepBytes steps{};
    const Encoding encoding =
        read_payload(kTvq, coded.opened.stream.info, coded.opened.stream.payload, steps).value();
    EXPECT_EQ(encoding.books.size(), books == "books=step" ? 2u : 1u);
    for (const BookSet& set : encoding.books) {
      EXPECT_EQ(set.books[2].size, 1u);
      for (const unsigned p : {0u, 1u}) {
        for (const Chapter& chapter : set.books[p].chapters)
          EXPECT_EQ(kBlockClasses[chapter.block_class].name, "BPz") << p;
      }
      EXPECT_EQ(set.books[1].chapters.size(), 1u);
    }
    EXPECT_LT(coded.decoder->recorded_error()->mean_squared, 4);
  }
}

}  // namespace
}  // namespace cvr::codecs::tvq
