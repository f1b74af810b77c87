// How the trees are checked, and how marks spread between a vertex and its children.
#include "HyperTreeGridTopology.h"

#include "Error.h"
#include "GridPartition.h"

#include "vtkBitArray.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTree.h"
#include "vtkSmartPointer.h"
#include "vtkUniformHyperTreeGrid.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace treeamr
{

namespace
{

/// Not of a vtkUniformHyperTreeGrid, whose GetXCoordinates() prints a complaint and writes to the grid.
std::array<vtkDataArray*, 3> coordinatesOf(vtkHyperTreeGrid& grid)
{
  return { grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates() };
}

/// Of three dimensions and branch factor 2.
vtkSmartPointer<vtkHyperTree> newTree()
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
  auto tree = vtkSmartPointer<vtkHyperTree>::New();
  tree->Initialize(2, 3);
  return tree;
#else
  return vtkSmartPointer<vtkHyperTree>::Take(vtkHyperTree::CreateInstance(2, 3));
#endif
}

void checkPlanes(const std::vector<double>& planes, const std::string& axis)
{
  const auto fail = [&](std::size_t i) {
    std::ostringstream message;
    message.precision(std::numeric_limits<double>::max_digits10);
    message << "hyper tree grid: coordinate " << i << " along " << axis << " is " << planes[i];
    if (i > 0)
    {
      message << " after " << planes[i - 1];
    }
    message << "; coordinates must be finite and strictly increase or strictly decrease";
    throw Error(message.str());
  };
  for (std::size_t i = 0; i < planes.size(); ++i)
  {
    if (!std::isfinite(planes[i]) || !std::isfinite(planes[i] - planes[0]))
    {
      fail(i);
    }
  }
  const bool increase = planes.back() > planes.front();
  for (std::size_t i = 1; i < planes.size(); ++i)
  {
    if (increase ? planes[i] <= planes[i - 1] : planes[i] >= planes[i - 1])
    {
      fail(i);
    }
  }
}

} // namespace

int turnedAxes(vtkHyperTreeGrid& grid)
{
  int turned = 0;
  auto* uniform = vtkUniformHyperTreeGrid::SafeDownCast(&grid);
  const auto coordinates = uniform ? std::array<vtkDataArray*, 3>{} : coordinatesOf(grid);
  for (int a = 0; a < 3; ++a)
  {
    const vtkIdType last = static_cast<vtkIdType>(grid.GetDimensions()[a]) - 1;
    const bool decrease = uniform
      ? uniform->GetGridScale()[a] < 0.
      : coordinates[a]->GetComponent(last, 0) < coordinates[a]->GetComponent(0, 0);
    turned |= static_cast<int>(decrease) << a;
  }
  return turned;
}

std::array<std::vector<double>, 3> readRootPlanes(vtkHyperTreeGrid& grid)
{
  if (grid.GetDimension() != 3)
  {
    throw Error("hyper tree grid: its dimension is " + std::to_string(grid.GetDimension()) +
      ", allowed is 3; ParaView's Surface shows others");
  }
  std::array<std::vector<double>, 3> planes;
  const unsigned int* count = grid.GetDimensions();
  auto* uniform = vtkUniformHyperTreeGrid::SafeDownCast(&grid);
  const auto coordinates = uniform ? std::array<vtkDataArray*, 3>{} : coordinatesOf(grid);
  for (int a = 0; a < 3; ++a)
  {
    const std::string axis(1, "xyz"[a]);
    const vtkIdType found = coordinates[a] ? coordinates[a]->GetNumberOfTuples() : 0;
    if (!uniform && found < static_cast<vtkIdType>(count[a]))
    {
      throw Error("hyper tree grid: " + std::to_string(found) + " coordinates along " + axis +
        ", its dimensions need " + std::to_string(count[a]));
    }
    planes[a].resize(count[a]);
    for (std::size_t i = 0; i < planes[a].size(); ++i)
    {
      planes[a][i] = uniform ? uniform->GetOrigin()[a] + static_cast<double>(i) * uniform->GetGridScale()[a]
                             : coordinates[a]->GetComponent(static_cast<vtkIdType>(i), 0);
    }
    checkPlanes(planes[a], axis);
    if (planes[a].back() < planes[a].front())
    {
      std::reverse(planes[a].begin(), planes[a].end());
    }
  }
  return planes;
}

std::vector<HyperTreeView> collectTrees(vtkHyperTreeGrid& grid)
{
  std::array<unsigned int, 3> roots;
  grid.GetCellDims(roots.data());
  const std::uint64_t rootCount = std::uint64_t(roots[0]) * roots[1] * roots[2];

  // VTK has no way to ask whether a tree has a table of global indices, and aborts (where its assertions are
  // on) when it reads a missing one: what the table adds to the memory size of a tree tells its length.
  const auto sizeWithoutTable = [](const vtkHyperTree& tree) {
    std::size_t count = 0;
    tree.GetElderChildIndexArray(count);
    return count * sizeof(unsigned int);
  };
  const vtkSmartPointer<vtkHyperTree> fresh = newTree();
  const std::size_t overhead = fresh->GetActualMemorySizeBytes() - sizeWithoutTable(*fresh);

  const int turned = turnedAxes(grid);
  std::vector<HyperTreeView> trees;
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid.InitializeTreeIterator(iterator);
  vtkIdType id = 0;
  while (vtkHyperTree* tree = iterator.GetNextTree(id))
  {
    const auto fail = [id](const std::string& what) {
      throw Error("hyper tree grid: tree " + std::to_string(id) + " " + what);
    };
    if (id < 0 || static_cast<std::uint64_t>(id) >= rootCount)
    {
      fail("is outside the lattice of " + std::to_string(rootCount) + " roots");
    }
    if (tree->GetBranchFactor() != 2 || tree->GetNumberOfChildren() != 8)
    {
      fail("has " + std::to_string(tree->GetNumberOfChildren()) + " children per node, allowed are 8");
    }
    HyperTreeView view;
    std::array<unsigned int, 3> root;
    grid.GetLevelZeroCoordinatesFromIndex(id, root[0], root[1], root[2]);
    for (int a = 0; a < 3; ++a)
    {
      view.root[a] = turnedRoot(root[a], roots[a], turned >> a & 1);
    }
    view.turned = turned;
    view.tree = tree;
    view.vertexCount = tree->GetNumberOfVertices();
    view.elderChild = tree->GetElderChildIndexArray(view.elderChildCount);
    const std::size_t tableSize =
      (tree->GetActualMemorySizeBytes() - overhead - sizeWithoutTable(*tree)) / sizeof(vtkIdType);
    view.globalStart = tableSize == 0 ? tree->GetGlobalIndexStart() : -1;
    if (view.globalStart < 0 && tableSize < static_cast<std::size_t>(view.vertexCount))
    {
      fail("has global indices for " + std::to_string(tableSize) + " of its " +
        std::to_string(view.vertexCount) + " vertices (see vtkHyperTree::SetGlobalIndexStart)");
    }
    trees.push_back(view);
  }
  std::sort(trees.begin(), trees.end(), [](const HyperTreeView& a, const HyperTreeView& b) {
    return std::lexicographical_compare(a.root.rbegin(), a.root.rend(), b.root.rbegin(), b.root.rend());
  });
  return trees;
}

HyperTreeGridTopology::HyperTreeGridTopology(vtkHyperTreeGrid* grid)
  : rootGrid_(readRootPlanes(checked(grid)))
  , trees_(collectTrees(*grid))
  , depthLimit_(grid->GetDepthLimiter())
  , isPartitioned_(partitionOf(*grid).has_value())
{
  checkTrees();
  measureGlobalIndices();
  markMaskAndGhosts(*grid);
}

vtkHyperTreeGrid& HyperTreeGridTopology::checked(vtkHyperTreeGrid* grid)
{
  if (!grid)
  {
    throw Error("hyper tree grid: there is none");
  }
  // The first question: a grid without trees has neither a dimension nor a branch factor.
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  if (!iterator.GetNextTree())
  {
    throw Error("hyper tree grid: it holds no tree");
  }
  if (grid->GetBranchFactor() != 2)
  {
    throw Error(
      "hyper tree grid: its branch factor is " + std::to_string(grid->GetBranchFactor()) + ", allowed is 2");
  }
  if (grid->GetHasInterface())
  {
    throw Error("hyper tree grid: it has material interfaces within cells, which are not supported");
  }
  return *grid;
}

/// Children must follow their parent, as in all trees that VTK builds: the sweeps by index rely on it, and a
/// broken tree may not lead out of its arrays or around in circles.
void HyperTreeGridTopology::checkTrees() const
{
  forEachVertex([&](const HyperTreeView& tree, vtkIdType v) {
    if (!tree.isLeaf(v) && (tree.firstChild(v) <= v || tree.firstChild(v) + 7 >= tree.vertexCount))
    {
      throw Error("hyper tree grid: the children of vertex " + std::to_string(v) + " in the tree at root (" +
        std::to_string(tree.root[0]) + ", " + std::to_string(tree.root[1]) + ", " +
        std::to_string(tree.root[2]) + ") start at vertex " + std::to_string(tree.firstChild(v)) +
        ", allowed are " + std::to_string(v + 1) + " to " + std::to_string(tree.vertexCount - 8));
    }
  });
}

void HyperTreeGridTopology::measureGlobalIndices()
{
  struct Measured
  {
    vtkIdType end = 0;
    ContentDigest digest;
  };
  const auto measure = [](const HyperTreeView& tree, vtkIdType begin, vtkIdType end) {
    Measured m;
    for (vtkIdType v = begin; v < end; ++v)
    {
      const vtkIdType index = tree.globalIndex(v);
      if (index < 0)
      {
        throw Error("hyper tree grid: vertex " + std::to_string(v) + " of a tree has no global index");
      }
      m.end = std::max(m.end, index + 1);
      m.digest.add(static_cast<std::uint64_t>(index));
    }
    return m;
  };
  // In blocks of a fixed size: the digest must not depend on the number of threads.
  constexpr vtkIdType blockSize = 1 << 15;
  std::vector<Measured> ofTrees(trees_.size());
  tbb::parallel_for(std::size_t(0), trees_.size(), [&](std::size_t t) {
    const HyperTreeView& tree = trees_[t];
    Measured& all = ofTrees[t];
    all.digest.add(static_cast<std::uint64_t>(tree.globalStart));
    all.end = tree.globalStart + tree.vertexCount;
    if (tree.globalStart < 0)
    {
      std::vector<Measured> blocks((tree.vertexCount + blockSize - 1) / blockSize);
      tbb::parallel_for(std::size_t(0), blocks.size(), [&](std::size_t b) {
        const auto begin = static_cast<vtkIdType>(b) * blockSize;
        blocks[b] = measure(tree, begin, std::min(tree.vertexCount, begin + blockSize));
      });
      all.end = 0;
      for (const Measured& block : blocks)
      {
        all.end = std::max(all.end, block.end);
        all.digest.add(block.digest);
      }
    }
  });
  for (const Measured& tree : ofTrees)
  {
    globalIndexEnd_ = std::max(globalIndexEnd_, tree.end);
    globalIndexDigest_.add(tree.digest);
  }
}

void HyperTreeGridTopology::markMaskAndGhosts(vtkHyperTreeGrid& grid)
{
  vtkBitArray* mask = grid.HasMask() ? grid.GetMask() : nullptr;
  vtkUnsignedCharArray* ghosts = grid.GetGhostCells();
  if (!mask && !ghosts)
  {
    return;
  }
  if (ghosts && ghosts->GetNumberOfTuples() < globalIndexEnd_)
  {
    throw Error("hyper tree grid: array '" + std::string(vtkDataSetAttributes::GhostArrayName()) + "' has " +
      std::to_string(ghosts->GetNumberOfTuples()) + " values, the cells need " +
      std::to_string(globalIndexEnd_));
  }
  const vtkIdType maskEnd = mask ? mask->GetNumberOfTuples() : 0;
  const auto state = [&](const HyperTreeView& tree, vtkIdType v) -> std::uint8_t {
    const vtkIdType index = tree.globalIndex(v);
    const unsigned char ghost = ghosts && tree.isLeaf(v) ? ghosts->GetValue(index) : 0;
    if ((index < maskEnd && mask->GetValue(index)) || (ghost & vtkDataSetAttributes::HIDDENCELL))
    {
      return 0;
    }
    return existsBit | (ghost & vtkDataSetAttributes::DUPLICATECELL ? ghostBit : 0);
  };

  std::atomic<bool> anyMark{ false };
  std::atomic<bool> anyGhost{ false };
  forEachVertex([&](const HyperTreeView& tree, vtkIdType v) {
    const std::uint8_t s = state(tree, v);
    if (s != existsBit && !anyMark.load(std::memory_order_relaxed))
    {
      anyMark.store(true, std::memory_order_relaxed);
    }
    if ((s & ghostBit) && !anyGhost.load(std::memory_order_relaxed))
    {
      anyGhost.store(true, std::memory_order_relaxed);
    }
  });
  if (!anyMark)
  {
    return;
  }
  hasGhosts_ = anyGhost;
  allocateStates();
  forEachVertex(
    [&](const HyperTreeView& tree, vtkIdType v) { states_[tree.firstState + v] = state(tree, v); });
  propagateStates();
}

bool HyperTreeGridTopology::hasCells() const noexcept
{
  return std::any_of(trees_.begin(), trees_.end(), [&](const HyperTreeView& t) { return exists(t, 0); });
}

void HyperTreeGridTopology::checkDepth(unsigned int level) const
{
  if (level >= static_cast<unsigned int>(rootGrid_.maxLevel()))
  {
    throw Error("hyper tree grid: a tree is deeper than level " + std::to_string(rootGrid_.maxLevel()) +
      ", the deepest allowed on this root grid");
  }
}

void HyperTreeGridTopology::allocateStates()
{
  if (states_.empty())
  {
    std::size_t count = 0;
    for (HyperTreeView& tree : trees_)
    {
      tree.firstState = count;
      count += tree.vertexCount;
    }
    states_.assign(count, existsBit);
  }
}

/// Nothing exists below a masked vertex. A coarse vertex exists when a child does; it is a ghost when all its
/// existing children are.
void HyperTreeGridTopology::propagateStates()
{
  tbb::parallel_for(
    std::size_t(0), trees_.size(), [&](std::size_t t) { propagateStates(trees_[t], 0, 0, false); });
}

std::uint8_t HyperTreeGridTopology::propagateStates(
  const HyperTreeView& tree, vtkIdType vertex, unsigned int level, bool belowMasked)
{
  std::uint8_t& state = states_[tree.firstState + vertex];
  if (tree.isLeaf(vertex))
  {
    return state = belowMasked ? 0 : state;
  }
  checkDepth(level); // bounds the recursion
  const bool masked = belowMasked || !state;
  std::array<std::uint8_t, 8> children;
  const auto propagate = [&](int o) {
    children[o] = propagateStates(tree, tree.child(vertex, o), level + 1, masked);
  };
  constexpr unsigned int parallelLevels = 4;
  constexpr vtkIdType parallelVertices = 1 << 14;
  if (level < parallelLevels && tree.vertexCount > parallelVertices)
  {
    tbb::parallel_for(0, 8, propagate);
  }
  else
  {
    for (int o = 0; o < 8; ++o)
    {
      propagate(o);
    }
  }
  std::uint8_t any = 0;
  std::uint8_t allGhosts = ghostBit;
  for (const std::uint8_t child : children)
  {
    any |= child & existsBit;
    allGhosts &= child & existsBit ? child : ghostBit;
  }
  return state = any ? existsBit | allGhosts : 0;
}

ContentDigest HyperTreeGridTopology::octreeDigest() const
{
  ContentDigest digest;
  for (int a = 0; a < 3; ++a)
  {
    digest.add(static_cast<std::uint64_t>(rootGrid_.roots()[a]));
    for (int i = 0; i <= rootGrid_.roots()[a]; ++i)
    {
      digest.add(rootGrid_.worldPlane(a, i, 0));
    }
  }
  digest.add(static_cast<std::uint64_t>(depthLimit_));
  digest.add(static_cast<std::uint64_t>(isPartitioned_));
  std::vector<ContentDigest> ofTrees(trees_.size());
  tbb::parallel_for(std::size_t(0), trees_.size(), [&](std::size_t t) {
    const HyperTreeView& tree = trees_[t];
    for (const Coord c : tree.root)
    {
      ofTrees[t].add(static_cast<std::uint64_t>(c));
    }
    ofTrees[t].add(static_cast<std::uint64_t>(tree.turned));
    ofTrees[t].add(static_cast<std::uint64_t>(tree.vertexCount));
    ofTrees[t].addBytes(tree.elderChild, tree.elderChildCount * sizeof(unsigned int));
  });
  for (const ContentDigest& tree : ofTrees)
  {
    digest.add(tree);
  }
  digest.addBytes(states_.data(), states_.size());
  return digest;
}

} // namespace treeamr
