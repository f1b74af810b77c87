#include "Surface/BlockBoxes.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace treeamr
{

namespace
{

constexpr std::size_t groups(std::size_t boxes) noexcept
{
  return (boxes + BoxGroup::size - 1) / BoxGroup::size;
}

/// Fills groups by box(i, low, high) of the boxes that there are.
template <class Box>
void fillGroups(std::size_t boxes, LargeVector<BoxGroup>& level, const Box& box)
{
  tbb::parallel_for(std::size_t(0), level.size(), [&](std::size_t g) {
    for (std::size_t k = 0; k < BoxGroup::size; ++k)
    {
      UnitBox one;
      if (const std::size_t i = BoxGroup::size * g + k; i < boxes)
      {
        one = box(i);
      }
      for (int a = 0; a < 3; ++a)
      {
        level[g].low[a][k] = one.low[a];
        level[g].high[a][k] = one.high[a];
      }
    }
  });
}

} // namespace

BlockBoxes::BlockBoxes(const BlockIntersection& intersection)
  : intersection_(intersection)
{
  std::size_t boxes = intersection.blocks().all().size();
  while (levels_.empty() || boxes > 1)
  {
    boxes = groups(boxes);
    levels_.emplace_back(boxes);
  }
  this->fill();
}

void BlockBoxes::fill()
{
  computedBefore_ = intersection_.blocks().computedCount();
  std::size_t boxes = intersection_.blocks().all().size();
  fillGroups(boxes, levels_[0], [&](std::size_t block) { return intersection_.unitBox(block); });
  for (std::size_t l = 1; l < levels_.size(); ++l)
  {
    const LargeVector<BoxGroup>& below = levels_[l - 1];
    fillGroups(below.size(), levels_[l], [&](std::size_t g) {
      UnitBox all;
      for (int a = 0; a < 3; ++a)
      {
        all.low[a] = *std::min_element(below[g].low[a].begin(), below[g].low[a].end());
        all.high[a] = *std::max_element(below[g].high[a].begin(), below[g].high[a].end());
      }
      return all;
    });
  }
}

void BlockBoxes::update()
{
  if (intersection_.blocks().areMuchNarrower(computedBefore_))
  {
    this->fill();
  }
}

void BlockBoxes::find(RayTile& tile) const
{
  findBlocks(intersection_.space(), levels_, tile.rays, tile.count, tile.blocks);
}

std::size_t BlockBoxes::byteSize() const noexcept
{
  std::size_t bytes = 0;
  for (const LargeVector<BoxGroup>& level : levels_)
  {
    bytes += level.size() * sizeof(BoxGroup);
  }
  return bytes;
}

} // namespace treeamr
