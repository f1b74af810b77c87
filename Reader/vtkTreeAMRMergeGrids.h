/**
 * @class   vtkTreeAMRMergeGrids
 * @brief   makes one vtkHyperTreeGrid of those of a composite data set
 *
 * Of pieces of one simulation, or of the halves of a mirrored domain, fields are continuous then where the pieces meet. The
 * roots of all grids must lie on one lattice: each between neighbouring planes of the lattice that the planes of all form,
 * which may be spaced unevenly and need not have a tree everywhere. Pieces may share trees whose cells are masked where
 * other pieces have them. Of cells at one place the first grid's counts, and none that are masked, hidden or ghosts.
 *
 * Cell arrays that all grids have alike keep type, name, components and values; a warning names the others, once. A coarse
 * cell has the mean of its children in arrays of float and double, and the value of its first child in others.
 *
 * An error names the grid that fits no lattice and cells that overlap; the output is empty then. In parallel each process
 * merges its own.
 */
#ifndef vtkTreeAMRMergeGrids_h
#define vtkTreeAMRMergeGrids_h

#include "vtkTreeAMRGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

class VTKTREEAMRREADER_EXPORT vtkTreeAMRMergeGrids : public vtkTreeAMRGridAlgorithm
{
public:
  static vtkTreeAMRMergeGrids* New();
  vtkTypeMacro(vtkTreeAMRMergeGrids, vtkTreeAMRGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkTreeAMRMergeGrids() = default;
  ~vtkTreeAMRMergeGrids() override = default;

  const char* GetInputKind() const override;
  bool GathersPieces() const override { return false; } // which ParaView cannot send
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) override;

private:
  vtkTreeAMRMergeGrids(const vtkTreeAMRMergeGrids&) = delete;
  void operator=(const vtkTreeAMRMergeGrids&) = delete;
};

#endif
