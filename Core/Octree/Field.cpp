#include "Octree/Field.h"

#include "Error.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

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

void Field::encodeNodeRanges(std::vector<Range> exact)
{
  const Octree& octree = *octree_;
  rangeCodes_.resize(octree.innerCount());
  if (octree.innerCount() == 0)
  {
    return;
  }
  // Down the depths: a node's exact range makes way for its decoded one once it is encoded.
  const auto encode = [&](std::uint64_t node, Range parent) {
    rangeCodes_[node] = RangeCode(exact[node], parent);
    exact[node] = rangeCodes_[node].decode(parent);
  };
  encode(0, range_);
  for (int depth = 0; depth < octree.innerDepths(); ++depth)
  {
    tbb::parallel_for(
      tbb::blocked_range<std::uint64_t>(octree.firstInner(depth), octree.firstInner(depth + 1), 4096),
      [&](const auto& nodes) {
        for (std::uint64_t n = nodes.begin(); n < nodes.end(); ++n)
        {
          for (int o = 0; o < 8; ++o)
          {
            const NodeRef child = octree.child({ NodeKind::Inner, depth, n }, o);
            if (child.isInner())
            {
              encode(child.index(), exact[n]);
            }
          }
        }
      });
  }
}

std::size_t Field::byteSize() const noexcept
{
  return (values_.capacity() + means_.capacity()) * sizeof(float) +
    rangeCodes_.capacity() * sizeof(RangeCode);
}

} // namespace treeamr
