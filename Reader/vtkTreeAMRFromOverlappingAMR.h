/**
 * @class   vtkTreeAMRFromOverlappingAMR
 * @brief   makes one vtkHyperTreeGrid of the blocks of block-structured AMR
 *
 * Input is a vtkOverlappingAMR, as readers of AMReX, Enzo, Flash and others make it: on each level blocks of equal cells,
 * those of a finer level 2, 4, 8 ... times smaller along all axes. Cells that no finer block covers become leaves, with
 * their own values, covered ones inner nodes; with ratios beyond 2 there are nodes of levels between. The coarsest cells
 * are the roots, joined to larger ones as vtkTreeAMRFromUnstructured does. Where there is no block the grid is masked.
 *
 * What is covered is known from the blocks' places, so the input need not be blanked. Blocks of a level may lie anywhere:
 * beyond those of the level before; on each other, where the first counts; or over a part of a coarser cell, the rest of
 * which is divided into cells of its value, and a warning names the first such block.
 *
 * Of vtkGhostType cells that are duplicate or hidden are left out, and those that are refined though no block there
 * covers them, as ParaView's Surface leaves them out. Layers of duplicates around a block cover nothing.
 *
 * An error names the first block, by level and index, that is not of three dimensions, whose cells are not of such a
 * ratio, or that fits not the lattice of the coarsest cells; the output is empty then. Of no cells it is empty, too,
 * without an error.
 *
 * Arrays are treated as vtkTreeAMRFromUnstructured does: cell arrays keep type, name, components and values, arrays of
 * points are averaged, what not all blocks have alike is left out, and warnings name these.
 *
 * In parallel the first process makes all of the grid: see vtkTreeAMRGridAlgorithm.
 */
#ifndef vtkTreeAMRFromOverlappingAMR_h
#define vtkTreeAMRFromOverlappingAMR_h

#include "vtkTreeAMRGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

class VTKTREEAMRREADER_EXPORT vtkTreeAMRFromOverlappingAMR : public vtkTreeAMRGridAlgorithm
{
public:
  static vtkTreeAMRFromOverlappingAMR* New();
  vtkTypeMacro(vtkTreeAMRFromOverlappingAMR, vtkTreeAMRGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkTreeAMRFromOverlappingAMR() = default;
  ~vtkTreeAMRFromOverlappingAMR() override = default;

  const char* GetInputKind() const override;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) override;

private:
  vtkTreeAMRFromOverlappingAMR(const vtkTreeAMRFromOverlappingAMR&) = delete;
  void operator=(const vtkTreeAMRFromOverlappingAMR&) = delete;
};

#endif
