// One scalar field on an octree: a value per leaf, a mean and a range per inner node.
#pragma once

#include "Field/RangeCode.h"
#include "Octree/Octree.h"

#include <memory>

namespace treeamr
{

class Field
{
public:
  /// values[i] belongs to leaf i; all must be finite (cells without a finite value are left out of the
  /// octree). Computes the means: volume-weighted over the leaves below, in lattice volume. Throws Error, also
  /// without an octree and for another number of values.
  Field(std::shared_ptr<const Octree> octree, LargeVector<float> values);
  /// Copies them.
  template <class Allocator>
  Field(std::shared_ptr<const Octree> octree, const std::vector<float, Allocator>& values)
    : Field(std::move(octree), LargeVector<float>(values.begin(), values.end()))
  {
  }

  const Identity& identity() const noexcept { return identity_; }
  const Octree& octree() const noexcept { return *octree_; }
  const std::shared_ptr<const Octree>& sharedOctree() const noexcept { return octree_; }

  /// The leaf's value or the inner node's mean.
  double value(NodeRef node) const noexcept
  {
    return node.isLeaf() ? values_[node.index()] : meanBase_ + means_[node.index()];
  }
  const LargeVector<float>& leafValues() const noexcept { return values_; }
  /// The inner nodes' means less meanBase().
  const LargeVector<float>& innerMeans() const noexcept { return means_; }
  double meanBase() const noexcept { return meanBase_; }

  /// Hull of the leaves' values, which also bounds the reconstructed field; {0, 0} without cells.
  Range range() const noexcept { return range_; }
  /// A range around the GTI reconstruction inside the inner node; `parent` is the node range of its parent,
  /// of the octree's root range(). Needs computeNodeRanges().
  Range nodeRange(NodeRef inner, Range parent) const noexcept
  {
    return rangeCodes_[inner.index()].decode(parent);
  }
  bool hasNodeRanges() const noexcept { return !rangeCodes_.empty() || octree_->innerCount() == 0; }
  /// Ranges are for skipping: who only asks for values leaves them out. Defined in
  /// Field/NodeRanges.cpp.
  void computeNodeRanges();

  /// Allocated bytes, without the octree.
  std::size_t byteSize() const noexcept;

private:
  void checkAndMeasureValues();
  void computeMeans();
  /// exact[n]: of the inner node n, within those of its ancestors and range().
  void encodeNodeRanges(LargeVector<Range> exact);

  Identity identity_;
  std::shared_ptr<const Octree> octree_;
  LargeVector<float> values_;
  LargeVector<float> means_;
  // Where the values' offset is larger than their range, means are rounded to the range's digits, not the offset's.
  double meanBase_ = 0.;
  LargeVector<RangeCode> rangeCodes_;
  Range range_{ 0.f, 0.f };
};

/// The field that `user` (who it is for, in the message) was given. Throws Error for a null pointer.
const Field& required(const std::shared_ptr<const Field>& field, const char* user);

} // namespace treeamr
