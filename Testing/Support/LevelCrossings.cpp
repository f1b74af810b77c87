#include "Support/LevelCrossings.h"

#include "Support/RandomTrees.h"
#include "Support/RefinedTrees.h"

#include <algorithm>
#include <cmath>

namespace treeamr::test
{

LevelCrossings::LevelCrossings(const Field& field, const Isosurface& surface)
  : grid_(field.octree().grid())
  , surface_(surface)
{
  TreePath root(field.octree());
  forEachNode(root, [&](const TreePath& path) {
    for (int f = 0; f < 6 && path.node().isLeaf(); ++f)
    {
      constexpr std::array<int, 3> stride{ 1, 3, 9 };
      const NodeRef beside = path.around(path.depth())[13 + (f & 1 ? stride[f >> 1] : -stride[f >> 1])];
      const int levels = path.depth() - beside.depth();
      if (!beside.isLeaf() || levels < 1 || levels > mostLevels)
      {
        continue;
      }
      const Face face{ path.index(), path.depth(), f >> 1, f & 1 };
      constexpr int tries = 8;
      std::array<SurfaceHit, 4> hits;
      for (int i = 0; i < tries; ++i)
      {
        if (this->cross(face, hits))
        {
          faces_[levels].push_back(face);
          break;
        }
      }
    }
  });
}

bool LevelCrossings::cross(int levels, std::array<SurfaceHit, 4>& hits)
{
  return this->cross(faces_[levels][random_() % faces_[levels].size()], hits);
}

/// By rays in planes beside the face, all along one line in it.
bool LevelCrossings::cross(const Face& face, std::array<SurfaceHit, 4>& hits)
{
  std::uniform_real_distribution<double> unit(-1., 1.);
  const Bounds leaf = grid_.nodeBounds(face.index, face.depth);
  Ray ray{};
  for (int a = 0; a < 3; ++a)
  {
    const double width = leaf.max[a] - leaf.min[a];
    const double middle = 0.5 * (leaf.min[a] + leaf.max[a]);
    const bool isAcross = a == face.axis;
    ray.origin[a] = !isAcross ? middle + 0.45 * width * unit(random_)
      : face.side != 0        ? leaf.max[a]
                              : leaf.min[a];
    ray.direction[a] = isAcross ? 0. : width * unit(random_);
  }
  for (int k = 0; k < 4; ++k)
  {
    Ray beside = ray;
    beside.origin[face.axis] += (2 * k - 3) * 1e-6 * (leaf.max[face.axis] - leaf.min[face.axis]);
    if (!surface_.intersect(beside, -0.3, 0.3, hits[k]) || std::abs(hits[k].t - hits[0].t) > 1e-3)
    {
      return false;
    }
  }
  return true;
}

double jumpOf(const std::array<SurfaceHit, 4>& hits, const std::function<Vec3(const SurfaceHit&)>& direction)
{
  const auto turn = [&](int k) { return degreesBetween(direction(hits[k]), direction(hits[k + 1])); };
  return std::max(0., turn(1) - 2. * std::max(turn(0), turn(2)));
}

} // namespace treeamr::test
