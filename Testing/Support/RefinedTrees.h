// Adaptive trees on the unit cube whose level boundaries stay where they are while every leaf is refined,
// filled with fields that are known everywhere: what orders of convergence are measured on.
#pragma once

#include "Field/Field.h"
#include "Geometry/Camera.h"
#include "Octree/OctreeBuilder.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace treeamr::test
{

using AnalyticField = std::function<double(const Vec3&)>;

/// By central differences.
Vec3 gradientOf(const AnalyticField& field, const Vec3& p);

/// Between the directions of two vectors, in degrees.
double degreesBetween(const Vec3& a, const Vec3& b);

/// Where the field, a signed distance from it less an offset, has the isovalue.
struct AnalyticSurface
{
  const char* name;
  AnalyticField field;
  double isovalue;
};

/// A sphere and a torus, off the cells' planes, and the width of a root refined once away from the domain's end: no
/// missing cell takes part.
std::vector<AnalyticSurface> makeAnalyticSurfaces();

/// Of 4 x 4 x 4 roots.
struct BaseTree
{
  static constexpr int roots = 4;

  std::string name;
  std::vector<LeafCell> cells;
  int levels; // of the deepest

  double finestWidth(int refinement) const;
};

/// "uniform", "one-level" and "four-levels": how far levels of neighbours are apart at most. In the latter
/// two, some roots are leaves.
std::vector<BaseTree> makeBaseTrees();

/// Every leaf refined so many times; values are those at the cells' centres.
std::shared_ptr<Field> makeField(const BaseTree& tree, int refinement, const AnalyticField& values);

/// The same where it matters to the surface, and much fewer cells: those farther from it are as large as may be.
std::shared_ptr<Field> makeFieldNear(const BaseTree& tree, int refinement, const AnalyticSurface& surface);

} // namespace treeamr::test
