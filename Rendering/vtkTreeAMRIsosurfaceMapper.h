/**
 * @class   vtkTreeAMRIsosurfaceMapper
 * @brief   ray-traces an isosurface of a vtkHyperTreeGrid on the CPU
 *
 * The surface is implicit: the points where the generalized trilinear interpolation of the cells' values (see
 * Core/Interpolation) equals Isovalue, without cracks at refinement levels and without triangles. The
 * contoured array is SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, name); unset it
 * is the active scalars or, when there are none, the first cell array.
 *
 * The actor's vtkProperty and the renderer's lights shade it as they shade polygons. It is coloured by an
 * array through vtkMapper's ScalarVisibility, ScalarMode, SelectColorArray() and LookupTable; arrays of
 * colours (direct scalars) are mapped like all others, and an array that does not exist leaves the solid
 * colour, with a warning. Real depth is written: the surface meets polygons and volumes correctly.
 *
 * Opacity below 1 shows the nearest layer of the surface translucent; layers behind it are not drawn yet.
 * Hardware selection gives the cells that the surface is seen in, as indices into the grid's cell arrays; a
 * surface has no points to select. Pickers that read the depth buffer (vtkPropPicker, vtkWorldPointPicker) find
 * points of the surface, where vtkTreeAMRProbeFilter gives the value of any array; those that intersect data
 * sets themselves (vtkCellPicker, vtkHardwarePicker) know no hyper tree grids. Clipping planes are not
 * implemented and warn. Needs an OpenGL window.
 */

#ifndef vtkTreeAMRIsosurfaceMapper_h
#define vtkTreeAMRIsosurfaceMapper_h

#include "vtkMapper.h"
#include "vtkTreeAMRRenderingModule.h" // for the export macro

#include <memory> // for std::unique_ptr
#include <string> // for std::string

class vtkHyperTreeGrid;

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRIsosurfaceMapper : public vtkMapper
{
public:
  static vtkTreeAMRIsosurfaceMapper* New();
  vtkTypeMacro(vtkTreeAMRIsosurfaceMapper, vtkMapper);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void SetInputData(vtkHyperTreeGrid* grid);
  vtkHyperTreeGrid* GetHyperTreeGrid();

  ///@{
  /// Default 0.
  vtkSetMacro(Isovalue, double);
  vtkGetMacro(Isovalue, double);
  ///@}
  ///@{
  /// Component of the contoured array; -1, the default, for the magnitude (of a scalar array the value).
  vtkSetMacro(IsosurfaceComponent, int);
  vtkGetMacro(IsosurfaceComponent, int);
  ///@}

  ///@{
  /// What hardware selection gives as composite index: the flat index of the grid's block in a composite data set.
  /// Default 1, as of a grid that is in none.
  vtkSetMacro(CompositeIndex, unsigned int);
  vtkGetMacro(CompositeIndex, unsigned int);
  ///@}

  ///@{
  /// Octants that the surface in use passes through, and when it was made; 0 before the first.
  vtkIdType GetNumberOfPrimitives();
  vtkMTimeType GetSurfaceBuildTime();
  ///@}

  /// Bounds of the trees that this process holds; uninitialised without input.
  double* GetBounds() VTK_SIZEHINT(6) override;
  void GetBounds(double bounds[6]) override { this->Superclass::GetBounds(bounds); }

  void Render(vtkRenderer* renderer, vtkActor* actor) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;
  bool GetSupportsSelection() override { return true; }

protected:
  vtkTreeAMRIsosurfaceMapper();
  ~vtkTreeAMRIsosurfaceMapper() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;

  double Isovalue = 0.;
  int IsosurfaceComponent = -1;
  unsigned int CompositeIndex = 1;

private:
  struct Internals;

  vtkHyperTreeGrid* UpdateInput();
  void UpdateSurface(vtkHyperTreeGrid* grid);
  void UpdateHits(vtkRenderer* renderer, vtkActor* actor);
  void RenderSurface(vtkRenderer* renderer, vtkActor* actor);
  void Select(vtkRenderer* renderer, vtkActor* actor);
  void Warn(const std::string& message);

  std::unique_ptr<Internals> Private;

  vtkTreeAMRIsosurfaceMapper(const vtkTreeAMRIsosurfaceMapper&) = delete;
  void operator=(const vtkTreeAMRIsosurfaceMapper&) = delete;
};

#endif
