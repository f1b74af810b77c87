// The surfaces of an isosurface mapper as polygons in its colours, for those who cannot trace rays. Private
// to the module.
#pragma once

#include "vtkPolyDataAlgorithm.h"
#include "vtkSmartPointer.h"

class vtkHyperTreeGrid;
class vtkTreeAMRIsosurfaceMapper;
class vtkUnsignedCharArray;

namespace treeamr
{

/// From the mapper's input to the triangles of vtkTreeAMRContourFilter, with Normals and the isovalues; where
/// the mapper colours by an array, the RGBA colours at the points are the active scalars, else there are
/// none. Errors leave the output empty or without colours, and are said as the filter's.
class IsosurfaceTriangles : public vtkPolyDataAlgorithm
{
public:
  static IsosurfaceTriangles* New();
  vtkTypeMacro(IsosurfaceTriangles, vtkPolyDataAlgorithm);

  void SetMapper(vtkTreeAMRIsosurfaceMapper* mapper);

  /// Changes with the mapper.
  vtkMTimeType GetMTime() override;

protected:
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkSmartPointer<vtkUnsignedCharArray> Colors(vtkHyperTreeGrid* grid, vtkPolyData* triangles);

  vtkSmartPointer<vtkTreeAMRIsosurfaceMapper> Mapper;
};

} // namespace treeamr
