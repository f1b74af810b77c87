/**
 * @class   vtkTreeAMRProbeFilter
 * @brief   the reconstructed arrays of a vtkHyperTreeGrid at the points of a data set
 *
 * Input 0 gives the points, input 1 (Source) the grid; exchanged they are an error that says so. The output has
 * the geometry of input 0 and, as point arrays, the numeric cell arrays of the grid (all but vtkGhostType, or
 * those that GetCellDataArraySelection() enables) under their own names, all components interpolated one by one,
 * and on request "<name>_gradient" with three components per component of the array (d/dx, d/dy, d/dz of the
 * first, then of the second ...). Values have the array's own type, whole numbers rounded as by vtkProbeFilter (bits
 * give unsigned char); gradients are double, as differences over short ways may be beyond float.
 *
 * The array named ValidPointMaskArrayName is 1 at points inside a cell (ghosts too) and 0 outside, where
 * values and gradients are 0. A point in a cell whose value is not finite in one array only is NaN in that
 * array. See HyperTreeGridConverter.h for the cells that are drawn.
 *
 * NEAREST copies the tuples of the cells, as the numbers of their array's type: identifiers stay what they are.
 *
 * The other methods reconstruct values from floats, those of doubles and integers that lie close together beside their
 * size less an offset (see HyperTreeGridConverter.h): about seven digits of the range. Of whole numbers that are
 * rounded, and of values that lie closer together than doubles can tell, a warning says so, once until it goes away.
 *
 * Without a usable array, or for a grid that cannot be converted, there is an error and the output is empty;
 * single arrays that cannot be converted are left out with a warning.
 */
#ifndef vtkTreeAMRProbeFilter_h
#define vtkTreeAMRProbeFilter_h

#include "vtkDataSetAlgorithm.h"
#include "vtkNew.h" // for CellDataArraySelection
#include "vtkTreeAMRReaderModule.h"

#include <memory> // for std::unique_ptr
#include <string> // for std::string
#include <vector> // for std::vector

class vtkDataArraySelection;
class vtkHyperTreeGrid;

namespace treeamr
{
class OnceReporter;
class ProcessGroup;
}

class VTKTREEAMRREADER_EXPORT vtkTreeAMRProbeFilter : public vtkDataSetAlgorithm
{
public:
  static vtkTreeAMRProbeFilter* New();
  vtkTypeMacro(vtkTreeAMRProbeFilter, vtkDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The grid to be probed.
   */
  void SetSourceData(vtkHyperTreeGrid* source);
  void SetSourceConnection(vtkAlgorithmOutput* source);
  vtkHyperTreeGrid* GetSource();
  ///@}

  /// As treeamr::InterpolationMethod (Sampler.h).
  enum InterpolationMethodType
  {
    NEAREST = 0,
    CURRENT = 1,
    FINEST = 2,
    OCTANT = 3,
    GTI = 4
  };

  ///@{
  /**
   * How values between the cells' centres are reconstructed, one of the paper's five methods; GTI by default.
   */
  vtkSetClampMacro(InterpolationMethod, int, NEAREST, GTI);
  vtkGetMacro(InterpolationMethod, int);
  void SetInterpolationMethodToNearest() { this->SetInterpolationMethod(NEAREST); }
  void SetInterpolationMethodToCurrent() { this->SetInterpolationMethod(CURRENT); }
  void SetInterpolationMethodToFinest() { this->SetInterpolationMethod(FINEST); }
  void SetInterpolationMethodToOctant() { this->SetInterpolationMethod(OCTANT); }
  void SetInterpolationMethodToGTI() { this->SetInterpolationMethod(GTI); }
  ///@}

  ///@{
  /**
   * Whether to add the gradients, in world coordinates. Off by default.
   */
  vtkSetMacro(ComputeGradients, bool);
  vtkGetMacro(ComputeGradients, bool);
  vtkBooleanMacro(ComputeGradients, bool);
  ///@}

  /**
   * The cell arrays to interpolate: those that are enabled, or all as long as the selection knows no array. What is not
   * selected costs no time or memory.
   */
  vtkDataArraySelection* GetCellDataArraySelection() { return this->CellDataArraySelection; }

  ///@{
  /**
   * Whether a selection that knows no array selects none. Off by default.
   */
  vtkSetMacro(SelectionIsFinal, bool);
  vtkGetMacro(SelectionIsFinal, bool);
  vtkBooleanMacro(SelectionIsFinal, bool);
  ///@}

  /**
   * Of the filter and its selection.
   */
  vtkMTimeType GetMTime() override;

  ///@{
  /**
   * Name of the array that marks the points inside; "vtkValidPointMask" by default.
   */
  vtkSetStringMacro(ValidPointMaskArrayName);
  vtkGetStringMacro(ValidPointMaskArrayName);
  ///@}

  ///@{
  /**
   * Whether to pass the arrays of input 0 whose names are not taken by the results (off by default), and its
   * field data (on by default), as in vtkProbeFilter.
   */
  vtkSetMacro(PassPointArrays, bool);
  vtkGetMacro(PassPointArrays, bool);
  vtkBooleanMacro(PassPointArrays, bool);
  vtkSetMacro(PassCellArrays, bool);
  vtkGetMacro(PassCellArrays, bool);
  vtkBooleanMacro(PassCellArrays, bool);
  vtkSetMacro(PassFieldArrays, bool);
  vtkGetMacro(PassFieldArrays, bool);
  vtkBooleanMacro(PassFieldArrays, bool);
  ///@}

protected:
  vtkTreeAMRProbeFilter();
  ~vtkTreeAMRProbeFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

  vtkNew<vtkDataArraySelection> CellDataArraySelection;
  bool SelectionIsFinal = false;
  int InterpolationMethod = GTI;
  bool ComputeGradients = false;
  char* ValidPointMaskArrayName = nullptr;
  bool PassPointArrays = false;
  bool PassCellArrays = false;
  bool PassFieldArrays = true;

private:
  vtkTreeAMRProbeFilter(const vtkTreeAMRProbeFilter&) = delete;
  void operator=(const vtkTreeAMRProbeFilter&) = delete;

  void ProbeOnAll(const treeamr::ProcessGroup& group, vtkDataSet* input, vtkHyperTreeGrid* source,
    const std::vector<std::string>& remarksOnSource, vtkDataSet* output);
  void Probe(vtkDataSet* input, vtkHyperTreeGrid* source, const std::vector<std::string>& remarksOnSource,
    vtkDataSet* output);

  std::unique_ptr<treeamr::OnceReporter> Warnings;
};

#endif
