#include "codecs/tvq/format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codecs/bytes.hpp"
#include "codecs/entropy/rans.hpp"
#include "volumes/parallel.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr std::uint32_t kFlagTransformMask = 3;
constexpr std::uint32_t kFlagSharedBooks = 4;

std::uint64_t plane_bytes(std::uint64_t blocks, unsigned bits) { return (blocks * bits + 7) / 8; }

/// Codes of `bits` bits, least significant first.
void put_plane(ByteWriter& out, std::span<const std::uint16_t> codes, unsigned bits) {
  if (bits == 0) return;
  std::uint64_t pending = 0;
  unsigned filled = 0;
  for (const std::uint16_t code : codes) {
    pending |= std::uint64_t{code} << filled;
    for (filled += bits; filled >= 8; filled -= 8, pending >>= 8)
      out.put(static_cast<std::uint8_t>(pending));
  }
  if (filled > 0) out.put(static_cast<std::uint8_t>(pending));
}

std::vector<std::uint16_t> get_plane(std::span<const std::byte> bytes, std::uint64_t count,
                                     unsigned bits) {
  std::vector<std::uint16_t> codes(count);
  std::uint64_t pending = 0;
  unsigned filled = 0;
  std::size_t at = 0;
  for (std::uint16_t& code : codes) {
    for (; filled < bits; filled += 8)
      pending |= std::to_integer<std::uint64_t>(bytes[at++]) << filled;
    code = static_cast<std::uint16_t>(pending & ((std::uint64_t{1} << bits) - 1));
    pending >>= bits;
    filled -= bits;
  }
  return codes;
}

/// Zones of eight coefficients that a partition consists of; LP begins with the second of its zone.
unsigned first_zone(unsigned partition) { return kPartitionBegin[partition] / 8; }
unsigned zone_count(unsigned partition) { return (kPartitionSize[partition] + 7) / 8; }
unsigned zone_of_coefficient(unsigned partition, unsigned j) {
  return (kPartitionBegin[partition] + j) / 8 - first_zone(partition);
}

/// Coefficients of all code vectors but the zero vector: per zone a rANS stream of bit lengths,
/// then all signs and lower bits as they are. Layout: per zone 16 frequencies (u16) and the
/// stream's length (u32); the streams; the bits.
void put_coefficients(ByteWriter& out, const Book& book, unsigned partition) {
  const unsigned n = kPartitionSize[partition];
  std::array<std::vector<std::uint8_t>, 4> lengths;
  std::vector<std::uint8_t> bits;
  unsigned filled = 0;
  std::uint64_t pending = 0;
  for (std::uint32_t k = 1; k < book.size; ++k) {
    for (unsigned j = 0; j < n; ++j) {
      const int value = book.coefficients[std::size_t{k} * n + j];
      const auto magnitude = static_cast<unsigned>(std::abs(value));
      const auto length = static_cast<unsigned>(std::bit_width(magnitude));
      lengths[zone_of_coefficient(partition, j)].push_back(static_cast<std::uint8_t>(length));
      if (length == 0) continue;
      // The leading one is known; its place takes the sign.
      const std::uint64_t field =
          (magnitude & ((1u << (length - 1)) - 1)) | (value < 0 ? 1u << (length - 1) : 0u);
      pending |= field << filled;
      for (filled += length; filled >= 8; filled -= 8, pending >>= 8)
        bits.push_back(static_cast<std::uint8_t>(pending));
    }
  }
  if (filled > 0) bits.push_back(static_cast<std::uint8_t>(pending));
  std::vector<std::uint8_t> streams;
  for (unsigned t = 0; t < zone_count(partition); ++t) {
    std::array<std::uint64_t, entropy::kRansSymbols> counts{};
    for (const std::uint8_t length : lengths[t]) ++counts[length];
    std::uint32_t possible = 0;
    for (unsigned s = 0; s < counts.size(); ++s) possible |= counts[s] > 0 ? 1u << s : 0u;
    const auto table = entropy::RansTable::fit(counts, possible);
    for (const std::uint16_t frequency : table.frequencies()) out.put(frequency);
    const std::size_t before = streams.size();
    table.encode(lengths[t], streams);
    out.put(narrow<std::uint32_t>(streams.size() - before));
  }
  out.append(std::as_bytes(std::span(streams)));
  out.append(std::as_bytes(std::span(bits)));
}

bool get_coefficients(ByteReader& in, Book& book, unsigned partition, std::size_t bytes) {
  const unsigned n = kPartitionSize[partition];
  ByteReader part(in.take(bytes));
  std::array<entropy::RansTable, 4> tables;
  std::array<std::uint32_t, 4> sizes{};
  for (unsigned t = 0; t < zone_count(partition); ++t) {
    std::array<std::uint16_t, entropy::kRansSymbols> frequencies;
    for (std::uint16_t& frequency : frequencies) frequency = part.get<std::uint16_t>();
    sizes[t] = part.get<std::uint32_t>();
    if (part.failed() || !entropy::RansTable::from_frequencies(frequencies, tables[t]))
      return false;
  }
  std::array<entropy::RansDecoder, 4> streams;
  for (unsigned t = 0; t < zone_count(partition); ++t) {
    const auto stream = part.take(sizes[t]);
    if (part.failed()) return false;
    streams[t] = entropy::RansDecoder(
        tables[t], {reinterpret_cast<const std::uint8_t*>(stream.data()), stream.size()});
  }
  book.coefficients.assign(std::size_t{book.size} * n, 0);
  std::uint64_t pending = 0;
  unsigned filled = 0;
  for (std::uint32_t k = 1; k < book.size; ++k) {
    for (unsigned j = 0; j < n; ++j) {
      auto& stream = streams[zone_of_coefficient(partition, j)];
      const unsigned length = stream.next();
      if (stream.failed()) return false;
      if (length == 0) continue;
      for (; filled < length; filled += 8)
        pending |= std::uint64_t{part.get<std::uint8_t>()} << filled;
      const auto field = static_cast<int>(pending & ((1u << length) - 1));
      pending >>= length;
      filled -= length;
      const int lead = 1 << (length - 1);
      const int magnitude = (field & (lead - 1)) | lead;
      book.coefficients[std::size_t{k} * n + j] =
          static_cast<std::int16_t>((field & lead) != 0 ? -magnitude : magnitude);
    }
  }
  return !part.failed() && part.remaining() == 0;
}

/// Entries as they lie in a device; a zero vector is left out.
void put_entries(ByteWriter& out, const Scheme& scheme, unsigned p, const Book& book) {
  for (std::size_t i = scheme.zero_vectors() ? scheme.length[p] : 0; i < book.entries.size(); ++i) {
    if (book.entry_bytes == 1) {
      out.put(static_cast<std::int8_t>(book.entries[i]));
    } else {
      out.put(book.entries[i]);
    }
  }
}

void get_entries(ByteReader& in, const Scheme& scheme, unsigned p, Book& book) {
  book.entries.assign(std::size_t{book.size} * scheme.length[p], 0);
  for (std::size_t i = scheme.zero_vectors() ? scheme.length[p] : 0; i < book.entries.size(); ++i) {
    book.entries[i] = book.entry_bytes == 1 ? in.get<std::int8_t>() : in.get<std::int16_t>();
  }
}

tl::unexpected<Error> malformed(std::size_t at, std::string_view expected) {
  return fail(ErrorCode::kMalformed, fmt::format("offset {}: expected {}", at, expected));
}

Expected<void> read_domain(ByteReader& in, const VolumeInfo& info, Domain& domain) {
  domain.type = info.type;
  domain.fraction = Domain::fraction_of(info.type);
  domain.zero = in.get<std::int32_t>();
  domain.offset = in.get<float>();
  domain.exponent = in.get<std::int32_t>();
  domain.low = in.get<std::int32_t>();
  domain.high = in.get<std::int32_t>();
  if (domain.low > domain.high)
    return malformed(12, "a least value that does not exceed the greatest");
  if (info.type == VoxelType::kF32) {
    constexpr std::int32_t kLimit = 1 << 22;
    if (domain.low < -kLimit || domain.high > kLimit || domain.zero != 0)
      return malformed(12, "sums within 2^22 of the offset");
    if (!std::isfinite(domain.offset) || domain.exponent < -149 || domain.exponent > 127) {
      return malformed(4, "a finite offset and an exponent of -149..127");
    }
    return {};
  }
  if (domain.offset != 0 || domain.exponent != 0)
    return malformed(4, "no offset and no exponent of integers");
  const std::int32_t least = info.type == VoxelType::kI16 ? -32768 : 0;
  const std::int32_t most = info.type == VoxelType::kU8    ? 255
                            : info.type == VoxelType::kU16 ? 65535
                                                           : 32767;
  if (domain.low < least || domain.high > most || domain.zero < least || domain.zero > most) {
    return malformed(0, fmt::format("values of type {}", name_of(info.type)));
  }
  return {};
}

Expected<void> read_exceptions(ByteReader& in, const VolumeInfo& info, std::uint64_t runs,
                               Encoding& encoding) {
  const std::size_t at = in.position();
  if (runs > in.remaining() / 12)
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected {} runs of exceptions", at, runs));
  if (runs > 0 && info.type != VoxelType::kF32) return malformed(at, "exceptions of f32 alone");
  const std::uint64_t voxels = info.extent.voxels();
  std::uint64_t total = 0, end = 0;
  for (std::uint64_t r = 0; r < runs; ++r) {
    ExceptionRun run{in.get<std::uint64_t>(), in.get<std::uint32_t>()};
    if (run.count == 0 || run.first < end || run.first >= voxels ||
        run.count > voxels - run.first) {
      return malformed(at + 12 * r, "a run of exceptions inside the volume and after the last");
    }
    end = run.first + run.count;
    total += run.count;
    encoding.exceptions.push_back(run);
  }
  if (total > in.remaining() / 4)
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected {} exceptions", in.position(), total));
  encoding.exception_bits.resize(total);
  for (std::uint32_t& bits : encoding.exception_bits) bits = in.get<std::uint32_t>();
  return {};
}

/// DC of a sub-volume.
Expected<void> read_part(const Scheme& scheme, ByteReader& in, SubVolume& part) {
  const std::size_t at = in.position();
  part.dc_bits = in.get<std::uint8_t>();
  part.dc_base = in.get<std::int32_t>();
  part.dc_step = in.get<std::uint32_t>();
  if (in.failed())
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected the header of a sub-volume", at));
  if (part.dc_bits > kMaxDcBits || (!scheme.dc && part.dc_bits > 0))
    return malformed(at, "at most 16 bits of DC, and none without DC");
  const std::int64_t last =
      std::int64_t{part.dc_base} + ((std::int64_t{1} << part.dc_bits) - 1) * part.dc_step;
  if (std::abs(std::int64_t{part.dc_base}) > kLargestTerm || last > kLargestTerm)
    return malformed(at + 1, "values of DC within 2^26");
  return {};
}

/// Sizes and scales of books, and the transform.
Expected<void> read_book_set(const Scheme& scheme, ByteReader& in, TransformKind kind,
                             BookSet& set) {
  const std::size_t at = in.position();
  for (unsigned p = 0; p < scheme.books; ++p) {
    const std::size_t book_at = in.position();
    Book& book = set.books[p];
    book.size = in.get<std::uint32_t>();
    book.scale = in.get<std::uint16_t>();
    book.entry_bytes = in.get<std::uint8_t>();
    book.step = in.get<std::uint32_t>();
    const auto chapters = in.get<std::uint8_t>();
    if (book.size == 0 || book.size > (1u << kMaxBookBits))
      return malformed(book_at, "a book of 1..16384 code vectors");
    if (book.scale == 0 || (book.entry_bytes != 1 && book.entry_bytes != 2))
      return malformed(book_at + 4, "a scale and entries of 1 or 2 bytes");
    if (book.step > kLargestStep) return malformed(book_at + 7, "a step of at most 200000");
    if (book.step > 0 && !scheme.has_transform())
      return malformed(book_at + 7, "entries, found coefficients");
    std::uint64_t sum = 0;
    int last_class = 0;
    for (unsigned c = 0; c < chapters; ++c) {
      const auto block_class = in.get<std::uint8_t>();
      const auto size = in.get<std::uint16_t>();
      if (block_class <= last_class || block_class >= kClasses || size == 0)
        return malformed(book_at + 12, "chapters of ascending classes");
      last_class = block_class;
      sum += size;
      book.chapters.push_back({block_class, size});
    }
    if (chapters > 0 && sum != book.size - 1)
      return malformed(book_at + 12, fmt::format("chapters of {} code vectors", book.size - 1));
  }
  std::vector<std::int16_t> stored(Basis::stored_values(kind));
  for (std::int16_t& value : stored) {
    value = in.get<std::int16_t>();
    if (std::abs(int{value}) > Basis::kStoredOne)
      return malformed(in.position() - 2, "a component of a unit vector");
  }
  if (in.failed())
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected the header of a sub-volume's books", at));
  set.basis = Basis(kind, stored);
  return {};
}

Expected<void> read_book(const Scheme& scheme, unsigned p, ByteReader& in, BookSet& set) {
  Book& book = set.books[p];
  const std::size_t at = in.position();
  if (book.step > 0) {
    const auto bytes = in.get<std::uint32_t>();
    if (in.failed() || bytes > in.remaining())
      return fail(ErrorCode::kTruncated,
                  fmt::format("offset {}: expected {} bytes of coefficients", at, bytes));
    if (book.size > 1) {
      if (!get_coefficients(in, book, p, bytes)) return malformed(at, "coefficients of a book");
    } else if (bytes != 0) {
      return malformed(at, "no coefficients of the zero vector");
    }
    book.coefficients.resize(std::size_t{book.size} * scheme.coefficients[p]);
    project(book, p, set.basis);
  } else {
    const std::uint32_t stored = scheme.zero_vectors() ? book.size - 1 : book.size;
    if (std::uint64_t{stored} * scheme.length[p] * book.entry_bytes > in.remaining()) {
      return fail(ErrorCode::kTruncated,
                  fmt::format("offset {}: expected {} code vectors", at, stored));
    }
    get_entries(in, scheme, p, book);
  }
  std::int64_t largest = 0;
  for (const std::int16_t entry : book.entries)
    largest = std::max<std::int64_t>(largest, std::abs(int{entry}));
  if (largest * book.scale > kLargestTerm) return malformed(at, "entries within 2^26 units");
  return {};
}

Expected<std::vector<std::uint16_t>> read_codes(ByteReader& in, std::uint64_t blocks, unsigned bits,
                                                std::uint32_t size) {
  if (bits == 0) return std::vector<std::uint16_t>{};
  const std::size_t at = in.position();
  if (blocks > std::uint64_t{in.remaining()} * 8 / bits) {
    return fail(ErrorCode::kTruncated,
                fmt::format("offset {}: expected {} codes of {} bits", at, blocks, bits));
  }
  auto codes = get_plane(in.take(plane_bytes(blocks, bits)), blocks, bits);
  for (std::uint64_t b = 0; b < blocks; ++b) {
    if (codes[b] >= size) {
      return malformed(at, fmt::format("codes below {}, found {} at block {}", size, codes[b], b));
    }
  }
  return codes;
}

}  // namespace

volumes::Box box_of(const Extent& step, std::uint32_t edge, const Coordinate& part) {
  if (edge == 0) return {{0, 0, 0}, step};
  const Coordinate origin{part.x * edge, part.y * edge, part.z * edge};
  return {origin,
          {std::min<std::uint64_t>(edge, step.x - origin.x),
           std::min<std::uint64_t>(edge, step.y - origin.y),
           std::min<std::uint64_t>(edge, step.z - origin.z)}};
}

void project(Book& book, unsigned partition, const Basis& basis) {
  const unsigned n = kPartitionSize[partition];
  const std::int64_t limit = book.entry_bytes == 1 ? 127 : 32767;
  // coefficient * basis * 2^24 * step / 2^8 units, in entries of `scale` units; halves go up.
  const std::int64_t divisor = (std::int64_t{book.scale} << (Basis::kFractionBits + 8));
  book.entries.assign(std::size_t{book.size} * kBlockVoxels, 0);
  for (std::uint32_t k = 1; k < book.size; ++k) {
    const std::int16_t* c = book.coefficients.data() + std::size_t{k} * n;
    std::array<std::int64_t, kBlockVoxels> sums{};
    for (unsigned j = 0; j < n; ++j) {
      if (c[j] == 0) continue;
      for (unsigned i = 0; i < kBlockVoxels; ++i)
        sums[i] += std::int64_t{c[j]} * basis.fixed(kPartitionBegin[partition] + j, i);
    }
    for (unsigned i = 0; i < kBlockVoxels; ++i) {
      const std::int64_t twice = 2 * sums[i] * book.step + divisor;
      std::int64_t entry = twice / (2 * divisor);
      if (twice < 0 && twice % (2 * divisor) != 0) --entry;
      book.entries[std::size_t{k} * kBlockVoxels + i] =
          static_cast<std::int16_t>(std::clamp(entry, -limit, limit));
    }
  }
}

Payload write_payload(const Scheme& scheme, const Encoding& encoding) {
  ByteWriter out;
  Payload payload;
  const Domain& domain = encoding.domain;
  out.put(domain.zero);
  out.put(domain.offset);
  out.put(domain.exponent);
  out.put(domain.low);
  out.put(domain.high);
  out.put(encoding.edge);
  static_assert(kErrorOffset == 6 * 4);
  out.put(encoding.error.largest);
  out.put(encoding.error.mean_squared);
  const bool shared = encoding.books.size() < encoding.parts.size();
  out.put(static_cast<std::uint32_t>(encoding.books.front().basis.kind()) |
          (shared ? kFlagSharedBooks : 0));
  out.put(static_cast<std::uint64_t>(encoding.exceptions.size()));
  for (std::size_t i = 0; i < encoding.parts.size(); ++i) {
    const SubVolume& part = encoding.parts[i];
    out.put(static_cast<std::uint8_t>(part.dc_bits));
    out.put(part.dc_base);
    out.put(part.dc_step);
    if (i >= encoding.books.size()) continue;
    const BookSet& set = encoding.books[i];
    for (unsigned p = 0; p < scheme.books; ++p) {
      const Book& book = set.books[p];
      out.put(book.size);
      out.put(book.scale);
      out.put(book.entry_bytes);
      out.put(book.step);
      out.put(static_cast<std::uint8_t>(book.chapters.size()));
      for (const Chapter& chapter : book.chapters) {
        out.put(chapter.block_class);
        out.put(narrow<std::uint16_t>(chapter.size));
      }
    }
    payload.breakdown[ByteClass::kTables] += 2 * set.basis.stored().size();
    for (const std::int16_t value : set.basis.stored()) out.put(value);
  }
  payload.breakdown[ByteClass::kHeader] = out.size() - payload.breakdown[ByteClass::kTables];
  std::size_t before = out.size();
  for (const ExceptionRun& run : encoding.exceptions) {
    out.put(run.first);
    out.put(narrow<std::uint32_t>(run.count));
  }
  for (const std::uint32_t bits : encoding.exception_bits) out.put(bits);
  payload.breakdown[ByteClass::kData] = out.size() - before;

  const auto put_codes = [&](std::span<const std::uint16_t> codes, unsigned bits) {
    before = out.size();
    put_plane(out, codes, bits);
    payload.breakdown[ByteClass::kOperations] += out.size() - before;
  };
  for (const SubVolume& part : encoding.parts) put_codes(part.dc, part.dc_bits);
  for (unsigned p = 0; p < scheme.books; ++p) {
    for (std::size_t i = 0; i < encoding.parts.size(); ++i) {
      const Book& book = encoding.books_of(i).books[p];
      before = out.size();
      if (i < encoding.books.size()) {
        if (book.step > 0) {
          ByteWriter coded;
          if (book.size > 1) put_coefficients(coded, book, p);
          out.put(narrow<std::uint32_t>(coded.size()));
          out.append(coded.take().bytes());
        } else {
          put_entries(out, scheme, p, book);
        }
      }
      payload.breakdown[ByteClass::kTables] += out.size() - before;
      put_codes(encoding.parts[i].codes[p], book.bits());
    }
  }
  payload.bytes = out.take();
  payload.published_bytes = device_bytes(scheme, encoding).total();
  return payload;
}

Expected<Encoding> read_payload(const Scheme& scheme, const VolumeInfo& info,
                                std::span<const std::byte> payload, StepBytes& steps) {
  ByteReader in(payload);
  Encoding encoding;
  if (auto ok = read_domain(in, info, encoding.domain); !ok) return tl::unexpected(ok.error());
  encoding.edge = in.get<std::uint32_t>();
  encoding.error = {in.get<double>(), in.get<double>()};
  const auto flags = in.get<std::uint32_t>();
  const auto runs = in.get<std::uint64_t>();
  if (in.failed())
    return fail(ErrorCode::kTruncated,
                fmt::format("expected a header of 52 bytes, found {}", payload.size()));
  if (encoding.edge % kBlockEdge != 0)
    return malformed(20, "an edge of sub-volumes that is a multiple of 4");
  if (!(encoding.error.largest >= 0) || !(encoding.error.mean_squared >= 0))
    return malformed(kErrorOffset, "errors that are not negative");
  const auto transform = flags & kFlagTransformMask;
  const bool shared = (flags & kFlagSharedBooks) != 0;
  if (transform > 2 || (transform > 0 && !scheme.has_transform()))
    return malformed(40, "a kind of transform");
  if ((flags & ~(kFlagTransformMask | kFlagSharedBooks)) != 0)
    return malformed(40, "a kind of transform and whether books are shared");
  if (shared && info.time_steps == 1)
    return malformed(40, "no books shared by the time steps of a single volume");
  const auto kind = static_cast<TransformKind>(transform);
  // Each sub-volume takes at least its header: too many for the payload are found before anything
  // is allocated for them.
  const Extent step = info.step_extent(), grid = encoding.grid(step),
               stack{grid.x, grid.y, grid.z * info.time_steps};
  const std::uint64_t most = in.remaining() / (9 + (shared ? 0 : 12 * scheme.books));
  if (stack.x > most || stack.y > most / stack.x || stack.z > most / (stack.x * stack.y)) {
    return fail(ErrorCode::kTruncated,
                fmt::format("offset 52: expected {} sub-volumes, found {} bytes", to_string(stack),
                            in.remaining()));
  }
  encoding.parts.reserve(stack.voxels());
  for (std::uint64_t i = 0; i < stack.voxels(); ++i) {
    SubVolume& part = encoding.parts.emplace_back();
    const Coordinate at{i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y) % grid.z};
    part.blocks = ceil_div(box_of(step, encoding.edge, at).size, kBlockEdge);
    if (auto ok = read_part(scheme, in, part); !ok) return tl::unexpected(ok.error());
    if (shared && i >= grid.voxels()) continue;
    if (auto ok = read_book_set(scheme, in, kind, encoding.books.emplace_back()); !ok)
      return tl::unexpected(ok.error());
  }
  if (auto ok = read_exceptions(in, info, runs, encoding); !ok) return tl::unexpected(ok.error());
  for (SubVolume& part : encoding.parts) {
    auto codes = read_codes(in, part.blocks.voxels(), part.dc_bits, 1u << part.dc_bits);
    if (!codes) return tl::unexpected(codes.error());
    part.dc = std::move(*codes);
  }
  steps[0] = in.position();
  for (unsigned p = 0; p < scheme.books; ++p) {
    for (std::size_t i = 0; i < encoding.parts.size(); ++i) {
      if (i < encoding.books.size()) {
        if (auto ok = read_book(scheme, p, in, encoding.books[i]); !ok)
          return tl::unexpected(ok.error());
      }
      const Book& book = encoding.books_of(i).books[p];
      auto codes = read_codes(in, encoding.parts[i].blocks.voxels(), book.bits(), book.size);
      if (!codes) return tl::unexpected(codes.error());
      encoding.parts[i].codes[p] = std::move(*codes);
    }
    steps[p + 1] = in.position();
  }
  if (in.failed() || in.remaining() != 0)
    return malformed(in.position(), fmt::format("the end, found {} bytes more", in.remaining()));
  return encoding;
}

DeviceBytes device_bytes(const Scheme& scheme, const Encoding& encoding) {
  DeviceBytes bytes{};
  for (const BookSet& set : encoding.books) {
    for (unsigned p = 0; p < scheme.books; ++p) {
      const Book& book = set.books[p];
      if (book.size > 1 || !scheme.zero_vectors())
        bytes.books += std::uint64_t{book.size} * scheme.length[p] * book.entry_bytes;
    }
  }
  for (std::size_t i = 0; i < encoding.parts.size(); ++i) {
    unsigned record = encoding.parts[i].dc_bits;
    for (unsigned p = 0; p < scheme.books; ++p) record += encoding.books_of(i).books[p].bits();
    bytes.index += plane_bytes(encoding.parts[i].blocks.voxels(), record);
  }
  return bytes;
}

}  // namespace cvr::codecs::tvq
