#include "VolumeOrder.h"

#include "TranslucentScene.h"
#include "vtkTreeAMRVolumeMapper.h"

#include "Geometry/Vec3.h"

#include "vtkCamera.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkPropCollection.h"
#include "vtkRenderer.h"
#include "vtkVolume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace treeamr
{

namespace
{

using Point = Vec3;

/// A volume's box in the world.
struct WorldBox
{
  vtkVolume* volume;
  std::array<Point, 8> corners;
  std::array<Point, 3> normals; // of the faces
  Point centre{};
};

WorldBox boxOf(vtkVolume* volume)
{
  WorldBox box{ volume, {}, {} };
  double bounds[6];
  volume->GetMapper()->GetBounds(bounds);
  vtkNew<vtkMatrix4x4> matrix;
  volume->GetMatrix(matrix);
  for (int c = 0; c < 8; ++c)
  {
    const double p[4] = { bounds[c & 1], bounds[2 + (c >> 1 & 1)], bounds[4 + (c >> 2)], 1. };
    double world[4];
    matrix->MultiplyPoint(p, world);
    std::copy_n(world, 3, box.corners[c].begin());
    for (int a = 0; a < 3; ++a)
    {
      box.centre[a] += world[a] / 8.;
    }
  }
  std::array<Point, 3> edges;
  for (int e = 0; e < 3; ++e)
  {
    vtkMath::Subtract(box.corners[1 << e].data(), box.corners[0].data(), edges[e].data());
  }
  for (int e = 0; e < 3; ++e)
  {
    vtkMath::Cross(edges[(e + 1) % 3].data(), edges[(e + 2) % 3].data(), box.normals[e].data());
  }
  return box;
}

using Extent = std::pair<double, double>;

Extent extentOf(const WorldBox& box, const Point& direction)
{
  Extent extent(dot(box.corners[0], direction), dot(box.corners[0], direction));
  for (const Point& corner : box.corners)
  {
    extent.first = std::min(extent.first, dot(corner, direction));
    extent.second = std::max(extent.second, dot(corner, direction));
  }
  return extent;
}

/// The eye, or the direction away from it.
struct Eye
{
  bool isFar;
  Point place;
  Point away;

  explicit Eye(vtkCamera* camera)
    : isFar(camera->GetParallelProjection() != 0)
  {
    camera->GetPosition(place.data());
    camera->GetDirectionOfProjection(away.data());
  }
  double distance(const Point& p) const
  {
    return isFar ? dot(p, away) : std::sqrt(vtkMath::Distance2BetweenPoints(p.data(), place.data()));
  }
};

enum class Depth
{
  Nearer,
  Farther,
  Overlapping
};

Depth compare(const WorldBox& a, const WorldBox& b, const Eye& eye)
{
  for (const auto* normals : { &a.normals, &b.normals })
  {
    for (const Point& normal : *normals)
    {
      const auto ofA = extentOf(a, normal);
      const auto ofB = extentOf(b, normal);
      // Boxes that share a face are apart, with their corners rounded.
      const double slack = 1e-9 * (ofA.second - ofA.first + ofB.second - ofB.first);
      const bool aIsBelow = ofA.second <= ofB.first + slack;
      if (!aIsBelow && !(ofB.second <= ofA.first + slack))
      {
        continue;
      }
      const double plane = aIsBelow ? 0.5 * (ofA.second + ofB.first) : 0.5 * (ofB.second + ofA.first);
      const bool eyeIsBelow = eye.isFar ? dot(eye.away, normal) > 0. : dot(eye.place, normal) < plane;
      return aIsBelow == eyeIsBelow ? Depth::Nearer : Depth::Farther;
    }
  }
  return Depth::Overlapping;
}

/// Where both are along a direction, at most.
Extent overlapOf(const WorldBox& a, const WorldBox& b, const Point& direction)
{
  const Extent ofA = extentOf(a, direction);
  const Extent ofB = extentOf(b, direction);
  // What the boxes along the axes around them have in common.
  Extent common(0., 0.);
  for (int axis = 0; axis < 3; ++axis)
  {
    Point unit{};
    unit[axis] = 1.;
    const Extent alongA = extentOf(a, unit);
    const Extent alongB = extentOf(b, unit);
    const auto [low, high] = std::minmax({ direction[axis] * std::max(alongA.first, alongB.first),
      direction[axis] * std::min(alongA.second, alongB.second) });
    common.first += low;
    common.second += high;
  }
  return { std::max({ ofA.first, ofB.first, common.first }),
    std::min({ ofA.second, ofB.second, common.second }) };
}

bool hasLayers(vtkVolume* volume)
{
  const int blend = vtkTreeAMRVolumeMapper::SafeDownCast(volume->GetMapper())->GetBlendMode();
  return blend == vtkVolumeMapper::COMPOSITE_BLEND || blend == vtkVolumeMapper::ISOSURFACE_BLEND ||
    blend == vtkVolumeMapper::SLICE_BLEND;
}

} // namespace

VolumeOrder orderVolumes(vtkRenderer* renderer)
{
  VolumeOrder order;
  std::vector<WorldBox> boxes;
  vtkPropCollection* props = renderer->GetViewProps();
  vtkCollectionSimpleIterator at;
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at))
  {
    auto volume = vtkVolume::SafeDownCast(prop);
    auto mapper = volume ? vtkTreeAMRVolumeMapper::SafeDownCast(volume->GetMapper()) : nullptr;
    if (mapper && volume->GetVisibility() && !isCulled(renderer, volume) && mapper->GetDataObjectInput())
    {
      order.first = order.first ? order.first : volume;
      order.volumes.push_back(volume);
    }
  }
  if (order.volumes.size() < 2)
  {
    return order;
  }
  const Eye eye(renderer->GetActiveCamera());
  std::transform(order.volumes.begin(), order.volumes.end(), std::back_inserter(boxes), boxOf);
  std::stable_sort(boxes.begin(), boxes.end(),
    [&](const WorldBox& a, const WorldBox& b) { return eye.distance(a.centre) < eye.distance(b.centre); });
  order.volumes.clear();
  const double eyeDepth = dot(eye.place, eye.away);
  while (!boxes.empty())
  {
    // The first one that nothing lies before; where there is none, for they lie in a ring, the nearest.
    auto next = std::find_if(boxes.begin(), boxes.end(), [&](const WorldBox& box) {
      return std::none_of(boxes.begin(), boxes.end(),
        [&](const WorldBox& other) { return &other != &box && compare(other, box, eye) == Depth::Nearer; });
    });
    next = next == boxes.end() ? boxes.begin() : next;
    for (const WorldBox& other : boxes)
    {
      if (&other != &*next && compare(other, *next, eye) == Depth::Overlapping)
      {
        const Extent common = overlapOf(other, *next, eye.away);
        const Extent fromEye(common.first - eyeDepth, common.second - eyeDepth);
        order.overlap = order.overlaps() ? Extent(std::min(order.overlap.first, fromEye.first),
                                             std::max(order.overlap.second, fromEye.second))
                                         : fromEye;
        order.isLayered = order.isLayered && hasLayers(other.volume) && hasLayers(next->volume);
      }
    }
    const Extent extent = extentOf(*next, eye.away);
    order.volumes.push_back(next->volume);
    order.extents.emplace_back(extent.first - eyeDepth, extent.second - eyeDepth);
    boxes.erase(next);
  }
  return order;
}

} // namespace treeamr
