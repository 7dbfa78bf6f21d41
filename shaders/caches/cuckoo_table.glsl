// The voxel cache: one table of 64-bit entries (shaders/shared/cuckoo.glsl). Entries are read and
// written whole, by 64-bit atomics. cache[0] the table; cache_sizes[0] its entries, [1] bits of a
// position.
#include "shaders/shared/cuckoo.glsl"

const uint64_t CVR_FREE_ENTRY = ~uint64_t(0);

struct CuckooSlot {
  uint first;
  uint key;
  uint64_t found;  // entry at the first position
};

uint64_t cvr_load_entry(uint position) {
  return atomicLoad(Words64(cvr_frame.cache[0]).w[position], gl_ScopeDevice,
                    gl_StorageSemanticsNone, gl_SemanticsRelaxed);
}
void cvr_store_entry(uint position, uint64_t entry) {
  atomicStore(Words64(cvr_frame.cache[0]).w[position], entry, gl_ScopeDevice,
              gl_StorageSemanticsNone, gl_SemanticsRelaxed);
}

// True if the table holds the cell; `slot` then serves cvr_cuckoo_insert.
bool cvr_cuckoo_find(uvec3 voxel, uint lod, out CuckooSlot slot, out uint code) {
  uint size = cvr_frame.cache_sizes[0];
  uint bits = cvr_frame.cache_sizes[1];
  slot.first = cvr_cuckoo_first(voxel.x, voxel.y, voxel.z, bits, size);
  slot.key = cvr_cuckoo_key(voxel.x, voxel.y, voxel.z, lod);
  slot.found = cvr_load_entry(slot.first);
  code = uint(slot.found);
  if (uint(slot.found >> 32) == slot.key) return true;
  uint64_t second = cvr_load_entry(cvr_cuckoo_second(slot.key, slot.first, bits, size));
  code = uint(second);
  return uint(second >> 32) == (slot.key | CVR_CUCKOO_SECOND);
}

// Stores at the first position; what lay there moves to its second position, unless it lay there
// already: then it is lost. So is what lies at that second position; where both positions are one,
// that is the cell itself, and its next lookup misses.
void cvr_cuckoo_insert(CuckooSlot slot, uint code) {
  cvr_store_entry(slot.first, (uint64_t(slot.key) << 32) | uint64_t(code));
  if (slot.found == CVR_FREE_ENTRY) return;
  uint ejected = uint(slot.found >> 32);
  if ((ejected & CVR_CUCKOO_SECOND) != 0u) {
    CVR_COUNT(CVR_COUNT_CACHE_LOSSES, 1);
    return;
  }
  CVR_COUNT(CVR_COUNT_CACHE_EJECTIONS, 1);
  uint second =
      cvr_cuckoo_second(ejected, slot.first, cvr_frame.cache_sizes[1], cvr_frame.cache_sizes[0]);
#ifdef CVR_INSTRUMENTED
  if (cvr_load_entry(second) != CVR_FREE_ENTRY) CVR_COUNT(CVR_COUNT_CACHE_LOSSES, 1);
#endif
  cvr_store_entry(second, slot.found | (uint64_t(CVR_CUCKOO_SECOND) << 32));
}
