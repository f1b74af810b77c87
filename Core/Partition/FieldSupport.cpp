#include "Partition/FieldSupport.h"

#include "Octree/TreePath.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>

namespace treeamr
{

namespace
{

constexpr std::array<int, 3> offsetOf(int entry)
{
  return { entry % 3 - 1, entry / 3 % 3 - 1, entry / 9 - 1 };
}

/// The children of a neighbour that touch the node in the middle, as a mask.
constexpr std::array<unsigned, 27> touchingChildren = [] {
  std::array<unsigned, 27> masks{};
  for (int e = 0; e < 27; ++e)
  {
    for (int o = 0; o < 8; ++o)
    {
      bool touches = true;
      for (int a = 0; a < 3; ++a)
      {
        // Below the middle its upper children do, above it the lower ones.
        touches = touches && offsetOf(e)[a] != (sideOf(o, a) != 0 ? 1 : -1);
      }
      masks[e] |= static_cast<unsigned>(touches) << o;
    }
  }
  return masks;
}();

/// Of nodes, set and read by several threads.
class Marks
{
public:
  explicit Marks(const Octree& octree)
    : ofLeaf_(octree.leafCount(), 0)
    , ofInner_(octree.innerCount(), 0)
  {
  }
  /// Whether it was not there.
  bool set(NodeRef node, std::uint8_t mark) noexcept
  {
    std::atomic_ref<std::uint8_t> marks(of(node));
    return (marks.load(std::memory_order_relaxed) & mark) == 0 &&
      (marks.fetch_or(mark, std::memory_order_relaxed) & mark) == 0;
  }
  bool has(NodeRef node, std::uint8_t mark) const noexcept
  {
    return (std::atomic_ref<std::uint8_t>(of(node)).load(std::memory_order_relaxed) & mark) != 0;
  }

private:
  std::uint8_t& of(NodeRef node) const noexcept { return (node.isLeaf() ? ofLeaf_ : ofInner_)[node.index()]; }

  // Mutable, for only what is not const can be read atomically.
  mutable std::vector<std::uint8_t> ofLeaf_;
  mutable std::vector<std::uint8_t> ofInner_;
};

constexpr std::uint8_t isNeeded = 1;    // with all below it
constexpr std::uint8_t givesValues = 2; // to gradients in the box, from all leaves below
constexpr std::uint8_t hasGivers = 4;   // below

class Search
{
public:
  Search(const Octree& octree, const LatticeBox& box, const CellSet& known)
    : octree_(octree)
    , padding_(octree.grid().paddingDepth())
    , box_(box)
    , known_(known)
    , marks_(octree)
  {
  }

  FieldSupport run()
  {
    forAllParts([this](const TreePath& path) { return visitBox(path); });
    if (markWhereGiversAre(octree_.root(), { {}, -padding_ }))
    {
      forAllParts([this](const TreePath& path) { return visitGradients(path); });
    }
    FieldSupport support{ CellSet(padding_), CellSet(padding_) };
    std::vector<CellId> needed;
    collectNeeded(octree_.root(), { {}, -padding_ }, needed);
    support.needed.add(needed);
    std::vector<CellId> unknown;
    for (const std::vector<CellId>& found : unknown_)
    {
      unknown.insert(unknown.end(), found.begin(), found.end());
    }
    support.unknown.add(unknown);
    return support;
  }

private:
  bool markWhereGiversAre(NodeRef node, const CellId& cell)
  {
    if (node.isNone() || (cell.level >= 0 && box_.contains(cell)))
    {
      return false;
    }
    if (marks_.has(node, givesValues))
    {
      return true;
    }
    bool any = false;
    for (int o = 0; node.isInner() && o < 8; ++o)
    {
      any =
        markWhereGiversAre(octree_.child(node, o), { indexOfChild(cell.index, o), cell.level + 1 }) || any;
    }
    if (any)
    {
      marks_.set(node, hasGivers);
    }
    return any;
  }

  void collectNeeded(NodeRef node, const CellId& cell, std::vector<CellId>& needed) const
  {
    if (node.isNone() || (cell.level >= 0 && box_.contains(cell)))
    {
      return;
    }
    if (marks_.has(node, isNeeded))
    {
      needed.push_back(cell);
      return;
    }
    for (int o = 0; node.isInner() && o < 8; ++o)
    {
      collectNeeded(octree_.child(node, o), { indexOfChild(cell.index, o), cell.level + 1 }, needed);
    }
  }

  CellId cellOf(const TreePath& path) const noexcept { return { path.index(), path.depth() - padding_ }; }
  CellId cellOf(const TreePath& path, const std::array<int, 3>& offset) const noexcept
  {
    return moved(cellOf(path), offset);
  }
  static CellId moved(CellId cell, const std::array<int, 3>& offset) noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      cell.index[a] += offset[a];
    }
    return cell;
  }
  bool isInDomain(const CellId& cell) const noexcept
  {
    bool inside = true;
    for (int a = 0; a < 3; ++a)
    {
      inside = inside && cell.index[a] >= 0 && cell.index[a] < Coord(octree_.grid().roots()[a]) << cell.level;
    }
    return inside;
  }
  bool isKnown(const CellId& cell) const noexcept
  {
    if (box_.contains(cell) || known_.covers(cell))
    {
      return true;
    }
    if (!known_.meets(cell))
    {
      return false;
    }
    for (int o = 0; o < 8; ++o)
    {
      if (!isKnown({ indexOfChild(cell.index, o), cell.level + 1 }))
      {
        return false;
      }
    }
    return true;
  }

  /// A node, a leaf around the place or none.
  NodeRef nodeAt(const CellId& cell) const noexcept
  {
    NodeRef node = octree_.root();
    for (int up = padding_ + cell.level - 1; up >= 0 && node.isInner(); --up)
    {
      node = octree_.child(node, octantAbove(cell.index, up));
    }
    return node;
  }

  /// Visits the nodes that visit(path) is true of, from the root down, and their children. Nodes at the box's level are
  /// shared out among threads.
  template <class Visit>
  void forAllParts(const Visit& visit)
  {
    std::vector<std::vector<std::uint8_t>> parts; // octants on the way to each
    {
      TreePath path(octree_);
      std::vector<std::uint8_t> way;
      walk(path, visit, [&](const TreePath& at) {
        way.clear();
        for (int up = at.depth() - 1; up >= 0; --up)
        {
          way.push_back(static_cast<std::uint8_t>(octantAbove(at.index(), up)));
        }
        const bool isPart = at.depth() == padding_ + box_.level;
        if (isPart)
        {
          parts.push_back(way);
        }
        return isPart;
      });
    }
    tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t i) {
      TreePath path(octree_);
      for (const std::uint8_t octant : parts[i])
      {
        path.descend(octant);
      }
      walk(path, visit, [](const TreePath&) { return false; });
    });
  }
  template <class Visit, class IsLeftOut>
  static void walk(TreePath& path, const Visit& visit, const IsLeftOut& isLeftOut)
  {
    if (isLeftOut(path) || !visit(path) || !path.node().isInner())
    {
      return;
    }
    for (int o = 0; o < 8; ++o)
    {
      path.descend(o);
      walk(path, visit, isLeftOut);
      path.ascend();
    }
  }

  /// A place and all below it, or the larger leaf around.
  void require(const CellId& cell, NodeRef node)
  {
    if (!isInDomain(cell) || box_.contains(cell))
    {
      return;
    }
    if (node.isNone())
    {
      requireKnown(cell);
    }
    else if (marks_.set(node, isNeeded) && node.isInner())
    {
      requireKnown(cell);
    }
  }
  void requireKnown(const CellId& cell)
  {
    if (!isKnown(cell))
    {
      unknown_.local().push_back(cell);
    }
  }

  static bool touchesLarger(const TreePath& path) noexcept
  {
    const Neighbourhood& around = path.around(path.depth());
    return std::ranges::any_of(
      around, [&](const NodeRef& node) { return node.isLeaf() && node.depth() < path.depth(); });
  }

  /// What the values in a leaf take, and those that hang on a larger leaf beside a node.
  void requireAround(const TreePath& path, bool hangs)
  {
    const Neighbourhood& around = path.around(path.depth());
    for (int e = 0; e < 27; ++e)
    {
      const CellId cell = cellOf(path, offsetOf(e));
      if (hangs || around[e].isLeaf())
      {
        require(cell, around[e]);
        continue;
      }
      if (!isInDomain(cell))
      {
        continue;
      }
      for (unsigned rest = touchingChildren[e]; rest != 0; rest &= rest - 1)
      {
        const int o = std::countr_zero(rest);
        const NodeRef child =
          around[e].isInner() ? octree_.children(around[e].index()).node(o, path.depth() + 1) : NodeRef{};
        require({ indexOfChild(cell.index, o), cell.level + 1 }, child);
      }
    }
  }

  /// Whether no cell is missing below a node.
  bool isFull(NodeRef node) const noexcept
  {
    if (!node.isInner())
    {
      return node.isLeaf();
    }
    const Octree::Children children = octree_.children(node.index());
    bool full = children.exists == 0xff;
    for (unsigned rest = full ? children.inner() : 0; full && rest != 0; rest &= rest - 1)
    {
      full = isFull(children.node(std::countr_zero(rest), node.depth() + 1));
    }
    return full;
  }

  void requireValues(const CellId& cell, NodeRef node)
  {
    if (!isInDomain(cell) || box_.contains(cell))
    {
      return;
    }
    require(cell, node);
    if (!node.isNone())
    {
      marks_.set(node, givesValues);
    }
  }
  /// Gradients take values a leaf's width away, or that of a larger leaf, which is twice a node's width, from the node's
  /// vertices: on the far faces of the nodes one or two steps along each axis. Where these lack cells, of what is around.
  void requireGradients(const TreePath& path, bool hangs)
  {
    for (const int e : { 12, 14, 10, 16, 4, 22 }) // across the faces
    {
      const std::array<int, 3> step = offsetOf(e);
      const CellId next = cellOf(path, step);
      requireAhead(next, path.around(path.depth())[e], step);
      if (hangs)
      {
        const CellId second = moved(next, step);
        requireAhead(second, isInDomain(second) ? nodeAt(second) : NodeRef{}, step);
      }
    }
  }
  void requireAhead(const CellId& cell, NodeRef node, const std::array<int, 3>& step)
  {
    requireValues(cell, node);
    if (isFull(node) || !isInDomain(cell) || !isKnown(cell))
    {
      return;
    }
    for (int e = 0; e < 27; ++e)
    {
      const std::array<int, 3> offset = offsetOf(e);
      if (offset[0] * step[0] + offset[1] * step[1] + offset[2] * step[2] >= 0)
      {
        const CellId beside = moved(cell, offset);
        requireValues(beside, isInDomain(beside) ? nodeAt(beside) : NodeRef{});
      }
    }
  }

  /// Whether leaves below may depend on what is not in the box.
  bool dependsOnOutside(const CellId& cell) const noexcept
  {
    CellId first = cell;
    CellId last = cell;
    constexpr Coord reach = 3; // two nodes along a gradient's step, and the one beyond
    for (int a = 0; a < 3; ++a)
    {
      first.index[a] = std::max<Coord>(cell.index[a] - reach, 0);
      last.index[a] =
        std::min<Coord>(cell.index[a] + reach, (Coord(octree_.grid().roots()[a]) << cell.level) - 1);
    }
    return !box_.contains(first) || !box_.contains(last);
  }

  /// Whether a place where there may be a leaf, outside the box, has one in it among its siblings.
  bool isBesideOwnLeaf(const TreePath& path) const noexcept
  {
    const int depth = path.depth();
    if (depth == 0 || path.node().isInner() || box_.meets(cellOf(path)))
    {
      return false;
    }
    const std::array<Coord, 3>& parent = path.index(depth - 1);
    unsigned leaves = octree_.children(path.around(depth - 1)[13].index()).leaf;
    bool any = false;
    for (; leaves != 0 && !any; leaves &= leaves - 1)
    {
      any = box_.meets({ indexOfChild(parent, std::countr_zero(leaves)), depth - padding_ });
    }
    return any;
  }

  bool visitBox(const TreePath& path)
  {
    const CellId cell = cellOf(path);
    if (cell.level < 0)
    {
      return true;
    }
    const bool isBeside = isBesideOwnLeaf(path);
    if (isBeside)
    {
      require(cell, path.node());
    }
    if (path.node().isNone() || !(isBeside || box_.reaches(cell)) || !dependsOnOutside(cell))
    {
      return false;
    }
    const bool hangs = touchesLarger(path);
    if (hangs || path.node().isLeaf())
    {
      requireAround(path, hangs);
      requireGradients(path, hangs);
    }
    requireBlocks(path);
    return true;
  }

  /// Contours join octants between blocks of eight leaves (DualCells.h): those around the block of a leaf are to be held if
  /// they are such.
  void requireBlocks(const TreePath& path)
  {
    if (!path.node().isInner() || octree_.children(path.node().index()).leaf == 0)
    {
      return;
    }
    const Neighbourhood& around = path.around(path.depth());
    for (int e = 0; e < 27; ++e)
    {
      const CellId block = cellOf(path, offsetOf(e));
      const Octree::Children children =
        around[e].isInner() ? octree_.children(around[e].index()) : Octree::Children{};
      if (!around[e].isInner() || children.inner() != 0 || box_.contains(block))
      {
        continue;
      }
      bool mayBePlain = true;
      for (unsigned missing = ~children.exists & 0xff; missing != 0 && mayBePlain; missing &= missing - 1)
      {
        mayBePlain = !isKnown({ indexOfChild(block.index, std::countr_zero(missing)), block.level + 1 });
      }
      for (int o = 0; mayBePlain && o < 8; ++o)
      {
        require({ indexOfChild(block.index, o), block.level + 1 }, children.node(o, path.depth() + 1));
      }
    }
  }

  /// Whether a node, or one that it lies in, gives values.
  bool isBelowGiver(const TreePath& path) const noexcept
  {
    for (int depth = padding_; depth <= path.depth(); ++depth)
    {
      const NodeRef node = path.around(depth)[13];
      if (marks_.has(node, givesValues))
      {
        return true;
      }
    }
    return false;
  }

  bool visitGradients(const TreePath& path)
  {
    const CellId cell = cellOf(path);
    const NodeRef node = path.node();
    if (node.isNone() || (cell.level >= 0 && box_.contains(cell)) ||
      !(marks_.has(node, hasGivers) || isBelowGiver(path)))
    {
      return false;
    }
    if (cell.level >= 0)
    {
      const bool hangs = touchesLarger(path);
      if (hangs || node.isLeaf())
      {
        requireAround(path, hangs);
      }
    }
    return true;
  }

  const Octree& octree_;
  int padding_;
  const LatticeBox& box_;
  const CellSet& known_;
  Marks marks_;
  tbb::enumerable_thread_specific<std::vector<CellId>> unknown_;
};

} // namespace

FieldSupport findFieldSupport(const Octree& octree, const LatticeBox& box, const CellSet& known)
{
  if (box.isEmpty())
  {
    const int padding = octree.grid().paddingDepth();
    return { CellSet(padding), CellSet(padding) };
  }
  return Search(octree, box, known).run();
}

} // namespace treeamr
