#include "HyperTreeGridBuilder.h"

#include "Error.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <utility>

namespace treeamr
{

void setLattice(vtkHyperTreeGrid* grid, const std::array<std::vector<double>, 3>& allPlanes)
{
  checkRootCount(allPlanes, {});
  std::array<vtkSmartPointer<vtkDoubleArray>, 3> coordinates;
  std::array<unsigned int, 3> points;
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::vector<double>& planes = allPlanes[axis];
    points[axis] = static_cast<unsigned int>(planes.size());
    coordinates[axis] = vtkSmartPointer<vtkDoubleArray>::New();
    coordinates[axis]->SetNumberOfValues(static_cast<vtkIdType>(planes.size()));
    std::ranges::copy(planes, coordinates[axis]->GetPointer(0));
  }
  grid->SetBranchFactor(2);
  grid->SetDimensions(points.data());
  grid->SetXCoordinates(coordinates[0]);
  grid->SetYCoordinates(coordinates[1]);
  grid->SetZCoordinates(coordinates[2]);
}

HyperTreeGridBuilder::HyperTreeGridBuilder(vtkHyperTreeGrid* grid, const TreeLattice& lattice,
  const std::vector<std::uint64_t>& nodeCounts, std::string source)
  : grid_(grid)
  , lattice_(lattice)
  , childCount_(1 << lattice.dimension())
  , source_(std::move(source))
  , treeStarts_(1, 0)
{
  treeStarts_.reserve(nodeCounts.size() + 1);
  for (const std::uint64_t nodes : nodeCounts)
  {
    constexpr std::uint64_t maxNodes = std::numeric_limits<unsigned int>::max();
    if (nodes > maxNodes)
    {
      throw Error(source_ + ": tree " + std::to_string(treeStarts_.size() - 1) + ": " +
        std::to_string(nodes) + " nodes, allowed " + std::to_string(maxNodes) +
        ", the most of a vtkHyperTree");
    }
    treeStarts_.push_back(treeStarts_.back() + static_cast<vtkIdType>(nodes));
  }
  setLattice(grid, lattice.planes());
}

HyperTreeGridBuilder::~HyperTreeGridBuilder() = default;

void HyperTreeGridBuilder::addArray(std::unique_ptr<CellArrayFiller> filler)
{
  grid_->GetCellData()->AddArray(filler->array());
  if (fillers_.empty())
  {
    grid_->GetCellData()->SetActiveScalars(filler->array()->GetName());
  }
  fillers_.push_back(std::move(filler));
}

/// Leaves that are read at a time, and what comes of them. Its memory serves one after the other.
struct HyperTreeGridBuilder::Block
{
  LeafBlock read;
  std::exception_ptr error; // of reading or counting

  // Of count().
  std::vector<std::int8_t>
    steps; // of each leaf: the level of the deepest node around it and the one before, -1: of another tree
  struct TreeEnd
  {
    std::int32_t tree;
    std::uint64_t inner;
  };
  std::vector<TreeEnd> ended; // before the last leaf
  // What the last leaf leaves behind. Of the first leaf's tree counted from behind this leaf, of others from 0.
  std::uint64_t inner = 0;
  Path path{};

  // Of startAt(): before the first leaf.
  std::uint64_t innerBefore = 0;
  Path pathBefore{};

  // Of place().
  std::vector<vtkIdType> nodes; // of each leaf
  struct Subdivision
  {
    std::int32_t level;
    vtkIdType node; // in its tree
  };
  std::vector<Subdivision> subdivisions;
  struct TreeBegin
  {
    std::int32_t tree;
    std::size_t subdivision;
  };
  std::vector<TreeBegin> begun;
  std::vector<Family> closed;                   // that began here, too, children before parents
  std::size_t kept = 0;                         // levels of those from before that are still open
  std::array<unsigned, maxLevel> addedBefore{}; // to the masks of those from before
  std::vector<Family> open;                     // at the end, from level `kept` on
  std::vector<vtkIdType> masked;                // in closed ones
};

namespace
{

/// Of the node of a level around the leaf, in its parent.
int octantOf(const TreeLeaf& leaf, int level) noexcept
{
  const int up = leaf.level - level;
  return static_cast<int>(
    (leaf.index[0] >> up & 1) | (leaf.index[1] >> up & 1) << 1 | (leaf.index[2] >> up & 1) << 2);
}

bool isCell(const TreeLeaf& leaf) noexcept
{
  return leaf.level >= 0 && leaf.level <= HyperTreeGridBuilder::maxLevel &&
    (leaf.index[0] | leaf.index[1] | leaf.index[2]) >> leaf.level == 0;
}

constexpr int noStep = -2;

/// Level of the deepest node around two cells of a tree, the first of which is right; noStep when the second does not follow
/// it.
int stepInTree(const TreeLeaf& before, const TreeLeaf& leaf) noexcept
{
  if (!isCell(leaf))
  {
    return noStep;
  }
  const int common = commonLevel(before, leaf);
  const bool follows =
    common < std::min(leaf.level, before.level) && octantOf(leaf, common + 1) > octantOf(before, common + 1);
  return follows ? common : noStep;
}

} // namespace

void reserveNodes(vtkHyperTree* tree, vtkIdType nodes)
{
  if (nodes == 1)
  {
    return;
  }
  vtkNew<vtkBitArray> leavesOnly;
  leavesOnly->SetNumberOfValues(nodes);
  std::fill_n(leavesOnly->GetPointer(0), (nodes + 7) / 8, static_cast<unsigned char>(0));
  tree->InitializeForReader(1, nodes, 0, leavesOnly, nullptr, nullptr);
  tree->InitializeForReader(1, 1, 0, leavesOnly, nullptr, nullptr);
}

void HyperTreeGridBuilder::build(std::uint64_t leafCount, std::uint64_t blockLeaves, const ReadLeaves& read,
  const std::function<void(std::uint64_t)>& progress)
{
  // Two for each thread: some are done sooner. The steps of one thread keep no more of them busy than have these.
  constexpr std::size_t most = 16;
  const std::size_t atOnce = std::min<std::size_t>(most, 2 * tbb::this_task_arena::max_concurrency());
  std::vector<Block> now(atOnce);
  std::vector<Block> before(atOnce);
  std::size_t filled = 0; // blocks of `before`
  for (std::uint64_t begin = 0; begin < leafCount || filled > 0;)
  {
    const std::size_t blocks =
      std::min<std::uint64_t>(atOnce, (leafCount - begin + blockLeaves - 1) / blockLeaves);
    const auto readBlock = [&](std::size_t b) {
      try
      {
        const std::uint64_t first = begin + b * blockLeaves;
        read(first, std::min(leafCount, first + blockLeaves), now[b].read);
        count(now[b]);
      }
      catch (...)
      {
        now[b].error = std::current_exception();
      }
    };
    tbb::parallel_invoke([&] { std::for_each_n(before.begin(), filled, [&](Block& b) { finish(b); }); },
      [&] { tbb::parallel_for(std::size_t(0), blocks, readBlock); });
    for (std::size_t b = 0; b < blocks; ++b)
    {
      if (now[b].error)
      {
        std::rethrow_exception(now[b].error);
      }
      startAt(now[b]);
    }
    tbb::parallel_for(std::size_t(0), blocks, [&](std::size_t b) {
      place(now[b]);
      fill(now[b]);
    });
    std::swap(now, before);
    filled = blocks;
    begin = std::min(leafCount, begin + blocks * blockLeaves);
    if (progress)
    {
      progress(begin);
    }
  }
  if (last_.tree >= 0)
  {
    endTree(last_.tree, inner_);
  }
  goToTree(static_cast<std::int32_t>(treeStarts_.size()) - 1, last_.tree);
  closeTo(0);
  if (mask_)
  {
    grid_->SetMask(mask_);
  }
}

void HyperTreeGridBuilder::fail(std::int32_t tree, const std::string& found, const std::string& allowed) const
{
  throw Error(source_ + ": tree " + std::to_string(tree) + ": " + found + ", allowed are " + allowed);
}

/// Block::steps. before: null: none.
int HyperTreeGridBuilder::stepTo(const TreeLeaf& leaf, const TreeLeaf* before) const
{
  const auto trees = static_cast<std::int32_t>(treeStarts_.size()) - 1;
  if (leaf.tree < 0 || leaf.tree >= trees || (before && leaf.tree < before->tree))
  {
    fail(before ? before->tree : -1, "then one of tree " + std::to_string(leaf.tree),
      "trees in the order of their numbers, up to " + std::to_string(trees - 1));
  }
  const bool isInPlane = childCount_ == 8 || leaf.index[2] == 0;
  const int step = before && before->tree == leaf.tree ? stepInTree(*before, leaf) : -1;
  if (!isCell(leaf) || !isInPlane || step == noStep)
  {
    fail(leaf.tree,
      "the cell of level " + std::to_string(leaf.level) + " at (" + std::to_string(leaf.index[0]) + ", " +
        std::to_string(leaf.index[1]) + ", " + std::to_string(leaf.index[2]) + ")",
      "disjoint cells in Morton order, of level " + std::to_string(maxLevel) + " at most");
  }
  return step;
}

/// Inner nodes, but for those that begin with the first leaf: which these are the block before decides.
void HyperTreeGridBuilder::count(Block& block) const
{
  const std::vector<TreeLeaf>& leaves = block.read.leaves;
  block.steps.resize(leaves.size());
  block.ended.clear();
  block.inner = 0;
  block.path.fill(none);
  stepTo(leaves[0], nullptr); // or an error: those after it are compared with it
  for (std::size_t i = 1; i < leaves.size(); ++i)
  {
    const TreeLeaf& leaf = leaves[i];
    const TreeLeaf& before = leaves[i - 1];
    const bool isLikely = leaf.tree == before.tree && (childCount_ == 8 || leaf.index[2] == 0);
    int step = isLikely ? stepInTree(before, leaf) : noStep;
    if (step == noStep)
    {
      step = stepTo(leaf, &before); // of another tree, or an error
    }
    block.steps[i] = static_cast<std::int8_t>(step);
    if (step < 0)
    {
      block.ended.push_back({ before.tree, block.inner });
      block.inner = 0;
    }
    for (int level = step + 1; level < leaf.level; ++level)
    {
      block.path[level] = block.inner++;
    }
  }
}

/// Goes on from the block before to behind this one.
void HyperTreeGridBuilder::startAt(Block& block)
{
  const TreeLeaf& first = block.read.leaves.front();
  const int step = stepTo(first, last_.tree >= 0 ? &last_ : nullptr);
  block.steps[0] = static_cast<std::int8_t>(step);
  if (step < 0)
  {
    if (last_.tree >= 0)
    {
      endTree(last_.tree, inner_);
    }
    goToTree(first.tree, last_.tree);
    inner_ = 0;
  }
  block.innerBefore = inner_;
  block.pathBefore = path_;
  for (int level = step + 1; level < first.level; ++level)
  {
    path_[level] = inner_++;
  }
  std::uint64_t base = inner_;
  std::int32_t tree = first.tree;
  for (const Block::TreeEnd& end : block.ended)
  {
    goToTree(end.tree, tree);
    endTree(end.tree, base + end.inner);
    tree = end.tree;
    base = 0;
  }
  last_ = block.read.leaves.back();
  goToTree(last_.tree, tree);
  inner_ = base + block.inner;
  for (int level = 0; level < last_.level; ++level)
  {
    path_[level] = block.path[level] == none ? path_[level] : base + block.path[level];
  }
  if (nodesWith(inner_) > told(last_.tree))
  {
    fail(last_.tree, "more nodes", "the " + std::to_string(told(last_.tree)) + " that were told");
  }
}

/// Those between have no leaf.
void HyperTreeGridBuilder::goToTree(std::int32_t tree, std::int32_t before) const
{
  for (std::int32_t t = before + 1; t < tree; ++t)
  {
    if (told(t) != 0)
    {
      fail(t, "no cell", "cells of the " + std::to_string(told(t)) + " nodes that were told");
    }
  }
}

void HyperTreeGridBuilder::endTree(std::int32_t tree, std::uint64_t inner) const
{
  if (nodesWith(inner) != told(tree))
  {
    fail(tree, std::to_string(nodesWith(inner)) + " nodes",
      "the " + std::to_string(told(tree)) + " that were told");
  }
}

/// Where everything of the block belongs.
void HyperTreeGridBuilder::place(Block& block) const
{
  const std::vector<TreeLeaf>& leaves = block.read.leaves;
  block.nodes.resize(leaves.size());
  block.subdivisions.clear();
  block.begun.clear();
  block.closed.clear();
  block.open.clear();
  block.addedBefore.fill(0);

  std::array<Family, maxLevel> path; // above the latest leaf
  vtkIdType treeStart = treeStarts_[leaves.front().tree];
  const auto firstChildOf = [&](std::uint64_t inner) {
    return treeStart + static_cast<vtkIdType>(nodesWith(inner));
  };
  std::size_t kept = static_cast<std::size_t>(block.steps[0] + 1);
  for (std::size_t level = 0; level < kept; ++level)
  {
    path[level] = { -1, firstChildOf(block.pathBefore[level]), 0 }; // its own node is not asked for
  }
  std::size_t height = kept; // of the path
  const auto closeTo = [&](std::size_t level) {
    for (; height > std::max(level, kept); --height)
    {
      block.closed.push_back(path[height - 1]);
    }
    for (; height > level; --height)
    {
      block.addedBefore[height - 1] = path[height - 1].present;
    }
    kept = std::min(kept, level);
  };

  std::uint64_t inner = block.innerBefore;
  const TreeOrientation* orientation = &lattice_.orientation(leaves.front().tree);
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    const TreeLeaf& leaf = leaves[i];
    closeTo(static_cast<std::size_t>(block.steps[i] + 1));
    if (block.steps[i] < 0)
    {
      inner = 0;
      treeStart = treeStarts_[leaf.tree];
      orientation = &lattice_.orientation(leaf.tree);
      block.begun.push_back({ leaf.tree, block.subdivisions.size() });
    }
    const auto nodeAt = [&](int level) {
      if (level == 0)
      {
        return treeStart;
      }
      const unsigned child = (*orientation)[octantOf(leaf, level)];
      path[level - 1].present |= 1u << child;
      return path[level - 1].firstChild + child;
    };
    for (; height < static_cast<std::size_t>(leaf.level); ++height)
    {
      const int level = static_cast<int>(height);
      path[height] = { nodeAt(level), firstChildOf(inner++), 0 };
      block.subdivisions.push_back({ level, path[height].node - treeStart });
    }
    block.nodes[i] = nodeAt(leaf.level);
  }
  block.open.assign(
    path.begin() + static_cast<std::ptrdiff_t>(kept), path.begin() + static_cast<std::ptrdiff_t>(height));
  for (std::size_t level = 0; level < kept; ++level)
  {
    block.addedBefore[level] = path[level].present;
  }
  block.kept = kept;
}

void HyperTreeGridBuilder::fill(Block& block) const
{
  for (const auto& filler : fillers_)
  {
    filler->setLeaves(block.read.leaves, block.nodes.data());
  }
  block.masked.clear();
  for (const Family& family : block.closed)
  {
    fillAndMask(family, block.masked);
  }
}

void HyperTreeGridBuilder::fillAndMask(const Family& family, std::vector<vtkIdType>& masked) const
{
  const unsigned all = (1u << childCount_) - 1;
  for (const auto& filler : fillers_)
  {
    fillFamily(*filler, family.node, family.firstChild, family.present, all);
  }
  for (unsigned missing = ~family.present & all; missing != 0; missing &= missing - 1)
  {
    masked.push_back(family.firstChild + std::countr_zero(missing));
  }
}

/// What one thread does for all, block by block.
void HyperTreeGridBuilder::finish(Block& block)
{
  for (std::size_t level = 0; level < open_.size(); ++level)
  {
    open_[level].present |= block.addedBefore[level];
  }
  closeTo(block.kept);
  open_.insert(open_.end(), block.open.begin(), block.open.end());
  mask(block.masked);

  auto tree = block.begun.begin();
  for (std::size_t s = 0; s <= block.subdivisions.size(); ++s)
  {
    for (; tree != block.begun.end() && tree->subdivision == s; ++tree)
    {
      makeTree(tree->tree);
    }
    if (s < block.subdivisions.size())
    {
      tree_->SubdivideLeaf(
        block.subdivisions[s].node, static_cast<unsigned int>(block.subdivisions[s].level));
    }
  }
}

void HyperTreeGridBuilder::closeTo(std::size_t level)
{
  std::vector<vtkIdType> masked;
  for (; open_.size() > level; open_.pop_back())
  {
    fillAndMask(open_.back(), masked);
  }
  mask(masked);
}

void HyperTreeGridBuilder::mask(const std::vector<vtkIdType>& nodes)
{
  if (!nodes.empty() && !mask_)
  {
    mask_ = vtkSmartPointer<vtkBitArray>::New();
    mask_->SetNumberOfValues(nodeCount());
    std::fill_n(mask_->GetPointer(0), (nodeCount() + 7) / 8, static_cast<unsigned char>(0));
  }
  for (const vtkIdType node : nodes)
  {
    mask_->SetValue(node, 1);
  }
}

void HyperTreeGridBuilder::makeTree(std::int32_t number)
{
  const std::array<int, 3>& place = lattice_.place(number);
  vtkIdType index;
  grid_->GetIndexFromLevelZeroCoordinates(index, static_cast<unsigned int>(place[0]),
    static_cast<unsigned int>(place[1]), static_cast<unsigned int>(place[2]));
  tree_ = grid_->GetTree(index, true);
  tree_->SetGlobalIndexStart(treeStarts_[number]);
  reserveNodes(tree_, static_cast<vtkIdType>(told(number)));
}

} // namespace treeamr
