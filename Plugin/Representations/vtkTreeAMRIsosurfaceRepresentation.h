// A ray-traced isosurface of a vtkHyperTreeGrid in ParaView's render view, by vtkTreeAMRIsosurfaceMapper.

#ifndef vtkTreeAMRIsosurfaceRepresentation_h
#define vtkTreeAMRIsosurfaceRepresentation_h

#include "vtkNew.h"                     // for members
#include "vtkProperty.h"                // for forwarding
#include "vtkTreeAMRIsosurfaceMapper.h" // for forwarding
#include "vtkTreeAMRRepresentation.h"

class vtkAlgorithm;
class vtkPolyData;
class vtkScalarsToColors;
class vtkTreeAMRIsosurfaceActor;

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
  void SetIsovalue(int index, double value) { this->Mapper->SetValue(index, value); }
  void SetNumberOfIsovalues(int number) { this->Mapper->SetNumberOfContours(number); }
  void SetAmbientOcclusionSamples(int samples) { this->Mapper->SetAmbientOcclusionSamples(samples); }
  void SetAutoAdjustSampleDistances(bool adjust) { this->Mapper->SetAutoAdjustSampleDistances(adjust); }
  void SetImageSampleDistance(double distance) { this->Mapper->SetImageSampleDistance(distance); }
  void SetMinimumImageSampleDistance(double distance)
  {
    this->Mapper->SetMinimumImageSampleDistance(distance);
  }
  void SetMaximumImageSampleDistance(double distance)
  {
    this->Mapper->SetMaximumImageSampleDistance(distance);
  }
  void SetInteractiveRenderTime(double seconds) { this->Mapper->SetInteractiveRenderTime(seconds); }
  void SetLevelOfDetail(double pixels) { this->Mapper->SetLevelOfDetail(pixels); }
  void SetAmbientOcclusionRadius(double radius) { this->Mapper->SetAmbientOcclusionRadius(radius); }
  void SetShadows(bool shadows) { this->Mapper->SetShadows(shadows); }
  ///@}

  ///@{
  /// What exporters write: the triangles of this process's part of the surfaces (null: none), and what a process that
  /// has not all of the grid has exporters write in their place. Both are of the last picture.
  vtkPolyData* GetTriangles();
  void SetExportedTriangles(vtkAlgorithm* triangles);
  ///@}

  /// Colours of the array chosen in the Coloring section. Without one the surface has the diffuse colour.
  void SetLookupTable(vtkScalarsToColors* colors) { this->Mapper->SetLookupTable(colors); }
  void SetMapScalars(bool map);

  ///@{
  /// Forwarded to the actor's property.
  void SetAmbient(double coefficient) { this->Property->SetAmbient(coefficient); }
  void SetDiffuse(double coefficient) { this->Property->SetDiffuse(coefficient); }
  void SetSpecular(double coefficient) { this->Property->SetSpecular(coefficient); }
  void SetSpecularPower(double power) { this->Property->SetSpecularPower(power); }
  void SetOpacity(double opacity) { this->Property->SetOpacity(opacity); }
  void SetInterpolation(int interpolation) { this->Property->SetInterpolation(interpolation); }
  void SetAmbientColor(double r, double g, double b) { this->Property->SetAmbientColor(r, g, b); }
  void SetDiffuseColor(double r, double g, double b) { this->Property->SetDiffuseColor(r, g, b); }
  void SetSpecularColor(double r, double g, double b) { this->Property->SetSpecularColor(r, g, b); }
  ///@}

protected:
  vtkTreeAMRIsosurfaceRepresentation();
  ~vtkTreeAMRIsosurfaceRepresentation() override;

  vtkProp3D* GetProp() override;
  bool NeedsOrderedCompositing() override;
  bool IsExportedWithoutTrees() override { return this->HasExportedTriangles; }
  std::set<std::string> GetShownArrays() override;
  bool HasSelectableCells() override { return true; }
  std::vector<double> GetDraftedIsovalues() override;
  void UpdateMapper(vtkAlgorithmOutput* grid) override;
  void AgreeOnDrafts(vtkRenderer* renderer, const Largest& largest) override;

private:
  vtkTreeAMRIsosurfaceRepresentation(const vtkTreeAMRIsosurfaceRepresentation&) = delete;
  void operator=(const vtkTreeAMRIsosurfaceRepresentation&) = delete;

  vtkNew<vtkTreeAMRIsosurfaceActor> Actor;
  vtkNew<vtkProperty> Property;
  vtkNew<vtkTreeAMRIsosurfaceMapper> Mapper;
  std::string IsosurfaceArray;
  int IsosurfaceComponent = 0;
  int RefusedComponent = 0; // that was told of
  bool HasExportedTriangles = false;
};

#endif
