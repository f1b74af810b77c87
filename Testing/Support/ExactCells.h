// Rays through cells that show one value each, against the boxes of all of them: what such volumes have to be.
#pragma once

#include "Field/TransferFunction.h"
#include "Geometry/Camera.h"
#include "Octree/OctreeBuilder.h"

#include <array>
#include <functional>
#include <vector>

namespace treeamr::test
{

/// A way through one cell.
struct CellPart
{
  double begin; // t
  double end;
  float value;
};

/// Those of a pixel's ray between the near and the far plane, in order. Without spare rays: those in faces belong to
/// either side.
std::vector<CellPart> partsOfRay(
  const RootGrid& grid, const std::vector<LeafCell>& cells, const Camera& camera, int x, int y);

/// What a composite of them is.
std::array<double, 4> lightOf(
  const std::vector<CellPart>& parts, const std::function<TransferFunction::Entry(float)>& entryOf);

} // namespace treeamr::test
