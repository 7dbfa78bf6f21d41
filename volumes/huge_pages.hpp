// Memory of large tables: asks the system for pages of 2 MiB. A table that is touched at random then
// takes a page fault for each of these in place of 512, and its look-ups hardly miss the TLB.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace cvr::volumes {

/// An allocator for std::vector. What is smaller than one such page comes from the heap as it is.
template <class T>
struct HugePages {
  using value_type = T;
  static constexpr std::size_t kPage = std::size_t{1} << 21;

  HugePages() = default;
  template <class U>
  explicit HugePages(const HugePages<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    const std::size_t alignment = bytes < kPage ? alignof(std::max_align_t) : kPage;
    const std::size_t aligned = alignof(T) > alignment ? alignof(T) : alignment;
    void* memory = std::aligned_alloc(aligned, (bytes + aligned - 1) / aligned * aligned);
    if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    if (bytes >= kPage) ::madvise(memory, bytes, MADV_HUGEPAGE);  // a hint: it may fail
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }
  template <class U>
  bool operator==(const HugePages<U>&) const {
    return true;
  }
};

}  // namespace cvr::volumes
