// Locates the chunks of an image; the structures are those of the HDF5 File Format Specification,
// version 3.0.
#include <fmt/format.h>

#include <cstring>
#include <string_view>

#include "codecs/general/hdf5_image.hpp"

namespace cvr::codecs::general {

namespace {

constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";

struct SuperblockLayout {
  static constexpr std::uint64_t kVersion = 8;
  static constexpr std::uint64_t kSizeOfOffsets = 13;
  static constexpr std::uint64_t kSizeOfLengths = 14;
  static constexpr std::uint64_t kBaseAddress = 24;
  static constexpr std::uint64_t kEndOfFile = 40;
  static constexpr std::uint64_t kRootCacheType = 72;
  static constexpr std::uint64_t kRootTree =
      80;  ///< scratch space of the root group's symbol table entry
  static constexpr std::uint64_t kBytes = 96;
};
struct TreeLayout {
  static constexpr std::uint64_t kType = 4;
  static constexpr std::uint64_t kLevel = 5;
  static constexpr std::uint64_t kEntries = 6;
  static constexpr std::uint64_t kKeys = 24;
  static constexpr std::uint64_t kGroupKeyBytes = 8;
  static constexpr std::uint64_t kChunkKeyBytes =
      40;  ///< u32 size, u32 filter mask, u64 offsets z, y, x and 0
  static constexpr std::uint64_t kChildBytes = 8;
};
struct SymbolNodeLayout {
  static constexpr std::uint64_t kSymbols = 6;
  static constexpr std::uint64_t kFirstHeader =
      16;  ///< address of the first symbol's object header
  static constexpr std::uint64_t kBytes = 48;
};
struct ObjectHeaderLayout {
  static constexpr std::uint64_t kMessages = 2;
  static constexpr std::uint64_t kSize = 8;
  static constexpr std::uint64_t kFirstMessage = 16;
  static constexpr std::uint64_t kMessageHeaderBytes = 8;
};
enum class Message : std::uint16_t {
  kDataspace = 1,
  kDatatype = 3,
  kLayout = 8,
  kFilters = 11,
  kContinuation = 16
};

constexpr std::uint16_t kDeflateFilter = 1;
constexpr std::uint16_t kShuffleFilter = 2;
constexpr unsigned kMaxMessages = 64;

class ImageReader {
 public:
  ImageReader(std::span<const std::byte> image, const ChunkedDataset& dataset)
      : image_(image), dataset_(dataset), grid_(dataset.grid()) {}

  Expected<std::vector<ChunkPlace>> read() {
    std::uint64_t header = 0, index = 0;
    if (auto ok = find_header(header); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_header(header, index); !ok) return tl::unexpected(ok.error());
    // Each chunk has a key in the index: a grid beyond that is refused before the places are
    // allocated.
    std::uint64_t room = image_.size() / (TreeLayout::kChunkKeyBytes + TreeLayout::kChildBytes);
    for (const std::uint64_t n : {grid_.x, grid_.y, grid_.z}) room /= n;
    if (room == 0)
      return fail(ErrorCode::kTruncated,
                  fmt::format("{} bytes cannot index {} chunks", image_.size(), to_string(grid_)));
    places_.resize(grid_.voxels());
    if (auto ok = read_node(index, -1); !ok) return tl::unexpected(ok.error());
    if (found_ != places_.size()) {
      return fail(ErrorCode::kTruncated, fmt::format("offset {}: expected {} chunks, found {}",
                                                     index, places_.size(), found_));
    }
    return std::move(places_);
  }

 private:
  bool holds(std::uint64_t at, std::uint64_t size) const {
    return at <= image_.size() && size <= image_.size() - at;
  }
  /// The caller has checked that the field is inside.
  template <class T>
  T field(std::uint64_t at) const {
    T value;
    std::memcpy(&value, image_.data() + at, sizeof value);
    return value;
  }
  bool has_text(std::uint64_t at, std::string_view text) const {
    return holds(at, text.size()) && std::memcmp(image_.data() + at, text.data(), text.size()) == 0;
  }
  static tl::unexpected<Error> malformed(std::uint64_t at, std::string_view expected) {
    return fail(ErrorCode::kMalformed, fmt::format("offset {}: expected {}", at, expected));
  }

  Expected<void> find_header(std::uint64_t& header) const {
    using S = SuperblockLayout;
    if (!holds(0, S::kBytes))
      return fail(ErrorCode::kTruncated,
                  fmt::format("expected an HDF5 superblock, found {} bytes", image_.size()));
    if (!has_text(0, kSignature)) return malformed(0, "the signature of HDF5");
    if (field<std::uint8_t>(S::kVersion) != 0 || field<std::uint8_t>(S::kSizeOfOffsets) != 8 ||
        field<std::uint8_t>(S::kSizeOfLengths) != 8 || field<std::uint64_t>(S::kBaseAddress) != 0) {
      return malformed(S::kVersion, "a superblock of version 0 with 8-byte addresses from 0 on");
    }
    const auto end = field<std::uint64_t>(S::kEndOfFile);
    if (end != image_.size()) {
      return fail(end > image_.size() ? ErrorCode::kTruncated : ErrorCode::kMalformed,
                  fmt::format("offset {}: {} bytes announced, found {}", S::kEndOfFile, end,
                              image_.size()));
    }
    if (field<std::uint32_t>(S::kRootCacheType) != 1)
      return malformed(S::kRootCacheType, "a cached symbol table");
    const auto tree = field<std::uint64_t>(S::kRootTree);
    const std::uint64_t child_at = tree + TreeLayout::kKeys + TreeLayout::kGroupKeyBytes;
    if (!has_text(tree, "TREE") ||
        !holds(tree, TreeLayout::kKeys + TreeLayout::kGroupKeyBytes + TreeLayout::kChildBytes) ||
        field<std::uint8_t>(tree + TreeLayout::kType) != 0 ||
        field<std::uint8_t>(tree + TreeLayout::kLevel) != 0 ||
        field<std::uint16_t>(tree + TreeLayout::kEntries) != 1) {
      return malformed(tree, "a group of one dataset");
    }
    const auto node = field<std::uint64_t>(child_at);
    if (!has_text(node, "SNOD") || !holds(node, SymbolNodeLayout::kBytes) ||
        field<std::uint16_t>(node + SymbolNodeLayout::kSymbols) != 1) {
      return malformed(node, "a symbol table of one dataset");
    }
    header = field<std::uint64_t>(node + SymbolNodeLayout::kFirstHeader);
    return {};
  }

  /// Walks the messages of the dataset's object header; `index` becomes the address of the chunk
  /// index.
  Expected<void> read_header(std::uint64_t header, std::uint64_t& index) const {
    using H = ObjectHeaderLayout;
    if (!holds(header, H::kFirstMessage) || field<std::uint8_t>(header) != 1)
      return malformed(header, "an object header of version 1");
    const unsigned messages = field<std::uint16_t>(header + H::kMessages);
    if (messages > kMaxMessages) return malformed(header, "at most 64 messages");
    std::uint64_t at = header + H::kFirstMessage, left = field<std::uint32_t>(header + H::kSize);
    std::pair<std::uint64_t, std::uint64_t> continuation{0, 0};
    bool has_space = false, has_type = false, has_layout = false, has_filters = false;
    for (unsigned i = 0; i < messages; ++i) {
      if (left < H::kMessageHeaderBytes) {
        std::tie(at, left) = continuation;
        continuation = {0, 0};
      }
      if (left < H::kMessageHeaderBytes || !holds(at, left))
        return malformed(at, "a header message");
      const auto type = static_cast<Message>(field<std::uint16_t>(at));
      const std::uint64_t size = field<std::uint16_t>(at + 2), body = at + H::kMessageHeaderBytes;
      if (size > left - H::kMessageHeaderBytes) return malformed(at, "a message inside its header");
      bool legal = true;
      switch (type) {
        case Message::kDataspace:
          legal = has_space = is_dataspace(body, size);
          break;
        case Message::kDatatype:
          legal = has_type = is_datatype(body, size);
          break;
        case Message::kLayout:
          legal = has_layout = is_layout(body, size, index);
          break;
        case Message::kFilters:
          legal = has_filters = is_pipeline(body, size);
          break;
        case Message::kContinuation:
          legal = size >= 16;
          if (legal) continuation = {field<std::uint64_t>(body), field<std::uint64_t>(body + 8)};
          break;
        default:
          break;  // fill value, modification time, ...: no influence on the chunks
      }
      if (!legal) return malformed(at, "a message that describes this volume");
      at = body + size;
      left -= H::kMessageHeaderBytes + size;
    }
    if (!has_space || !has_type || !has_layout || !has_filters) {
      return malformed(header, "a chunked, compressed dataset");
    }
    return {};
  }

  bool is_dataspace(std::uint64_t at, std::uint64_t size) const {
    const Extent& e = dataset_.info.extent;
    return size >= 32 && field<std::uint8_t>(at) == 1 && field<std::uint8_t>(at + 1) == 3 &&
           field<std::uint64_t>(at + 8) == e.z && field<std::uint64_t>(at + 16) == e.y &&
           field<std::uint64_t>(at + 24) == e.x;
  }
  bool is_datatype(std::uint64_t at, std::uint64_t size) const {
    return size >= 8 && field<std::uint32_t>(at + 4) == size_of(dataset_.info.type);
  }
  bool is_layout(std::uint64_t at, std::uint64_t size, std::uint64_t& index) const {
    constexpr std::uint64_t kTree = 3, kEdges = 11;
    if (size < kEdges + 16 || field<std::uint8_t>(at) != 3 || field<std::uint8_t>(at + 1) != 2 ||
        field<std::uint8_t>(at + 2) != 4) {
      return false;
    }
    index = field<std::uint64_t>(at + kTree);
    const std::uint64_t edges[4] = {dataset_.chunk.z, dataset_.chunk.y, dataset_.chunk.x,
                                    size_of(dataset_.info.type)};
    for (unsigned i = 0; i < 4; ++i) {
      if (field<std::uint32_t>(at + kEdges + 4 * i) != edges[i]) return false;
    }
    return true;
  }
  bool is_pipeline(std::uint64_t at, std::uint64_t size) const {
    if (size < 8 || field<std::uint8_t>(at) != 1) return false;
    const unsigned filters = field<std::uint8_t>(at + 1);
    if (filters != (dataset_.shuffle ? 2u : 1u)) return false;
    std::uint64_t next = 8;
    for (unsigned i = 0; i < filters; ++i) {
      if (size - next < 8) return false;
      const auto id = field<std::uint16_t>(at + next);
      if (id != (dataset_.shuffle && i == 0 ? kShuffleFilter : kDeflateFilter)) return false;
      const std::uint64_t name = (field<std::uint16_t>(at + next + 2) + 7u) / 8 * 8;
      const std::uint64_t values = (field<std::uint16_t>(at + next + 6) + 1u) / 2 * 8;
      if (size - next - 8 < name + values) return false;
      next += 8 + name + values;
    }
    return true;
  }

  /// level: that of this node, -1 for any (the root). Levels descend, and a leaf has at least one
  /// chunk that no other leaf has, so this ends whatever the addresses are.
  Expected<void> read_node(std::uint64_t at, int level) {
    using N = TreeLayout;
    if (!holds(at, N::kKeys) || !has_text(at, "TREE") || field<std::uint8_t>(at + N::kType) != 1)
      return malformed(at, "a chunk index");
    const int here = field<std::uint8_t>(at + N::kLevel);
    const std::uint64_t entries = field<std::uint16_t>(at + N::kEntries);
    constexpr std::uint64_t kStep = N::kChunkKeyBytes + N::kChildBytes;
    if ((level >= 0 && here != level) || entries == 0 || !holds(at + N::kKeys, entries * kStep)) {
      return malformed(at, "a node of the chunk index");
    }
    for (std::uint64_t i = 0; i < entries; ++i) {
      const std::uint64_t key = at + N::kKeys + i * kStep;
      const auto child = field<std::uint64_t>(key + N::kChunkKeyBytes);
      Expected<void> ok = here > 0 ? read_node(child, here - 1) : add_chunk(key, child);
      if (!ok) return ok;
    }
    return {};
  }

  Expected<void> add_chunk(std::uint64_t key, std::uint64_t offset) {
    const std::uint64_t size = field<std::uint32_t>(key);
    const Coordinate origin{field<std::uint64_t>(key + 24), field<std::uint64_t>(key + 16),
                            field<std::uint64_t>(key + 8)};
    const Extent& chunk = dataset_.chunk;
    const Coordinate position{origin.x / chunk.x, origin.y / chunk.y, origin.z / chunk.z};
    if (field<std::uint32_t>(key + 4) != 0 || origin.x % chunk.x != 0 || origin.y % chunk.y != 0 ||
        origin.z % chunk.z != 0 || !grid_.contains(position) || size == 0 || !holds(offset, size)) {
      return malformed(key, "a filtered chunk inside the volume and the file");
    }
    ChunkPlace& place = places_[grid_.index(position)];
    if (place.size != 0) return malformed(key, "each chunk once");
    place = {offset, size};
    ++found_;
    return {};
  }

  std::span<const std::byte> image_;
  const ChunkedDataset& dataset_;
  Extent grid_;
  std::vector<ChunkPlace> places_;
  std::uint64_t found_ = 0;
};

}  // namespace

Expected<std::vector<ChunkPlace>> locate_chunks(std::span<const std::byte> image,
                                                const ChunkedDataset& dataset) {
  return ImageReader(image, dataset).read();
}

}  // namespace cvr::codecs::general
