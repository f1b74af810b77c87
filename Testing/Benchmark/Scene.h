// The data sets of the benchmark: where each comes from, how it is looked at and coloured.
#pragma once

#include "ContentDigest.h"
#include "Field/Field.h"
#include "Field/TransferFunction.h"
#include "Geometry/Camera.h"
#include "Octree/OctreeBuilder.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace treeamr::bench
{

struct Scene
{
  std::string name; // the forest is in <folder>/<name>.p8est
  TransferFunction transferFunction;
  double isovalue;
  std::vector<double> moreIsovalues; // from few active cells to many
};

/// From few cells to many.
std::vector<Scene> makeScenes();

/// A square picture, 1.6 edge lengths from the centre of the unit cube, elevation 25, azimuth 35 and 40 degrees of
/// view. pixels: along an edge.
Camera makeCamera(int pixels = 1000);

/// In the unit cube.
struct Forest
{
  LargeVector<LeafCell> cells;
  ContentDigest digest;
  std::array<int, 3> roots{ 1, 1, 1 };
};

/// A forest of one tree with one double per quadrant. Throws Error.
Forest readForest(const std::string& path);
/// The paper's synthetic data set without a digest: 4 x 4 x 4 cells, the upper half in x refined once, with x y z
/// at their centres, where a cell of the coarse ones is 1 wide.
Forest makeSyntheticForest();

/// With node ranges.
std::shared_ptr<Field> buildField(const std::array<int, 3>& roots, LargeVector<LeafCell> cells);
/// Of test::ProceduralTree, with node ranges.
std::shared_ptr<Field> buildProceduralField(int deepest, double widths);

} // namespace treeamr::bench
