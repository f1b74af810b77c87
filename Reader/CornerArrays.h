// Cell arrays of values at the cells' corners: how they are marked, and what there is to say of them.
//
// A function that is trilinear in each cell (finite elements Q1) goes through vtkHyperTreeGrid as a cell array of eight
// components, of which other filters see an ordinary one. Component c belongs to the corner at the sides c & 1 along the
// grid's x, c >> 1 & 1 along y and c >> 2 along z, and is named by these sides, as 100. Names or the key mark an array: VTK's
// filters copy both, and its files for other data keep the names. Its .htg files have neither (VTK 9.2).
#pragma once

#include "HyperTreeGridConverter.h"
#include "LostDigits.h"

#include <string>
#include <vector>

class vtkInformationIntegerKey;

namespace treeamr
{

constexpr int cornerCount = 8;

/// 1 in the information of an array of eight components: they are values at corners.
VTKTREEAMRREADER_EXPORT vtkInformationIntegerKey* cornerValuesKey();

/// Gives an array its eight components, their names and the key.
VTKTREEAMRREADER_EXPORT void markAsCorners(vtkDataArray& array);

/// Whether an array has the mark.
VTKTREEAMRREADER_EXPORT bool isAtCorners(vtkDataArray& array);

/// Gives the cell arrays of values at corners the hull of these as the range of their magnitude and of each component, which
/// ParaView colours by: whichever is chosen, the scalar that all of them are is drawn. Puts others in the place of the arrays.
VTKTREEAMRREADER_EXPORT void setCornerRanges(vtkHyperTreeGrid& grid);

/// Of the field that an array stands for: 1 of values at corners.
VTKTREEAMRREADER_EXPORT int fieldComponents(vtkDataArray& array);

/// Of fields of values at corners where cells disagree, so that their means are used; or whose hanging corners do not
/// have the values of the larger cells beside them.
class CornerRemarks
{
public:
  /// array: the field's own.
  void add(vtkDataArray& array, const Field& field);
  /// One of each kind for all arrays.
  std::vector<Remark> all() const;

private:
  struct Kind
  {
    std::vector<std::string> arrays;
    double largest = 0.; // difference
  };
  Kind jumping_;
  Kind hanging_;
};

/// Of a single field.
VTKTREEAMRREADER_EXPORT Remark unevenCorners(vtkDataArray& array, const Field& field);

} // namespace treeamr
