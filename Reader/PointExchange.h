// Points sent to the processes in whose boxes they lie, and what these know of them sent back. Private to the module.
#pragma once

#include "ProcessGroup.h"

#include "vtkNew.h"
#include "vtkType.h"

#include <vector>

class vtkDataSet;
class vtkHyperTreeGrid;
class vtkPointData;
class vtkPolyData;

namespace treeamr
{

/// All processes make and use it together.
class PointExchange
{
public:
  /// grid: with the processes' boxes (GridPartition.h), on all. points: of this process.
  PointExchange(const ProcessGroup& group, vtkHyperTreeGrid& grid, vtkDataSet& points);
  ~PointExchange();

  /// Those of all processes in this one's box: points alone.
  vtkPolyData& asked() const { return *asked_; }
  /// answers: of asked(), arrays of numbers in memory, not the same ones on all processes. Adds to `data`, on all, the arrays
  /// that some have, with the answers to this process' points; others are NaN, of integers 0.
  void answer(vtkPointData& answers, vtkPointData& data) const;

private:
  const ProcessGroup& group_;
  vtkIdType count_;                          // of this process' points
  std::vector<std::vector<vtkIdType>> sent_; // by process: which
  std::vector<std::size_t> askedOf_;         // by process: how many
  vtkNew<vtkPolyData> asked_;
};

} // namespace treeamr
