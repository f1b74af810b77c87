/**
 * @class   vtkTreeAMRContourFilter
 * @brief   isosurfaces of a vtkHyperTreeGrid as polygons, watertight across refinement levels
 *
 * The triangles of the surfaces where the reconstructed field (GTI, as vtkTreeAMRIsosurfaceMapper draws it)
 * has the given values. Within a surface every edge has two triangles, whatever the levels that meet there,
 * but for edges on the boundary of the domain, towards missing cells and towards ghosts. Normals and the
 * order of a triangle's points point to lower values, as those of vtkContourFilter do. Points are double
 * precision.
 *
 * SetInputArrayToProcess() chooses the cell array, the active scalars by default, and SetComponent() which of its
 * components counts. Every other numeric cell array (but vtkGhostType), or those that GetCellDataArraySelection()
 * enables, is interpolated at the points, component by component: arrays of double and of integers of 32 bits or more
 * give double, all others float. A point is NaN where an array has no finite value in the cells around. Of whole
 * numbers that are rounded, and of values that lie closer together than doubles can tell, a warning says so, once
 * until it goes away. See HyperTreeGridConverter.h for the cells that are drawn and the digits of their values.
 *
 * The output does not depend on the number of threads. It is empty for a grid without trees; for a value that
 * is not finite and for a grid or array that cannot be converted there is an error, too.
 */
#ifndef vtkTreeAMRContourFilter_h
#define vtkTreeAMRContourFilter_h

#include "vtkNew.h" // for its members
#include "vtkPolyDataAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

#include <memory> // for std::unique_ptr

class vtkContourValues;
class vtkDataArraySelection;
class vtkHyperTreeGrid;

namespace treeamr
{
class OnceReporter;
class ProcessGroup;
struct Remark;
} // namespace treeamr

class VTKTREEAMRREADER_EXPORT vtkTreeAMRContourFilter : public vtkPolyDataAlgorithm
{
public:
  static vtkTreeAMRContourFilter* New();
  vtkTypeMacro(vtkTreeAMRContourFilter, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The isovalues, as in vtkContourFilter: a single 0 by default.
   */
  void SetValue(int i, double value);
  double GetValue(int i);
  double* GetValues();
  void GetValues(double* contourValues);
  void SetNumberOfContours(int number);
  vtkIdType GetNumberOfContours();
  void GenerateValues(int numContours, double range[2]);
  void GenerateValues(int numContours, double rangeStart, double rangeEnd);
  ///@}

  ///@{
  /**
   * Component of the contoured array; -1, or one beyond the last, for the magnitude. Default 0, the first.
   */
  vtkSetMacro(Component, int);
  vtkGetMacro(Component, int);
  ///@}

  /**
   * The cell arrays to interpolate beside the contoured one: those that are enabled, or all as long as the selection
   * knows no array. What is not selected costs no time or memory.
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
   * Of the filter, its values and its selection.
   */
  vtkMTimeType GetMTime() override;

  ///@{
  /**
   * Whether to add "Normals", against the gradients. On by default.
   */
  vtkSetMacro(ComputeNormals, bool);
  vtkGetMacro(ComputeNormals, bool);
  vtkBooleanMacro(ComputeNormals, bool);
  ///@}

  ///@{
  /**
   * Whether to add "Gradients" in world coordinates, continuous across all levels as the normals are: interpolated
   * between those of the vertices (see Core/Interpolation/BlockGradients.h). Double precision, as differences of floats
   * over short ways may be beyond float. Off by default.
   */
  vtkSetMacro(ComputeGradients, bool);
  vtkGetMacro(ComputeGradients, bool);
  vtkBooleanMacro(ComputeGradients, bool);
  ///@}

  ///@{
  /**
   * Whether to add the isovalue as active scalars, under the name of the array. On by default.
   */
  vtkSetMacro(ComputeScalars, bool);
  vtkGetMacro(ComputeScalars, bool);
  vtkBooleanMacro(ComputeScalars, bool);
  ///@}

protected:
  vtkTreeAMRContourFilter();
  ~vtkTreeAMRContourFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

  vtkNew<vtkContourValues> ContourValues;
  vtkNew<vtkDataArraySelection> CellDataArraySelection;
  bool SelectionIsFinal = false;
  int Component = 0;
  bool ComputeNormals = true;
  bool ComputeGradients = false;
  bool ComputeScalars = true;

private:
  vtkTreeAMRContourFilter(const vtkTreeAMRContourFilter&) = delete;
  void operator=(const vtkTreeAMRContourFilter&) = delete;

  void ContourOnAll(const treeamr::ProcessGroup& group, vtkDataObject* input, vtkPolyData* output);
  void ContourAll(vtkDataObject* input, vtkPolyData* output);
  void Contour(vtkHyperTreeGrid* input, vtkPolyData* output);
  void Warn(const treeamr::Remark& remark);

  std::unique_ptr<treeamr::OnceReporter> Warnings;
};

#endif
