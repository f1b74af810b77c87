// What users should know of values that single precision does not tell apart. Not installed.
#pragma once

#include "HyperTreeGridConverter.h"

namespace treeamr
{

/// Empty where there is nothing to say.
struct Remark
{
  std::string about; // for OnceReporter: the same whatever the numbers in the text are
  std::string text;
};

/// Of whole numbers beyond those that are all exact in single precision.
Remark roundedIntegers(vtkDataArray& array);

/// Of doubles which lie so close together that float, with less than 1024 steps from the least to the greatest, makes
/// some that differ the same. field: of the selection, by acquireField(). The values are read again only where the
/// steps are so few; elsewhere it costs nothing.
VTKTREEAMRREADER_EXPORT Remark mergedDoubles(
  vtkHyperTreeGrid* grid, const ArraySelection& selection, const Field& field);

} // namespace treeamr
