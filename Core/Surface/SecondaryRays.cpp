#include "Surface/SecondaryRays.h"

#include "Error.h"
#include "Progress.h"
#include "Surface/SurfaceFrame.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace treeamr
{

namespace
{

/// Start of a ray off the surface, in widths of the hit's cell: far above the rounding of hits, far below
/// what pixels show.
constexpr double startOffset = 1e-3;

/// Calls body(index of the hit, its pixel) for all hits, tile by tile: rays near each other ask for
/// the same vertex values.
template <class Body>
void forEachHit(const Camera& camera, const HitImage& hits, Progress* progress, const Body& body)
{
  checkPixels(hits, camera, "secondary rays");
  if (progress)
  {
    progress->begin(hits.hits.size());
  }
  constexpr int tile = 16;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, camera.height(), tile, 0, camera.width(), tile),
    [&](const tbb::blocked_range2d<int>& range) {
      for (int y = range.rows().begin(); y < range.rows().end(); ++y)
      {
        for (int x = range.cols().begin(); x < range.cols().end(); ++x)
        {
          const std::size_t pixel = static_cast<std::size_t>(y) * camera.width() + x;
          for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
          {
            body(i, x, y);
            if (progress)
            {
              progress->step();
            }
          }
        }
      }
    });
}

struct Start
{
  Vec3 pData;
  Vec3 pWorld;
  Vec3 normalWorld; // towards the camera
};

Start startOf(const Isosurface& surface, const SurfaceFrame& frame, const Ray& ray, const SurfaceHit& hit)
{
  const Vec3 away = normalized(frame.worldVector(ray.direction));
  Start start;
  start.pData = pointAt(ray, hit.t);
  start.pWorld = frame.worldPoint(start.pData);
  start.normalWorld = frame.worldNormal(hit.gradient, { -away[0], -away[1], -away[2] });
  const Vec3 off = normalized(frame.dataVector(start.normalWorld));
  const double distance = startOffset * surface.leafWidth(hit);
  for (int a = 0; a < 3; ++a)
  {
    start.pData[a] += distance * off[a];
  }
  return start;
}

/// Points of the unit square that fill it evenly, however many: the additive recurrence of the plastic number
/// (Roberts 2018), in 32-bit fixed point. Those of pixels next to each other are moved by the points of a lattice
/// (Keller, Heidrich 2001): the 16 pixels of any square of 4 x 4 fill it together.
class EvenPoints
{
public:
  static constexpr std::uint32_t patterns = 16;
  static std::uint32_t patternOf(int x, int y) noexcept
  {
    return (static_cast<std::uint32_t>(x) + 4u * static_cast<std::uint32_t>(y)) % patterns;
  }
  explicit EvenPoints(std::uint32_t inPattern) noexcept
  {
    startU_ = inPattern * sixteenth + sixteenth / 2;
    startV_ = 5u * inPattern * sixteenth + sixteenth / 2; // modulo 1
  }
  void at(std::uint32_t i, double& u, double& v) const noexcept
  {
    constexpr std::uint32_t stepU = 3242174889u; // 2^32 / p, p^3 = p + 1
    constexpr std::uint32_t stepV = 2447445414u; // 2^32 / p^2
    u = 0x1p-32 * (startU_ + i * stepU);
    v = 0x1p-32 * (startV_ + i * stepV);
  }

private:
  static constexpr std::uint32_t sixteenth = 1u << 28;
  std::uint32_t startU_;
  std::uint32_t startV_;
};

/// Two unit vectors that are orthogonal to a third and to each other (Duff et al. 2017).
std::array<Vec3, 2> tangents(const Vec3& n) noexcept
{
  const double sign = std::copysign(1., n[2]);
  const double a = -1. / (sign + n[2]);
  const double b = n[0] * n[1] * a;
  return { { { 1. + sign * n[0] * n[0] * a, sign * b, -sign * n[0] },
    { b, sign + n[1] * n[1] * a, -n[1] } } };
}

/// Directions of the rays [first, end) above the plane of the first two components, by cosine, for each pattern in turn.
std::vector<Vec3> cosineDirections(int first, int end)
{
  std::vector<Vec3> directions;
  for (std::uint32_t pattern = 0; pattern < EvenPoints::patterns; ++pattern)
  {
    const EvenPoints points(pattern);
    for (int k = first; k < end; ++k)
    {
      double u;
      double v;
      points.at(static_cast<std::uint32_t>(k), u, v);
      const double angle = 2. * std::numbers::pi * v;
      directions.push_back(
        { std::sqrt(u) * std::cos(angle), std::sqrt(u) * std::sin(angle), std::sqrt(1. - u) });
    }
  }
  return directions;
}

bool isOccluded(const Isosurface& surface, const Ray& ray, double tMax, const DataCut& cut)
{
  return cut.isEmpty() ? surface.occluded(ray, 0., tMax) : surface.occluded(ray, 0., tMax, cut);
}

} // namespace

void traceAmbientOcclusion(const Isosurface& surface, const Camera& camera, const HitImage& hits,
  double radius, int first, int end, std::vector<std::uint16_t>& open, const DataCut& cut, Progress* progress)
{
  if (open.size() != hits.hits.size())
  {
    throw Error("ambient occlusion: " + std::to_string(open.size()) + " counts of open rays for " +
      std::to_string(hits.hits.size()) + " hits");
  }
  surface.tighten();
  const SurfaceFrame frame(camera.worldFromData());
  const std::vector<Vec3> directions = cosineDirections(first, end);
  const auto count = static_cast<std::size_t>(std::max(0, end - first));
  forEachHit(camera, hits, progress, [&](std::size_t i, int x, int y) {
    const Start start = startOf(surface, frame, camera.ray(x, y), hits.hits[i]);
    const std::array<Vec3, 2> across = tangents(start.normalWorld);
    const Vec3* const own = directions.data() + count * EvenPoints::patternOf(x, y);
    for (std::size_t k = 0; k < count; ++k)
    {
      const auto& [s, t, along] = own[k];
      Vec3 direction;
      for (int a = 0; a < 3; ++a)
      {
        direction[a] = s * across[0][a] + t * across[1][a] + along * start.normalWorld[a];
      }
      open[i] += !isOccluded(surface, { start.pData, frame.dataVector(direction) }, radius, cut);
    }
  });
}

void traceShadows(const Isosurface& surface, const Camera& camera, const HitImage& hits,
  const std::vector<Light>& lights, std::vector<std::uint8_t>& lit, const DataCut& cut, Progress* progress)
{
  lit.assign(hits.hits.size() * lights.size(), 1);
  surface.tighten();
  const SurfaceFrame frame(camera.worldFromData());
  forEachHit(camera, hits, progress, [&](std::size_t i, int x, int y) {
    const Start start = startOf(surface, frame, camera.ray(x, y), hits.hits[i]);
    for (std::size_t l = 0; l < lights.size(); ++l)
    {
      const Light& light = lights[l];
      if (!light.castsShadows)
      {
        continue;
      }
      Vec3 towards;
      for (int a = 0; a < 3; ++a)
      {
        towards[a] = light.positional ? light.position[a] - start.pWorld[a] : -light.direction[a];
      }
      if (dot(towards, start.normalWorld) > 0.)
      {
        const double reach = light.positional ? 1. : std::numeric_limits<double>::infinity();
        lit[l + lights.size() * i] =
          !isOccluded(surface, { start.pData, frame.dataVector(towards) }, reach, cut);
      }
    }
  });
}

} // namespace treeamr
