// The cells of many processes sent to those that need them. Private to the module.
#pragma once

#include "GridPartition.h"

#include "vtkSmartPointer.h"

#include <array>
#include <limits>
#include <vector>

class vtkHyperTreeGrid;

namespace treeamr
{

class HyperTreeGridTopology;
class ProcessGroup;
class SharedArrays;

/// What is the same on all processes, but for `partition.own` and the arrays' values.
struct ExchangePlan
{
  std::array<std::vector<double>, 3> planes; // between roots
  unsigned int depthLimit = std::numeric_limits<unsigned int>::max();
  int deepest = 0;          // level of a cell
  std::vector<int> sources; // by process: the first one that has the same grid; -1: it has none
  GridPartition partition;
};

/// Each process calls it. topology: of its grid; none where there are no trees. Returns the grid of its box, with the partition.
/// Throws on all processes the Error of any.
vtkSmartPointer<vtkHyperTreeGrid> exchangeCells(const ProcessGroup& group, const ExchangePlan& plan,
  const SharedArrays& arrays, const HyperTreeGridTopology* topology);

} // namespace treeamr
