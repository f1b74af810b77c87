// One scalar field on an octree: a value per leaf, a mean and a range per inner node.
#pragma once

#include "Octree/Octree.h"

#include <memory>
#include <vector>

namespace treeamr
{

struct Range
{
  float min;
  float max;
};

class Field
{
public:
  /// values[i] belongs to leaf i; all must be finite (cells without a finite value are left out of the
  /// octree). Computes the means: volume-weighted over the leaves below, in lattice volume.
  Field(std::shared_ptr<const Octree> octree, std::vector<float> values);

  const Octree& octree() const noexcept { return *octree_; }
  const std::shared_ptr<const Octree>& sharedOctree() const noexcept { return octree_; }

  /// The leaf's value or the inner node's mean.
  float value(NodeRef node) const noexcept
  {
    return node.isLeaf() ? values_[node.index()] : means_[node.index()];
  }
  const std::vector<float>& leafValues() const noexcept { return values_; }

  /// Hull of the leaves' values, which also bounds the reconstructed field; {0, 0} without cells.
  Range range() const noexcept { return range_; }
  /// Range of the GTI reconstruction inside the inner node. Needs computeRanges().
  Range nodeRange(NodeRef inner) const noexcept { return ranges_[inner.index()]; }
  bool hasNodeRanges() const noexcept { return !ranges_.empty() || octree_->innerCount() == 0; }
  /// Ranges are for skipping: who only asks for values leaves them out. Defined in
  /// Interpolation/NodeRanges.cpp.
  void computeNodeRanges();

  /// Allocated bytes, without the octree.
  std::size_t byteSize() const noexcept;

private:
  std::shared_ptr<const Octree> octree_;
  std::vector<float> values_;
  std::vector<float> means_;
  std::vector<Range> ranges_;
  Range range_{ 0.f, 0.f };
};

} // namespace treeamr
