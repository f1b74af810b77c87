#include "Surface/OcclusionFilter.h"

#include "Error.h"
#include "Surface/SurfaceFrame.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Weights of a box of four pixels, centred on a pixel: each of the 16 places in the pattern of rays gets the same.
constexpr int reach = 2;
constexpr std::array<double, reach + 1> window{ 1., 1., 0.5 };

/// How far neighbours are used, so that what they get wrong and what few rays get wrong are about equal. The factors
/// have the least error on the benchmark's Mandelbulb with 4, 16 and 64 rays.
struct Tolerance
{
  /// Of the distance from a tangent plane to that across the view; 1 less the cosine of two normals may be as much.
  double slopeSquared;
  /// Of the part of open rays: three standard deviations of rays as even as these.
  float change;

  explicit Tolerance(int samples) noexcept
    : slopeSquared(std::min(0.5, 3.2 / samples))
    , change(static_cast<float>(2. * std::pow(samples, -0.75)))
  {
  }
};

/// A hit in the world, from the origin of the image's first ray: small differences stay exact far from the
/// coordinate origin.
struct Place
{
  Vec3 point;
  Vec3 normal; // towards the camera
  Vec3 away;   // from the camera
  float t;
  float open;
  std::uint32_t surface;
};

/// 1 for places of one plane, less the more they differ; 0: they have nothing to do with each other, also for NaN.
/// The distance from the tangent planes counts against that across the view, which a step in depth leaves small.
/// Without branches: on a rough surface nobody could predict them.
double similarity(const Place& a, const Place& b, double slopeSquared) noexcept
{
  const Vec3 way{ b.point[0] - a.point[0], b.point[1] - a.point[1], b.point[2] - a.point[2] };
  const double ofA = dot(a.normal, way);
  const double ofB = dot(b.normal, way);
  const double inDepth = dot(a.away, way);
  const double allowed = slopeSquared * (dot(way, way) - inDepth * inDepth);
  const double inPlane = allowed - std::max(ofA * ofA, ofB * ofB);
  const double aligned = slopeSquared - (1. - dot(a.normal, b.normal));
  const double same = a.surface == b.surface ? 1. : 0.;
  // Of NaN remains the first argument of std::max.
  return same * std::max(0., std::max(0., inPlane) * aligned / (slopeSquared * allowed));
}

/// Averages the hits of tiles, each from a copy of them and of those of the pixels around it.
class TileFilter
{
public:
  /// Keeps references.
  TileFilter(
    const Camera& camera, const HitImage& hits, const std::vector<std::uint16_t>& open, int samples) noexcept
    : camera_(camera)
    , hits_(hits)
    , open_(open)
    , samples_(static_cast<float>(samples))
    , tolerance_(samples)
    , frame_(camera.worldFromData())
    , origin_(camera.ray(0, 0).origin)
  {
  }

  void run(const tbb::blocked_range2d<int>& tile, std::vector<float>& filtered)
  {
    x0_ = std::max(tile.cols().begin() - reach, 0);
    y0_ = std::max(tile.rows().begin() - reach, 0);
    x1_ = std::min(tile.cols().end() + reach, camera_.width());
    y1_ = std::min(tile.rows().end() + reach, camera_.height());
    copy();
    for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
    {
      for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
      {
        sum(x, y);
        float* out = filtered.data() + hits_.first[static_cast<std::size_t>(y) * camera_.width() + x];
        const Place* place = places_.data() + placesOf(x, y).first;
        for (const Sum& s : sums_)
        {
          const auto change = static_cast<float>(s.change / s.weights);
          *out++ = place++->open + std::clamp(change, -tolerance_.change, tolerance_.change);
        }
      }
    }
  }

private:
  struct Sum
  {
    double weights;
    double change;
  };

  void copy()
  {
    places_.clear();
    first_.clear();
    for (int y = y0_; y < y1_; ++y)
    {
      const std::size_t* first = &hits_.first[static_cast<std::size_t>(y) * camera_.width()];
      for (int x = x0_; x < x1_; ++x)
      {
        first_.push_back(static_cast<std::uint32_t>(places_.size()));
        if (first[x] != first[x + 1])
        {
          copyPixel(camera_.ray(x, y), first[x], first[x + 1]);
        }
      }
    }
    first_.push_back(static_cast<std::uint32_t>(places_.size()));
  }

  void copyPixel(const Ray& ray, std::size_t begin, std::size_t end)
  {
    const Vec3 away = normalized(frame_.worldVector(ray.direction));
    for (std::size_t i = begin; i < end; ++i)
    {
      const SurfaceHit& hit = hits_.hits[i];
      Vec3 fromOrigin;
      for (int a = 0; a < 3; ++a)
      {
        fromOrigin[a] = ray.origin[a] - origin_[a] + hit.t * ray.direction[a];
      }
      places_.push_back(
        { frame_.worldVector(fromOrigin), frame_.worldNormal(hit.gradient, { -away[0], -away[1], -away[2] }),
          away, static_cast<float>(hit.t), static_cast<float>(open_[i]) / samples_, hit.surface });
    }
  }

  /// Its places: from the first up to the second.
  std::pair<std::uint32_t, std::uint32_t> placesOf(int x, int y) const noexcept
  {
    const std::uint32_t* first = &first_[static_cast<std::size_t>(y - y0_) * (x1_ - x0_) + (x - x0_)];
    return { first[0], first[1] };
  }

  /// Of the pixel's places. Of each other pixel that place counts whose distance from the camera is nearest to the
  /// own: both lists ascend, so one walk along them finds all.
  void sum(int x, int y)
  {
    const auto [begin, end] = placesOf(x, y);
    // The window stays inside the image, or its edge would have half a pattern.
    const int middleX = std::clamp(x, reach, std::max(camera_.width() - 1 - reach, reach));
    const int middleY = std::clamp(y, reach, std::max(camera_.height() - 1 - reach, reach));
    const auto weightOf = [&](int xx, int yy) {
      return window[std::abs(xx - middleX)] * window[std::abs(yy - middleY)];
    };
    sums_.assign(end - begin, { weightOf(x, y), 0. });
    if (sums_.empty())
    {
      return;
    }
    for (int yy = std::max(middleY - reach, y0_); yy <= std::min(middleY + reach, y1_ - 1); ++yy)
    {
      for (int xx = std::max(middleX - reach, x0_); xx <= std::min(middleX + reach, x1_ - 1); ++xx)
      {
        auto [other, otherEnd] = placesOf(xx, yy);
        if (other == otherEnd || (xx == x && yy == y))
        {
          continue;
        }
        const double near = weightOf(xx, yy);
        for (std::uint32_t own = begin; own < end; ++own)
        {
          const Place& place = places_[own];
          while (other + 1 < otherEnd &&
            std::abs(places_[other + 1].t - place.t) < std::abs(places_[other].t - place.t))
          {
            ++other;
          }
          const double weight = near * similarity(place, places_[other], tolerance_.slopeSquared);
          sums_[own - begin].weights += weight;
          sums_[own - begin].change += weight * (places_[other].open - place.open);
        }
      }
    }
  }

  const Camera& camera_;
  const HitImage& hits_;
  const std::vector<std::uint16_t>& open_;
  float samples_;
  Tolerance tolerance_;
  SurfaceFrame frame_;
  Vec3 origin_;
  int x0_ = 0; // the copied pixels: up to (x1, y1)
  int y0_ = 0;
  int x1_ = 0;
  int y1_ = 0;
  std::vector<std::uint32_t> first_; // place of each of them
  std::vector<Place> places_;
  std::vector<Sum> sums_;
};

} // namespace

std::vector<float> filterAmbientOcclusion(
  const Camera& camera, const HitImage& hits, const std::vector<std::uint16_t>& open, int samples)
{
  checkPixels(hits, camera, "ambient occlusion");
  if (open.size() != hits.hits.size() || samples < 1)
  {
    throw Error("ambient occlusion: " + std::to_string(open.size()) + " counts of " +
      std::to_string(samples) + " rays for " + std::to_string(hits.hits.size()) +
      " hits, allowed is one for each, of 1 ray or more");
  }
  std::vector<float> filtered(hits.hits.size());
  tbb::enumerable_thread_specific<TileFilter> workers(
    [&] { return TileFilter(camera, hits, open, samples); });
  constexpr int tileSize = 16; // fits the first cache
  tbb::parallel_for(
    tbb::blocked_range2d<int>(0, camera.height(), tileSize, 0, camera.width(), tileSize),
    [&](const tbb::blocked_range2d<int>& tile) { workers.local().run(tile, filtered); },
    tbb::simple_partitioner());
  return filtered;
}

} // namespace treeamr
