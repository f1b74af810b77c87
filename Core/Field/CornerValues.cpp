#include "Field/CornerValues.h"

#include "Error.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace treeamr
{

namespace
{

/// Of the node of one size at an entry of a neighbourhood, from the middle one's.
std::array<Coord, 3> indexOfEntry(const TreePath& path, int depth, int entry) noexcept
{
  const std::array<Coord, 3>& index = path.index(depth);
  return { index[0] + entry % 3 - 1, index[1] + entry / 3 % 3 - 1, index[2] + entry / 9 - 1 };
}

/// The other way round.
int entryOfIndex(const TreePath& path, int depth, const std::array<Coord, 3>& index) noexcept
{
  const std::array<Coord, 3>& own = path.index(depth);
  return static_cast<int>(index[0] - own[0] + 1 + 3 * (index[1] - own[1] + 1) + 9 * (index[2] - own[2] + 1));
}

std::array<Coord, 3> ancestorOf(const std::array<Coord, 3>& index, int up) noexcept
{
  return { index[0] >> up, index[1] >> up, index[2] >> up };
}

} // namespace

/// What a thread knows of the corners of the nodes on its path, by depth: each is found once, however deep it hangs.
struct CornerValues::KnownCorners
{
  std::uint64_t node = ~std::uint64_t(0);
  std::uint32_t known = 0; // mask of vertices
  std::array<double, 27> value{};
};

CornerValues::CornerValues(const Octree& octree, const CornerSource& source, LargeVector<float>& means)
{
  const int deepest = octree.grid().paddingDepth() + octree.leafLevels(); // leaf
  parity_ = deepest == 0 ? 1 : deepest & 1; // the deepest leaves are grandchildren
  std::uint64_t count = 0;
  for (int depth = -1; depth < octree.innerDepths(); ++depth)
  {
    if ((depth & 1) == parity_)
    {
      const std::uint64_t first = depth < 0 ? 0 : octree.firstInner(depth);
      firstBrick_[depth + 1] = count - first;
      count += depth < 0 ? 1 : octree.firstInner(depth + 1) - first;
    }
  }
  bricks_.resize(count);
  if (!octree.root().isNone())
  {
    markCorners(octree);
    fill(octree, source, means);
    jump_ = std::max(
      jump_, largestOfFamilies(octree, [this](const TreePath& path) { return this->jumpAround(path); }));
    if (this->isContinuous())
    {
      const std::vector<KnownCorners> nothing(octree.innerDepths());
      tbb::enumerable_thread_specific<std::vector<KnownCorners>> known(nothing);
      hangingChange_ = largestOfFamilies(
        octree, [&](const TreePath& path) { return this->constrain(path, known.local().data()); });
    }
  }
}

/// Calls f(leaf, first, step) for the leaves of a brick: their lowest corners, and how far apart they are.
template <class F>
void CornerValues::forEachLeaf(const Octree& octree, int depth, std::uint64_t inner, const F& f)
{
  const auto forChildren = [&](std::uint64_t node, int first, int step) {
    const Octree::Children children = octree.children(node);
    for (unsigned rest = children.leaf; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      f(children.leafIndex(octant), first + step * cornerOffset(octant, brickStride), step);
    }
    return children;
  };
  if (depth < 0)
  {
    octree.root().isLeaf() ? f(0, 0, 2) : void(forChildren(0, 0, 1));
    return;
  }
  const Octree::Children children = forChildren(inner, 0, 2);
  for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
  {
    const int octant = std::countr_zero(rest);
    forChildren(children.innerIndex(octant), 2 * cornerOffset(octant, brickStride), 1);
  }
}

/// Calls f(depth, inner, brick) for all, from several threads.
template <class F>
void CornerValues::forEachBrick(const Octree& octree, const F& f)
{
  for (int depth = -1; depth < octree.innerDepths(); ++depth)
  {
    if ((depth & 1) != parity_)
    {
      continue;
    }
    const std::uint64_t first = depth < 0 ? 0 : octree.firstInner(depth);
    const std::uint64_t end = depth < 0 ? 1 : octree.firstInner(depth + 1);
    tbb::parallel_for(tbb::blocked_range<std::uint64_t>(first, end, 512), [&](const auto& range) {
      for (std::uint64_t inner = range.begin(); inner < range.end(); ++inner)
      {
        f(depth, inner, bricks_[firstBrick_[depth + 1] + inner]);
      }
    });
  }
}

void CornerValues::markCorners(const Octree& octree)
{
  forEachBrick(octree, [&](int depth, std::uint64_t inner, Brick& brick) {
    forEachLeaf(octree, depth, inner, [&](std::uint64_t /*leaf*/, int first, int step) {
      for (int c = 0; c < 8; ++c)
      {
        const int corner = first + step * cornerOffset(c, brickStride);
        brick.exists[corner >> 6] |= std::uint64_t(1) << (corner & 63);
      }
    });
  });
  std::uint64_t count = 0;
  for (Brick& brick : bricks_)
  {
    brick.first = count;
    count += brick.count();
  }
  values_.resize(count);
}

void CornerValues::fill(const Octree& octree, const CornerSource& source, LargeVector<float>& means)
{
  means.resize(octree.leafCount());
  struct Found
  {
    float min = std::numeric_limits<float>::max();
    float max = std::numeric_limits<float>::lowest();
    double jump = 0.;
    std::uint64_t notFinite = ~std::uint64_t(0);
  };
  tbb::combinable<Found> ofThreads;
  forEachBrick(octree, [&](int depth, std::uint64_t inner, Brick& brick) {
    Found& found = ofThreads.local();
    std::array<float, 125> value;
    Brick known; // corners
    forEachLeaf(octree, depth, inner, [&](std::uint64_t leaf, int first, int step) {
      const std::array<float, 8> corners = source(leaf);
      double sum = 0.;
      for (int c = 0; c < 8; ++c)
      {
        const float v = corners[c];
        found.notFinite = std::isfinite(v) ? found.notFinite : std::min(found.notFinite, leaf);
        found.min = std::min(found.min, v);
        found.max = std::max(found.max, v);
        sum += v;
        const int corner = first + step * cornerOffset(c, brickStride);
        if (known.has(corner))
        {
          found.jump = std::max(found.jump, std::abs(static_cast<double>(v) - value[corner]));
          continue;
        }
        known.exists[corner >> 6] |= std::uint64_t(1) << (corner & 63);
        value[corner] = v;
      }
      means[leaf] = static_cast<float>(sum / 8.);
    });
    float* to = values_.data() + brick.first;
    for (int half = 0; half < 2; ++half)
    {
      for (std::uint64_t rest = brick.exists[half]; rest != 0; rest &= rest - 1)
      {
        *to++ = value[64 * half + std::countr_zero(rest)];
      }
    }
  });
  const Found all = ofThreads.combine([](const Found& a, const Found& b) {
    return Found{ std::min(a.min, b.min), std::max(a.max, b.max), std::max(a.jump, b.jump),
      std::min(a.notFinite, b.notFinite) };
  });
  if (all.notFinite < octree.leafCount())
  {
    throw Error("field: a value at a corner of leaf " + std::to_string(all.notFinite) + " is not finite");
  }
  range_ = { all.min, all.max };
  jump_ = all.jump;
}

bool CornerValues::isRounding(double difference) const noexcept
{
  // Single precision has 24 digits, files in text form as many as their writers leave: six at least.
  constexpr double ofRange = 1e-6;
  constexpr double ofSize = 0x1p-22;
  const double size = std::max(std::abs(range_.min), std::abs(range_.max));
  return difference <= ofRange * (static_cast<double>(range_.max) - range_.min) + ofSize * size;
}

CornerValues::Family CornerValues::family(const TreePath& path, int depth, int entry) const noexcept
{
  const std::uint64_t inner = path.around(depth)[entry].index();
  if (depth <= 0 || (depth & 1) == parity_)
  {
    return this->family(depth, inner, 0, 0);
  }
  const std::array<Coord, 3> index = indexOfEntry(path, depth, entry);
  const int above = entryOfIndex(path, depth - 1, ancestorOf(index, 1));
  return this->family(depth, inner, path.around(depth - 1)[above].index(), octantAbove(index, 0));
}

/// At the faces of the leaves among the children of the path's node, as far as it is not told by others.
double CornerValues::jumpAround(const TreePath& path) const noexcept
{
  const int depth = path.depth();
  const Family own = this->family(path, depth, 13);
  double jump = 0.;
  for (int face = 0; face < 6; ++face)
  {
    const int axis = face >> 1;
    const int entry = 13 + (face & 1 ? familyStride[axis] : -familyStride[axis]);
    const NodeRef node = path.around(depth)[entry];
    if (node.isNone() || (node.isInner() && !(face & 1)))
    {
      continue; // of two families the lower one sees the face
    }
    const int up = depth - node.depth();
    const std::array<Coord, 3> index = ancestorOf(indexOfEntry(path, depth, entry), up); // of a leaf
    const Family other = node.isInner()
      ? this->family(path, depth, entry)
      : this->family(path, node.depth() - 1, entryOfIndex(path, node.depth() - 1, ancestorOf(index, 1)));
    const int octant = octantAbove(index, 0);
    for (int i = 0; i < 9; ++i)
    {
      std::array<int, 3> at;
      at[axis] = 2 * (face & 1);
      at[(axis + 1) % 3] = i % 3;
      at[(axis + 2) % 3] = i / 3;
      const int vertex = at[0] + 3 * at[1] + 9 * at[2];
      int others = 0;
      bool isCorner = true; // of the other one
      for (int a = 0; a < 3; ++a)
      {
        if (node.isInner())
        {
          others += familyStride[a] * (a == axis ? 0 : at[a]);
          continue;
        }
        const Coord place =
          2 * path.index(depth)[a] + at[a] - (index[a] << (up + 1)); // from its lowest corner
        isCorner = isCorner && (place == 0 || place == Coord(2) << up);
        others += familyStride[a] * (sideOf(octant, a) + (place != 0));
      }
      if (isCorner && own.has(vertex) && other.has(others))
      {
        jump = std::max(jump, std::abs(static_cast<double>(own[vertex]) - other[others]));
      }
    }
  }
  return jump;
}

/// At a corner that hangs on no leaf larger than the children of the path's node at a depth: of one that is as large. Else
/// between these.
double CornerValues::constrained(const TreePath& path, int depth, int vertex, KnownCorners* levels) const
{
  KnownCorners& level = levels[depth];
  if (const std::uint64_t node = path.around(depth)[13].index(); level.node != node)
  {
    level.node = node;
    level.known = 0;
  }
  if (level.known >> vertex & 1)
  {
    return level.value[vertex];
  }
  const CornerPlace at = placeOfCorner(vertex);
  double value = 0.; // of no corner that a hanging one asks for
  if (touchesCoarser(path, depth, at))
  {
    const int count = forCoarserCorners(
      path, depth, at, [&](int coarser) { value += this->constrained(path, depth - 1, coarser, levels); });
    value /= count;
  }
  else
  {
    for (int side = 0; side < 8; ++side)
    {
      const ChildPlace cell(cellBeside(at, side));
      const NodeRef around = path.around(depth)[cell.entry];
      // What leaves of this size have there is theirs and stays as it is, while other threads change what hangs.
      if (around.isInner() && path.octree().child(around, cell.octant).isLeaf())
      {
        const int own = cornerOffset(cell.octant, familyStride) + cornerOffset(7 - side, familyStride);
        value = this->family(path, depth, cell.entry)[own];
        break;
      }
    }
  }
  level.known |= 1u << vertex;
  return level.value[vertex] = value;
}

/// Those that hang among the corners of the leaves that are children of the path's node; returns the largest change.
double CornerValues::constrain(const TreePath& path, KnownCorners* levels)
{
  const Family own = this->family(path, path.depth(), 13);
  double largest = 0.;
  for (int vertex = 0; vertex < 27; ++vertex)
  {
    if (own.has(vertex) && touchesCoarser(path, path.depth(), placeOfCorner(vertex)))
    {
      const auto value = static_cast<float>(this->constrained(path, path.depth(), vertex, levels));
      // Others may give the same value to the same corner.
      const std::atomic_ref kept(values_[own.place(vertex) - values_.data()]);
      if (const float before = kept.load(std::memory_order_relaxed); before != value)
      {
        largest = std::max(largest, std::abs(static_cast<double>(before) - value));
        kept.store(value, std::memory_order_relaxed);
      }
    }
  }
  return largest;
}

/// Of what f(path) gives for the nodes with leaves among their children.
template <class F>
double CornerValues::largestOfFamilies(const Octree& octree, const F& f)
{
  const int serialDepth = octree.grid().paddingDepth() + octree.leafLevels() - 4;
  tbb::combinable<double> largest([] { return 0.; });
  const auto visit = [&](const auto& self, TreePath& path) -> void {
    const Octree::Children children = octree.children(path.node().index());
    if (children.leaf != 0)
    {
      double& ofThread = largest.local();
      ofThread = std::max(ofThread, f(path));
    }
    if (path.depth() < serialDepth)
    {
      tbb::parallel_for(0, 8, [&](int octant) {
        if (children.inner() >> octant & 1)
        {
          TreePath own(path);
          own.descend(octant);
          self(self, own);
        }
      });
      return;
    }
    for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
    {
      path.descend(std::countr_zero(rest));
      self(self, path);
      path.ascend();
    }
  };
  if (octree.root().isInner())
  {
    TreePath path(octree);
    visit(visit, path);
  }
  return largest.combine([](double a, double b) { return std::max(a, b); });
}

} // namespace treeamr
