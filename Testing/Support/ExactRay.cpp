#include "Support/ExactRay.h"

#include <algorithm>
#include <cmath>

namespace treeamr::test
{

ExactRay::ExactRay(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells)
  : truth_(roots, cells)
{
  for (const LeafCell& c : cells)
  {
    levels_ = std::max(levels_, c.cell.level);
  }
  for (int a = 0; a < 3; ++a)
  {
    for (const LeafCell& c : cells)
    {
      const Coord half = Coord(1) << (levels_ - c.cell.level);
      for (int i = 0; i < 3; ++i)
      {
        planes_[a].push_back((2 * c.cell.index[a] + i) * half);
      }
    }
    std::sort(planes_[a].begin(), planes_[a].end());
    planes_[a].erase(std::unique(planes_[a].begin(), planes_[a].end()), planes_[a].end());
  }
}

long double ExactRay::Octant::at(long double part) const
{
  std::array<long double, 8> v = values;
  for (int a = 0, n = 4; a < 3; ++a, n /= 2)
  {
    const long double x = from[a] + part * (to[a] - from[a]);
    for (int i = 0; i < n; ++i)
    {
      v[i] = (1.L - x) * v[2 * i] + x * v[2 * i + 1]; // exact at both ends, whatever the other end is
    }
  }
  return v[0];
}

ExactRay::ExactRay(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells,
  std::function<double(const BruteForceGTI::Vertex&)> vertices)
  : ExactRay(roots, cells)
{
  vertices_ = std::move(vertices);
}

double ExactRay::vertex(const BruteForceGTI::Vertex& v)
{
  const auto known = values_.find(v);
  return known != values_.end() ? known->second
                                : values_[v] = vertices_ ? vertices_(v) : truth_.vertex(v).value();
}

void ExactRay::forEachOctant(
  const Ray& ray, double tMin, double tMax, const std::function<void(const Octant&)>& visit)
{
  const long double perRoot = std::ldexp(2.L, levels_); // half widths
  std::vector<long double> ts{ tMin, tMax };
  for (int a = 0; a < 3; ++a)
  {
    for (const Coord plane : planes_[a])
    {
      const long double t = (plane / perRoot - ray.origin[a]) / static_cast<long double>(ray.direction[a]);
      if (t > tMin && t < tMax) // not for NaN
      {
        ts.push_back(t);
      }
    }
  }
  std::sort(ts.begin(), ts.end());
  for (std::size_t i = 0; i + 1 < ts.size(); ++i)
  {
    if (!(ts[i] < ts[i + 1]))
    {
      continue;
    }
    const auto at = [&](int a, long double t) { return ray.origin[a] + t * ray.direction[a]; };
    const long double middle = 0.5L * (ts[i] + ts[i + 1]);
    const CellId* leaf = truth_.leafAt({ static_cast<double>(at(0, middle)),
      static_cast<double>(at(1, middle)), static_cast<double>(at(2, middle)) });
    if (!leaf)
    {
      continue;
    }
    Octant octant{ ts[i], ts[i + 1], {}, {}, {} };
    const Coord half = Coord(1) << (levels_ - leaf->level);
    BruteForceGTI::Vertex corner;
    for (int a = 0; a < 3; ++a)
    {
      const Coord low = 2 * half * leaf->index[a];
      corner[a] = low + (at(a, middle) * perRoot >= low + half ? half : 0);
      const auto place = [&](long double t) {
        // On a seam exactly, so that vertices beside it have no part.
        const long double rounding = 0x1p-58L * perRoot / half; // of coordinates of a few roots
        const long double x = (at(a, t) * perRoot - corner[a]) / half;
        return std::abs(x) < rounding ? 0.L : std::abs(x - 1.L) < rounding ? 1.L : x;
      };
      octant.from[a] = place(octant.t0);
      octant.to[a] = place(octant.t1);
    }
    for (int c = 0; c < 8; ++c)
    {
      octant.values[c] = vertex(
        { corner[0] + (c & 1 ? half : 0), corner[1] + (c & 2 ? half : 0), corner[2] + (c & 4 ? half : 0) });
    }
    visit(octant);
  }
}

std::vector<double> ExactRay::crossings(const Ray& ray, double tMin, double tMax, double isovalue)
{
  std::vector<double> found;
  forEachOctant(ray, tMin, tMax, [&](const Octant& octant) {
    const auto [low, high] = std::minmax_element(octant.values.begin(), octant.values.end());
    if (*low > isovalue || *high < isovalue)
    {
      return;
    }
    constexpr int steps = 64;
    const auto f = [&](long double part) { return octant.at(part) - isovalue; };
    long double before = f(0.L);
    for (int i = 0; i < steps; ++i)
    {
      long double a = static_cast<long double>(i) / steps;
      long double b = static_cast<long double>(i + 1) / steps;
      const long double after = f(b);
      if ((before < 0.L) != (after < 0.L))
      {
        for (int k = 0; k < 80; ++k)
        {
          const long double m = 0.5L * (a + b);
          ((f(m) < 0.L) == (before < 0.L) ? a : b) = m;
        }
        found.push_back(static_cast<double>(octant.t0 + 0.5L * (a + b) * (octant.t1 - octant.t0)));
      }
      before = after;
    }
  });
  return found;
}

std::array<double, 4> ExactRay::light(
  const Ray& ray, double tMin, double tMax, const TransferFunction& transferFunction, int samples)
{
  long double passes = 1.L;
  std::array<long double, 4> light{};
  forEachOctant(ray, tMin, tMax, [&](const Octant& octant) {
    const long double step = (octant.t1 - octant.t0) / samples;
    for (int i = 0; i < samples; ++i)
    {
      const TransferFunction::Entry e =
        transferFunction.at(static_cast<float>(octant.at((i + 0.5L) / samples)));
      const long double held = -std::expm1(-e.extinction * step);
      const std::array<long double, 4> emitted{ e.r, e.g, e.b, 1.L };
      for (int c = 0; c < 4; ++c)
      {
        light[c] += passes * held * emitted[c];
      }
      passes *= 1.L - held;
    }
  });
  std::array<double, 4> rgba;
  std::copy(light.begin(), light.end(), rgba.begin());
  return rgba;
}

} // namespace treeamr::test
