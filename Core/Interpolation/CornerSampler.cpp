#include "Interpolation/CornerSampler.h"

#include "Geometry/Trilinear.h"

namespace treeamr
{

CornerSampler::CornerSampler(const Field& field) noexcept
  : corners_(*field.corners())
  , octree_(field.octree())
  , leaves_(octree_)
{
}

bool CornerSampler::sample(const Vec3& pWorld, FieldSample& sample) noexcept
{
  LeafFinder::Leaf leaf;
  if (!leaves_.find(pWorld, leaf))
  {
    return false;
  }
  const int octant = leaf.depth == 0 ? 0 : octantAbove(leaf.index, 0);
  const Corners values = familyOf(corners_, octree_, leaves_.pathToParent()).corners(octant);
  sample = { trilinear(values, leaf.place), trilinearGradient(values, leaf.place) };
  const Bounds box = octree_.grid().nodeBounds(leaf.index, leaf.depth);
  for (int a = 0; a < 3; ++a)
  {
    sample.gradient[a] /= box.max[a] - box.min[a];
  }
  return true;
}

} // namespace treeamr
