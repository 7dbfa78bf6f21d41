// How much memory a piece of code holds at most: malloc and its kin are replaced in this program by
// counting ones.
#pragma once

#include <cstddef>

namespace cvr::fuzz {

/// Whether this build counts (not under a sanitizer, which has an allocator of its own, and only
/// with glibc).
bool counts_allocations();
/// Forgets the highest mark; what is held now counts as zero.
void start_watching();
/// The most bytes held at once since start_watching(), beyond those held then. Of the calling
/// thread's doing alone.
std::size_t most_bytes_held();

}  // namespace cvr::fuzz
