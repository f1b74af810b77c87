#include "MergedGrid.h"

#include "CornerArrays.h"
#include "Error.h"
#include "GridOfCells.h"
#include "OwnLeaves.h"

#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace treeamr
{

namespace
{

using Planes = std::array<std::vector<double>, 3>;

/// The cells of a tree, and how many there are of trees before.
struct TreeCells
{
  std::size_t grid;
  const HyperTreeView* tree;
  std::size_t before = 0;
  int deepest = 0;
};

class GridMerger
{
public:
  explicit GridMerger(const std::vector<NamedGrid>& grids)
    : grids_(grids)
  {
    topologies_.reserve(grids.size());
    for (const NamedGrid& grid : grids)
    {
      topologies_.emplace_back(grid.grid);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      findPlanes(axis);
    }
    checkRootCount(planes_, {});
    countCells();
  }

  std::vector<std::string> build(vtkHyperTreeGrid* merged)
  {
    const BlockArrays arrays = arraysOfGrids();
    unsigned int depthLimit = 0;
    for (const HyperTreeGridTopology& topology : topologies_)
    {
      depthLimit = std::max(depthLimit, topology.depthLimit());
    }
    merged->SetDepthLimiter(depthLimit);
    if (cellCount_ > 0)
    {
      const int padding = RootGrid(planes_).paddingDepth();
      withKeys(padding + deepest_, [&]<class Keys>() {
        SortedCells<Keys, std::uint64_t> cells(padding, deepest_, cellCount_);
        setCells(cells);
        cells.sort();
        keepFirstOfDuplicates(cells, [this](const auto&... found) { this->failOfOverlap(found...); });
        buildGrid(cells, planes_, arrays, merged);
      });
    }
    return arrays.leftOut;
  }

private:
  /// Planes that are the same in several grids differ by rounding at most.
  void findPlanes(int axis)
  {
    constexpr double ofRoot = 1e-6; // floats of coordinates up to some roots from the origin
    constexpr double roundings = 8.;
    std::vector<double>& planes = planes_[axis];
    double narrowest = std::numeric_limits<double>::infinity();
    double largest = 0.;
    for (const HyperTreeGridTopology& topology : topologies_)
    {
      const RootGrid& roots = topology.rootGrid();
      for (Coord i = 0; i <= roots.roots()[axis]; ++i)
      {
        planes.push_back(roots.worldPlane(axis, i, 0));
        largest = std::max(largest, std::abs(planes.back()));
        narrowest = i > 0 ? std::min(narrowest, planes.back() - planes[planes.size() - 2]) : narrowest;
      }
    }
    const double tolerance =
      std::max(ofRoot * narrowest, roundings * std::numeric_limits<double>::epsilon() * largest);
    std::ranges::sort(planes);
    const auto same = [&](double a, double b) { return b - a <= tolerance; };
    planes.erase(std::unique(planes.begin(), planes.end(), same), planes.end());

    for (std::size_t g = 0; g < grids_.size(); ++g)
    {
      const RootGrid& roots = topologies_[g].rootGrid();
      const auto placeOf = [&](double coordinate) {
        return static_cast<Coord>(std::ranges::upper_bound(planes, coordinate + tolerance) - planes.begin()) -
          1;
      };
      firstPlace_.resize(grids_.size());
      firstPlace_[g][axis] = placeOf(roots.worldPlane(axis, 0, 0));
      for (Coord i = 0; i < roots.roots()[axis]; ++i)
      {
        const double low = roots.worldPlane(axis, i, 0);
        const double high = roots.worldPlane(axis, i + 1, 0);
        if (placeOf(high) != placeOf(low) + 1)
        {
          throw Error(grids_[g].name + ": roots from " + std::to_string(low) + " to " + std::to_string(high) +
            " along " + "xyz"[axis] + " span " + std::to_string(placeOf(high) - placeOf(low)) +
            " of the lattice that all grids form, allowed 1");
        }
      }
    }
  }

  CellId rootOf(const TreeCells& cells) const
  {
    CellId root{ cells.tree->root, 0 };
    for (int a = 0; a < 3; ++a)
    {
      root.index[a] += firstPlace_[cells.grid][a];
    }
    return root;
  }

  void countCells()
  {
    for (std::size_t g = 0; g < topologies_.size(); ++g)
    {
      for (const HyperTreeView& tree : topologies_[g].trees())
      {
        trees_.push_back({ g, &tree });
      }
    }
    tbb::parallel_for(std::size_t(0), trees_.size(), [&](std::size_t t) {
      TreeCells& cells = trees_[t];
      forEachOwnLeaf(
        topologies_[cells.grid], *cells.tree, rootOf(cells), [&](const CellId& place, vtkIdType /*vertex*/) {
          ++cells.before;
          cells.deepest = std::max(cells.deepest, place.level);
        });
    });
    for (TreeCells& cells : trees_)
    {
      const std::size_t count = cells.before;
      cells.before = cellCount_;
      cellCount_ += count;
      deepest_ = std::max(deepest_, cells.deepest);
    }
  }

  template <class Cells>
  void setCells(Cells& sorted) const
  {
    tbb::parallel_for(std::size_t(0), trees_.size(), [&](std::size_t t) {
      const TreeCells& cells = trees_[t];
      std::size_t at = cells.before;
      forEachOwnLeaf(
        topologies_[cells.grid], *cells.tree, rootOf(cells), [&](const CellId& place, vtkIdType vertex) {
          sorted.set(at++, place, CellNumber(cells.grid, cells.tree->globalIndex(vertex)).number());
        });
    });
  }

  [[noreturn]] void failOfOverlap(
    const CellNumber& first, const CellNumber& second, const CellId& place) const
  {
    const RootGrid roots(planes_);
    std::array<double, 3> low{};
    for (int a = 0; a < 3; ++a)
    {
      low[a] = roots.worldPlane(a, place.index[a], place.level);
    }
    throw Error(grids_[first.block()].name + " and " + grids_[second.block()].name +
      ": cells of different levels overlap at " + textOf(low) + ", allowed is one at each place");
  }

  BlockArrays arraysOfGrids()
  {
    std::vector<NamedDataSet> sets;
    for (std::size_t g = 0; g < grids_.size(); ++g)
    {
      vtkCellData* data = grids_[g].grid->GetCellData();
      if (const int turned = turnedAxes(*grids_[g].grid); turned != 0)
      {
        data = withTurnedCorners(data, turned);
      }
      sets.emplace_back(data, topologies_[g].globalIndexEnd(), grids_[g].name);
    }
    return arraysOf(std::move(sets), {});
  }

  /// Of a grid whose axes are turned, values at corners as the corners are along increasing coordinates.
  vtkCellData* withTurnedCorners(vtkCellData* data, int turned)
  {
    vtkCellData* const copy = turnedData_.emplace_back(vtkSmartPointer<vtkCellData>::New());
    copy->ShallowCopy(data);
    for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    {
      vtkDataArray* const array = data->GetArray(i);
      if (!array || !isAtCorners(*array))
      {
        continue;
      }
      const auto values = vtk::TakeSmartPointer(array->NewInstance());
      values->DeepCopy(array);
      for (vtkIdType tuple = 0; tuple < array->GetNumberOfTuples(); ++tuple)
      {
        for (int c = 0; c < cornerCount; ++c)
        {
          values->SetComponent(tuple, c, array->GetComponent(tuple, c ^ turned));
        }
      }
      copy->AddArray(values); // in place of that of its name
    }
    return copy;
  }

  const std::vector<NamedGrid>& grids_;
  std::vector<HyperTreeGridTopology> topologies_;
  Planes planes_;
  std::vector<std::array<Coord, 3>> firstPlace_; // of each grid's first roots
  std::vector<TreeCells> trees_;
  std::size_t cellCount_ = 0;
  int deepest_ = 0;
  std::vector<vtkSmartPointer<vtkCellData>> turnedData_;
};

} // namespace

std::vector<NamedGrid> gridsWithTrees(vtkDataObject* input)
{
  std::vector<NamedGrid> grids;
  const auto add = [&](vtkDataObject* data, const std::string& name, unsigned int flatIndex) {
    auto* const grid = vtkHyperTreeGrid::SafeDownCast(data);
    vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
    if (grid)
    {
      grid->InitializeTreeIterator(trees);
      if (trees.GetNextTree())
      {
        grids.push_back({ grid, name, flatIndex });
      }
    }
  };
  auto* const composite = vtkCompositeDataSet::SafeDownCast(input);
  if (!composite)
  {
    add(input, "hyper tree grid", 1);
    return grids;
  }
  const auto leaves = vtk::TakeSmartPointer(composite->NewIterator());
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    add(leaves->GetCurrentDataObject(), nameOfBlock(*leaves), leaves->GetCurrentFlatIndex());
  }
  return grids;
}

std::vector<std::string> blocksOfOtherKinds(vtkDataObject* input)
{
  std::vector<std::string> others;
  if (auto* const composite = vtkCompositeDataSet::SafeDownCast(input))
  {
    const auto leaves = vtk::TakeSmartPointer(composite->NewIterator());
    for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
    {
      vtkDataObject* const data = leaves->GetCurrentDataObject();
      const bool isEmpty = data->GetNumberOfElements(vtkDataObject::CELL) == 0 &&
        data->GetNumberOfElements(vtkDataObject::POINT) == 0;
      if (!vtkHyperTreeGrid::SafeDownCast(data) && !isEmpty)
      {
        others.push_back(nameOfBlock(*leaves) + " is a " + data->GetClassName());
      }
    }
  }
  return others;
}

std::vector<std::string> mergeGrids(const std::vector<NamedGrid>& grids, vtkHyperTreeGrid* merged)
{
  if (grids.size() == 1)
  {
    merged->ShallowCopy(grids[0].grid);
    return {};
  }
  return GridMerger(grids).build(merged);
}

} // namespace treeamr
