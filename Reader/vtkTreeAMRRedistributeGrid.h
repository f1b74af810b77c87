/**
 * @class   vtkTreeAMRRedistributeGrid
 * @brief   spreads the cells of a vtkHyperTreeGrid over the processes by boxes
 *
 * Whatever cells each process has, afterwards it has those of a box of the domain, about as many each, and those beyond that
 * the field there depends on, marked DUPLICATECELL. So its isosurfaces and interpolated values are those of all cells together,
 * bit for bit, and those of all processes fit seamlessly. Mappers and vtkTreeAMRContourFilter of this module draw in the box
 * alone. The Tree AMR representations of ParaView do this by themselves.
 *
 * Cells marked as ghosts, hidden and masked ones are left out; of cells that several processes have the first one's counts,
 * and a source that gives each process the same grid is told by its content. Cell arrays of numbers that all processes with
 * trees have alike keep type, name, components and values; a warning names others. Grids that are spread so already, as
 * forests' readers make them, and those of a single process pass as they are.
 *
 * All processes of the controller must execute it, as ParaView's do. What is wrong with one of the grids is an error on all,
 * and the outputs are empty then.
 */
#ifndef vtkTreeAMRRedistributeGrid_h
#define vtkTreeAMRRedistributeGrid_h

#include "vtkSmartPointer.h" // for Controller
#include "vtkTreeAMRGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

class vtkMultiProcessController;

class VTKTREEAMRREADER_EXPORT vtkTreeAMRRedistributeGrid : public vtkTreeAMRGridAlgorithm
{
public:
  static vtkTreeAMRRedistributeGrid* New();
  vtkTypeMacro(vtkTreeAMRRedistributeGrid, vtkTreeAMRGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// Of the processes; the global one unless set, null: this process alone.
  void SetController(vtkMultiProcessController* controller);
  vtkMultiProcessController* GetController();
  ///@}

protected:
  vtkTreeAMRRedistributeGrid();
  ~vtkTreeAMRRedistributeGrid() override;

  const char* GetInputKind() const override;
  bool GathersPieces() const override { return false; }
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) override;

private:
  vtkTreeAMRRedistributeGrid(const vtkTreeAMRRedistributeGrid&) = delete;
  void operator=(const vtkTreeAMRRedistributeGrid&) = delete;

  vtkSmartPointer<vtkMultiProcessController> Controller;
};

#endif
