// Marching octants. The field is trilinear in each of the eight octants of a leaf and continuous, so loops of
// contour lines on the octants' faces, filled octant by octant, make a surface without cracks wherever both
// sides of a face have the same lines. Three rules see to that:
//
// - A vertex has one value, bit for bit, whichever block asks for it (BlockValues.h), and with it one side.
// - A face between octants of two sizes has the lines of the finer ones, who hand them to the coarser octant
//   (Transitions.h). A face between octants of one size has the same four values on both sides.
// - An edge may be part of a coarser octant's edge. The field is linear along that one: it has one crossing,
//   which goes by the name of the largest octant edge around and lies where the largest octant puts it. All
//   octants that meet at an edge are around each of its leaves, so every one finds the same name.
//
// Octants that join to a dual cell (DualCells.h) follow the same rules, with the dual cell as the coarser
// octant: the line between the centres of two leaves of one size is its edge. Leaves of a field that is given at their
// corners are whole pieces, and follow them as well.
//
// The coarser pieces are done last. Values that hang on a coarser face are rounded on their own, so a coarse
// edge may seem to cross its isovalue more than once: these crossings become one point, and the lines between
// them still form loops.
#include "Contour/Contour.h"

#include "Contour/BlockContour.h"
#include "Contour/MeshInterpolation.h"
#include "Contour/MortonSort.h"
#include "Error.h"
#include "Octree/TreePath.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>

namespace treeamr
{

namespace
{

/// Of the finest octants.
int octantDepth(const Octree& octree) noexcept
{
  return octree.grid().paddingDepth() + octree.leafLevels() + 1;
}

/// Part of the tree: below a node, or its leaves alone.
struct Task
{
  std::array<Coord, 3> index;
  int depth;
  bool subtree;
};

class Extraction
{
public:
  Extraction(const Field& field, double isovalue, const std::optional<LatticeBox>& box)
    : field_(field)
    , ranges_(field.nodeRanges())
    , octree_(field.octree())
    , isovalue_(isovalue)
    , subtreeDepth_(octree_.grid().paddingDepth() + octree_.leafLevels() - 4)
    , blocks_([=, &field] { return BlockContour(field, isovalue, box); })
  {
  }

  std::vector<Task> tasks() const
  {
    std::vector<Task> list;
    if (octree_.root().isInner())
    {
      TreePath place(octree_);
      collect(place, field_.range(), list);
    }
    else if (octree_.root().isLeaf() && field_.corners() && crosses(field_.range()))
    {
      list.push_back({ {}, -1, false });
    }
    return list;
  }

  void run(const Task& task, ContourPart& part)
  {
    TreePath place(octree_);
    Range range = field_.range();
    for (int depth = 1; depth <= task.depth; ++depth)
    {
      range = ranges_.of(place.node().index(), range);
      place.descend(octantAbove(task.index, task.depth - depth));
    }
    BlockContour& block = blocks_.local();
    if (task.depth < 0)
    {
      block.extractOnlyLeaf(part);
    }
    else if (task.subtree)
    {
      visit(place, range, block, part);
    }
    else
    {
      block.extract(place, part);
    }
  }

private:
  bool crosses(Range range) const noexcept { return range.min < isovalue_ && isovalue_ <= range.max; }

  void collect(TreePath& place, Range parent, std::vector<Task>& list) const
  {
    const Range range = ranges_.of(place.node().index(), parent);
    if (!crosses(range))
    {
      return;
    }
    const bool subtree = place.depth() >= subtreeDepth_;
    const Octree::Children children = octree_.children(place.node().index());
    if (subtree || children.leaf != 0)
    {
      list.push_back({ place.index(), place.depth(), subtree });
    }
    for (unsigned rest = subtree ? 0 : children.inner(); rest != 0; rest &= rest - 1)
    {
      place.descend(std::countr_zero(rest));
      collect(place, range, list);
      place.ascend();
    }
  }

  void visit(TreePath& place, Range parent, BlockContour& block, ContourPart& part) const
  {
    const Range range = ranges_.of(place.node().index(), parent);
    if (!crosses(range))
    {
      return;
    }
    const Octree::Children children = octree_.children(place.node().index());
    if (children.leaf != 0)
    {
      block.extract(place, part);
    }
    for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
    {
      place.descend(std::countr_zero(rest));
      visit(place, range, block, part);
      place.ascend();
    }
  }

  const Field& field_;
  const NodeRanges& ranges_;
  const Octree& octree_;
  double isovalue_;
  int subtreeDepth_;
  tbb::enumerable_thread_specific<BlockContour> blocks_;
};

/// The parts' points with one number for all of a crossing.
class PointNumbers
{
public:
  explicit PointNumbers(const std::vector<ContourPart>& parts)
  {
    first_.reserve(parts.size() + 1);
    first_.push_back(0);
    for (const ContourPart& part : parts)
    {
      first_.push_back(first_.back() + static_cast<std::int64_t>(part.points.size()));
    }
    numbers_.assign(first_.back(), 0);
  }

  std::int64_t first(std::size_t part) const noexcept { return first_[part]; }
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
auto concatenated(std::vector<ContourPart>& parts, Member member)
{
  std::vector<std::size_t> first{ 0 };
  for (const ContourPart& part : parts)
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
void mergeCrossings(int octantDepth, std::vector<SharedCrossing>& shared, PointNumbers& numbers)
{
  sortByPlace(shared, octantDepth + 2, [](const SharedCrossing& s) { return s.middle; });
  for (std::size_t i = 0, owner = 0; i < shared.size(); ++i)
  {
    if (i == owner || shared[i].middle != shared[owner].middle)
    {
      owner = i;
      continue;
    }
    numbers.merge(shared[i].point, shared[owner].point);
  }
  numbers.assign();
}

bool isDegenerate(const std::array<std::int64_t, 3>& triangle) noexcept
{
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// Puts a part's own points where the mesh has them, and keeps the blocks that have some.
void placePoints(const PointNumbers& numbers, std::int64_t first, ContourPart& part, ContourMesh& mesh)
{
  std::vector<ContourMesh::Block> blocks; // that have points of their own
  auto block = part.blocks.begin();
  for (std::size_t p = 0; p < part.points.size(); ++p)
  {
    const std::int64_t found = first + static_cast<std::int64_t>(p);
    if (!numbers.isOwn(found))
    {
      continue;
    }
    const std::int64_t number = numbers(found);
    mesh.points[number] = part.points[p];
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
}

/// Gives triangles and lines of a part the numbers of their points; whether a triangle has one of them twice.
bool placeTriangles(const PointNumbers& numbers, std::int64_t first, std::int64_t firstValue,
  ContourPart& part, std::array<std::int64_t, 3>* triangle)
{
  bool degenerate = false;
  for (const auto& points : part.triangles)
  {
    *triangle = { numbers(first + points[0]), numbers(first + points[1]), numbers(first + points[2]) };
    degenerate = isDegenerate(*triangle++) || degenerate;
  }
  part.triangles = {};
  for (TransitionLine& line : part.lines)
  {
    if (line.face == TransitionLine::valuesFace)
    {
      line.from += firstValue;
      continue;
    }
    for (std::int64_t* point : { &line.from, &line.to })
    {
      *point = *point == TransitionLine::none ? *point : numbers(first + *point);
    }
  }
  return degenerate;
}

/// Numbers the points of all parts, in their order, and empties the parts but for the lines and octants.
ContourMesh assemble(int octantDepth, std::vector<ContourPart>& parts)
{
  const auto forParts = [&](const auto& body) { tbb::parallel_for(std::size_t(0), parts.size(), body); };
  PointNumbers numbers(parts);
  forParts([&](std::size_t i) {
    for (SharedCrossing& s : parts[i].shared)
    {
      s.point += numbers.first(i);
    }
  });
  {
    auto shared = concatenated(parts, &ContourPart::shared);
    mergeCrossings(octantDepth, shared, numbers);
  }
  ContourMesh mesh;
  mesh.points.resize(numbers.count());
  forParts([&](std::size_t i) { placePoints(numbers, numbers.first(i), parts[i], mesh); });
  mesh.blocks = concatenated(parts, &ContourPart::blocks);

  std::vector<std::size_t> firstTriangle{ 0 };
  std::vector<std::int64_t> firstValues{ 0 };
  for (const ContourPart& part : parts)
  {
    firstValues.push_back(firstValues.back() + static_cast<std::int64_t>(part.values.size()));
    firstTriangle.push_back(firstTriangle.back() + part.triangles.size());
  }
  mesh.triangles.resize(firstTriangle.back());
  std::atomic<bool> degenerate{ false };
  forParts([&](std::size_t i) {
    if (placeTriangles(
          numbers, numbers.first(i), firstValues[i], parts[i], mesh.triangles.data() + firstTriangle[i]))
    {
      degenerate = true;
    }
  });
  if (degenerate)
  {
    std::erase_if(mesh.triangles, isDegenerate);
  }
  return mesh;
}

/// Those of pieces that others own.
void removeUnusedPoints(ContourMesh& mesh)
{
  std::vector<std::int64_t> numbers(
    mesh.points.size() + 1, 0); // 1 for those that are used, then how many come before
  for (const auto& triangle : mesh.triangles)
  {
    for (const std::int64_t point : triangle)
    {
      numbers[point] = 1;
    }
  }
  std::int64_t count = 0;
  for (std::size_t p = 0; p < numbers.size(); ++p)
  {
    const bool isUsed = numbers[p] != 0;
    numbers[p] = count;
    if (isUsed)
    {
      mesh.points[count++] = mesh.points[p];
    }
  }
  mesh.points.resize(count);
  for (auto& triangle : mesh.triangles)
  {
    for (std::int64_t& point : triangle)
    {
      point = numbers[point];
    }
  }
  std::size_t kept = 0;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    ContourMesh::Block block = mesh.blocks[b];
    const std::int64_t end = b + 1 < mesh.blocks.size() ? numbers[mesh.blocks[b + 1].firstPoint] : count;
    block.firstPoint = numbers[block.firstPoint];
    if (block.firstPoint < end)
    {
      mesh.blocks[kept++] = block;
    }
  }
  mesh.blocks.resize(kept);
}

} // namespace

ContourMesh contour(const Field& field, double isovalue, const ContourOptions& options)
{
  if (!std::isfinite(isovalue))
  {
    throw Error("contour: isovalue " + std::to_string(isovalue) + ", allowed are finite values");
  }
  const auto goesOn = [&](double done) { return !options.progress || options.progress(done); };
  Extraction extraction(field, field.stored(isovalue), options.box);
  const std::vector<Task> tasks = extraction.tasks();
  std::vector<ContourPart> parts(tasks.size());
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
  ContourMesh mesh = assemble(octantDepth(field.octree()), parts);
  auto lines = concatenated(parts, &ContourPart::lines);
  const auto values = concatenated(parts, &ContourPart::values);
  closeTransitions(field.octree().grid(), octantDepth(field.octree()), options.box, lines, values, mesh);
  if (options.box)
  {
    removeUnusedPoints(mesh);
  }
  mesh.octree = field.octree().identity();
  if (options.gradients)
  {
    mesh.gradients = interpolateGradients(field, mesh);
  }
  return goesOn(1.) ? std::move(mesh) : ContourMesh{};
}

} // namespace treeamr
