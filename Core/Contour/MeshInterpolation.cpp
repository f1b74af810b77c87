// Fields at the points of a mesh: of one block of leaves after the other, by what they are at its vertices.
#include "Contour/MeshInterpolation.h"

#include "Contour/BlockContour.h"
#include "Error.h"
#include "Interpolation/BlockGradients.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <span>

namespace treeamr
{

namespace
{

/// A point in an octant of a block.
struct PlaceInBlock
{
  std::array<int, 3> octant;
  Vec3 local; // 0 to 1
};

/// planes: octantPlanes(). Just beside the octant that a point belongs to, where rounding may put it, the others'
/// vertices weigh next to nothing.
PlaceInBlock placeIn(const OctantPlanes& planes, const Vec3& pWorld) noexcept
{
  PlaceInBlock place;
  for (int a = 0; a < 3; ++a)
  {
    const double* plane = planes[a].data() + 1;
    int low = 0;
    while (low < 3 && pWorld[a] >= plane[low + 1] && plane[low + 2] > plane[low + 1])
    {
      ++low;
    }
    place.octant[a] = low;
    place.local[a] = std::clamp((pWorld[a] - plane[low]) / (plane[low + 1] - plane[low]), 0., 1.);
  }
  return place;
}

/// The blocks that the points of one may lie in: those of dual cells may lie in the block beyond, which has leaves of
/// the same size there.
class BlocksAround
{
public:
  static constexpr int count = 27; // the block itself in the middle

  explicit BlocksAround(const Octree& octree)
    : octree_(octree)
  {
  }
  void goTo(const ContourMesh::Block& block) noexcept
  {
    block_ = block;
    known_ = {};
  }
  /// The number of the block that a point lies in, and where.
  int find(const Vec3& pWorld, PlaceInBlock& place) noexcept
  {
    const OctantPlanes& own = this->planes(count / 2);
    int number = 0;
    for (int a = 2; a >= 0; --a)
    {
      number = 3 * number + 1 + (pWorld[a] > own[a][5]) - (pWorld[a] < own[a][1]);
    }
    place = placeIn(this->planes(number), pWorld);
    return number;
  }
  BlockPath path(int number) const noexcept { return BlockPath(octree_, this->index(number), block_.depth); }

private:
  std::array<Coord, 3> index(int number) const noexcept
  {
    return { block_.index[0] + number % 3 - 1, block_.index[1] + number / 3 % 3 - 1,
      block_.index[2] + number / 9 - 1 };
  }
  const OctantPlanes& planes(int number) noexcept
  {
    if (!known_[number])
    {
      known_[number] = true;
      planes_[number] = octantPlanes(octree_.grid(), this->index(number), block_.depth);
    }
    return planes_[number];
  }

  const Octree& octree_;
  ContourMesh::Block block_;
  std::array<bool, count> known_{};
  std::array<OctantPlanes, count> planes_;
};

class ValueInterpolation
{
public:
  explicit ValueInterpolation(const Field& field)
    : around_(field.octree())
    , evaluator_(field)
  {
  }
  void interpolate(const ContourMesh::Block& block, std::span<const Vec3> points, float* values) noexcept
  {
    around_.goTo(block);
    std::array<bool, BlocksAround::count> known{};
    for (const Vec3& point : points)
    {
      PlaceInBlock place;
      const int number = around_.find(point, place);
      if (!known[number])
      {
        known[number] = true;
        evaluator_.compute(around_.path(number), BlockCells::Leaves, blocks_[number]);
      }
      const auto& [x, y, z] = place.octant;
      *values++ = static_cast<float>(
        trilinear(cornersOf(blocks_[number].values.data() + block::vertexIndex(x, y, z), block::vertexStride),
          place.local));
    }
  }

private:
  BlocksAround around_;
  BlockEvaluator evaluator_;
  std::array<BlockValues, BlocksAround::count> blocks_;
};

class GradientInterpolation
{
public:
  explicit GradientInterpolation(const Field& field)
    : around_(field.octree())
    , evaluator_(field)
  {
  }
  void interpolate(const ContourMesh::Block& block, std::span<const Vec3> points, Vec3* gradients)
  {
    around_.goTo(block);
    wanted_.fill({});
    found_.clear();
    for (const Vec3& point : points)
    {
      Found& found = found_.emplace_back();
      found.block = around_.find(point, found.place);
      forCorners(found.place, [&](int x, int y, int z, double) { add(wanted_[found.block], x, y, z); });
    }
    for (int number = 0; number < BlocksAround::count; ++number)
    {
      if (wanted_[number] != BlockVertices{})
      {
        evaluator_.compute(around_.path(number), BlockCells::Leaves, wanted_[number], blocks_[number]);
      }
    }
    for (const Found& found : found_)
    {
      Vec3 sum{};
      forCorners(found.place, [&](int x, int y, int z, double weight) {
        const Vec3& gradient = blocks_[found.block][block::vertexIndex(x, y, z)];
        for (int a = 0; a < 3; ++a)
        {
          sum[a] += weight * gradient[a];
        }
      });
      *gradients++ = sum;
    }
  }

private:
  struct Found
  {
    int block;
    PlaceInBlock place;
  };
  /// Calls f(x, y, z, weight) for the vertices of the octant that have a weight: most points lie on edges.
  template <class F>
  static void forCorners(const PlaceInBlock& place, const F& f) noexcept
  {
    for (int c = 0; c < 8; ++c)
    {
      double weight = 1.;
      std::array<int, 3> at = place.octant;
      for (int a = 0; a < 3; ++a)
      {
        at[a] += sideOf(c, a);
        weight *= sideOf(c, a) != 0 ? place.local[a] : 1. - place.local[a];
      }
      if (weight != 0.)
      {
        f(at[0], at[1], at[2], weight);
      }
    }
  }

  BlocksAround around_;
  GradientEvaluator evaluator_;
  std::array<BlockGradients, BlocksAround::count> blocks_;
  std::array<BlockVertices, BlocksAround::count> wanted_{};
  std::vector<Found> found_;
};

/// By blocks, on all threads.
template <class Interpolation, class T>
std::vector<T> interpolated(const Field& field, const ContourMesh& mesh)
{
  std::vector<T> found(mesh.points.size());
  tbb::enumerable_thread_specific<Interpolation> interpolations([&field] { return Interpolation(field); });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.blocks.size(), 64), [&](const auto& range) {
    Interpolation& interpolation = interpolations.local();
    for (std::size_t b = range.begin(); b != range.end(); ++b)
    {
      const auto first = static_cast<std::size_t>(mesh.blocks[b].firstPoint);
      const std::size_t end =
        b + 1 < mesh.blocks.size() ? static_cast<std::size_t>(mesh.blocks[b + 1].firstPoint) : found.size();
      interpolation.interpolate(
        mesh.blocks[b], std::span(mesh.points).subspan(first, end - first), found.data() + first);
    }
  });
  return found;
}

} // namespace

std::vector<float> interpolate(const Field& field, const ContourMesh& mesh)
{
  if (!mesh.points.empty() && mesh.octree != field.octree().identity())
  {
    throw Error("contour: values for a mesh of another octree than the field's");
  }
  return interpolated<ValueInterpolation, float>(field, mesh);
}

std::vector<std::array<double, 3>> interpolateGradients(const Field& field, const ContourMesh& mesh)
{
  return interpolated<GradientInterpolation, Vec3>(field, mesh);
}

} // namespace treeamr
