#include "HyperTreeGridBuilder.h"

#include "Error.h"
#include "Geometry/Octant.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"

#include <algorithm>
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

void HyperTreeGridBuilder::add(const TreeLeaf& leaf)
{
  if (leaf.tree != treeNumber_)
  {
    finishTree();
    startTree(leaf.tree);
  }
  while (complete_ || level_ != leaf.level || index_[level_] != leaf.index)
  {
    if (complete_ || leaf.level > maxLevel)
    {
      fail("the cell of level " + std::to_string(leaf.level) + " at (" + std::to_string(leaf.index[0]) +
          ", " + std::to_string(leaf.index[1]) + ", " + std::to_string(leaf.index[2]) + ")",
        "disjoint cells in Morton order, of level " + std::to_string(maxLevel) + " at most");
    }
    isAround(leaf) ? subdivide() : mask();
  }
  for (const auto& filler : fillers_)
  {
    filler->setLeaf(treeStarts_[treeNumber_] + node_[level_], leaf);
  }
  goOn(true);
}

void HyperTreeGridBuilder::finish()
{
  finishTree();
  if (mask_)
  {
    grid_->SetMask(mask_);
  }
}

void HyperTreeGridBuilder::fail(const std::string& found, const std::string& allowed) const
{
  throw Error(source_ + ": tree " + std::to_string(treeNumber_) + ": " + found + ", allowed are " + allowed);
}

void HyperTreeGridBuilder::startTree(std::int32_t tree)
{
  if (tree <= treeNumber_ || tree >= static_cast<std::int32_t>(treeStarts_.size()) - 1)
  {
    fail("then one of tree " + std::to_string(tree),
      "trees in the order of their numbers, up to " + std::to_string(treeStarts_.size() - 2));
  }
  treeNumber_ = tree;
  const std::array<int, 3>& place = lattice_.place(tree);
  vtkIdType index;
  grid_->GetIndexFromLevelZeroCoordinates(index, place[0], place[1], place[2]);
  tree_ = grid_->GetTree(index, true);
  tree_->SetGlobalIndexStart(treeStarts_[tree]);
  orientation_ = lattice_.orientation(tree);
  level_ = 0;
  node_[0] = 0;
  index_[0] = {};
  complete_ = false;
}

void HyperTreeGridBuilder::finishTree()
{
  if (!tree_)
  {
    return;
  }
  while (!complete_)
  {
    mask();
  }
  const vtkIdType told = treeStarts_[treeNumber_ + 1] - treeStarts_[treeNumber_];
  if (tree_->GetNumberOfVertices() != told)
  {
    fail(std::to_string(tree_->GetNumberOfVertices()) + " nodes",
      "the " + std::to_string(told) + " that were told");
  }
  tree_ = nullptr;
}

/// Whether the leaf is in a child of the current place.
bool HyperTreeGridBuilder::isAround(const TreeLeaf& leaf) const noexcept
{
  const int up = leaf.level - level_;
  const std::array<std::uint32_t, 3>& index = index_[level_];
  return up > 0 && leaf.index[0] >> up == index[0] && leaf.index[1] >> up == index[1] &&
    leaf.index[2] >> up == index[2];
}

void HyperTreeGridBuilder::subdivide()
{
  // A subdivision's children are appended to the tree's vertices.
  firstChild_[level_] = tree_->GetNumberOfVertices();
  if (firstChild_[level_] + childCount_ > treeStarts_[treeNumber_ + 1] - treeStarts_[treeNumber_])
  {
    fail("more nodes",
      "the " + std::to_string(treeStarts_[treeNumber_ + 1] - treeStarts_[treeNumber_]) + " that were told");
  }
  tree_->SubdivideLeaf(node_[level_], static_cast<unsigned int>(level_));
  filled_[level_] = 0;
  child_[level_ + 1] = 0;
  node_[level_ + 1] = firstChild_[level_] + orientation_[0];
  for (int a = 0; a < 3; ++a)
  {
    index_[level_ + 1][a] = 2 * index_[level_][a];
  }
  ++level_;
}

void HyperTreeGridBuilder::mask()
{
  if (!mask_)
  {
    mask_ = vtkSmartPointer<vtkBitArray>::New();
    mask_->SetNumberOfValues(nodeCount());
    std::fill_n(mask_->GetPointer(0), (nodeCount() + 7) / 8, static_cast<unsigned char>(0));
  }
  mask_->SetValue(treeStarts_[treeNumber_] + node_[level_], 1);
  goOn(false);
}

/// To the next place, through all inner nodes that are complete.
void HyperTreeGridBuilder::goOn(bool hasCell)
{
  while (level_ > 0)
  {
    const int child = child_[level_];
    filled_[level_ - 1] |= static_cast<unsigned>(hasCell) << orientation_[child];
    if (child + 1 < childCount_)
    {
      child_[level_] = child + 1;
      node_[level_] = firstChild_[level_ - 1] + orientation_[child + 1];
      for (int a = 0; a < 3; ++a)
      {
        index_[level_][a] ^= static_cast<std::uint32_t>(sideOf(child ^ (child + 1), a));
      }
      return;
    }
    --level_;
    for (const auto& filler : fillers_)
    {
      fillFamily(*filler, treeStarts_[treeNumber_] + node_[level_],
        treeStarts_[treeNumber_] + firstChild_[level_], filled_[level_], (1u << childCount_) - 1);
    }
    hasCell = filled_[level_] != 0;
  }
  complete_ = true;
}

} // namespace treeamr
