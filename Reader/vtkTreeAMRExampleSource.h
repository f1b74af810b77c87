/**
 * @class   vtkTreeAMRExampleSource
 * @brief   example data that need no file: the paper's Synthetic grid, the Mandelbulb and a smooth sheet
 *
 * Synthetic (the paper's Figure 10): 4 x 4 x 4 roots over [0, 4]^3, those with x > 2 refined once: 288
 * leaves. Cell array "xyz" is f = xyz at the cells' centres.
 *
 * Mandelbulb: one root over the unit cube. Cells coarser than MinimumLevel are refined, and of the others
 * coarser than MaximumLevel those where the field's range over 3 x 3 x 3 probes exceeds RefinementThreshold;
 * then the tree is balanced 2:1 across faces, edges and corners. Cell array "mandelbulb" is the field at the
 * cells' centres. Levels 4 to 7 and a threshold of 0.05, the defaults, give 305,096 leaves; 4 to 9 and 0.55
 * give 2,636,936.
 *
 * Sheet: the same of a wavy shear sheet among blobs, a smooth field of values from 0 to 1, as cell array "sheet".
 * The defaults give 617,296 leaves.
 *
 * Coarse cells hold the mean of their children. Piece 0 has the whole grid; other pieces have no tree.
 * Properties out of range are an error and leave the output empty.
 */
#ifndef vtkTreeAMRExampleSource_h
#define vtkTreeAMRExampleSource_h

#include "vtkHyperTreeGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

class VTKTREEAMRREADER_EXPORT vtkTreeAMRExampleSource : public vtkHyperTreeGridAlgorithm
{
public:
  static vtkTreeAMRExampleSource* New();
  vtkTypeMacro(vtkTreeAMRExampleSource, vtkHyperTreeGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What the class description has by these names.
  enum DatasetType
  {
    SYNTHETIC = 0,
    MANDELBULB = 1,
    SHEET = 2
  };

  ///@{
  /**
   * SYNTHETIC, MANDELBULB or SHEET (default).
   */
  vtkSetMacro(Dataset, int);
  vtkGetMacro(Dataset, int);
  void SetDatasetToSynthetic() { this->SetDataset(SYNTHETIC); }
  void SetDatasetToMandelbulb() { this->SetDataset(MANDELBULB); }
  void SetDatasetToSheet() { this->SetDataset(SHEET); }
  ///@}

  ///@{
  /**
   * Level of the coarsest leaves, 0 to MaximumLevel; 4 by default. Not of Synthetic.
   */
  vtkSetMacro(MinimumLevel, int);
  vtkGetMacro(MinimumLevel, int);
  ///@}

  ///@{
  /**
   * Level of the finest leaves, at most 12; 7 by default. Not of Synthetic.
   */
  vtkSetMacro(MaximumLevel, int);
  vtkGetMacro(MaximumLevel, int);
  ///@}

  ///@{
  /**
   * Range of the field in a cell beyond which it is refined, >= 0; 0.05 by default. Not of Synthetic.
   */
  vtkSetMacro(RefinementThreshold, double);
  vtkGetMacro(RefinementThreshold, double);
  ///@}

protected:
  vtkTreeAMRExampleSource();
  ~vtkTreeAMRExampleSource() override = default;

  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int ProcessTrees(vtkHyperTreeGrid*, vtkDataObject*) override;

  int Dataset = SHEET;
  int MinimumLevel = 4;
  int MaximumLevel = 7;
  double RefinementThreshold = 0.05;

private:
  vtkTreeAMRExampleSource(const vtkTreeAMRExampleSource&) = delete;
  void operator=(const vtkTreeAMRExampleSource&) = delete;

  void CheckProperties();
};

#endif
