// Colours of a mapper's hits by an array, and what was made for them. Private to the module.
#pragma once

#include "MapperInput.h"
#include "MapperMessages.h"
#include "SurfaceActorView.h"
#include "SurfaceColors.h"

#include <array>
#include <memory>

class vtkHyperTreeGrid;
class vtkMapper;

namespace treeamr
{

class SurfaceColoring
{
public:
  /// As the mapper's scalar settings ask for; none: the hits have the solid colour. contoured: what they are
  /// isosurfaces of. Values beyond float are warned of. Throws Error for an array that there is not or that is unfit.
  HitColors map(vtkMapper* mapper, MapperMessages& messages, SurfaceActorView& view, vtkHyperTreeGrid* grid,
    const ArraySelection& contoured);

private:
  HitColors mapCells(vtkMapper* mapper, MapperMessages& messages, SurfaceActorView& view,
    vtkHyperTreeGrid* grid, const ColorSource& source, bool isContoured);

  std::array<FieldSlot, 4> fields_; // of the components of a colour
  CategorySlot categories_;
};

} // namespace treeamr
