// The fields and the refinement criterion of the example data.
//
// The Mandelbulb (White and Nylander, power 8) is z -> z^8 + c in spherical form with theta = acos(z / r) and
// phi = atan2(y, x). Refined from level 4 on, and the forest balanced across faces, edges and corners, the
// unit cube has 305,096 cells up to level 7 with a threshold of 0.05, 2,636,936 up to level 9 with 0.55, and
// 20,445,706 up to level 10 with 0.40.
//
// The sheet is smooth: up to level 10 with 0.035 it has 22,719,418 cells, a quarter of which touches another
// level, where nearly all of the two large Mandelbulbs' do.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace treeamr
{

/// The smooth escape time at a point of the unit cube, in [0, 1]; 1 where the orbit is bounded after 12
/// steps.
inline double mandelbulb(double x, double y, double z) noexcept
{
  constexpr int maxSteps = 12;
  constexpr double escapeRadiusSquared = 4.;
  // The cube reaches 1.2 to each side of the origin.
  const std::array<double, 3> c = { 2.4 * (x - 0.5), 2.4 * (y - 0.5), 2.4 * (z - 0.5) };
  std::array<double, 3> p = c;
  for (int step = 0; step <= maxSteps; ++step)
  {
    const double r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    if (r2 > escapeRadiusSquared)
    {
      const double smooth = std::log(std::log(r2) / (2. * std::log(2.))) / std::log(8.);
      return std::clamp((step + 1 - smooth) / maxSteps, 0., 1.);
    }
    // acos(0 / 0) at the origin: the pole's direction does as well as any, since r is zero.
    const double theta = r2 > 0. ? 8. * std::acos(p[2] / std::sqrt(r2)) : 0.;
    const double phi = 8. * std::atan2(p[1], p[0]);
    const double r8 = r2 * r2 * r2 * r2;
    p = { r8 * std::sin(theta) * std::cos(phi) + c[0], r8 * std::sin(theta) * std::sin(phi) + c[1],
      r8 * std::cos(theta) + c[2] };
  }
  return 1.;
}

/// A wavy Gaussian shear sheet through the unit cube and 120 Gaussian blobs around it, of values from 0 to
/// about 2.2: to be called like mandelbulb(). The blobs are random but the same on every machine.
class Sheet
{
public:
  Sheet()
  {
    for (int i = 0; i < blobCount; ++i)
    {
      const double x = random();
      const double z = random();
      const double y = 0.5 + height(x, z) + 0.3 * (random() + random() - 1.);
      // Uniform in 1 / sigma: few are large.
      const double sigma = 1. / (1. / 0.008 - random() * (1. / 0.008 - 1. / 0.16));
      addBlob({ { x, y, z }, 0.3 + 0.7 * random(), reachInSigmas * reachInSigmas * sigma * sigma,
        0.5 / (sigma * sigma) });
    }
  }

  double operator()(double x, double y, double z) const noexcept
  {
    constexpr double sigma = 0.025;
    const double s = y - 0.5 - height(x, z);
    double value = 0.;
    if (std::abs(s) < reachInSigmas * sigma)
    {
      value =
        0.6 * std::exp(-0.5 / (sigma * sigma) * s * s) * (0.6 + 0.4 * std::sin(40. * x) * std::sin(31. * z));
    }
    for (const Blob& blob : buckets_[bucket(x) + size * (bucket(y) + size * bucket(z))])
    {
      const double dx = x - blob.centre[0];
      const double dy = y - blob.centre[1];
      const double dz = z - blob.centre[2];
      const double r2 = dx * dx + dy * dy + dz * dz;
      value += r2 < blob.reach2 ? blob.height * std::exp(-blob.fall * r2) : 0.;
    }
    return value;
  }

private:
  static constexpr int blobCount = 120;
  static constexpr double reachInSigmas = 6.; // beyond it, less than 2e-8 is left out
  static constexpr int size = 32;             // buckets per axis

  struct Blob
  {
    std::array<double, 3> centre;
    double height;
    double reach2; // squared
    double fall;   // 1 / (2 sigma^2)
  };

  /// Of the sheet above y = 1/2.
  static double height(double x, double z) noexcept
  {
    return 0.08 * std::sin(9. * x + 2. * std::sin(5. * z));
  }
  static int bucket(double coordinate) noexcept
  {
    return std::clamp(static_cast<int>(coordinate * size), 0, size - 1);
  }

  /// In [0, 1), by splitmix64 (Vigna): those of the standard library differ between systems.
  double random() noexcept
  {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  }

  /// To each bucket that it reaches.
  void addBlob(const Blob& blob)
  {
    for (int i = 0; i < size * size * size; ++i)
    {
      const std::array<int, 3> place = { i % size, i / size % size, i / (size * size) };
      double distance2 = 0.;
      for (int a = 0; a < 3; ++a)
      {
        const double lower = static_cast<double>(place[a]) / size;
        const double d = std::clamp(blob.centre[a], lower, lower + 1. / size) - blob.centre[a];
        distance2 += d * d;
      }
      if (distance2 < blob.reach2)
      {
        buckets_[i].push_back(blob);
      }
    }
  }

  std::uint64_t state_ = 1;
  std::vector<std::vector<Blob>> buckets_ = std::vector<std::vector<Blob>>(size * size * size);
};

/// The same from 0 to 1, its small values larger: half way up, where surfaces are by default, are the sheet and most
/// blobs, not the blobs alone that lie on each other.
class SaturatedSheet
{
public:
  double operator()(double x, double y, double z) const noexcept
  {
    return 1. - std::exp(-2. * sheet_(x, y, z));
  }

private:
  Sheet sheet_;
};

/// max - min of field(x, y, z) over 3 x 3 x 3 probes of a cubic cell, at the fractions 1/6, 1/2 and 5/6 of
/// its width: the centres of its 27 thirds. A cell is refined when this exceeds the threshold.
template <class Field>
double rangeOverProbes(const Field& field, const std::array<double, 3>& cellMin, double cellWidth)
{
  constexpr std::array<double, 3> fractions = { 1. / 6., 1. / 2., 5. / 6. };
  double min = std::numeric_limits<double>::infinity();
  double max = -min;
  for (const double fz : fractions)
  {
    for (const double fy : fractions)
    {
      for (const double fx : fractions)
      {
        const double value =
          field(cellMin[0] + cellWidth * fx, cellMin[1] + cellWidth * fy, cellMin[2] + cellWidth * fz);
        min = std::min(min, value);
        max = std::max(max, value);
      }
    }
  }
  return max - min;
}

} // namespace treeamr
