#include "Octree/Field.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace treeamr
{

Field::Field(std::shared_ptr<const Octree> octree, std::vector<float> values)
  : octree_(std::move(octree))
  , values_(std::move(values))
{
  if (values_.size() != octree_->leafCount())
  {
    throw Error("field: " + std::to_string(values_.size()) + " values for " +
      std::to_string(octree_->leafCount()) + " leaves");
  }
  for (std::size_t i = 0; i < values_.size(); ++i)
  {
    if (!std::isfinite(values_[i]))
    {
      throw Error("field: the value of leaf " + std::to_string(i) + " is not finite");
    }
  }
  if (!values_.empty())
  {
    const auto [low, high] = std::minmax_element(values_.begin(), values_.end());
    range_ = { *low, *high };
  }

  // Children follow their parent in breadth-first order: one backward pass sees them first. `volume` is the
  // covered part of a node (1 = all of it), which differs between siblings where cells are missing.
  means_.resize(octree_->innerCount());
  std::vector<double> volume(octree_->innerCount());
  for (std::uint64_t n = octree_->innerCount(); n-- > 0;)
  {
    double sum = 0.;
    double covered = 0.;
    for (int o = 0; o < 8; ++o)
    {
      const NodeRef child = octree_->child({ NodeKind::Inner, 0, n }, o);
      if (!child.isNone())
      {
        const double v = child.isLeaf() ? 1. : volume[child.index()];
        sum += v * value(child);
        covered += v;
      }
    }
    if (covered == 0.)
    {
      throw Error("octree: inner node " + std::to_string(n) + " has no leaf below");
    }
    volume[n] = covered / 8.;
    means_[n] = static_cast<float>(sum / covered);
  }
}

std::size_t Field::byteSize() const noexcept
{
  return (values_.capacity() + means_.capacity()) * sizeof(float) + ranges_.capacity() * sizeof(Range);
}

} // namespace treeamr
