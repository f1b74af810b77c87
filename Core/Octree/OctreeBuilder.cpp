#include "Octree/OctreeBuilder.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>

namespace treeamr
{

void OctreeAssembler::append(const std::vector<Masks>& masks)
{
  Octree& tree = *octree_;
  tree.nodes_.reserve(tree.nodes_.size() + masks.size());
  for (const Masks& m : masks)
  {
    if ((tree.nodes_.size() & ((std::uint64_t(1) << Octree::blockBits) - 1)) == 0)
    {
      tree.bases_.push_back({ nextInner_, nextLeaf_ });
    }
    const Octree::Base& base = tree.bases_.back();
    tree.nodes_.push_back({ m.exists, m.leaf, static_cast<std::uint16_t>(nextInner_ - base.inner),
      static_cast<std::uint16_t>(nextLeaf_ - base.leaf) });
    const int leaves = std::popcount(static_cast<unsigned>(m.leaf));
    nextLeaf_ += leaves;
    nextInner_ += std::popcount(static_cast<unsigned>(m.exists)) - leaves;
  }
  tree.firstInner_.push_back(tree.nodes_.size());
  tree.leafCount_ = nextLeaf_;
}

void OctreeAssembler::setLeafDepth(int depth) noexcept
{
  octree_->leafLevels_ = depth - octree_->grid_.paddingDepth();
}

std::shared_ptr<const Octree> OctreeAssembler::finish()
{
  octree_->nodes_.shrink_to_fit();
  octree_->bases_.shrink_to_fit();
  return octree_;
}

namespace
{

std::string name(const CellId& c)
{
  return "cell (" + std::to_string(c.index[0]) + ", " + std::to_string(c.index[1]) + ", " +
    std::to_string(c.index[2]) + ") of level " + std::to_string(c.level);
}

/// Whether the first cell's corner comes before the second's in Morton order (x fastest), without forming
/// keys, which would need three times the coordinates' bits. Equal corners: the coarser cell first.
bool mortonLess(const CellId& a, const CellId& b)
{
  const int level = std::max(a.level, b.level);
  std::uint64_t deciding = 0;
  bool less = a.level < b.level;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto p = static_cast<std::uint64_t>(a.index[axis]) << (level - a.level);
    const auto q = static_cast<std::uint64_t>(b.index[axis]) << (level - b.level);
    const std::uint64_t difference = p ^ q;
    // The axis with the highest differing bit decides; of equals, the later (slower) axis.
    if (difference != 0 && std::bit_width(difference) >= std::bit_width(deciding))
    {
      deciding = difference;
      less = p < q;
    }
  }
  return less;
}

bool contains(const CellId& outer, const CellId& inner)
{
  if (inner.level < outer.level)
  {
    return false;
  }
  for (int a = 0; a < 3; ++a)
  {
    if (inner.index[a] >> (inner.level - outer.level) != outer.index[a])
    {
      return false;
    }
  }
  return true;
}

/// Sorted cells as a tree: a node is the range of the cells below it.
class SortedCells
{
public:
  struct Handle
  {
    std::uint64_t begin;
    std::uint64_t end;
    int level;
  };

  explicit SortedCells(const std::vector<LeafCell>& cells)
    : cells_(cells)
  {
  }

  bool root(const std::array<Coord, 3>& index, Handle& handle) const
  {
    const CellId root{ index, 0 };
    const auto begin = std::lower_bound(cells_.begin(), cells_.end(), root,
      [](const LeafCell& c, const CellId& r) { return mortonLess(c.cell, r); });
    const auto end =
      std::partition_point(begin, cells_.end(), [&](const LeafCell& c) { return contains(root, c.cell); });
    handle = { static_cast<std::uint64_t>(begin - cells_.begin()),
      static_cast<std::uint64_t>(end - cells_.begin()), 0 };
    return begin != end;
  }
  NodeKind kind(const Handle& h) const
  {
    if (h.begin == h.end)
    {
      return NodeKind::None;
    }
    return cells_[h.begin].cell.level == h.level ? NodeKind::Leaf : NodeKind::Inner;
  }
  Handle child(const Handle& h, int octant) const
  {
    const auto octantOf = [&](const LeafCell& c) {
      const int up = c.cell.level - h.level - 1;
      return static_cast<int>(
        (c.cell.index[0] >> up & 1) | (c.cell.index[1] >> up & 1) << 1 | (c.cell.index[2] >> up & 1) << 2);
    };
    const auto begin = cells_.begin() + h.begin;
    const auto end = cells_.begin() + h.end;
    const auto first =
      std::partition_point(begin, end, [&](const LeafCell& c) { return octantOf(c) < octant; });
    const auto last =
      std::partition_point(first, end, [&](const LeafCell& c) { return octantOf(c) == octant; });
    return { static_cast<std::uint64_t>(first - cells_.begin()),
      static_cast<std::uint64_t>(last - cells_.begin()), h.level + 1 };
  }
  float value(const Handle& h) const { return cells_[h.begin].value; }
  static constexpr bool ghosts() { return false; }
  static constexpr bool isGhost(const Handle&) { return false; }

private:
  const std::vector<LeafCell>& cells_;
};

} // namespace

OctreeAndValues buildOctree(RootGrid grid, std::vector<LeafCell> cells)
{
  for (const LeafCell& c : cells)
  {
    if (c.cell.level < 0 || c.cell.level > grid.maxLevel())
    {
      throw Error("octree: " + name(c.cell) + ", allowed are levels 0 to " + std::to_string(grid.maxLevel()));
    }
    for (int a = 0; a < 3; ++a)
    {
      const Coord end = Coord(grid.roots()[a]) << c.cell.level;
      if (c.cell.index[a] < 0 || c.cell.index[a] >= end)
      {
        throw Error("octree: " + name(c.cell) + " lies outside the root grid, which ends at " +
          std::to_string(end) + " along " + "xyz"[a]);
      }
    }
  }
  tbb::parallel_sort(cells.begin(), cells.end(),
    [](const LeafCell& a, const LeafCell& b) { return mortonLess(a.cell, b.cell); });
  for (std::size_t i = 1; i < cells.size(); ++i)
  {
    // Whatever lies inside a cell follows it directly in Morton order.
    if (contains(cells[i - 1].cell, cells[i].cell))
    {
      throw Error("octree: " + name(cells[i].cell) + " overlaps " + name(cells[i - 1].cell));
    }
  }
  return buildOctree(std::move(grid), SortedCells(cells));
}

} // namespace treeamr
