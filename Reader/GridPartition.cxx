#include "GridPartition.h"

#include "HyperTreeGridTopology.h"

#include "vtkDataArray.h"
#include "vtkFieldData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkTypeInt64Array.h"

#include <utility>

namespace treeamr
{

namespace
{

// Tuples of six: the level, the own box, how many there are, and roots along each axis; then begin and end of each box.
constexpr const char* arrayName = "TreeAMRPartition";
constexpr int tupleSize = 6;

std::array<vtkTypeInt64, 3> rootsOf(vtkHyperTreeGrid& grid)
{
  std::array<vtkTypeInt64, 3> roots;
  for (int a = 0; a < 3; ++a)
  {
    roots[a] = static_cast<vtkTypeInt64>(grid.GetDimensions()[a]) - 1;
  }
  return roots;
}

} // namespace

void setPartition(vtkHyperTreeGrid& grid, const GridPartition& partition)
{
  vtkNew<vtkTypeInt64Array> array;
  array->SetName(arrayName);
  array->SetNumberOfComponents(tupleSize);
  const auto insert = [&](const std::array<vtkTypeInt64, tupleSize>& tuple) {
    array->InsertNextTypedTuple(tuple.data());
  };
  const auto [x, y, z] = rootsOf(grid);
  insert(
    { partition.box().level, partition.own, static_cast<vtkTypeInt64>(partition.boxes.size()), x, y, z });
  for (const LatticeBox& box : partition.boxes)
  {
    insert({ box.begin[0], box.begin[1], box.begin[2], box.end[0], box.end[1], box.end[2] });
  }
  grid.GetFieldData()->AddArray(array);
}

std::optional<GridPartition> partitionOf(vtkHyperTreeGrid& grid)
{
  auto* const array = vtkTypeInt64Array::FastDownCast(grid.GetFieldData()->GetArray(arrayName));
  if (!array || array->GetNumberOfComponents() != tupleSize || array->GetNumberOfTuples() < 2)
  {
    return std::nullopt;
  }
  std::array<vtkTypeInt64, tupleSize> tuple;
  array->GetTypedTuple(0, tuple.data());
  const auto [level, own, count, x, y, z] = tuple;
  const std::array<vtkTypeInt64, 3> roots = rootsOf(grid);
  constexpr vtkTypeInt64 deepest = 30;
  if (roots != std::array{ x, y, z } || count != array->GetNumberOfTuples() - 1 || own < 0 || own >= count ||
    level < 0 || level > deepest || grid.GetDimension() != 3)
  {
    return std::nullopt;
  }
  const int turned = turnedAxes(grid);
  GridPartition partition;
  partition.own = static_cast<int>(own);
  for (vtkIdType i = 1; i <= count; ++i)
  {
    array->GetTypedTuple(i, tuple.data());
    LatticeBox& box = partition.boxes.emplace_back();
    box.level = static_cast<int>(level);
    for (int a = 0; a < 3; ++a)
    {
      const Coord end = static_cast<Coord>(roots[a]) << level;
      box.begin[a] = turned >> a & 1 ? end - tuple[a + 3] : tuple[a];
      box.end[a] = turned >> a & 1 ? end - tuple[a] : tuple[a + 3];
      if (box.begin[a] < 0 || box.begin[a] > box.end[a] || box.end[a] > end)
      {
        return std::nullopt;
      }
    }
  }
  return partition;
}

std::vector<HalfSpace> partitionFaces(vtkHyperTreeGrid& grid)
{
  std::vector<HalfSpace> faces;
  const auto partition = partitionOf(grid);
  if (!partition)
  {
    return faces;
  }
  const RootGrid roots(readRootPlanes(grid));
  const LatticeBox& box = partition->box();
  const Bounds bounds = box.bounds(roots);
  for (int a = 0; a < 3; ++a)
  {
    const auto add = [&](double direction, double plane) {
      HalfSpace face{ {}, direction * plane };
      face.normal[a] = direction;
      faces.push_back(face);
    };
    if (box.begin[a] > 0)
    {
      add(1., bounds.min[a]);
    }
    if (box.end[a] < Coord(roots.roots()[a]) << box.level)
    {
      add(-1., bounds.max[a]);
    }
  }
  return faces;
}

} // namespace treeamr
