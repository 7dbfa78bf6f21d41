#include "gpu/frame_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

namespace {

constexpr std::uint32_t kLargestImage = 16384;

}  // namespace

double FrameRenderer::start_seconds() const {
  double sum = 0;
  for (const auto& [name, seconds] : start_parts()) sum += seconds;
  return sum;
}

volumes::Expected<void> check_options(const RenderOptions& options) {
  if (find_cache(options.access) == nullptr)
    return volumes::fail(volumes::ErrorCode::kBadArgument,
                         fmt::format("no access mode '{}'", options.access));
  if (std::min(options.width, options.height) < 1 ||
      std::max(options.width, options.height) > kLargestImage)
    return volumes::fail(volumes::ErrorCode::kBadArgument,
                         fmt::format("image: expected 1 to {} pixels a side, found {}x{}",
                                     kLargestImage, options.width, options.height));
  return {};
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace cvr::gpu
