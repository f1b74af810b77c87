// The data sets of the benchmark: where each comes from, how it is looked at and coloured.
#pragma once

#include "ContentDigest.h"
#include "Octree/OctreeBuilder.h"
#include "RayTracing/Camera.h"
#include "RayTracing/TransferFunction.h"

#include <string>
#include <vector>

namespace treeamr::bench
{

struct Scene
{
  std::string name; // the forest is in <folder>/<name>.p8est
  TransferFunction transferFunction;
};

/// From few cells to many.
std::vector<Scene> makeScenes();

/// 1000 x 1000 pixels, 1.6 edge lengths from the centre of the unit cube, elevation 25, azimuth 35 and 40
/// degrees of vertical view.
Camera makeCamera();

struct Forest
{
  std::vector<LeafCell> cells;
  ContentDigest digest;
};

/// A forest of one tree with one double per quadrant. Throws Error.
Forest readForest(const std::string& path);

} // namespace treeamr::bench
