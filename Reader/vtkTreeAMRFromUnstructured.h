/**
 * @class   vtkTreeAMRFromUnstructured
 * @brief   makes a vtkHyperTreeGrid of the octree's leaves that unstructured grids hold as hexahedra
 *
 * What writers of p8est_vtk, deal.II, ForestClaw, t8code and others export of an octree or of a forest of octrees: cells of
 * VTK_HEXAHEDRON and VTK_VOXEL, their points shared or not, in any order, of any levels. Input is a vtkUnstructuredGrid or a
 * composite data set of them, all of whose blocks become one grid.
 *
 * The largest cells say how wide the roots are; every other cell has half, a quarter ... of that along all three axes and
 * begins at a multiple of its own widths from one of the largest. Coordinates may be rounded, to float or to six digits,
 * and cells shrunk about their centres, all alike. See Forest/BoxLattice.h for how much. Roots are joined to larger ones as
 * long as their numbers are even along all axes or there are more than 65,536: the last ones may reach beyond the cells then.
 * Where there is no cell the grid is masked.
 *
 * Of cells at one place the first counts, and none that vtkGhostType marks as duplicate, refined or hidden. An error names
 * the first cell that is no box along the axes or fits not the lattice, with its bounds, and cells that overlap; the output is
 * empty then. Of no cells it is empty, too, without an error.
 *
 * Cell arrays keep type, name, components and values. So do those arrays of points, of all or those that
 * GetPointDataArraySelection() enables, that no cell array has the name of. Those of one component of float or double get
 * eight, the values at the corners of each cell, in a cell array marked so (CornerArrays.h): what reads TreeAMR's grids
 * interpolates between them. Where each cell has one value at all its points it is the cell's. Others become the means of a
 * cell's eight points, as vtkPointDataToCellData makes them: a warning says so, once until that changes. It also names
 * arrays that not all blocks have alike, which are left out. A coarse cell has the mean of its children in arrays of float
 * and double, the values at its own corners in those of corners, and the value of its first child in others.
 *
 * In parallel the first process makes all of the grid: see vtkTreeAMRGridAlgorithm.
 */
#ifndef vtkTreeAMRFromUnstructured_h
#define vtkTreeAMRFromUnstructured_h

#include "vtkDataArraySelection.h" // for PointDataArraySelection
#include "vtkNew.h"                // for PointDataArraySelection
#include "vtkTreeAMRGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

#include <string> // for std::string

class VTKTREEAMRREADER_EXPORT vtkTreeAMRFromUnstructured : public vtkTreeAMRGridAlgorithm
{
public:
  static vtkTreeAMRFromUnstructured* New();
  vtkTypeMacro(vtkTreeAMRFromUnstructured, vtkTreeAMRGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The arrays of points to take, by name. As long as it knows none, and is not final: all.
  vtkDataArraySelection* GetPointDataArraySelection() { return this->PointDataArraySelection; }

  ///@{
  /**
   * Whether a selection that knows no array means none. Off by default.
   */
  vtkSetMacro(SelectionIsFinal, bool);
  vtkGetMacro(SelectionIsFinal, bool);
  vtkBooleanMacro(SelectionIsFinal, bool);
  ///@}

  /// Changes with the selection, too.
  vtkMTimeType GetMTime() override;

protected:
  vtkTreeAMRFromUnstructured() = default;
  ~vtkTreeAMRFromUnstructured() override = default;

  const char* GetInputKind() const override;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) override;

private:
  bool IsWanted(const std::string& array);
  void WarnOfUnknownArrays(const treeamr::BlockArrays& arrays);

  vtkNew<vtkDataArraySelection> PointDataArraySelection;
  bool SelectionIsFinal = false;

  vtkTreeAMRFromUnstructured(const vtkTreeAMRFromUnstructured&) = delete;
  void operator=(const vtkTreeAMRFromUnstructured&) = delete;
};

#endif
