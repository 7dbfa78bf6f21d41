#include "volumes/slab_pipe.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace cvr::volumes {

/// The producer's end.
class SlabPipe::Sink final : public SlabSink {
 public:
  explicit Sink(const SlabPipe& pipe) : pipe_(pipe) {}
  std::uint64_t preferred_depth() const override { return pipe_.depth_; }

  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    if (z0 != next_ || z1 <= z0 || z1 > pipe_.info_.extent.z)
      throw std::logic_error("slabs must ascend without gaps");
    {
      std::unique_lock lock(pipe_.mutex_);
      pipe_.changed_.wait(lock, [this] { return pipe_.ready_.empty() || pipe_.cancelled_; });
      if (pipe_.cancelled_) throw Cancelled();
      if (!pipe_.spare_.empty()) {
        slab_.voxels = std::move(pipe_.spare_.back());
        pipe_.spare_.pop_back();
      }
    }
    slab_.z0 = z0;
    slab_.z1 = z1;
    slab_.voxels.resize((z1 - z0) * pipe_.plane_bytes_);
    return slab_.voxels.data();
  }

  void end(std::uint64_t, std::uint64_t z1) override {
    next_ = z1;
    {
      const std::scoped_lock lock(pipe_.mutex_);
      pipe_.ready_.push_back(std::exchange(slab_, {}));
    }
    pipe_.changed_.notify_all();
  }

  bool whole() const { return next_ == pipe_.info_.extent.z; }

 private:
  const SlabPipe& pipe_;
  Slab slab_;
  std::uint64_t next_ = 0;
};

SlabPipe::SlabPipe(const VolumeInfo& info, std::string file, Producer produce,
                   std::uint64_t slab_bytes)
    : info_(info),
      file_(std::move(file)),
      produce_(std::move(produce)),
      plane_bytes_(info.extent.x * info.extent.y * size_of(info.type)),
      depth_(std::clamp<std::uint64_t>(slab_bytes / std::max<std::uint64_t>(plane_bytes_, 1), 1,
                                       info.extent.z)) {}

SlabPipe::~SlabPipe() { stop(); }

void SlabPipe::start() const {
  stop();
  window_.clear();
  window_begin_ = 0;
  ready_.clear();
  cancelled_ = ended_ = false;
  result_ = {};
  thrown_ = nullptr;
  ++passes_;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error&) {
    thrown_ = std::current_exception();
    ended_ = true;
  }
}

void SlabPipe::stop() const {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    cancelled_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SlabPipe::run() const {
  Expected<void> result;
  std::exception_ptr thrown;
  try {
    Sink sink(*this);
    result = produce_(sink);
    if (result && !sink.whole())
      result = fail(ErrorCode::kTruncated, "fewer planes than the volume has");
  } catch (const Cancelled&) {
    // Nobody reads any more.
  } catch (...) {
    thrown = std::current_exception();
  }
  {
    const std::scoped_lock lock(mutex_);
    result_ = std::move(result);
    thrown_ = thrown;
    ended_ = true;
  }
  changed_.notify_all();
}

/// Waits for the next slab and moves it into the window; the last one waits for the producer's end.
void SlabPipe::take_next() const {
  std::unique_lock lock(mutex_);
  changed_.wait(
      lock, [this] { return ended_ || (!ready_.empty() && ready_.front().z1 < info_.extent.z); });
  if (thrown_) std::rethrow_exception(thrown_);
  if (!result_) {
    if (result_.error().code == ErrorCode::kOutOfMemory) throw std::bad_alloc();
    throw InputError(file_ + ": " + result_.error().message);
  }
  window_.push_back(std::move(ready_.front()));
  ready_.pop_front();
  lock.unlock();
  changed_.notify_all();
}

void SlabPipe::read(const Box& box, std::byte* out) const {
  const std::uint64_t begin = box.origin.z, end = box.origin.z + box.size.z;
  if (box.size.voxels() == 0) return;
  if (passes_ == 0 || begin < window_begin_) start();
  while (!window_.empty() && window_.front().z1 <= begin) drop_first();
  while (window_end() < end) {
    take_next();
    if (window_.size() == 1 && window_.front().z1 <= begin) drop_first();
  }
  const std::size_t voxel = size_of(info_.type);
  const std::size_t row = box.size.x * voxel;
  for (const Slab& slab : window_) {
    for (std::uint64_t z = std::max(begin, slab.z0); z < std::min(end, slab.z1); ++z) {
      const std::byte* plane = slab.voxels.data() + (z - slab.z0) * plane_bytes_;
      std::byte* to = out + (z - begin) * box.size.y * row;
      if (box.size.x == info_.extent.x) {
        std::memcpy(to, plane + box.origin.y * row, box.size.y * row);
        continue;
      }
      for (std::uint64_t y = 0; y < box.size.y; ++y) {
        std::memcpy(to + y * row,
                    plane + (box.origin.x + info_.extent.x * (box.origin.y + y)) * voxel, row);
      }
    }
  }
}

/// Gives up the first slab of the window; its memory is there for the producer.
void SlabPipe::drop_first() const {
  window_begin_ = window_.front().z1;
  {
    const std::scoped_lock lock(mutex_);
    if (spare_.empty()) spare_.push_back(std::move(window_.front().voxels));
  }
  window_.pop_front();
}

}  // namespace cvr::volumes
