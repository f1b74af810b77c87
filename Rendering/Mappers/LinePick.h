// The first point on a line that pickers find, of surfaces and volumes. Private to the module.
#pragma once

#include "Geometry/Camera.h"
#include "Geometry/RayStops.h"
#include "Interpolation/Sampler.h"
#include "Octree/Octree.h"
#include "Surface/Isosurface.h"

#include "vtkType.h"

#include <functional>
#include <optional>

class vtkHyperTreeGrid;

namespace treeamr
{

/// A line in data coordinates: the part [begin, end] of a ray.
struct PickLine
{
  Ray ray;
  double begin = 0.;
  double end = 1.;
};

struct LinePick
{
  double t;
  Vec3 normal; // of any length; 0: none
  double value;
  CellId cell;
};

PickLine pickLine(const double p1[3], const double p2[3], double t1, double t2);

/// In the form of the mappers' IntersectWithLine().
vtkIdType tell(const LinePick& pick, vtkHyperTreeGrid* grid, double& t, double normal[3], double& value);

/// Towards lower values.
std::optional<LinePick> pickSurface(const Isosurface& surface, const PickLine& line);

/// Where the opacity of the sampler's value is at least `least`, found in steps of an eighth of a cell; the normal towards
/// lower values, or that of the face that the line enters by.
std::optional<LinePick> pickVolume(const Sampler& sampler, const Octree& octree, const PickLine& line,
  const DataCut& cut, const std::function<double(double)>& opacity, double least);

} // namespace treeamr
