#include "vtkTreeAMRIsosurfaceRepresentation.h"

#include "vtkAlgorithmOutput.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkHyperTreeGrid.h"
#include "vtkObjectFactory.h"
#include "vtkProperty.h"
#include "vtkScalarsToColors.h"
#include "vtkTreeAMRIsosurfaceActor.h"
#include "vtkTreeAMRIsosurfaceMapper.h"

vtkStandardNewMacro(vtkTreeAMRIsosurfaceRepresentation);

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceRepresentation::vtkTreeAMRIsosurfaceRepresentation()
{
  this->Actor->SetProperty(this->Property);
  this->Actor->SetMapper(this->Mapper);
  this->Mapper->SetScalarModeToUseCellFieldData();
  // ParaView puts the range into the table, not into the mapper.
  this->Mapper->UseLookupTableScalarRangeOn();
  this->FollowProgress(this->Mapper);
}

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceRepresentation::~vtkTreeAMRIsosurfaceRepresentation() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "IsosurfaceArray: " << this->IsosurfaceArray << endl;
  os << indent << "IsosurfaceComponent: " << this->IsosurfaceComponent << endl;
  os << indent << "Mapper: " << endl;
  this->Mapper->PrintSelf(os, indent.GetNextIndent());
}

//------------------------------------------------------------------------------
vtkProp3D* vtkTreeAMRIsosurfaceRepresentation::GetProp()
{
  return this->Actor;
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceRepresentation::NeedsOrderedCompositing()
{
  if (this->Property->GetOpacity() < 1.)
  {
    return true;
  }
  // The mapper gets the grid when it is rendered, which is later.
  const std::string colored = this->GetColorArrayName();
  vtkDataArray* array = this->Grid ? this->Grid->GetCellData()->GetArray(colored.c_str()) : nullptr;
  return !colored.empty() && this->Mapper->HasTranslucentColors(array);
}

//------------------------------------------------------------------------------
std::set<std::string> vtkTreeAMRIsosurfaceRepresentation::GetShownArrays()
{
  std::set<std::string> names{ this->IsosurfaceArray };
  if (const std::string colored = this->GetColorArrayName(); !colored.empty())
  {
    names.insert(colored);
  }
  return names;
}

//------------------------------------------------------------------------------
std::vector<double> vtkTreeAMRIsosurfaceRepresentation::GetDraftedIsovalues()
{
  if (!this->Mapper->GetAutoAdjustSampleDistances())
  {
    return {};
  }
  const double* values = this->Mapper->GetValues();
  return { values, values + this->Mapper->GetNumberOfContours() };
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::UpdateMapper(vtkAlgorithmOutput* grid)
{
  // Not left to the actor, which a client does not draw.
  this->Actor->ReleaseTriangles();
  this->Mapper->SetInputConnection(grid);
  this->Mapper->SetCompositeIndex(this->GridFlatIndex);
  const char* contoured = this->IsosurfaceArray.empty() ? nullptr : this->IsosurfaceArray.c_str();
  // Without a name the mapper takes the first array.
  this->Mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, contoured);
  // Behind the components ParaView's choices have the magnitude.
  vtkDataArray* array = this->Grid->GetCellData()->GetArray(contoured);
  const int components = array ? array->GetNumberOfComponents() : 0;
  const bool component = this->IsosurfaceComponent < components;
  if (array && (this->IsosurfaceComponent > components || this->IsosurfaceComponent < -1) &&
    this->IsosurfaceComponent != this->RefusedComponent)
  {
    vtkWarningMacro("IsosurfaceComponent " << this->IsosurfaceComponent << ", allowed are 0 to "
                                           << components - 1 << " of the array '" << contoured << "' and "
                                           << components << " for the magnitude, which is taken.");
    this->RefusedComponent = this->IsosurfaceComponent;
  }
  this->Mapper->SetIsosurfaceComponent(component ? this->IsosurfaceComponent : -1);

  const std::string colored = this->GetColorArrayName();
  this->Mapper->SetScalarVisibility(!colored.empty());
  this->Mapper->SelectColorArray(colored.c_str());
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::AgreeOnDrafts(vtkRenderer* renderer, const Largest& largest)
{
  this->Mapper->AgreeOnDrafts(renderer, this->Actor, largest);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::SetIsosurfaceArray(int vtkNotUsed(index), int vtkNotUsed(port),
  int vtkNotUsed(connection), int vtkNotUsed(association), const char* name)
{
  this->IsosurfaceArray = name ? name : "";
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::SetIsosurfaceComponent(int component)
{
  this->IsosurfaceComponent = component;
}

//------------------------------------------------------------------------------
vtkPolyData* vtkTreeAMRIsosurfaceRepresentation::GetTriangles()
{
  return this->Actor->GetTriangles();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::SetExportedTriangles(vtkAlgorithm* triangles)
{
  this->HasExportedTriangles = triangles != nullptr;
  this->Actor->SetExportedTriangles(triangles);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceRepresentation::SetMapScalars(bool map)
{
  map ? this->Mapper->SetColorModeToMapScalars() : this->Mapper->SetColorModeToDirectScalars();
}
