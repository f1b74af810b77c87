// Ranges of the reconstructed field per inner node: what renderers skip by and surfaces are found by. Unlike the
// paper's ranges of cell values they hold for sure: an octant's vertices also use the cells around it. Beside cells
// of other sizes they may be wider than the field: its exact hull takes twice as long and leaves out two more nodes in
// a hundred.
#pragma once

#include "Field/RangeCode.h"
#include "LargeArray.h"
#include "Prefetch.h"

#include <cstddef>
#include <cstdint>

namespace treeamr
{

class Field;

/// Two bytes for an inner node. Field::nodeRanges() has them made once for all who ask.
class NodeRanges
{
public:
  /// Of all inner nodes.
  explicit NodeRanges(const Field& field);

  /// A range around the GTI reconstruction inside an inner node. parent: that of its parent, of the octree's root
  /// Field::range().
  Range of(std::uint64_t inner, Range parent) const noexcept { return codes_[inner].decode(parent); }
  /// Announces that a node and the seven after it will be asked for.
  void prefetch(std::uint64_t inner) const noexcept { treeamr::prefetch(codes_.data() + inner); }
  /// Allocated bytes.
  std::size_t byteSize() const noexcept { return codes_.capacity() * sizeof(RangeCode); }

private:
  /// exact[n]: of the inner node n, within those of its ancestors and the field's.
  void encode(const Field& field, LargeVector<Range> exact);

  LargeVector<RangeCode> codes_;
};

} // namespace treeamr
