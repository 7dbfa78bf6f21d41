// The codecs vq, hvq and tvq from voxels to voxels: what they promise, and the hard cases.
#include <algorithm>
#include <cfloat>

#include "codecs/tvq/format.hpp"
#include "shaders/shared/shared.hpp"
#include "tests/unit/codecs/tvq/coded.hpp"

namespace cvr::codecs::tvq {
namespace {

TEST(BlockCodecs, RecordTheErrorThatDecodingHas) {
  const Volume volume = rings_u8({37, 22, 29});
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, volume, {"rate=500"});
    const RecordedError measured = error_of<std::uint8_t>(volume, coded.decoded),
                        promised = coded.decoder->recorded_error().value();
    EXPECT_EQ(promised.largest, measured.largest) << id;
    EXPECT_NEAR(promised.mean_squared, measured.mean_squared, 1e-6 * measured.mean_squared) << id;
    EXPECT_GT(measured.mean_squared, 0) << id;
  }
}

TEST(BlockCodecs, WriteTheSameBytesForAnyThreads) {
  const Volume volume = rings_u8({61, 45, 52});
  for (const std::string_view id : kIds) {
    for (const std::string how :
         {"effort=fast", "effort=best", "init=pnn", "init=scalar", "init=random", "edge=32"}) {
      const auto one = try_encode(id, volume, {how, "rate=700"}, 1).value();
      for (const unsigned threads : {2u, 3u, 7u}) {
        const auto more = try_encode(id, volume, {how, "rate=700"}, threads).value();
        ASSERT_EQ(one.bytes.size(), more.bytes.size()) << id << ' ' << how;
        ASSERT_EQ(std::memcmp(one.bytes.data(), more.bytes.data(), one.bytes.size()), 0)
            << id << ' ' << how << ' ' << threads;
      }
    }
  }
}

TEST(BlockCodecs, SingleVoxelsAgreeWithTheWhole) {
  const Extent extent{41, 23, 38};
  for (const std::string_view id : kIds) {
    for (const std::string edge : {"edge=0", "edge=32"}) {
      expect_single_voxels_agree<std::uint8_t>(code(id, rings_u8(extent), {edge, "rate=1500"}));
      expect_single_voxels_agree<std::uint16_t>(
          code(id,
               make_scalars<std::uint16_t>(
                   extent, VoxelType::kU16,
                   [](const Coordinate& c) { return static_cast<std::uint16_t>(rings(c) * 250); }),
               {edge, "rate=1500"}));
      expect_single_voxels_agree<std::uint16_t>(code(
          id,
          make_scalars<std::int16_t>(extent, VoxelType::kI16,
                                     [](const Coordinate& c) {
                                       return static_cast<std::int16_t>((rings(c) - 110) * 250);
                                     }),
          {edge, "rate=1500", "zero=mode"}));
      expect_single_voxels_agree<std::uint32_t>(code(
          id,
          make_scalars<float>(
              extent, VoxelType::kF32,
              [](const Coordinate& c) { return static_cast<float>(rings(c) - 100.25) * 0.37f; }),
          {edge, "rate=1500"}));
    }
  }
}

TEST(BlockCodecs, AreExactWhereTheVolumeIsConstant) {
  for (const std::string_view id : kIds) {
    for (const Extent& extent : {Extent{1, 1, 1}, {9, 6, 7}}) {
      const Volume bytes = make_scalars<std::uint8_t>(
          extent, VoxelType::kU8, [](const Coordinate&) { return std::uint8_t{77}; });
      const Volume shorts = make_scalars<std::int16_t>(
          extent, VoxelType::kI16, [](const Coordinate&) { return std::int16_t{-3001}; });
      const Volume floats =
          make_scalars<float>(extent, VoxelType::kF32, [](const Coordinate&) { return -0.1f; });
      for (const Volume* volume : {&bytes, &shorts, &floats}) {
        const Coded coded = code(id, *volume, {});
        EXPECT_TRUE(same_voxels(coded.decoded, *volume)) << id;
        EXPECT_EQ(coded.decoder->recorded_error()->largest, 0.0);
      }
    }
  }
}

TEST(BlockCodecs, KeepZeroBlocksExactInNoise) {
  const Volume volume =
      make_scalars<std::uint8_t>({32, 32, 32}, VoxelType::kU8, [](const Coordinate& c) {
        if (c.x / 4 % 2 == c.y / 4 % 2) return std::uint8_t{0};
        return static_cast<std::uint8_t>(samples::random_at(3, c.x + 100 * (c.y + 100 * c.z)));
      });
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, volume, {});
    for (std::uint64_t i = 0; i < volume.extent().voxels(); ++i) {
      if (i % 32 / 4 % 2 == i / 32 % 32 / 4 % 2) {
        ASSERT_EQ(coded.decoded.voxels<std::uint8_t>()[i], 0) << id;
      }
    }
  }
  // Flat blocks of other grey levels too, where there is DC.
  const Volume steps =
      make_scalars<std::uint8_t>({32, 32, 32}, VoxelType::kU8, [](const Coordinate& c) {
        return static_cast<std::uint8_t>(
            c.z < 16 ? c.x / 4 * 31 + c.y / 4
                     : samples::random_at(4, c.x + 100 * (c.y + 100 * c.z)));
      });
  for (const std::string_view id : {"hvq", "tvq"}) {
    const Coded coded = code(id, steps, {"rate=0"});
    EXPECT_EQ(std::memcmp(coded.decoded.data(), steps.data(), 32 * 32 * 16), 0) << id;
  }
}

TEST(BlockCodecs, SurviveThinVolumes) {
  for (const std::string_view id : kIds) {
    for (const Extent& extent : {Extent{1, 1, 1}, {1, 50, 33}, {70, 1, 1}, {5, 7, 9}, {3, 2, 41}}) {
      const Volume volume = rings_u8(extent);
      const Coded coded = code(id, volume, {"rate=0", "edge=32"});
      EXPECT_EQ(coded.decoded.extent(), extent);
      EXPECT_LE(coded.decoder->recorded_error()->mean_squared, 6000) << id;
    }
  }
}

TEST(BlockCodecs, StayInRangeAtTheWorstContrast) {
  const auto board = [](const Coordinate& c) { return (c.x + c.y + c.z) % 2 == 0; };
  const Volume bytes = make_scalars<std::uint8_t>(
      {20, 16, 24}, VoxelType::kU8,
      [&](const Coordinate& c) { return std::uint8_t(board(c) ? 255 : 0); });
  const Volume floats =
      make_scalars<float>({20, 16, 24}, VoxelType::kF32,
                          [&](const Coordinate& c) { return board(c) ? FLT_MAX : -FLT_MAX; });
  for (const std::string_view id : kIds) {
    const Coded b = code(id, bytes, {"rate=0"});
    EXPECT_LE(b.decoder->recorded_error()->largest, 4) << id;
    const Coded f = code(id, floats, {"rate=0"});
    for (const float v : f.decoded.voxels<float>()) ASSERT_TRUE(std::isfinite(v)) << id;
    EXPECT_LE(f.decoder->recorded_error()->largest, 1e-2 * FLT_MAX) << id;
  }
}

TEST(BlockCodecs, TellTheErrorOfASingleOutlier) {
  const Volume volume =
      make_scalars<std::uint8_t>({48, 48, 48}, VoxelType::kU8, [](const Coordinate& c) {
        return static_cast<std::uint8_t>(c == Coordinate{21, 22, 23} ? 255 : 100 + (c.x + c.y) / 8);
      });
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, volume, {});
    EXPECT_EQ(coded.decoder->recorded_error()->largest,
              error_of<std::uint8_t>(volume, coded.decoded).largest);
    EXPECT_LT(coded.decoder->recorded_error()->mean_squared, 4) << id;
  }
}

TEST(BlockCodecs, ScaleFloatsByPowersOfTwoWithoutAnyDifference) {
  const Extent extent{25, 18, 21};
  const auto scaled = [&](int exponent) {
    return make_scalars<float>(extent, VoxelType::kF32, [exponent](const Coordinate& c) {
      return static_cast<float>(std::ldexp(std::floor(rings(c) * 16), exponent));
    });
  };
  for (const std::string_view id : kIds) {
    const Coded one = code(id, scaled(-4), {"rate=900"});
    for (const int exponent : {-149, -20, 100}) {  // -149: denormals all
      const Coded other = code(id, scaled(exponent), {"rate=900"});
      // All but offset and exponent (bytes 4..11) and the recorded error (24..39) of the payload.
      const auto a = one.opened.stream.payload, b = other.opened.stream.payload;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        if (i >= 12 && (i < 24 || i >= 40)) {
          ASSERT_EQ(a[i], b[i]) << id << ' ' << exponent << ' ' << i;
        }
      }
    }
  }
}

TEST(BlockCodecs, SurviveAnyRangeOfFloats) {
  const Volume volume = make_scalars<float>({17, 19, 16}, VoxelType::kF32, [](const Coordinate& c) {
    const std::uint64_t n = samples::random_at(8, c.x + 100 * (c.y + 100 * c.z));
    return static_cast<float>(
        std::ldexp(n % 2 == 0 ? 1.0 : -1.0, static_cast<int>(n / 2 % 240) - 120));
  });
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, volume, {"rate=2000"});
    for (const float v : coded.decoded.voxels<float>()) ASSERT_TRUE(std::isfinite(v)) << id;
    EXPECT_TRUE(std::isfinite(coded.decoder->recorded_error()->mean_squared));
  }
}

TEST(BlockCodecs, RefuseOrKeepWhatIsNotFinite) {
  Volume volume = make_scalars<float>({13, 11, 12}, VoxelType::kF32, [](const Coordinate& c) {
    return static_cast<float>(rings(c));
  });
  auto voxels = volume.voxels<float>();
  const std::uint32_t payload_nan = 0xffc12345u;
  std::memcpy(&voxels[volume.extent().index({3, 5, 2})], &payload_nan, 4);
  for (std::uint64_t x = 0; x < 13; ++x)
    voxels[volume.extent().index({x, 10, 2})] = x % 2 == 0 ? INFINITY : -INFINITY;
  voxels.back() = NAN;
  for (const std::string_view id : kIds) {
    const auto refused = try_encode(id, volume, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(refused.error().message.find(
                  "found 15 of 1716 that are NaN or infinite, the first at (3, 5, 2)"),
              std::string::npos)
        << refused.error().message;
    const Coded coded = code(id, volume, {"nonfinite=mask"});
    std::vector<Coordinate> points;
    for (std::uint64_t i = 0; i < voxels.size(); ++i) {
      points.push_back({i % 13, i / 13 % 11, i / 143});
      if (std::isfinite(voxels[i])) {
        ASSERT_TRUE(std::isfinite(coded.decoded.voxels<float>()[i]));
      } else {
        ASSERT_EQ(coded.decoded.voxels<std::uint32_t>()[i], volume.voxels<std::uint32_t>()[i])
            << id << ' ' << i;
      }
    }
    std::vector<std::uint64_t> found(points.size());
    ASSERT_TRUE(coded.decoder->voxel_access()->at(points, 0, found));
    EXPECT_TRUE(std::ranges::equal(found, coded.decoded.voxels<std::uint32_t>()));
    EXPECT_LT(coded.decoder->recorded_error()->mean_squared, 5000);
    // Nothing but what is not finite.
    const Volume none =
        make_scalars<float>({5, 4, 3}, VoxelType::kF32, [](const Coordinate&) { return NAN; });
    EXPECT_TRUE(same_voxels(code(id, none, {"nonfinite=mask"}).decoded, none));
  }
}

TEST(BlockCodecs, DropBooksWithoutBits) {
  const Volume volume = rings_u8({33, 30, 29});
  double last = 1e300;
  for (const std::string bits :
       {"bits=0,0,0", "bits=1,0,0", "bits=6,0,0", "bits=6,5,0", "bits=6,5,4"}) {
    const Coded coded = code("tvq", volume, {"rate=0", bits, "assign=global"});
    const double error = coded.decoder->recorded_error()->mean_squared;
    EXPECT_LT(error, last) << bits;
    last = error;
  }
  EXPECT_EQ(code("hvq", volume, {"octants=0", "voxels=0"}).decoder->recorded_error()->mean_squared,
            code("tvq", volume, {"rate=0", "bits=0,0,0"}).decoder->recorded_error()->mean_squared);
}

TEST(BlockCodecs, TakeTheRateThatIsAskedFor) {
  const Volume volume = rings_u8({96, 80, 88});
  const double voxels = static_cast<double>(volume.extent().voxels());
  for (const std::string_view id : kIds) {
    double last = 1e300;
    for (const int rate : {300, 600, 1200}) {
      for (const std::string how : {"alloc=operational", "alloc=paper", "count=device"}) {
        const Coded coded = code(id, volume, {"rate=" + std::to_string(rate), how});
        const double bytes = how == "count=device"
                                 ? static_cast<double>(coded.file.published_bytes)
                                 : static_cast<double>(coded.opened.stream.payload.size());
        EXPECT_LT(8 * bytes / voxels, rate * 1.05e-3 + 8 * 700 / voxels) << id << ' ' << how;
        if (how != "alloc=operational") continue;
        EXPECT_LT(coded.decoder->recorded_error()->mean_squared, last) << id << ' ' << rate;
        last = coded.decoder->recorded_error()->mean_squared;
      }
    }
  }
}

TEST(BlockCodecs, RandomCodesFillTheirBooksAndDecode) {
  const Volume bytes = rings_u8({64, 48, 40});
  for (const std::string_view id : kIds) {
    const std::vector<std::string> random{"codes=random", id == "tvq" ? "bits=8,8,8" : "rate=0"};
    const Coded coded = code(id, bytes, random);
    EXPECT_EQ(coded.decoder->recorded_error()->largest,
              error_of<std::uint8_t>(bytes, coded.decoded).largest)
        << id;
    const auto voxels = coded.decoded.voxels<std::uint8_t>();
    const auto [least, most] = std::ranges::minmax_element(voxels);
    EXPECT_GT(*most - *least, 120) << id;
    expect_single_voxels_agree<std::uint8_t>(coded);
    // As many codes as the same books trained would have, and others by another seed.
    const Coded trained = code(id, bytes, {"rate=0"}),
                other = code(id, bytes, {random[0], random[1], "seed=2"});
    if (id != "vq") {
      EXPECT_EQ(coded.file.breakdown[ByteClass::kOperations],
                trained.file.breakdown[ByteClass::kOperations])
          << id;
    }
    EXPECT_FALSE(same_voxels(coded.decoded, other.decoded)) << id;
  }
}

/// A device that decodes slices reads four voxels at a time.
TEST(BlockCodecs, RunsOfFourAgreeWithSingleVoxels) {
  const Extent extent{20, 12, 8}, blocks{5, 3, 2};
  const Volume bytes = rings_u8(extent),
               floats = make_scalars<float>(extent, VoxelType::kF32, [](const Coordinate&c) {
                 return static_cast<float>(rings(c));
               });
  for (const std::string_view id : kIds) {
    for (const Volume* volume : {&bytes, &floats}) {
      const Coded coded = code(id, *volume, {"rate=4000"});
      const ProgressiveAccess* steps = coded.decoder->progressive_access();
      const auto samples = coded.decoder->gpu_samples(steps == nullptr ? 0 : steps->steps() - 1);
      ASSERT_TRUE(samples) << samples.error().message;
      std::vector<std::uint32_t> copy(samples->buffers[0].bytes.size() / 4);
      std::memcpy(copy.data(), samples->buffers[0].bytes.data(), 4 * copy.size());
      const shaders::Words words{copy.data()};
      const shaders::TvqRow row = shaders::cvr_tvq_row(words, 0);
      for (std::uint32_t books = 0; books <= kMaxBooks; ++books) {
        for (std::uint64_t n = 0; n < blocks.voxels(); ++n) {
          for (std::uint32_t i = 0; i < kBlockVoxels; ++i) {
            ASSERT_EQ(shaders::cvr_tvq_run(words, row, n, i / 4, books).sum[i % 4],
                      shaders::cvr_tvq_sum(words, row, n, i, books))
                << id << ' ' << i;
          }
        }
      }
    }
  }
}

TEST(BlockCodecs, UseTheRangeThatOccursOfWiderTypes) {
  // 12 bits in u16, and 12 bits about -1000 in i16 as of a CT: the error is that of the range, not
  // of the type.
  const Extent extent{48, 40, 36};
  const auto level = [](const Coordinate& c) { return 17 * (rings(c) - 20); };
  const Volume unsigned12 = make_scalars<std::uint16_t>(
      extent, VoxelType::kU16,
      [&](const Coordinate& c) { return static_cast<std::uint16_t>(level(c)); });
  const Volume signed12 = make_scalars<std::int16_t>(
      extent, VoxelType::kI16,
      [&](const Coordinate& c) { return static_cast<std::int16_t>(level(c) - 1000); });
  for (const std::string_view id : kIds) {
    const double first =
        code(id, unsigned12, {"rate=1000"}).decoder->recorded_error()->mean_squared;
    const double second =
        code(id, signed12, {"rate=1000", "zero=least"}).decoder->recorded_error()->mean_squared;
    EXPECT_LT(std::sqrt(first), 0.15 * 17 * 220) << id;
    EXPECT_NEAR(second / first, 1, 0.2) << id;
  }
}

TEST(BlockCodecs, AnEmptyVolumeIsAHeader) {
  const Volume empty = make_scalars<std::uint8_t>(
      {80, 64, 48}, VoxelType::kU8, [](const Coordinate&) { return std::uint8_t{0}; });
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, empty, {});
    EXPECT_TRUE(same_voxels(coded.decoded, empty)) << id;
    EXPECT_EQ(coded.file.breakdown[ByteClass::kOperations], 0u) << id;
    EXPECT_LT(coded.file.bytes.size(), 700u) << id;
  }
}

TEST(Tvq, CountsAsThePaperDoes) {
  // Figure 6: 131072 blocks, 8 bits each of DC, LP, BP, HP, books of 256 entries of 64 bytes: 560
  // KB for 8192 KB of voxels.
  const Volume volume =
      make_scalars<std::uint8_t>({256, 256, 128}, VoxelType::kU8, [](const Coordinate& c) {
        return static_cast<std::uint8_t>(samples::random_at(6, c.x + 256 * (c.y + 256 * c.z)) %
                                             256 / 4 +
                                         c.x / 4 + c.y / 4 + c.z / 2);
      });
  const Coded coded =
      code("tvq", volume,
           {"rate=0", "bits=8,8,8", "assign=chapter", "book=assoc", "transform=dct", "tau=50"}, 2);
  EXPECT_EQ(coded.file.published_bytes, 560u * 1024);
  // What a device gets is what is counted, one row that says where things lie, and two words to
  // read beyond the end.
  const auto samples = coded.decoder->gpu_samples(3);
  ASSERT_TRUE(samples);
  ASSERT_EQ(samples->buffers.size(), 1u);
  EXPECT_EQ(samples->buffers[0].bytes.size(), 560u * 1024 + 4 * (CVR_TVQ_ROW + 2));
  const ProgressiveAccess& steps = *coded.decoder->progressive_access();
  ASSERT_EQ(steps.steps(), 4u);
  // 128, 272, 416, 560 KB, less the 64 zero bytes of each book that the file leaves out, after one
  // header.
  const std::uint64_t header = steps.step_bytes(0) - 128 * 1024;
  EXPECT_LT(header, 200u);
  for (unsigned step = 0; step < 4; ++step)
    EXPECT_EQ(steps.step_bytes(step), header + (128 + 144 * step) * 1024 - 64 * step);
  EXPECT_EQ(steps.step_bytes(3), coded.opened.stream.payload.size());
}

TEST(Tvq, StepsNeedNoMoreThanTheirPrefix) {
  const Volume volume = rings_u8({45, 39, 41});
  for (const std::string_view id : {"hvq", "tvq"}) {
    const Coded coded = code(id, volume, {"rate=0", "edge=32"});
    const ProgressiveAccess& steps = *coded.decoder->progressive_access();
    double last = 1e300;
    for (unsigned step = 0; step < steps.steps(); ++step) {
      volumes::VolumeSink sink(volume.info());
      ASSERT_TRUE(steps.decode_step(step, 2, sink));
      const Volume found = sink.take();
      const double error = error_of<std::uint8_t>(volume, found).mean_squared;
      EXPECT_LT(error, last) << id << ' ' << steps.step_name(step);
      last = error;
      if (step + 1 == steps.steps()) {
        EXPECT_TRUE(same_voxels(found, coded.decoded));
      }
      EXPECT_LT(steps.step_bytes(step), step + 1 == steps.steps()
                                            ? coded.opened.stream.payload.size() + 1
                                            : steps.step_bytes(step + 1));
      // Damage behind the prefix must not reach the step: code bits there are turned round, which
      // no check forbids in full books.
      if (step + 1 < steps.steps() &&
          coded.opened.stream.payload.size() > steps.step_bytes(step) + 64) {
        Buffer changed;
        changed.append(coded.opened.stream.payload);
        changed.data()[changed.size() - 1] ^= std::byte{0x01};
        const Stream stream{coded.opened.stream.info, coded.opened.stream.parameters,
                            changed.bytes()};
        if (const auto other = coded.opened.codec->open(stream)) {
          volumes::VolumeSink again(volume.info());
          ASSERT_TRUE((*other)->progressive_access()->decode_step(step, 1, again));
          EXPECT_TRUE(same_voxels(again.take(), found));
        }
      }
    }
    volumes::VolumeSink sink(volume.info());
    EXPECT_FALSE(steps.decode_step(steps.steps(), 1, sink));
  }
  EXPECT_EQ(code("vq", volume, {}).decoder->progressive_access(), nullptr);
}

TEST(Tvq, KeepsChaptersOfTheClassesThatOccurAlone) {
  // Planes of alternating value: all frequency along z.
  const Volume volume =
      make_scalars<std::uint8_t>({32, 32, 32}, VoxelType::kU8, [](const Coordinate& c) {
        return static_cast<std::uint8_t>(
            c.z % 2 *
                (40 + samples::random_at(2, c.x / 4 + 100 * (c.y / 4) + 10000 * (c.z / 4)) % 80) +
            60);
      });
  const Coded coded =
      code("tvq", volume, {"rate=0", "assign=chapter", "tau=20", "psnr=40", "transform=dct"});
  EXPECT_LT(coded.decoder->recorded_error()->mean_squared, 4);
}

TEST(Tvq, RefusesCodesBeyondTheirBook) {
  // Two shapes and the zero block in BP: a book of three, so code 3 of two bits is free.
  const Volume volume =
      make_scalars<std::uint8_t>({64, 4, 4}, VoxelType::kU8, [](const Coordinate& c) {
        const std::uint64_t block = c.x / 4;
        return static_cast<std::uint8_t>(
            block % 3 == 0 ? 50 : (block % 3 == 1 ? c.z % 2 : c.y % 2) * 100 + 50);
      });
  const Coded coded = code("vq", volume, {"bits=5"});
  EXPECT_EQ(coded.decoder->recorded_error()->largest, 0.0);
  Buffer changed;
  changed.append(coded.opened.stream.payload);
  changed.data()[changed.size() - 1] = std::byte{0xff};
  const auto refused = coded.opened.codec->open(
      {coded.opened.stream.info, coded.opened.stream.parameters, changed.bytes()});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kMalformed);
  EXPECT_NE(refused.error().message.find("expected codes below"), std::string::npos)
      << refused.error().message;
}

TEST(Tvq, RefusesAShortPayload) {
  for (const std::string_view id : kIds) {
    const Coded coded = code(id, rings_u8({20, 18, 22}), {"rate=0"});
    const auto payload = coded.opened.stream.payload;
    for (std::size_t size = 0; size < payload.size(); size += 1 + size / 9) {
      Buffer cut;
      cut.append(payload.first(size));
      EXPECT_FALSE(coded.opened.codec->open(
          {coded.opened.stream.info, coded.opened.stream.parameters, cut.bytes()}))
          << id << ' ' << size;
    }
  }
}

TEST(Tvq, CodesWhiteNoiseAsWellAsTheTheoryAllows) {
  // Uniform noise is Gaussian-like after the transform: with R bits per voxel no code does better
  // than variance * 2^-2R.
  const Volume volume =
      make_scalars<std::uint8_t>({96, 96, 96}, VoxelType::kU8, [](const Coordinate& c) {
        return static_cast<std::uint8_t>(samples::random_at(1, c.x + 96 * (c.y + 96 * c.z)));
      });
  const double variance = (256.0 * 256 - 1) / 12;
  for (const std::string_view id : {"hvq", "tvq"}) {
    const Coded coded = code(id, volume, {"rate=400"});
    const double bits = 8.0 * static_cast<double>(coded.opened.stream.payload.size()) /
                        static_cast<double>(volume.extent().voxels());
    const double bound = 10 * std::log10(variance * std::exp2(-2 * bits)),
                 found = 10 * std::log10(coded.decoder->recorded_error()->mean_squared);
    EXPECT_GT(found, bound - 0.1) << id;
    EXPECT_LT(found, bound + 2.5) << id;
  }
}

TEST(Tvq, ClassifiesOrNotAtAboutTheSameError) {
  const Volume volume = rings_u8({80, 72, 64});
  const double on = code("tvq", volume, {"rate=0"}).decoder->recorded_error()->mean_squared;
  const double off =
      code("tvq", volume, {"rate=0", "classify=off"}).decoder->recorded_error()->mean_squared;
  const double chapter =
      code("tvq", volume, {"rate=0", "assign=chapter"}).decoder->recorded_error()->mean_squared;
  EXPECT_NEAR(10 * std::log10(on / off), 0, 0.5);
  EXPECT_LT(on, chapter);
}

}  // namespace
}  // namespace cvr::codecs::tvq
