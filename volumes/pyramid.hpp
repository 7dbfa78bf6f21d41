// The label pyramid: each level halves the extent (rounding up), each node takes the most frequent
// label below it.
//
// Rule (CSGV-R paper, section 2.5): a node's label is the most frequent label of its up to eight
// valid children; ties go to the first such label in Morton child order, child = x + 2y + 4z.
// Children outside the volume do not vote. Level 0 is the volume.
#pragma once

#include "volumes/source.hpp"

namespace cvr::volumes {

/// One plane of the next coarser level from the one or two planes (fine.z) of a finer level that it
/// covers. `coarse` takes ceil(fine.x / 2) * ceil(fine.y / 2) labels. T: u8, u16, u32, u64.
template <class T>
void coarsen_planes(const T* finer, const Extent& fine, T* coarse);

/// The next coarser level of a label volume: extent ceil(extent / 2), voxel size doubled, same
/// type. Reads the source in slabs of a few planes. The same labels for any number of threads.
Volume coarser_level(const VolumeSource& finer, unsigned threads);

}  // namespace cvr::volumes
