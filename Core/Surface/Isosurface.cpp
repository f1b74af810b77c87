#include "Surface/Isosurface.h"

#include "Error.h"
#include "Surface/SurfaceHierarchy.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

std::vector<double> checked(std::vector<double> isovalues)
{
  if (isovalues.empty())
  {
    throw Error("isosurface: no isovalue, needed is at least one");
  }
  for (const double isovalue : isovalues)
  {
    if (!std::isfinite(isovalue))
    {
      throw Error("isosurface: isovalue " + std::to_string(isovalue) + ", allowed are finite values");
    }
  }
  std::sort(isovalues.begin(), isovalues.end());
  isovalues.erase(std::unique(isovalues.begin(), isovalues.end()), isovalues.end());
  return isovalues;
}

/// The rays of an image, and what of them is asked about.
class ImageRays
{
public:
  ImageRays(const Camera& camera, const RayStops& stops, const Bounds& box)
    : camera_(camera)
    , stops_(stops)
    , box_(box)
    , eye_(camera.eye())
    , fan_(camera.isPerspective() ? std::optional(camera.fan()) : std::nullopt)
    , isCut_(!camera.seesAllDepthsOf(box.min, box.max))
  {
  }

  /// True only for pixels whose ray passes the box at a distance: cheaper than to make the ray.
  bool miss(int x, int y) const noexcept
  {
    double in = 0.;
    double out = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
    {
      const double inverse = 1. / (fan_->direction[a] + x * fan_->perX[a] + y * fan_->perY[a]);
      const double margin = 1e-6 * (box_.max[a] - box_.min[a]);
      const double low = (box_.min[a] - margin - eye_[a]) * inverse;
      const double high = (box_.max[a] + margin - eye_[a]) * inverse;
      in = std::max(in, std::min(low, high));
      out = std::min(out, std::max(low, high));
    }
    return in > out; // not for NaN
  }

  /// Whether some of a square's pixels may: those that show the box form a convex area.
  bool mayMiss(int x, int y, int size) const noexcept
  {
    bool any = false;
    for (int corner = 0; fan_ && corner < 4; ++corner)
    {
      any = any || miss(x + (corner & 1) * size, y + (corner >> 1) * size);
    }
    return any;
  }

  RayParts parts(const Ray& ray, int x, int y) const noexcept
  {
    if (!stops_.isEmpty())
    {
      return stops_.parts(camera_, ray, x, y);
    }
    RayParts parts;
    isCut_ ? parts.add(camera_.tFromDepth(ray, 0.), camera_.tFromDepth(ray, 1.))
           : parts.add(0., std::numeric_limits<double>::infinity());
    return parts;
  }

private:
  const Camera& camera_;
  const RayStops& stops_;
  Bounds box_;
  Vec3 eye_;
  std::optional<PixelFan> fan_; // perspective only
  bool isCut_;                  // by the near or far plane
};

/// The tiles of an image.
class ImageTiles
{
public:
  ImageTiles(int width, int height)
    : width_(width)
    , height_(height)
    , columns_((width + RayTile::size - 1) / RayTile::size)
    , rows_((height + RayTile::size - 1) / RayTile::size)
  {
  }

  std::size_t pixels() const noexcept { return static_cast<std::size_t>(width_) * height_; }
  std::size_t count() const noexcept { return static_cast<std::size_t>(columns_) * rows_; }
  std::size_t number(int i, int j) const noexcept { return static_cast<std::size_t>(j) * columns_ + i; }

  /// Calls body(column, row) for all of them, on all threads.
  template <class Body>
  void forAll(const Body& body) const
  {
    tbb::parallel_for(
      tbb::blocked_range2d<int>(0, rows_, 0, columns_), [&](const tbb::blocked_range2d<int>& range) {
        for (int j = range.rows().begin(); j < range.rows().end(); ++j)
        {
          for (int i = range.cols().begin(); i < range.cols().end(); ++i)
          {
            body(i, j);
          }
        }
      });
  }

  /// Calls body(x, y, number) for the pixels of a tile, packet by packet.
  template <class Body>
  void forPixels(int i, int j, const Body& body) const
  {
    constexpr int packet = RayTile::packet;
    for (int k = 0; k < RayTile::most; ++k)
    {
      const int inPacket = k % (packet * packet);
      const int ofTile = k / (packet * packet);
      const int x = i * RayTile::size + packet * (ofTile % 4) + inPacket % packet;
      const int y = j * RayTile::size + packet * (ofTile / 4) + inPacket / packet;
      if (x < width_ && y < height_)
      {
        body(x, y, static_cast<std::size_t>(y) * width_ + x);
      }
    }
  }

private:
  int width_;
  int height_;
  int columns_;
  int rows_;
};

} // namespace

struct Isosurface::Impl
{
  SurfaceBlocks blocks;
  TraceSpace space;
  BlockIntersection intersection;
  double extractionSeconds; // until here
  SurfaceHierarchy hierarchy;
  tbb::enumerable_thread_specific<std::unique_ptr<RayTile>> tiles; // for frames

  Impl(std::shared_ptr<const Field> field, std::vector<double> isovalues, std::size_t keptBytes,
    int mostCellDepth, std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now())
    : blocks(field, std::move(isovalues), keptBytes, mostCellDepth)
    , space(field->octree().grid())
    , intersection(blocks, space)
    , extractionSeconds(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count())
    , hierarchy(intersection)
  {
  }

  /// Adds a ray to a tile, of whose parts the hits count; false when it meets nothing.
  bool add(const Ray& ray, const RayParts& parts, std::size_t mostHits, RayTile& tile) const
  {
    RayPart part;
    const int i = tile.count;
    if (parts.count == 0 || !intersection.start(ray, parts.begin[0], parts.end[parts.count - 1], part) ||
      !hierarchy.enter(part, i, tile.rays))
    {
      return false;
    }
    intersection.add(mostHits, tile);
    if (parts.count > 1)
    {
      tile.parts.resize(RayTile::most);
      tile.parts[i] = parts;
      tile.hits[i].parts = &tile.parts[i];
    }
    return true;
  }
  RayTile& tile()
  {
    std::unique_ptr<RayTile>& own = tiles.local();
    own = own ? std::move(own) : std::make_unique<RayTile>();
    own->clear();
    return *own;
  }
};

void checkPixels(const HitImage& hits, const Camera& camera, const char* user)
{
  const std::size_t needed = static_cast<std::size_t>(camera.width()) * camera.height() + 1;
  if (hits.first.size() != needed)
  {
    throw Error(std::string(user) + ": surface hits in " + std::to_string(hits.first.size()) +
      " entries by pixel, needed are " + std::to_string(needed));
  }
  if (hits.first.back() != hits.hits.size())
  {
    throw Error(std::string(user) + ": " + std::to_string(hits.hits.size()) +
      " surface hits, where the entries by pixel end at " + std::to_string(hits.first.back()));
  }
}

Isosurface::Isosurface(
  std::shared_ptr<const Field> field, std::vector<double> isovalues, std::size_t keptBytes, int mostCellDepth)
{
  isovalues = checked(std::move(isovalues));
  required(field, "isosurface");
  impl_ = std::make_unique<Impl>(std::move(field), std::move(isovalues), keptBytes, mostCellDepth);
}

Isosurface::~Isosurface() = default;

const std::vector<double>& Isosurface::isovalues() const noexcept
{
  return impl_->blocks.isovalues();
}

IsosurfaceStatistics Isosurface::statistics() const
{
  IsosurfaceStatistics statistics;
  statistics.blocks = impl_->blocks.all().size();
  statistics.blockBytes = impl_->blocks.byteSize();
  statistics.hierarchyBytes = impl_->hierarchy.byteSize();
  statistics.keptBytes = impl_->blocks.keptBytes();
  statistics.extractionSeconds = impl_->extractionSeconds;
  statistics.hierarchySeconds = impl_->hierarchy.seconds();
  return statistics;
}

std::uint64_t Isosurface::octantCount() const
{
  return impl_->blocks.octantCount();
}

void Isosurface::startFrame() const
{
  impl_->blocks.startFrame();
  this->tighten();
}

void Isosurface::tighten() const
{
  impl_->hierarchy.update();
}

bool Isosurface::intersect(const Ray& ray, double tMin, double tMax, SurfaceHit& hit) const
{
  RayPart part;
  RayHits hits;
  hits.clear();
  if (impl_->intersection.start(ray, tMin, tMax, part))
  {
    impl_->hierarchy.intersect(part, hits);
  }
  if (hits.any())
  {
    hit = impl_->intersection.nearest(hits);
  }
  return hits.any();
}

void Isosurface::intersectAll(const Ray& ray, double tMin, double tMax, std::vector<SurfaceHit>& all) const
{
  all.clear();
  RayPart part;
  RayHits hits;
  hits.clear();
  hits.all = &all;
  if (impl_->intersection.start(ray, tMin, tMax, part))
  {
    impl_->hierarchy.intersect(part, hits);
    impl_->intersection.sort(part.ray.direction, hits);
  }
}

bool Isosurface::occluded(const Ray& ray, double tMin, double tMax) const
{
  RayPart part;
  RayHits hits;
  hits.clear();
  if (impl_->intersection.start(ray, tMin, tMax, part))
  {
    impl_->hierarchy.occluded(part, hits);
  }
  return hits.any();
}

bool Isosurface::occluded(const Ray& ray, double tMin, double tMax, const DataCut& cut) const
{
  const RayParts parts = cut.parts(ray.origin, ray.direction, tMin, tMax);
  bool any = false;
  for (int i = 0; i < parts.count && !any; ++i)
  {
    any = this->occluded(ray, parts.begin[i], parts.end[i]);
  }
  return any;
}

void Isosurface::render(
  const Camera& camera, SurfaceLayers layers, HitImage& image, std::size_t mostHits) const
{
  this->render(camera, {}, layers, image, mostHits);
}

void Isosurface::render(const Camera& camera, const RayStops& stops, SurfaceLayers layers, HitImage& image,
  std::size_t mostHits) const
{
  stops.check(camera, "isosurface");
  const std::size_t most = layers == SurfaceLayers::Nearest ? 1 : mostHits;
  const ImageRays rays(camera, stops, impl_->blocks.field().octree().grid().bounds());
  const ImageTiles tiles(camera.width(), camera.height());
  std::vector<std::vector<SurfaceHit>> parts(tiles.count());
  image.first.assign(tiles.pixels() + 1, 0);
  tiles.forAll([&](int i, int j) {
    RayTile& tile = impl_->tile();
    std::array<std::size_t, RayTile::most> pixelOf;
    const bool mayMiss = rays.mayMiss(i * RayTile::size, j * RayTile::size, RayTile::size);
    tiles.forPixels(i, j, [&](int x, int y, std::size_t pixel) {
      if (mayMiss && rays.miss(x, y))
      {
        return;
      }
      pixelOf[tile.count] = pixel;
      const Ray ray = camera.ray(x, y);
      impl_->add(ray, rays.parts(ray, x, y), most, tile);
    });
    if (tile.count != 0)
    {
      impl_->hierarchy.intersect(tile);
      impl_->intersection.finish(tile);
    }
    std::vector<SurfaceHit>& found = parts[tiles.number(i, j)];
    for (int k = 0; k < tile.count; ++k)
    {
      const RayHits& hits = tile.hits[k];
      const std::size_t before = found.size();
      if (hits.all)
      {
        found.insert(found.end(), hits.all->begin(), hits.all->end());
      }
      else if (hits.any())
      {
        found.push_back(hits.nearest);
      }
      image.first[pixelOf[k] + 1] = found.size() - before;
    }
  });
  for (std::size_t p = 0; p < tiles.pixels(); ++p)
  {
    image.first[p + 1] += image.first[p];
  }
  image.hits.resize(image.first[tiles.pixels()]);
  tiles.forAll([&](int i, int j) {
    auto next = parts[tiles.number(i, j)].begin();
    tiles.forPixels(i, j, [&](int, int, std::size_t pixel) {
      const auto count = static_cast<std::ptrdiff_t>(image.first[pixel + 1] - image.first[pixel]);
      std::copy(next, next + count, image.hits.begin() + static_cast<std::ptrdiff_t>(image.first[pixel]));
      next += count;
    });
  });
}

CellId Isosurface::cell(const SurfaceHit& hit) const noexcept
{
  const SurfaceBlock& block = impl_->blocks.all()[hit.block];
  CellId cell{ {}, block.depth() + 1 - impl_->blocks.field().octree().grid().paddingDepth() };
  for (int a = 0; a < 3; ++a)
  {
    cell.index[a] = 2 * block.index(a) + (hit.octant >> (2 * a + 1) & 1);
  }
  return cell;
}

double Isosurface::leafWidth(const SurfaceHit& hit) const noexcept
{
  return impl_->intersection.leafWidth(hit, impl_->intersection.unit());
}

} // namespace treeamr
