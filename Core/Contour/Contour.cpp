// Marching octants. The field is trilinear in each of the eight octants of a leaf and continuous, so loops of
// contour lines on the octants' faces, filled octant by octant, make a surface without cracks wherever both
// sides of a face have the same lines. Three rules see to that:
//
// - A vertex has one value, bit for bit, whichever block asks for it (BlockValues.h), and with it one side.
// - A face between octants of two sizes has the lines of the finer ones, who hand them to the coarser octant
//   (Transitions.h). A face between octants of one size has the same four values on both sides.
// - An edge may be part of a coarser octant's edge. The field is linear along that one: it has one crossing, which
//   goes by the name of the largest octant edge around and lies where the largest octant puts it. All octants that
//   meet at an edge are around each of its leaves, so every one finds the same name.
//
// The coarser octants are done last. Values that hang on a coarser face are rounded on their own, so a coarse
// edge may seem to cross its isovalue more than once: these crossings become one point, and the lines between
// them still form loops.
#include "Contour/Contour.h"

#include "Contour/Octant.h"
#include "Contour/Transitions.h"
#include "Error.h"
#include "Interpolation/BlockValues.h"
#include "Octree/TreePath.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>

namespace treeamr
{

namespace
{

/// A crossing that other blocks may find, too.
struct SharedCrossing
{
  std::array<Coord, 3> middle; // of the largest edge, which it names, in half widths of the finest octants
  int size; // of the edge on which it was found: log2 of its length over the finest octants'
  std::int64_t point;

  /// Crossings of one edge follow each other, those of the largest octants first.
  bool operator<(const SharedCrossing& other) const noexcept
  {
    if (middle != other.middle)
    {
      return middle < other.middle;
    }
    return size != other.size ? size > other.size : point < other.point;
  }
};

/// What one task finds; points count from 0 in each.
struct Part
{
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<float, 4>> gradients; // sums and the number of summands
  std::vector<SharedCrossing> shared;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<TransitionLine> lines;
  std::vector<TransitionOctant> transitions;
  std::vector<ContourMesh::Block> blocks;
};

/// World coordinates per axis of the five planes of a block's octants; those beyond the domain lie at its end.
using BlockPlanes = std::array<std::array<double, 5>, 3>;

BlockPlanes blockPlanes(const RootGrid& grid, const std::array<Coord, 3>& index, int depth) noexcept
{
  const int level = depth + 2 - grid.paddingDepth(); // of the octants
  BlockPlanes planes;
  for (int a = 0; a < 3; ++a)
  {
    for (int i = 0; i < 5; ++i)
    {
      planes[a][i] = grid.worldPlane(a, std::min(4 * index[a] + i, Coord(grid.roots()[a]) << level), level);
    }
  }
  return planes;
}

/// A leaf with neighbours of other sizes among the 26 around it.
struct LeafPlace
{
  int octant; // in the block
  bool ghost;
  std::uint32_t inner;             // masks of entries of its neighbourhood: refined,
  std::uint32_t coarse;            // parts of coarser leaves,
  std::uint32_t ghosts;            // and of these, ghosts
  std::array<std::uint8_t, 27> up; // levels to the coarse
};

class BlockContour
{
public:
  BlockContour(const Field& field, double isovalue, bool gradients)
    : octree_(field.octree())
    , isovalue_(isovalue)
    , gradients_(gradients)
    , finestDepth_(octree_.grid().paddingDepth() + octree_.leafLevels() + 1)
    , evaluator_(field)
  {
  }

  /// Of the leaves among the children of the inner node at the paths' ends.
  void extract(TreePath& path, const BlockPath& blockPath, Part& part)
  {
    evaluator_.compute(blockPath, BlockCells::Leaves, block_);
    if (!(block_.range.min < isovalue_ && isovalue_ <= block_.range.max))
    {
      return;
    }
    markInside();
    const Octree::Children children = octree_.children(path.node().index());
    started_ = false;
    for (unsigned rest = children.leaf; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      if (crossesLeaf(octant))
      {
        if (!started_)
        {
          start(path, children, part);
        }
        extractLeaf(path, octant, part);
      }
    }
    if (started_ && static_cast<std::int64_t>(part.points.size()) == part.blocks.back().firstPoint)
    {
      part.blocks.pop_back();
    }
  }

private:
  void markInside() noexcept
  {
    for (int row = 0; row < 25; ++row)
    {
      unsigned mask = 0;
      for (int x = 0; x < 5; ++x)
      {
        mask |= static_cast<unsigned>(block_.values[5 * row + x] >= isovalue_) << x;
      }
      inside_[row] = static_cast<std::uint8_t>(mask);
    }
  }

  bool crossesLeaf(int octant) const noexcept
  {
    const int x = 2 * (octant & 1);
    const int row = 2 * (octant >> 1 & 1) + 10 * (octant >> 2);
    unsigned any = 0;
    unsigned all = 7;
    for (int i = 0; i < 9; ++i)
    {
      const unsigned bits = inside_[row + i % 3 + 5 * (i / 3)] >> x;
      any |= bits;
      all &= bits;
    }
    return (any & 7) != 0 && (all & 7) != 7;
  }

  void start(const TreePath& path, const Octree::Children& children, Part& part)
  {
    started_ = true;
    pointOfEdge_.fill(-1);
    alone_ = children.inner() == 0;
    depth_ = path.depth() + 2; // of the octants
    plane_ = blockPlanes(octree_.grid(), path.index(), path.depth());
    for (int a = 0; a < 3; ++a)
    {
      base_[a] = 4 * path.index()[a];
    }
    part.blocks.push_back({ path.index(), path.depth(), static_cast<std::int64_t>(part.points.size()) });
  }

  void extractLeaf(TreePath& path, int octant, Part& part)
  {
    path.descend(octant);
    const int depth = path.depth();
    LeafPlace leaf{ octant, octree_.isGhost(path.node().index()), 0, 0, 0, {} };
    const Neighbourhood& around = path.around(depth);
    for (int e = 0; e < 27; ++e)
    {
      const NodeRef node = around[e];
      leaf.inner |= static_cast<std::uint32_t>(node.isInner()) << e;
      if (node.isLeaf() && node.depth() < depth)
      {
        leaf.coarse |= 1u << e;
        leaf.ghosts |= static_cast<std::uint32_t>(octree_.isGhost(node.index())) << e;
        leaf.up[e] = static_cast<std::uint8_t>(depth - node.depth());
      }
    }
    path.ascend();
    for (int o = 0; o < 8; ++o)
    {
      std::array<int, 3> place;
      for (int a = 0; a < 3; ++a)
      {
        place[a] = 2 * (octant >> a & 1) + (o >> a & 1);
      }
      const std::uint8_t* row = inside_.data() + place[1] + 5 * place[2];
      const auto pair = [&](int i) { return static_cast<unsigned>(row[i] >> place[0] & 3); };
      const unsigned inside = pair(0) | pair(1) << 2 | pair(5) << 4 | pair(6) << 6;
      if (inside != 0 && inside != 0xff)
      {
        extractOctant(leaf, place, inside, part);
      }
    }
  }

  void extractOctant(const LeafPlace& leaf, const std::array<int, 3>& place, unsigned inside, Part& part)
  {
    const int base = place[0] + 5 * place[1] + 25 * place[2];
    for (int c = 0; c < 8; ++c)
    {
      values_[c] = block_.values[base + (c & 1) + 5 * (c >> 1 & 1) + 25 * (c >> 2)] - isovalue_;
    }
    unsigned finer = 0; // masks of faces: towards finer octants
    unsigned coarser = 0;
    if ((leaf.inner | leaf.coarse) != 0)
    {
      for (int f = 0; f < 6; ++f)
      {
        const std::uint32_t entry = 1u << entryOfFace(f);
        const bool onBoundary = (place[f >> 1] & 1) == (f & 1);
        finer |= static_cast<unsigned>(onBoundary && (leaf.inner & entry) != 0) << f;
        coarser |= static_cast<unsigned>(onBoundary && (leaf.coarse & ~leaf.ghosts & entry) != 0) << f;
      }
    }
    if (gradients_)
    {
      addGradients(leaf, place, inside, leaf.ghost ? coarser : allFaces, part);
    }
    if (leaf.ghost)
    {
      for (int f = 0; f < 6; ++f)
      {
        if (coarser >> f & 1)
        {
          handToCoarser(leaf, place, f, faceSegments(f, inside, values_), part);
        }
      }
      return;
    }
    const OctantKey key{ depth_, { base_[0] + place[0], base_[1] + place[1], base_[2] + place[2] } };
    if (finer != 0)
    {
      part.transitions.push_back({ key, values_ });
    }
    std::array<std::int8_t, 12> next;
    next.fill(-1);
    for (int f = 0; f < 6; ++f)
    {
      if (finer >> f & 1)
      {
        askFiner(leaf, place, f, inside, key, part);
        continue;
      }
      const FaceSegments segments = faceSegments(f, inside, values_);
      for (int i = 0; i < segments.count; ++i)
      {
        next[segments.from[i]] = static_cast<std::int8_t>(segments.to[i]);
        if (finer != 0)
        {
          part.lines.push_back({ key, TransitionLine::ownFace, pointOn(leaf, place, segments.from[i], part),
            pointOn(leaf, place, segments.to[i], part) });
        }
      }
      if (coarser >> f & 1)
      {
        handToCoarser(leaf, place, f, segments, part);
      }
    }
    if (finer == 0)
    {
      fillLoops(leaf, place, next, part);
    }
  }

  static constexpr unsigned allFaces = 0x3f;

  static constexpr int entryOfFace(int face)
  {
    constexpr std::array<int, 3> stride{ 1, 3, 9 };
    return 13 + (face & 1 ? stride[face >> 1] : -stride[face >> 1]);
  }

  void handToCoarser(const LeafPlace& leaf, const std::array<int, 3>& place, int face,
    const FaceSegments& segments, Part& part)
  {
    const int up = leaf.up[entryOfFace(face)];
    OctantKey key{ depth_ - up, {} };
    for (int a = 0; a < 3; ++a)
    {
      const int beside = a != face >> 1 ? 0 : face & 1 ? 1 : -1;
      key.index[a] = (base_[a] + place[a] + beside) >> up;
    }
    for (int i = 0; i < segments.count; ++i)
    {
      // Seen from the other side.
      part.lines.push_back({ key, face ^ 1, pointOn(leaf, place, segments.to[i], part),
        pointOn(leaf, place, segments.from[i], part) });
    }
  }

  /// Where lines that come from the finer side must begin and end.
  void askFiner(const LeafPlace& leaf, const std::array<int, 3>& place, int face, unsigned inside,
    const OctantKey& key, Part& part)
  {
    const OctantTables::Face& f = octantTables.face[face];
    for (int i = 0; i < 4; ++i)
    {
      const bool first = inside >> f.corner[i] & 1;
      const bool second = inside >> f.corner[(i + 1) % 4] & 1;
      if (first != second)
      {
        const std::int64_t point = pointOn(leaf, place, f.edge[i], part);
        part.lines.push_back(
          { key, face, second ? point : TransitionLine::none, second ? TransitionLine::none : point });
      }
    }
  }

  int edgeSlot(const std::array<int, 3>& place, int edge) const noexcept
  {
    const OctantTables::Edge& e = octantTables.edge[edge];
    return 125 * e.axis + place[0] + (e.low & 1) + 5 * (place[1] + (e.low >> 1 & 1)) +
      25 * (place[2] + (e.low >> 2));
  }

  std::array<double, 3> localPoint(int edge) const noexcept
  {
    const OctantTables::Edge& e = octantTables.edge[edge];
    std::array<double, 3> p{ double(e.low & 1), double(e.low >> 1 & 1), double(e.low >> 2) };
    p[e.axis] = crossing(values_, edge);
    return p;
  }

  std::uint32_t addPoint(const std::array<int, 3>& place, const std::array<double, 3>& local, Part& part)
  {
    std::array<double, 3> p;
    for (int a = 0; a < 3; ++a)
    {
      const double low = plane_[a][place[a]];
      const double high = plane_[a][place[a] + 1];
      p[a] = local[a] == 1. ? high : low + local[a] * (high - low);
    }
    part.points.push_back(p);
    if (gradients_)
    {
      part.gradients.push_back({});
    }
    return static_cast<std::uint32_t>(part.points.size() - 1);
  }

  /// The point on an edge of an octant with the current values.
  std::uint32_t pointOn(const LeafPlace& leaf, const std::array<int, 3>& place, int edge, Part& part)
  {
    std::int32_t& known = pointOfEdge_[edgeSlot(place, edge)];
    if (known < 0)
    {
      known = static_cast<std::int32_t>(addPoint(place, localPoint(edge), part));
      nameCrossing(leaf, place, edge, known, part);
    }
    return static_cast<std::uint32_t>(known);
  }

  void nameCrossing(
    const LeafPlace& leaf, const std::array<int, 3>& place, int edge, std::int64_t point, Part& part) const
  {
    const OctantTables::Edge& e = octantTables.edge[edge];
    std::array<int, 3> low;    // end, in the block
    std::array<int, 3> step{}; // to the entries beside the edge, 0 where it is inside the leaf
    bool inBlock = alone_;
    constexpr std::array<int, 3> stride{ 1, 3, 9 };
    for (int a = 0; a < 3; ++a)
    {
      const int side = e.low >> a & 1;
      low[a] = place[a] + side;
      if (a != e.axis)
      {
        inBlock = inBlock && low[a] != 0 && low[a] != 4;
        step[a] = (place[a] & 1) != side ? 0 : side ? stride[a] : -stride[a];
      }
    }
    if (inBlock)
    {
      return;
    }
    const int b = (e.axis + 1) % 3;
    const int c = (e.axis + 2) % 3;
    int up = 0;
    if (leaf.coarse != 0)
    {
      for (const int entry : { 13 + step[b], 13 + step[c], 13 + step[b] + step[c] })
      {
        const int more = leaf.up[entry];
        const Coord rest = (Coord(1) << more) - 1;
        if ((leaf.coarse >> entry & 1) && (((base_[b] + low[b]) | (base_[c] + low[c])) & rest) == 0)
        {
          up = std::max(up, more);
        }
      }
    }
    SharedCrossing shared;
    shared.size = finestDepth_ - depth_;
    for (int a = 0; a < 3; ++a)
    {
      const Coord at = base_[a] + low[a];
      shared.middle[a] = a == e.axis ? (2 * (at >> up) + 1) << (up + shared.size) : at << (1 + shared.size);
    }
    shared.point = point;
    part.shared.push_back(shared);
  }

  /// At the octant's points on some of its faces.
  void addGradients(
    const LeafPlace& leaf, const std::array<int, 3>& place, unsigned inside, unsigned faces, Part& part)
  {
    for (int e = 0; e < 12; ++e)
    {
      const OctantTables::Edge& edge = octantTables.edge[e];
      if ((edge.faces & faces) != 0 && (inside >> edge.low & 1) != (inside >> edge.high & 1))
      {
        addGradient(place, localPoint(e), part.gradients[pointOn(leaf, place, e, part)]);
      }
    }
  }

  void addGradient(
    const std::array<int, 3>& place, const std::array<double, 3>& local, std::array<float, 4>& sum) const
  {
    const std::array<double, 3> gradient = trilinearGradient(values_, local);
    for (int a = 0; a < 3; ++a)
    {
      sum[a] += static_cast<float>(gradient[a] / (plane_[a][place[a] + 1] - plane_[a][place[a]]));
    }
    sum[3] += 1.f;
  }

  void fillLoops(
    const LeafPlace& leaf, const std::array<int, 3>& place, std::array<std::int8_t, 12>& next, Part& part)
  {
    for (int first = 0; first < 12; ++first)
    {
      if (next[first] < 0)
      {
        continue;
      }
      std::array<int, 12> loop;
      int count = 0;
      for (int e = first; next[e] >= 0;)
      {
        loop[count++] = e;
        const int to = next[e];
        next[e] = -1;
        e = to;
      }
      fillLoop(leaf, place, loop, count, part);
    }
  }

  void fillLoop(const LeafPlace& leaf, const std::array<int, 3>& place, const std::array<int, 12>& loop,
    int count, Part& part)
  {
    std::array<std::uint32_t, 12> points;
    for (int i = 0; i < count; ++i)
    {
      points[i] = pointOn(leaf, place, loop[i], part);
    }
    if (count == 3)
    {
      part.triangles.push_back({ points[0], points[1], points[2] });
      return;
    }
    std::array<std::array<double, 3>, 12> local;
    for (int i = 0; i < count; ++i)
    {
      local[i] = localPoint(loop[i]);
    }
    const int apex = fanApex(loop, local, count);
    if (apex >= 0)
    {
      for (int i = 1; i + 1 < count; ++i)
      {
        part.triangles.push_back(
          { points[apex], points[(apex + i) % count], points[(apex + i + 1) % count] });
      }
      return;
    }
    const std::array<double, 3> centre = loopCentre(values_, local.data(), count);
    const std::uint32_t point = addPoint(place, centre, part);
    if (gradients_)
    {
      addGradient(place, centre, part.gradients[point]);
    }
    for (int i = 0; i < count; ++i)
    {
      part.triangles.push_back({ points[i], points[(i + 1) % count], point });
    }
  }

  /// The point from which the diagonals are shortest; none may lie on a face, where the neighbour could have the
  /// same. -1: from every point one does.
  static int fanApex(
    const std::array<int, 12>& loop, const std::array<std::array<double, 3>, 12>& local, int count) noexcept
  {
    int best = -1;
    double shortest = 0.;
    for (int apex = 0; apex < count; ++apex)
    {
      double sum = 0.;
      bool allowed = true;
      for (int i = 2; i + 1 < count; ++i)
      {
        const int other = (apex + i) % count;
        allowed =
          allowed && (octantTables.edge[loop[apex]].faces & octantTables.edge[loop[other]].faces) == 0;
        for (int a = 0; a < 3; ++a)
        {
          const double d = local[apex][a] - local[other][a];
          sum += d * d;
        }
      }
      if (allowed && (best < 0 || sum < shortest))
      {
        best = apex;
        shortest = sum;
      }
    }
    return best;
  }

  const Octree& octree_;
  double isovalue_;
  bool gradients_;
  int finestDepth_; // of octants
  BlockEvaluator evaluator_;

  // Of the current block.
  BlockValues block_;
  std::array<std::uint8_t, 25> inside_; // a bit per vertex, row after row
  bool started_;
  bool alone_; // no child is refined: edges inside belong to no other block
  int depth_;  // of the octants' lattice
  std::array<Coord, 3> base_;
  BlockPlanes plane_;
  std::array<std::int32_t, 375> pointOfEdge_; // axis by axis by lower end; -1: none yet

  OctantValues values_; // of the current octant
};

/// That leads down to the node `up` levels above a place.
int octantOf(const std::array<Coord, 3>& index, int up) noexcept
{
  return static_cast<int>((index[0] >> up & 1) | (index[1] >> up & 1) << 1 | (index[2] >> up & 1) << 2);
}

/// Part of the tree: below a node, or its leaves alone.
struct Task
{
  std::array<Coord, 3> index;
  int depth;
  bool subtree;
};

/// Where a walk is, for both kinds of neighbourhoods.
struct Place
{
  TreePath path;
  BlockPath blockPath;

  explicit Place(const Octree& octree)
    : path(octree)
  {
  }
  void descend(int octant) noexcept
  {
    path.descend(octant);
    blockPath.descend(octant, path.node().index());
  }
  void ascend() noexcept
  {
    path.ascend();
    blockPath.ascend();
  }
};

class Extraction
{
public:
  Extraction(const Field& field, double isovalue, bool gradients)
    : field_(field)
    , octree_(field.octree())
    , isovalue_(isovalue)
    , subtreeDepth_(octree_.grid().paddingDepth() + octree_.leafLevels() - 4)
    , blocks_([=, &field] { return BlockContour(field, isovalue, gradients); })
  {
  }

  std::vector<Task> tasks() const
  {
    std::vector<Task> list;
    if (octree_.root().isInner())
    {
      Place place(octree_);
      collect(place, field_.range(), list);
    }
    return list;
  }

  void run(const Task& task, Part& part)
  {
    Place place(octree_);
    Range range = field_.range();
    for (int depth = 1; depth <= task.depth; ++depth)
    {
      range = field_.nodeRange(place.path.node(), range);
      place.descend(octantOf(task.index, task.depth - depth));
    }
    BlockContour& block = blocks_.local();
    if (task.subtree)
    {
      visit(place, range, block, part);
    }
    else
    {
      block.extract(place.path, place.blockPath, part);
    }
  }

private:
  bool crosses(Range range) const noexcept { return range.min < isovalue_ && isovalue_ <= range.max; }

  void collect(Place& place, Range parent, std::vector<Task>& list) const
  {
    const Range range = field_.nodeRange(place.path.node(), parent);
    if (!crosses(range))
    {
      return;
    }
    const bool subtree = place.path.depth() >= subtreeDepth_;
    const Octree::Children children = octree_.children(place.path.node().index());
    if (subtree || children.leaf != 0)
    {
      list.push_back({ place.path.index(), place.path.depth(), subtree });
    }
    for (unsigned rest = subtree ? 0 : children.inner(); rest != 0; rest &= rest - 1)
    {
      place.descend(std::countr_zero(rest));
      collect(place, range, list);
      place.ascend();
    }
  }

  void visit(Place& place, Range parent, BlockContour& block, Part& part) const
  {
    const Range range = field_.nodeRange(place.path.node(), parent);
    if (!crosses(range))
    {
      return;
    }
    const Octree::Children children = octree_.children(place.path.node().index());
    if (children.leaf != 0)
    {
      block.extract(place.path, place.blockPath, part);
    }
    for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
    {
      place.descend(std::countr_zero(rest));
      visit(place, range, block, part);
      place.ascend();
    }
  }

  const Field& field_;
  const Octree& octree_;
  double isovalue_;
  int subtreeDepth_;
  tbb::enumerable_thread_specific<BlockContour> blocks_;
};

/// The parts' points with one number for all of a crossing.
class PointNumbers
{
public:
  explicit PointNumbers(const std::vector<Part>& parts)
  {
    first_.reserve(parts.size() + 1);
    first_.push_back(0);
    for (const Part& part : parts)
    {
      first_.push_back(first_.back() + static_cast<std::int64_t>(part.points.size()));
    }
    numbers_.assign(first_.back(), 0);
  }

  std::int64_t first(std::size_t part) const noexcept { return first_[part]; }
  std::int64_t found() const noexcept { return first_.back(); }
  std::int64_t count() const noexcept { return count_; }
  bool isOwn(std::int64_t point) const noexcept { return numbers_[point] >= 0; }
  /// Before assign().
  void merge(std::int64_t point, std::int64_t into) noexcept { numbers_[point] = ~into; }
  void assign() noexcept
  {
    for (std::int64_t& number : numbers_)
    {
      if (number >= 0)
      {
        number = count_++;
      }
    }
  }
  std::int64_t operator()(std::int64_t point) const noexcept
  {
    const std::int64_t number = numbers_[point];
    return number >= 0 ? number : numbers_[~number];
  }

private:
  std::vector<std::int64_t> first_;   // by part, and the end
  std::vector<std::int64_t> numbers_; // the point's own, or ~ the point that stands for it
  std::int64_t count_ = 0;
};

template <class Member>
auto concatenated(std::vector<Part>& parts, Member member)
{
  std::vector<std::size_t> first{ 0 };
  for (const Part& part : parts)
  {
    first.push_back(first.back() + (part.*member).size());
  }
  std::remove_reference_t<decltype(parts[0].*member)> all(first.back());
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t i) {
    auto& from = parts[i].*member;
    std::copy(from.begin(), from.end(), all.begin() + static_cast<std::ptrdiff_t>(first[i]));
    from = {};
  });
  return all;
}

/// Joins what all parts say about one crossing.
void mergeCrossings(
  std::vector<SharedCrossing>& shared, PointNumbers& numbers, std::vector<std::array<float, 4>>& gradients)
{
  tbb::parallel_sort(shared.begin(), shared.end());
  for (std::size_t i = 0, owner = 0; i < shared.size(); ++i)
  {
    if (i == owner || shared[i].middle != shared[owner].middle)
    {
      owner = i;
      continue;
    }
    numbers.merge(shared[i].point, shared[owner].point);
    for (int a = 0; !gradients.empty() && a < 4; ++a)
    {
      gradients[shared[owner].point][a] += gradients[shared[i].point][a];
    }
  }
  numbers.assign();
}

/// Trilinear between a block's vertices. Just beside the octant that a point belongs to, where rounding may put
/// it, the others' vertices weigh next to nothing.
float interpolateIn(
  const BlockValues& block, const BlockPlanes& planes, const std::array<double, 3>& pWorld) noexcept
{
  int base = 0;
  std::array<double, 3> local;
  constexpr std::array<int, 3> stride{ 1, 5, 25 };
  for (int a = 0; a < 3; ++a)
  {
    const std::array<double, 5>& plane = planes[a];
    int low = 0;
    while (low < 3 && pWorld[a] >= plane[low + 1] && plane[low + 2] > plane[low + 1])
    {
      ++low;
    }
    base += stride[a] * low;
    local[a] = std::clamp((pWorld[a] - plane[low]) / (plane[low + 1] - plane[low]), 0., 1.);
  }
  OctantValues corners;
  for (int c = 0; c < 8; ++c)
  {
    corners[c] = block.values[base + (c & 1) + 5 * (c >> 1 & 1) + 25 * (c >> 2)];
  }
  return static_cast<float>(trilinear(corners, local));
}

bool isDegenerate(const std::array<std::int64_t, 3>& triangle) noexcept
{
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// Numbers the points of all parts, in their order, and empties the parts but for the lines and octants.
ContourMesh assemble(std::vector<Part>& parts)
{
  const auto forParts = [&](const auto& body) { tbb::parallel_for(std::size_t(0), parts.size(), body); };
  PointNumbers numbers(parts);
  forParts([&](std::size_t i) {
    for (SharedCrossing& s : parts[i].shared)
    {
      s.point += numbers.first(i);
    }
  });
  auto sums = concatenated(parts, &Part::gradients);
  {
    auto shared = concatenated(parts, &Part::shared);
    mergeCrossings(shared, numbers, sums);
  }
  ContourMesh mesh;
  mesh.points.resize(numbers.count());
  mesh.gradients.resize(sums.empty() ? 0 : numbers.count());
  forParts([&](std::size_t i) {
    Part& part = parts[i];
    std::vector<ContourMesh::Block> blocks; // that have points of their own
    auto block = part.blocks.begin();
    for (std::size_t p = 0; p < part.points.size(); ++p)
    {
      const std::int64_t found = numbers.first(i) + static_cast<std::int64_t>(p);
      if (!numbers.isOwn(found))
      {
        continue;
      }
      const std::int64_t number = numbers(found);
      mesh.points[number] = part.points[p];
      for (int a = 0; !sums.empty() && a < 3; ++a)
      {
        mesh.gradients[number][a] = sums[found][a] / sums[found][3];
      }
      bool isFirst = blocks.empty();
      while (block + 1 != part.blocks.end() && (block + 1)->firstPoint <= static_cast<std::int64_t>(p))
      {
        ++block;
        isFirst = true;
      }
      if (isFirst)
      {
        blocks.push_back({ block->index, block->depth, number });
      }
    }
    part.blocks = std::move(blocks);
    part.points = {};
  });
  mesh.blocks = concatenated(parts, &Part::blocks);

  std::vector<std::size_t> firstTriangle{ 0 };
  for (const Part& part : parts)
  {
    firstTriangle.push_back(firstTriangle.back() + part.triangles.size());
  }
  mesh.triangles.resize(firstTriangle.back());
  std::atomic<bool> degenerate{ false };
  forParts([&](std::size_t i) {
    Part& part = parts[i];
    const std::int64_t first = numbers.first(i);
    auto* triangle = mesh.triangles.data() + firstTriangle[i];
    for (const auto& points : part.triangles)
    {
      *triangle = { numbers(first + points[0]), numbers(first + points[1]), numbers(first + points[2]) };
      if (isDegenerate(*triangle++))
      {
        degenerate = true;
      }
    }
    part.triangles = {};
    for (TransitionLine& line : part.lines)
    {
      for (std::int64_t* point : { &line.from, &line.to })
      {
        *point = *point == TransitionLine::none ? *point : numbers(first + *point);
      }
    }
  });
  if (degenerate)
  {
    std::erase_if(mesh.triangles, isDegenerate);
  }
  return mesh;
}

} // namespace

ContourMesh contour(const Field& field, double isovalue, const ContourOptions& options)
{
  if (!std::isfinite(isovalue))
  {
    throw Error("contour: isovalue " + std::to_string(isovalue) + ", allowed are finite values");
  }
  if (!field.hasNodeRanges())
  {
    throw Error("contour: the field has no node ranges to find the surface by");
  }
  const auto goesOn = [&](double done) { return !options.progress || options.progress(done); };
  Extraction extraction(field, isovalue, options.gradients);
  const std::vector<Task> tasks = extraction.tasks();
  std::vector<Part> parts(tasks.size());
  constexpr std::size_t steps = 8;
  for (std::size_t step = 0; step < steps; ++step)
  {
    tbb::parallel_for(step * tasks.size() / steps, (step + 1) * tasks.size() / steps,
      [&](std::size_t i) { extraction.run(tasks[i], parts[i]); });
    if (!goesOn(0.8 * static_cast<double>(step + 1) / steps))
    {
      return {};
    }
  }
  ContourMesh mesh = assemble(parts);
  auto lines = concatenated(parts, &Part::lines);
  auto octants = concatenated(parts, &Part::transitions);
  closeTransitions(field.octree().grid(), lines, octants, mesh);
  return goesOn(1.) ? std::move(mesh) : ContourMesh{};
}

std::vector<float> interpolate(const Field& field, const ContourMesh& mesh)
{
  const Octree& octree = field.octree();
  std::vector<float> values(mesh.points.size());
  tbb::enumerable_thread_specific<BlockEvaluator> evaluators([&field] { return BlockEvaluator(field); });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.blocks.size(), 64), [&](const auto& range) {
    BlockEvaluator& evaluator = evaluators.local();
    for (std::size_t b = range.begin(); b != range.end(); ++b)
    {
      const ContourMesh::Block& block = mesh.blocks[b];
      BlockPath path;
      for (int up = block.depth - 1; up >= 0; --up)
      {
        const int octant = octantOf(block.index, up);
        path.descend(octant, octree.children(path.node[path.depth]).innerIndex(octant));
      }
      BlockValues vertices;
      evaluator.compute(path, BlockCells::Leaves, vertices);
      const BlockPlanes planes = blockPlanes(octree.grid(), block.index, block.depth);
      const std::size_t end =
        b + 1 < mesh.blocks.size() ? static_cast<std::size_t>(mesh.blocks[b + 1].firstPoint) : values.size();
      for (auto p = static_cast<std::size_t>(block.firstPoint); p < end; ++p)
      {
        values[p] = interpolateIn(vertices, planes, mesh.points[p]);
      }
    }
  });
  return values;
}

} // namespace treeamr
