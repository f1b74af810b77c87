#include "vtkTreeAMRIsosurfaceActor.h"

#include "IsosurfaceTriangles.h"

#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkPolyDataMapper.h"
#include "vtkPropCollection.h"
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
    this->Mapper->SetInputConnection(this->Triangles->GetOutputPort());
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
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::GetActors(vtkPropCollection* actors)
{
  auto mapper = vtkTreeAMRIsosurfaceMapper::SafeDownCast(this->Mapper);
  if (!mapper)
  {
    this->Superclass::GetActors(actors);
    return;
  }
  if (!this->Exported)
  {
    this->Exported = std::make_unique<Polygons>();
  }
  const Polygons& exported = *this->Exported;
  exported.Triangles->SetMapper(mapper);
  exported.Triangles->SetInputConnection(
    mapper->GetNumberOfInputConnections(0) > 0 ? mapper->GetInputConnection(0, 0) : nullptr);
  this->GetMatrix(exported.Matrix);
  exported.Actor->SetProperty(this->GetProperty());
  exported.Actor->SetVisibility(this->GetVisibility());
  actors->AddItem(exported.Actor);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceActor::Render(vtkRenderer* renderer, vtkMapper* mapper)
{
  if (this->Exported && this->Exported->Triangles->GetOutput()->GetNumberOfPoints() > 0)
  {
    this->Exported->Triangles->GetOutput()->ReleaseData();
    this->Exported->Triangles->Modified();
  }
  this->Superclass::Render(renderer, mapper);
}
