#include "experiments/run/raw_copies.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_set>
#include <vector>

#include "experiments/results/json_lines.hpp"
#include "volumes/error.hpp"
#include "volumes/io/file.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;
using volumes::InputError;
using volumes::OutputError;

constexpr std::size_t kBlock = std::size_t{4} << 20;  ///< bytes; a multiple of every voxel's size

using Stop = std::function<void()>;  ///< throws Interrupted when it is time

std::string hash_text(std::string_view text) {
  return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  return std::move(text).str();
}

/// What a copy's file IDENTITY.raw.hash says: hash of the voxels, distinct labels, hash of the
/// sidecar, and a hash of these three.
struct Record {
  std::string content, labels, sidecar;

  std::string text() const {
    const std::string words = fmt::format("{} {} {}", content, labels, sidecar);
    return fmt::format("{} {}\n", words, hash_text(words));
  }
};

std::optional<Record> read_record(const std::string& path) {
  const std::string text = read_text(path);
  std::istringstream words(text);
  Record record;
  if (!(words >> record.content >> record.labels >> record.sidecar) || record.text() != text)
    return std::nullopt;
  return record;
}

/// Calls `use` with the file piece by piece. It is read, not mapped: a mapped file that is cut
/// meanwhile would end the run. False where it cannot be read to its end.
template <class Use>
bool for_each_block(const std::string& path, std::uint64_t size, const Stop& stop, const Use& use) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) return false;
  std::vector<std::byte> block(std::min<std::uint64_t>(kBlock, size));
  while (size > 0) {
    stop();
    const std::size_t part = std::min<std::uint64_t>(size, block.size());
    if (std::fread(block.data(), 1, part, file.get()) != part) return false;
    use(std::span(block.data(), part));
    size -= part;
  }
  return true;
}

class Content {
 public:
  explicit Content(const volumes::VolumeInfo& info)
      : info_(info), state_(XXH3_createState(), XXH3_freeState) {
    XXH3_64bits_reset(state_.get());
  }
  void add(std::span<const std::byte> voxels) {
    XXH3_64bits_update(state_.get(), voxels.data(), voxels.size());
  }
  void count_labels(std::span<const std::byte> bytes) {
    if (info_.kind != volumes::VolumeKind::kLabels) return;
    volumes::with_label_type(info_.type, [&]<class T>() {
      const std::span voxels(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T));
      for (std::size_t i = 0; i < voxels.size(); ++i) {
        if (i == 0 || voxels[i] != voxels[i - 1]) labels_.insert(voxels[i]);
      }
    });
  }
  std::string hash() const { return fmt::format("{:016x}", XXH3_64bits_digest(state_.get())); }
  std::uint64_t labels() const { return labels_.size(); }

 private:
  volumes::VolumeInfo info_;
  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state_;
  std::unordered_set<std::uint64_t> labels_;
};

/// Another source, read until it is time to stop.
class StoppableSource final : public volumes::VolumeSource {
 public:
  StoppableSource(const volumes::VolumeSource& source, const Stop& stop)
      : source_(source), stop_(stop) {}
  const volumes::VolumeInfo& info() const override { return source_.info(); }
  void read(const volumes::Box& box, std::byte* out) const override {
    stop_();
    source_.read(box, out);
  }
  volumes::Provenance provenance() const override { return source_.provenance(); }
  std::vector<std::string> files() const override { return source_.files(); }

 private:
  const volumes::VolumeSource& source_;
  const Stop& stop_;
};

class Copy {
 public:
  Copy(const Location& location, const std::string& cache)
      : location_(location),
        path_((fs::path(cache) / (location.identity + ".raw")).string()),
        sidecar_(path_ + ".yaml"),
        record_(path_ + ".hash") {}

  /// The copy, if what is there is what was made.
  std::optional<RawCopy> find(const Stop& stop) const {
    const auto record = read_record(record_);
    std::error_code error;
    if (!record || fs::file_size(path_, error) != location_.info.bytes() || error)
      return std::nullopt;
    if (hash_text(read_text(sidecar_)) != record->sidecar) return std::nullopt;
    Content content(location_.info);
    const bool whole = for_each_block(path_, location_.info.bytes(), stop,
                                      [&](auto block) { content.add(block); });
    if (!whole || content.hash() != record->content) return std::nullopt;
    return RawCopy{path_, record->content, std::stoull(record->labels)};
  }

  RawCopy make(unsigned threads, const Stop& stop) const {
    const auto source = open_location(location_, threads);
    volumes::write_volume(path_, StoppableSource(*source, stop));
    Content content(location_.info);
    const bool whole = for_each_block(path_, location_.info.bytes(), stop, [&](auto block) {
      content.add(block);
      content.count_labels(block);
    });
    if (!whole)
      throw OutputError(
          fmt::format("{}: cannot write: the file is shorter than what was written", path_));
    const Record record{content.hash(), std::to_string(content.labels()),
                        hash_text(read_text(sidecar_))};
    volumes::OutputFile out(record_);
    out.write(record.text());
    out.commit();
    return {path_, record.content, content.labels()};
  }

 private:
  const Location& location_;
  std::string path_, sidecar_, record_;
};

/// Unfinished files of copies that nobody is making: of processes that were killed.
void remove_unfinished(const fs::path& cache, const std::string& own) {
  constexpr std::size_t kDigits = 16;
  std::set<std::string> identities;
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& file : fs::directory_iterator(cache, error)) {
    const std::string name = file.path().filename().string();
    if (name.size() < kDigits || name.find(".raw", kDigits) != kDigits ||
        name.find(".part") == std::string::npos)
      continue;
    identities.insert(name.substr(0, kDigits));
    files.push_back(file.path());
  }
  for (const std::string& identity : identities) {
    std::optional<LockedFile> lock;
    try {
      if (identity != own)
        lock.emplace((cache / (identity + ".lock")).string(), [] { return false; });
    } catch (const std::runtime_error&) {
      continue;  // somebody is at it
    }
    for (const fs::path& file : files) {
      if (file.filename().string().starts_with(identity)) fs::remove(file, error);
    }
  }
}

}  // namespace

RawCopy materialise(const Location& location, const Places& places, unsigned threads,
                    const std::function<bool()>& interrupted) {
  const Stop stop = [&interrupted] {
    if (interrupted && interrupted()) throw Interrupted();
  };
  const Copy copy(location, places.cache);
  if (auto found = copy.find(stop)) return *found;
  std::error_code error;
  fs::create_directories(places.cache, error);
  if (error || !fs::is_directory(places.cache, error)) {
    throw OutputError(fmt::format(
        "{}: cannot write: the cache of raw copies (--cache DIR) is no folder that can be made{}{}",
        places.cache, error ? ": " : "", error ? error.message() : ""));
  }
  const LockedFile lock((fs::path(places.cache) / (location.identity + ".lock")).string(), [&stop] {
    stop();
    return true;
  });
  if (auto found = copy.find(stop)) return *found;  // another process has made it meanwhile
  remove_unfinished(places.cache, location.identity);
  const auto free_bytes = fs::space(places.cache, error).available;
  if (error || location.info.bytes() > free_bytes / 2) return {};
  return copy.make(threads, stop);
}

}  // namespace cvr::experiments
