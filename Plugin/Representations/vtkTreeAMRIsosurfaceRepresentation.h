// A ray-traced isosurface of a vtkHyperTreeGrid in ParaView's render view, by vtkTreeAMRIsosurfaceMapper.

#ifndef vtkTreeAMRIsosurfaceRepresentation_h
#define vtkTreeAMRIsosurfaceRepresentation_h

#include "vtkNew.h" // for members
#include "vtkTreeAMRRepresentation.h"

class vtkAlgorithm;
class vtkPolyData;
class vtkProperty;
class vtkScalarsToColors;
class vtkTreeAMRIsosurfaceActor;
class vtkTreeAMRIsosurfaceMapper;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkTreeAMRIsosurfaceRepresentation : public vtkTreeAMRRepresentation
{
public:
  static vtkTreeAMRIsosurfaceRepresentation* New();
  vtkTypeMacro(vtkTreeAMRIsosurfaceRepresentation, vtkTreeAMRRepresentation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The contoured cell array, in the five values of an array property: its name counts. Empty: the first.
  void SetIsosurfaceArray(int index, int port, int connection, int association, const char* name);
  /// The contoured component. The number of components, or more: the magnitude.
  void SetIsosurfaceComponent(int component);
  ///@{
  /// Forwarded to the mapper.
  void SetIsovalue(int index, double value);
  void SetNumberOfIsovalues(int number);
  void SetAmbientOcclusionSamples(int samples);
  void SetAutoAdjustSampleDistances(bool adjust);
  void SetImageSampleDistance(double distance);
  void SetMinimumImageSampleDistance(double distance);
  void SetMaximumImageSampleDistance(double distance);
  void SetInteractiveRenderTime(double seconds);
  void SetLevelOfDetail(double pixels);
  void SetAmbientOcclusionRadius(double radius);
  void SetShadows(bool shadows);
  ///@}

  ///@{
  /// What exporters write: the triangles of this process's part of the surfaces (null: none), and what a process that
  /// has not all of the grid has exporters write in their place. Both are of the last picture.
  vtkPolyData* GetTriangles();
  void SetExportedTriangles(vtkAlgorithm* triangles);
  ///@}

  /// Colours of the array chosen in the Coloring section. Without one the surface has the diffuse colour.
  void SetLookupTable(vtkScalarsToColors* colors);
  void SetMapScalars(bool map);

  ///@{
  /// Forwarded to the actor's property.
  void SetAmbient(double coefficient);
  void SetDiffuse(double coefficient);
  void SetSpecular(double coefficient);
  void SetSpecularPower(double power);
  void SetOpacity(double opacity);
  void SetInterpolation(int interpolation);
  void SetAmbientColor(double r, double g, double b);
  void SetDiffuseColor(double r, double g, double b);
  void SetSpecularColor(double r, double g, double b);
  ///@}

protected:
  vtkTreeAMRIsosurfaceRepresentation();
  ~vtkTreeAMRIsosurfaceRepresentation() override;

  vtkProp3D* GetProp() override;
  bool NeedsOrderedCompositing() override;
  bool IsExportedWithoutTrees() override { return this->HasExportedTriangles; }
  std::vector<double> GetDraftedIsovalues() override;
  void UpdateMapper(vtkAlgorithmOutput* grid) override;

private:
  vtkTreeAMRIsosurfaceRepresentation(const vtkTreeAMRIsosurfaceRepresentation&) = delete;
  void operator=(const vtkTreeAMRIsosurfaceRepresentation&) = delete;

  vtkNew<vtkTreeAMRIsosurfaceActor> Actor;
  vtkNew<vtkProperty> Property;
  vtkNew<vtkTreeAMRIsosurfaceMapper> Mapper;
  std::string IsosurfaceArray;
  int IsosurfaceComponent = 0;
  bool HasExportedTriangles = false;
};

#endif
