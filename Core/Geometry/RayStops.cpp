#include "Geometry/RayStops.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace treeamr
{

namespace
{

/// Narrows [begin, end) to a half space.
void narrow(
  const HalfSpace& half, const Vec3& origin, const Vec3& direction, double& begin, double& end) noexcept
{
  const double inside = dot(half.normal, origin) - half.offset;
  const double slope = dot(half.normal, direction);
  if (slope > 0.)
  {
    begin = std::max(begin, -inside / slope);
  }
  else if (slope < 0.)
  {
    end = std::min(end, -inside / slope);
  }
  else if (!(inside >= 0.))
  {
    end = begin;
  }
}

RayParts crop(const CroppingRegions& cropping, const Vec3& origin, const Vec3& direction, double begin,
  double end) noexcept
{
  std::array<double, 8> stops{ begin }; // ascending
  int count = 1;
  for (int i = 0; i < 6; ++i)
  {
    const double t = (cropping.planes[i] - origin[i / 2]) / direction[i / 2];
    if (t > begin && t < end) // not so when the ray does not cross the plane
    {
      int place = count++;
      for (; stops[place - 1] > t; --place)
      {
        stops[place] = stops[place - 1];
      }
      stops[place] = t;
    }
  }
  stops[count] = end;
  RayParts parts;
  for (int i = 0; i < count; ++i)
  {
    const double from = stops[i];
    const double to = stops[i + 1];
    if (!(from < to))
    {
      continue;
    }
    const double middle = std::isfinite(to) ? 0.5 * (from + to) : from + std::max(1., std::abs(from));
    Vec3 point;
    for (int a = 0; a < 3; ++a)
    {
      point[a] = origin[a] + middle * direction[a];
    }
    if (!cropping.shows(point))
    {
      continue;
    }
    if (parts.count > 0 && parts.end[parts.count - 1] == from)
    {
      parts.end[parts.count - 1] = to;
    }
    else
    {
      parts.add(from, to);
    }
  }
  return parts;
}

bool isFinite(const HalfSpace& half)
{
  return std::isfinite(half.normal[0] + half.normal[1] + half.normal[2] + half.offset);
}

} // namespace

bool CroppingRegions::shows(const Vec3& point) const noexcept
{
  constexpr std::array<int, 3> strides{ 1, 3, 9 };
  int region = 0;
  for (int a = 0; a < 3; ++a)
  {
    region += strides[a] * (point[a] <= planes[2 * a] ? 0 : point[a] >= planes[2 * a + 1] ? 2 : 1);
  }
  return shown >> region & 1;
}

void DataCut::addBox(const Bounds& box)
{
  for (int a = 0; a < 3; ++a)
  {
    HalfSpace half{ {}, box.min[a] };
    half.normal[a] = 1.;
    halfSpaces.push_back(half);
    half.normal[a] = -1.;
    half.offset = -box.max[a];
    halfSpaces.push_back(half);
  }
}

RayParts DataCut::parts(const Vec3& origin, const Vec3& direction, double begin, double end) const noexcept
{
  for (const HalfSpace& half : halfSpaces)
  {
    narrow(half, origin, direction, begin, end);
  }
  RayParts parts;
  if (begin < end && cropping)
  {
    return crop(*cropping, origin, direction, begin, end);
  }
  if (begin < end)
  {
    parts.add(begin, end);
  }
  return parts;
}

RayParts RayStops::parts(const Camera& camera, const Ray& ray, int x, int y) const noexcept
{
  const std::size_t pixel = static_cast<std::size_t>(y) * camera.width() + x;
  const double begin = beginDepth ? beginDepth[pixel] : 0.;
  const double end = endDepth ? endDepth[pixel] : 1.;
  return begin < end
    ? cut.parts(ray.origin, ray.direction, camera.tFromDepth(ray, begin), camera.tFromDepth(ray, end))
    : RayParts();
}

void RayStops::check(const Camera& camera, const char* user) const
{
  const std::string name(user);
  for (const HalfSpace& half : cut.halfSpaces)
  {
    if (!isFinite(half))
    {
      throw Error(name + ": a clipping plane of normal (" + std::to_string(half.normal[0]) + ", " +
        std::to_string(half.normal[1]) + ", " + std::to_string(half.normal[2]) + ") and offset " +
        std::to_string(half.offset) + ", allowed are finite ones");
    }
  }
  for (int i = 0; cut.cropping && i < 6; ++i)
  {
    if (std::isnan(cut.cropping->planes[i]))
    {
      throw Error(name + ": cropping plane " + std::to_string(i) + " is not a number");
    }
  }
  if (!hits)
  {
    return;
  }
  const std::size_t needed = static_cast<std::size_t>(camera.width()) * camera.height() + 1;
  if (hits->first.size() != needed)
  {
    throw Error(name + ": surface hits in " + std::to_string(hits->first.size()) +
      " entries by pixel, needed are " + std::to_string(needed));
  }
  if (hits->first.back() != hits->hits.size())
  {
    throw Error(name + ": " + std::to_string(hits->hits.size()) +
      " surface hits, where the entries by pixel end at " + std::to_string(hits->first.back()));
  }
}

} // namespace treeamr
