#include "tests/fuzz/allocation_watch.hpp"

#include <malloc.h>

#include <algorithm>
#include <cstdint>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CVR_COUNT_ALLOCATIONS 1
#endif

namespace cvr::fuzz {

namespace {

// Per thread: the code under test runs on the watching thread. Frees of other threads' blocks may
// turn it negative.
thread_local std::int64_t held = 0;
thread_local std::int64_t most = 0;

}  // namespace

void count(std::int64_t bytes) {
  held += bytes;
  most = std::max(most, held);
}

bool counts_allocations() {
#ifdef CVR_COUNT_ALLOCATIONS
  return true;
#else
  return false;
#endif
}

void start_watching() { held = most = 0; }
std::size_t most_bytes_held() { return static_cast<std::size_t>(most); }

}  // namespace cvr::fuzz

#ifdef CVR_COUNT_ALLOCATIONS

// glibc's documented way of replacing malloc: define the public names; the __libc_ ones stay
// reachable.
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);

// Requests are counted, not pages: a block that is too large is a mistake whether or not it is
// touched.
void* malloc(std::size_t size) {
  void* block = __libc_malloc(size);
  if (block != nullptr) cvr::fuzz::count(static_cast<std::int64_t>(malloc_usable_size(block)));
  return block;
}

void* calloc(std::size_t count, std::size_t size) {
  void* block = __libc_calloc(count, size);
  if (block != nullptr) cvr::fuzz::count(static_cast<std::int64_t>(malloc_usable_size(block)));
  return block;
}

void* realloc(void* old, std::size_t size) {
  const auto before = static_cast<std::int64_t>(old == nullptr ? 0 : malloc_usable_size(old));
  void* block = __libc_realloc(old, size);
  const auto after = static_cast<std::int64_t>(block == nullptr ? 0 : malloc_usable_size(block));
  if (block != nullptr || size == 0) cvr::fuzz::count(after - before);
  return block;
}

void free(void* block) {
  if (block != nullptr) cvr::fuzz::count(-static_cast<std::int64_t>(malloc_usable_size(block)));
  __libc_free(block);
}

}  // extern "C"

#endif
