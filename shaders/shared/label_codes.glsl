// From labels of 64 bits to codes of 32: where the labels of a volume do not fit in 32 bits, a code
// is the label's place in the ascending list of all labels. The list has two words per label, low
// first, and at most 2^31 labels.
#ifndef CVR_LABEL_CODES_GLSL
#define CVR_LABEL_CODES_GLSL

#include "shaders/shared/portable.glsl"

// The place of a label that is in the list; for others the place of the next smaller one, or 0.
CVR_FUNC uint cvr_code_of(Global list, uint size, uint64_t label) {
  uint first = 0u;
  for (uint count = size; count > 1u;) {
    uint below = count >> 1;
    if (cvr_word64_global(list, 2u * (first + below)) <= label) first += below;
    count -= below;
  }
  return first;
}

#endif
