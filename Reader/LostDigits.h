// What users should know of values of which neither floats nor doubles hold all digits. Not installed.
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

/// Of a field of whole numbers that are rounded, as they are stored beyond those that single precision has all of.
/// array: its own.
Remark roundedIntegers(vtkDataArray& array, const Field& field);

/// Of a field that leaves out finite values beyond the range of single precision; or with a range so small that 2^-20 of it
/// is less than doubles can tell: isovalues, colours and results count in these, whatever the field's offset is. array: its
/// own.
VTKTREEAMRREADER_EXPORT Remark unsuitableRange(vtkDataArray& array, const Field& field);

} // namespace treeamr
