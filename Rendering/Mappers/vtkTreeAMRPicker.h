/**
 * @class   vtkTreeAMRPicker
 * @brief   picks points of ray-traced isosurfaces and volumes, and what vtkVolumePicker picks
 *
 * VTK's own pickers that intersect data sets (vtkCellPicker, vtkVolumePicker, vtkPointPicker) know no hyper tree grids of
 * three dimensions, and pick nothing of them. This one, used in their place, picks the first point on the line of sight
 * of all there is: of a vtkTreeAMRIsosurfaceMapper the surface, exactly; of a vtkTreeAMRVolumeMapper, as vtkCellPicker of
 * images, where the scalar opacity is VolumeOpacityIsovalue or more, to an eighth of a cell (gradient opacity, a second
 * property of that picker, takes no part), within the mapper's cropping regions. Everything else is the superclass's.
 *
 * PickPosition, MapperPosition and the normals are as always: towards lower values or, of volumes that are opaque where the
 * line enters, of the face there. CellId is the index into the grid's cell arrays, PickedGrid has these, PickedValue is the
 * value of the contoured or drawn array there. DataSet, sub-cells and points are for data sets.
 */

#ifndef vtkTreeAMRPicker_h
#define vtkTreeAMRPicker_h

#include "vtkSmartPointer.h"           // for PickedGrid
#include "vtkTreeAMRRenderingModule.h" // for the export macro
#include "vtkVolumePicker.h"

class vtkHyperTreeGrid;

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRPicker : public vtkVolumePicker
{
public:
  static vtkTreeAMRPicker* New();
  vtkTypeMacro(vtkTreeAMRPicker, vtkVolumePicker);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Of the last pick; null: nothing of a hyper tree grid was picked.
  vtkHyperTreeGrid* GetPickedGrid();
  /// Of the last pick; NaN then.
  vtkGetMacro(PickedValue, double);

protected:
  vtkTreeAMRPicker();
  ~vtkTreeAMRPicker() override;

  void ResetPickInfo() override;
  double IntersectActorWithLine(const double p1[3], const double p2[3], double t1, double t2, double tol,
    vtkProp3D* prop, vtkMapper* mapper) override;
  double IntersectVolumeWithLine(const double p1[3], const double p2[3], double t1, double t2,
    vtkProp3D* prop, vtkAbstractVolumeMapper* mapper) override;

private:
  struct Found;

  /// If it is the nearest so far. Returns its parameter.
  double Take(const Found& found, const double p1[3], const double p2[3], vtkAbstractMapper3D* mapper,
    vtkHyperTreeGrid* grid);

  vtkSmartPointer<vtkHyperTreeGrid> PickedGrid;
  double PickedValue;

  vtkTreeAMRPicker(const vtkTreeAMRPicker&) = delete;
  void operator=(const vtkTreeAMRPicker&) = delete;
};

#endif
