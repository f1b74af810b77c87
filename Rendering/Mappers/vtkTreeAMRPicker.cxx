#include "vtkTreeAMRPicker.h"

#include "vtkAbstractVolumeMapper.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRVolumeMapper.h"
#include "vtkVolume.h"

vtkStandardNewMacro(vtkTreeAMRPicker);

struct vtkTreeAMRPicker::Found
{
  double T;
  double Normal[3];
  double Value;
  vtkIdType Cell;
};

//------------------------------------------------------------------------------
vtkTreeAMRPicker::vtkTreeAMRPicker()
  : PickedValue(vtkMath::Nan())
{
}

//------------------------------------------------------------------------------
vtkTreeAMRPicker::~vtkTreeAMRPicker() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRPicker::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "PickedGrid: " << this->PickedGrid << endl;
  os << indent << "PickedValue: " << this->PickedValue << endl;
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRPicker::GetPickedGrid()
{
  return this->PickedGrid;
}

//------------------------------------------------------------------------------
void vtkTreeAMRPicker::ResetPickInfo()
{
  this->Superclass::ResetPickInfo();
  this->PickedGrid = nullptr;
  this->PickedValue = vtkMath::Nan();
}

//------------------------------------------------------------------------------
double vtkTreeAMRPicker::IntersectActorWithLine(const double p1[3], const double p2[3], double t1, double t2,
  double tol, vtkProp3D* prop, vtkMapper* mapper)
{
  auto* const surfaces = vtkTreeAMRIsosurfaceMapper::SafeDownCast(mapper);
  if (!surfaces)
  {
    return this->Superclass::IntersectActorWithLine(p1, p2, t1, t2, tol, prop, mapper);
  }
  Found found;
  found.Cell = surfaces->IntersectWithLine(p1, p2, t1, t2, found.T, found.Normal, found.Value);
  return this->Take(found, p1, p2, mapper, surfaces->GetHyperTreeGrid());
}

//------------------------------------------------------------------------------
double vtkTreeAMRPicker::IntersectVolumeWithLine(const double p1[3], const double p2[3], double t1, double t2,
  vtkProp3D* prop, vtkAbstractVolumeMapper* mapper)
{
  auto* const own = vtkTreeAMRVolumeMapper::SafeDownCast(mapper);
  auto* const volume = vtkVolume::SafeDownCast(prop);
  if (!own || !volume)
  {
    return this->Superclass::IntersectVolumeWithLine(p1, p2, t1, t2, prop, mapper);
  }
  Found found;
  found.Cell = own->IntersectWithLine(
    volume, p1, p2, t1, t2, this->VolumeOpacityIsovalue, found.T, found.Normal, found.Value);
  return this->Take(found, p1, p2, mapper, own->GetHyperTreeGrid());
}

//------------------------------------------------------------------------------
double vtkTreeAMRPicker::Take(const Found& found, const double p1[3], const double p2[3],
  vtkAbstractMapper3D* mapper, vtkHyperTreeGrid* grid)
{
  if (found.Cell < 0)
  {
    return VTK_DOUBLE_MAX;
  }
  if (found.T < this->GlobalTMin)
  {
    this->ResetPickInfo();
    this->Mapper = mapper;
    this->PickedGrid = grid;
    this->CellId = found.Cell;
    this->PickedValue = found.Value;
    for (int i = 0; i < 3; ++i)
    {
      this->MapperPosition[i] = (1. - found.T) * p1[i] + found.T * p2[i];
      this->MapperNormal[i] = found.Normal[i];
    }
    if (vtkMath::Normalize(this->MapperNormal) == 0.)
    {
      vtkMath::Subtract(p1, p2, this->MapperNormal); // as the superclass where there is none
      vtkMath::Normalize(this->MapperNormal);
    }
  }
  return found.T;
}
