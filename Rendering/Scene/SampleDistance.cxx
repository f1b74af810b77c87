#include "SampleDistance.h"

#include "Octree/Octree.h"

#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkProp3D.h"

#include <algorithm>
#include <cmath>

namespace treeamr
{

namespace
{

/// Of the largest leaves; 0: a root.
int coarsestLevel(const Octree& octree)
{
  for (int depth = 0; depth < octree.innerDepths(); ++depth)
  {
    for (std::uint64_t node = octree.firstInner(depth); node < octree.firstInner(depth + 1); ++node)
    {
      if (octree.children(node).leaf != 0)
      {
        return std::max(0, depth + 1 - octree.grid().paddingDepth());
      }
    }
  }
  return 0;
}

/// Along any axis, in data coordinates.
double widestRoot(const RootGrid& grid)
{
  double widest = 0.;
  for (int a = 0; a < 3; ++a)
  {
    for (int i = 0; i < grid.roots()[a]; ++i)
    {
      widest = std::max(widest, grid.worldPlane(a, i + 1, 0) - grid.worldPlane(a, i, 0));
    }
  }
  return widest;
}

} // namespace

double samplesPerCellFor(double distance, const Octree& octree, vtkProp3D* volume)
{
  vtkNew<vtkMatrix4x4> worldFromData;
  volume->GetMatrix(worldFromData);
  double scale = 0.;
  for (int column = 0; column < 3; ++column)
  {
    scale = std::max(scale,
      std::hypot(worldFromData->GetElement(0, column), worldFromData->GetElement(1, column),
        worldFromData->GetElement(2, column)));
  }
  return std::ldexp(widestRoot(octree.grid()), -coarsestLevel(octree)) * scale / distance;
}

} // namespace treeamr
