#include "vtkTreeAMRIsosurfaceActor.h"

#include "IsosurfaceTriangles.h"

#include "vtkAlgorithm.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkPolyDataMapper.h"
#include "vtkPropCollection.h"
#include "vtkRenderer.h"
#include "vtkTreeAMRIsosurfaceMapper.h"

vtkStandardNewMacro(vtkTreeAMRIsosurfaceActor);

//------------------------------------------------------------------------------
struct vtkTreeAMRIsosurfaceActor::Polygons
{
  vtkNew<treeamr::IsosurfaceTriangles> Triangles;
  vtkNew<vtkPolyDataMapper> Mapper;
  vtkNew<vtkMatrix4x4> Matrix;
  vtkNew<vtkActor> Actor;

  Polygons()
  {
    this->Mapper->SetScalarModeToUsePointData();
    this->Actor->SetMapper(this->Mapper);
    this->Actor->SetUserMatrix(this->Matrix);
  }
};

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceActor::vtkTreeAMRIsosurfaceActor() = default;

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceActor::~vtkTreeAMRIsosurfaceActor() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Exported: " << (this->Exported ? "yes" : "no") << endl;
  os << indent << "ExportedTriangles: " << this->ExportedTriangles.Get() << endl;
}

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceActor::Polygons* vtkTreeAMRIsosurfaceActor::UpdatePolygons()
{
  auto mapper = vtkTreeAMRIsosurfaceMapper::SafeDownCast(this->Mapper);
  if (!mapper)
  {
    return nullptr;
  }
  if (!this->Exported)
  {
    this->Exported = std::make_unique<Polygons>();
  }
  this->Exported->Triangles->SetMapper(mapper);
  this->Exported->Triangles->SetInputConnection(
    mapper->GetNumberOfInputConnections(0) > 0 ? mapper->GetInputConnection(0, 0) : nullptr);
  return this->Exported.get();
}

//------------------------------------------------------------------------------
vtkPolyData* vtkTreeAMRIsosurfaceActor::GetTriangles()
{
  Polygons* polygons = this->UpdatePolygons();
  if (!polygons || !vtkMath::AreBoundsInitialized(this->Mapper->GetBounds()))
  {
    return nullptr;
  }
  polygons->Triangles->Update();
  return polygons->Triangles->GetOutput();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::SetExportedTriangles(vtkAlgorithm* triangles)
{
  this->ExportedTriangles = triangles;
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::ReleaseTriangles()
{
  if (this->Exported && this->Exported->Triangles->GetOutput()->GetNumberOfPoints() > 0)
  {
    this->Exported->Triangles->GetOutput()->ReleaseData();
    this->Exported->Triangles->Modified();
  }
  if (this->ExportedTriangles)
  {
    this->ExportedTriangles->GetOutputDataObject(0)->ReleaseData();
    this->ExportedTriangles->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::GetActors(vtkPropCollection* actors)
{
  Polygons* polygons = this->UpdatePolygons();
  if (!polygons)
  {
    this->Superclass::GetActors(actors);
    return;
  }
  vtkAlgorithm* triangles = this->ExportedTriangles ? this->ExportedTriangles : polygons->Triangles;
  polygons->Mapper->SetInputConnection(triangles->GetOutputPort());
  this->GetMatrix(polygons->Matrix);
  polygons->Actor->SetProperty(this->GetProperty());
  polygons->Actor->SetVisibility(this->GetVisibility());
  actors->AddItem(polygons->Actor);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::Render(vtkRenderer* renderer, vtkMapper* mapper)
{
  this->ReleaseTriangles();
  if (!this->ExportedTriangles || vtkMath::AreBoundsInitialized(mapper->GetBounds()))
  {
    this->Superclass::Render(renderer, mapper);
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceActor::IsTranslucent()
{
  return this->Superclass::HasTranslucentPolygonalGeometry() != 0;
}

//------------------------------------------------------------------------------
vtkTypeBool vtkTreeAMRIsosurfaceActor::HasTranslucentPolygonalGeometry()
{
  return !this->IsDrawn && this->IsTranslucent();
}

//------------------------------------------------------------------------------
int vtkTreeAMRIsosurfaceActor::RenderOpaqueGeometry(vtkViewport* viewport)
{
  auto mapper = vtkTreeAMRIsosurfaceMapper::SafeDownCast(this->Mapper);
  auto renderer = vtkRenderer::SafeDownCast(viewport);
  this->IsDrawn = mapper && renderer && this->IsTranslucent() && mapper->RenderAfterOpaque(renderer, this);
  if (!this->IsDrawn)
  {
    return this->Superclass::RenderOpaqueGeometry(viewport);
  }
  this->ReleaseTriangles();
  return 1;
}

//------------------------------------------------------------------------------
int vtkTreeAMRIsosurfaceActor::RenderVolumetricGeometry(vtkViewport* viewport)
{
  auto mapper = vtkTreeAMRIsosurfaceMapper::SafeDownCast(this->Mapper);
  auto renderer = vtkRenderer::SafeDownCast(viewport);
  if (!this->IsDrawn && mapper && renderer && this->IsTranslucent())
  {
    mapper->RenderWithVolumes(renderer, this);
  }
  this->IsDrawn = false;
  return 0;
}
