// One scalar field on an octree: a value per leaf and a mean per inner node.
//
// A field that is given at the corners of leaves has these beside (CornerValues.h) and is trilinear between them in each
// leaf; a leaf's value is their mean.
//
// Both are floats, and where these would lose too many digits (offsetFor()) less an offset in double, which only what
// a user gives or sees is told: what is called relative here, and all that is computed from it, is less that offset.
#pragma once

#include "Field/FieldOffset.h"
#include "Field/NodeRanges.h"
#include "Octree/Octree.h"

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

namespace treeamr
{

class CornerValues;

/// The values at the corners of a leaf, numbered as in Octant.h. Called once for each, from several threads.
using CornerSource = std::function<std::array<float, 8>(std::uint64_t leaf)>;

/// A scalar for each leaf of an octree. Never changes, so any number of threads may read it.
class Field
{
public:
  /// offset + values[i] belongs to leaf i; all must be finite (cells without a finite value are left out of the
  /// octree). Computes the means: volume-weighted over the leaves below, in lattice volume. whole: the hull of the values,
  /// less the offset, that other processes hold, too, so that ranges and means are alike; none: these are all. Throws Error, also
  /// without an octree and for another number of values.
  Field(std::shared_ptr<const Octree> octree, LargeVector<float> values, double offset = 0.,
    const std::optional<Range>& whole = {});
  /// Copies them.
  template <class Allocator>
  Field(std::shared_ptr<const Octree> octree, const std::vector<float, Allocator>& values, double offset = 0.)
    : Field(std::move(octree), LargeVector<float>(values.begin(), values.end()), offset)
  {
  }

  /// offset + the eight values belong to the corners of each leaf, but for those that hang on a coarser one
  /// (CornerValues.h). Where leaves disagree beyond rounding at a corner that they share, the field is one of means at the
  /// leaves' centres instead, and cornerJump() says so. Throws Error as the other. Takes 8 to 11 bytes a cell more, 15 on
  /// the most irregular trees.
  static Field ofCorners(
    std::shared_ptr<const Octree> octree, const CornerSource& corners, double offset = 0.);

  /// Tells fields apart; copies have the same.
  const Identity& identity() const noexcept { return identity_; }
  ///@{
  /// That the values are of.
  const Octree& octree() const noexcept { return *octree_; }
  const std::shared_ptr<const Octree>& sharedOctree() const noexcept { return octree_; }
  ///@}

  /// The leaf's value or the inner node's mean.
  double value(NodeRef node) const noexcept { return offset_ + relative(node); }
  /// What the stored values are less.
  double offset() const noexcept { return offset_; }
  /// What cells of a value have: relative, rounded.
  float stored(double value) const noexcept { return static_cast<float>(value - offset_); }
  /// value() less offset().
  double relative(NodeRef node) const noexcept
  {
    return node.isLeaf() ? values_[node.index()] : meanBase_ + means_[node.index()];
  }
  /// Relative.
  const LargeVector<float>& leafValues() const noexcept { return values_; }
  /// The inner nodes' relative means less meanBase().
  const LargeVector<float>& innerMeans() const noexcept { return means_; }
  /// What the stored means are less besides, where all values are of one size.
  double meanBase() const noexcept { return meanBase_; }

  /// Relative; null: the values are those at centres.
  const CornerValues* corners() const noexcept { return corners_.get(); }
  /// The most by which leaves disagreed at a corner, of values at corners that are not kept; else 0.
  double cornerJump() const noexcept { return cornerJump_; }

  /// Hull of the leaves' relative values, or those at corners, which also bounds the reconstructed field; {0, 0} without cells.
  Range range() const noexcept { return range_; }
  /// Relative. Made on the first call for this field or a copy, which share them. Safe from several threads.
  const NodeRanges& nodeRanges() const;

  /// Allocated bytes, without the octree; with the node ranges when there are any.
  std::size_t byteSize() const;

private:
  void checkAndMeasureValues();
  void computeMeans(const Range& whole);

  struct SharedRanges
  {
    std::mutex mutex;
    std::unique_ptr<const NodeRanges> made; // null: not yet
  };

  Identity identity_;
  std::shared_ptr<const Octree> octree_;
  LargeVector<float> values_;
  LargeVector<float> means_;
  double offset_; // none is -0, which added to a zero leaves its sign
  // Where the relative values are all of one size, means are rounded to the digits of their range, not of the size.
  double meanBase_ = 0.;
  Range range_{ 0.f, 0.f };
  std::shared_ptr<const CornerValues> corners_;
  double cornerJump_ = 0.;
  std::shared_ptr<SharedRanges> ranges_ = std::make_shared<SharedRanges>();
};

/// The field that `user` (who it is for, in the message) was given. Throws Error for a null pointer.
const Field& required(const std::shared_ptr<const Field>& field, const char* user);

} // namespace treeamr
