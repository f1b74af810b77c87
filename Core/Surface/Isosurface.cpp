#include "Surface/Isosurface.h"

#include "Error.h"
#include "Progress.h"
#include "Surface/BlockBoxes.h"
#include "Surface/SurfaceHierarchy.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
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

/// Less the field's offset: of values that cells have, as they have them. At the least one all is inside, as contours have it:
/// then such that no surface is found.
std::vector<double> relative(std::vector<double> isovalues, const Field& field)
{
  const LargeVector<float>& values = field.leafValues();
  const double min = field.range().min;
  const double width = field.range().max - min;
  constexpr double ofRange = 0x1p-16; // by which fields' values are rounded at most, or they would have an offset
  for (double& isovalue : isovalues)
  {
    const float stored = field.stored(isovalue);
    isovalue -= field.offset();
    if (std::abs(stored - isovalue) > ofRange * width)
    {
      continue;
    }
    if (stored == min)
    {
      isovalue = min - width - std::abs(min) - 1.;
    }
    else if (std::find(values.begin(), values.end(), stored) != values.end())
    {
      isovalue = stored;
    }
  }
  return isovalues;
}

/// Calls body(i) for the bits that are set.
template <class Body>
void forBits(std::uint32_t bits, const Body& body)
{
  for (; bits != 0; bits &= bits - 1)
  {
    body(std::countr_zero(bits));
  }
}

/// For so many at least; what it has besides comes from a frame before, and takes no time to make.
void makeRoom(LargeVector<SurfaceHit>& hits, std::size_t count)
{
  if (count > hits.size())
  {
    hits.reserve(count > hits.capacity() ? std::max(count, hits.size() + hits.size() / 4) : count);
    hits.resize(count);
  }
}

/// What a tile's rays have found, until all of it has its place in the image.
class TileHits
{
public:
  /// Lends a tile the room for it.
  class Room
  {
  public:
    Room(TileHits& hits, RayTile& tile) noexcept
      : hits_(hits)
      , tile_(tile)
    {
      hits_.found_.clear();
      hits_.found_.swap(tile_.found);
    }
    ~Room() { hits_.found_.swap(tile_.found); }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;

  private:
    TileHits& hits_;
    RayTile& tile_;
  };

  /// Of the tile that has the room; calls count(ray, how many hits it has) for each.
  template <class Count>
  void take(RayTile& tile, const Count& count)
  {
    order_.clear();
    if (tile.count > 0 && tile.hits[0].all)
    {
      for (int ray = 0; ray < tile.count; ++ray)
      {
        for (const FoundHit& hit : *tile.hits[ray].all)
        {
          order_.push_back(hit.number);
        }
        count(ray, tile.hits[ray].all->size());
      }
      return;
    }
    tile.found.reserve(static_cast<std::size_t>(std::count_if(
      tile.hits.begin(), tile.hits.begin() + tile.count, [](const RayHits& hits) { return hits.any(); })));
    for (int ray = 0; ray < tile.count; ++ray)
    {
      const RayHits& hits = tile.hits[ray];
      if (hits.any())
      {
        tile.found.push_back(hits.nearest);
      }
      count(ray, std::size_t(hits.any()));
    }
  }
  /// Of the hits that count, ray by ray, the i-th.
  const SurfaceHit& hit(std::size_t i) const noexcept { return found_[order_.empty() ? i : order_[i]]; }

private:
  std::vector<SurfaceHit> found_;
  std::vector<std::uint32_t> order_; // none: the same
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
  int rows() const noexcept { return rows_; }
  /// So many rows that each thread has some tiles of them.
  int rowsTogether() const noexcept
  {
    constexpr int tilesOfThread = 32;
    return std::min(rows_, 1 + tilesOfThread * tbb::this_task_arena::max_concurrency() / columns_);
  }
  std::size_t ofRows(int rows) const noexcept { return static_cast<std::size_t>(rows) * columns_; }
  /// Of the tiles from a row on.
  std::size_t number(int i, int j, int firstRow) const noexcept { return ofRows(j - firstRow) + i; }
  /// The first pixel of a row of tiles.
  std::size_t firstPixel(int row) const noexcept
  {
    return static_cast<std::size_t>(std::min(row * RayTile::size, height_)) * width_;
  }

  /// Calls body(column, row) for all of some rows, on all threads.
  template <class Body>
  void forAll(int firstRow, int endRow, const Body& body) const
  {
    tbb::parallel_for(
      tbb::blocked_range2d<int>(firstRow, endRow, 0, columns_), [&](const tbb::blocked_range2d<int>& range) {
        for (int j = range.rows().begin(); j < range.rows().end(); ++j)
        {
          for (int i = range.cols().begin(); i < range.cols().end(); ++i)
          {
            body(i, j);
          }
        }
      });
  }

  /// Calls body(x, y, pixels) for the packets of a tile that are in the image: that of their first pixel, and a bit for
  /// each that is.
  template <class Body>
  void forPackets(int i, int j, const Body& body) const
  {
    constexpr int packet = RayTile::packet;
    for (int k = 0; k < RayTile::most / PixelRays::most; ++k)
    {
      const int x = i * RayTile::size + packet * (k % 4);
      const int y = j * RayTile::size + packet * (k / 4);
      std::uint32_t pixels = 0;
      for (int p = 0; p < PixelRays::most; ++p)
      {
        pixels |= static_cast<std::uint32_t>(x + p % packet < width_ && y + p / packet < height_) << p;
      }
      if (pixels != 0)
      {
        body(x, y, pixels);
      }
    }
  }
  /// Calls body(number) for the pixels of a tile, packet by packet.
  template <class Body>
  void forPixels(int i, int j, const Body& body) const
  {
    forPackets(i, j,
      [&](int x, int y, std::uint32_t pixels) { forBits(pixels, [&](int p) { body(pixelOf(x, y, p)); }); });
  }
  /// Of the p-th of a packet.
  std::size_t pixelOf(int x, int y, int p) const noexcept
  {
    return static_cast<std::size_t>(y + p / RayTile::packet) * width_ + x + p % RayTile::packet;
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
  std::vector<double> isovalues; // as asked for
  SurfaceBlocks blocks;
  SurfaceGradients gradients;
  TraceSpace space;
  BlockIntersection intersection;
  double extractionSeconds; // until here
  SurfaceHierarchy hierarchy;
  std::once_flag makesBoxes;
  std::optional<BlockBoxes> boxes;                                 // for layers
  tbb::enumerable_thread_specific<std::unique_ptr<RayTile>> tiles; // for frames

  Impl(std::shared_ptr<const Field> field, std::vector<double> ascending, std::size_t keptBytes,
    int mostCellDepth, std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now())
    : isovalues(std::move(ascending))
    , blocks(field, relative(isovalues, *field), keptBytes, mostCellDepth)
    , gradients(blocks, keptBytes / 2 + (keptBytes - std::min(keptBytes, blocks.mostKeptBytes())))
    , space(field->octree().grid())
    , intersection(blocks, gradients, space)
    , extractionSeconds(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count())
    , hierarchy(intersection)
  {
  }

  /// Adds to a tile the rays of a packet's pixels whose bits are set, and returns the bits of those that may meet
  /// something. isCut: whether the near or the far plane cuts them.
  std::uint32_t add(const Camera& camera, const RayStops& stops, bool isCut, int x, int y,
    std::uint32_t pixels, std::size_t mostHits, RayTile& tile) const
  {
    PixelRays rays;
    castRays(camera, isCut, x, y, rays);
    std::array<RayParts, PixelRays::most> parts;
    if (!stops.isEmpty())
    {
      forBits(pixels, [&](int p) {
        parts[p] = stops.parts(camera, rays.at(p), x + p % RayTile::packet, y + p / RayTile::packet);
        if (parts[p].count > 0)
        {
          rays.begin[p] = parts[p].begin[0];
          rays.end[p] = parts[p].end[parts[p].count - 1];
        }
        else
        {
          pixels &= ~(1u << p);
        }
      });
    }
    const std::uint32_t started = startRays(space, rays, pixels, tile.count, tile.rays);
    forBits(started, [&](int p) {
      const int i = tile.count;
      intersection.add(mostHits, tile);
      if (parts[p].count > 1)
      {
        tile.parts.resize(RayTile::most);
        tile.parts[i] = parts[p];
        tile.hits[i].parts = &tile.parts[i];
      }
    });
    return started;
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
  return impl_->isovalues;
}

IsosurfaceStatistics Isosurface::statistics() const
{
  IsosurfaceStatistics statistics;
  statistics.blocks = impl_->blocks.all().size();
  statistics.blockBytes = impl_->blocks.byteSize();
  statistics.hierarchyBytes = impl_->hierarchy.byteSize() + (impl_->boxes ? impl_->boxes->byteSize() : 0);
  statistics.keptBytes = impl_->blocks.keptBytes();
  statistics.gradientBytes = impl_->gradients.byteSize();
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
  impl_->gradients.startFrame();
  this->tighten();
}

void Isosurface::tighten() const
{
  impl_->hierarchy.update();
  if (impl_->boxes)
  {
    impl_->boxes->update();
  }
}

bool Isosurface::intersect(const Ray& ray, double tMin, double tMax, SurfaceHit& hit) const
{
  RayPart part;
  RayHits hits;
  hits.clear();
  if (impl_->space.start(ray, tMin, tMax, part))
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
  std::vector<FoundHit> sorted;
  std::vector<SurfaceHit> found;
  hits.all = &sorted;
  hits.found = &found;
  if (impl_->space.start(ray, tMin, tMax, part))
  {
    impl_->hierarchy.intersect(part, hits);
    impl_->intersection.sort(part.ray.direction, hits);
  }
  for (const FoundHit& hit : sorted)
  {
    all.push_back(found[hit.number]);
  }
}

bool Isosurface::occluded(const Ray& ray, double tMin, double tMax) const
{
  RayPart part;
  RayHits hits;
  hits.clear();
  if (impl_->space.start(ray, tMin, tMax, part))
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

void Isosurface::render(const RayView& view, SurfaceLayers layers, HitImage& image, std::size_t mostHits,
  SurfaceNormals normals) const
{
  const Camera& camera = view.camera;
  const RayStops& stops = view.stops;
  stops.check(camera, "isosurface");
  const std::size_t most = layers == SurfaceLayers::Nearest ? 1 : mostHits;
  const Bounds box = impl_->blocks.field().octree().grid().bounds();
  const bool isCut = !camera.seesAllDepthsOf(box.min, box.max);
  const ImageTiles tiles(camera.width(), camera.height());
  image.first.assign(tiles.pixels() + 1, 0);
  if (most != 1)
  {
    std::call_once(impl_->makesBoxes, [&] { impl_->boxes.emplace(impl_->intersection); });
  }
  const auto trace = [&](int i, int j, TileHits& found) {
    RayTile& tile = impl_->tile();
    const TileHits::Room room(found, tile);
    tile.places.withNormals = normals == SurfaceNormals::Smooth;
    std::array<std::size_t, RayTile::most> pixelOf;
    tiles.forPackets(i, j, [&](int x, int y, std::uint32_t pixels) {
      int ray = tile.count;
      forBits(impl_->hierarchy.isEmpty() ? 0 : impl_->add(camera, stops, isCut, x, y, pixels, most, tile),
        [&](int p) { pixelOf[ray++] = tiles.pixelOf(x, y, p); });
    });
    if (tile.count != 0)
    {
      most == 1 ? impl_->hierarchy.intersect(tile) : impl_->boxes->find(tile);
      impl_->intersection.finish(tile);
    }
    found.take(tile, [&](int ray, std::size_t count) { image.first[pixelOf[ray] + 1] = count; });
  };
  // Of many hits those of a few rows at a time, which caches hold until they are in the image.
  const int rows = most == 1 ? tiles.rows() : tiles.rowsTogether();
  if (view.progress)
  {
    view.progress->begin(tiles.ofRows(tiles.rows()));
  }
  std::vector<TileHits> parts(tiles.ofRows(rows));
  for (int row = 0; row < tiles.rows(); row += rows)
  {
    const int end = std::min(row + rows, tiles.rows());
    tiles.forAll(row, end, [&](int i, int j) {
      trace(i, j, parts[tiles.number(i, j, row)]);
      if (view.progress)
      {
        view.progress->step();
      }
    });
    for (std::size_t p = tiles.firstPixel(row); p < tiles.firstPixel(end); ++p)
    {
      image.first[p + 1] += image.first[p];
    }
    makeRoom(image.hits, image.first[tiles.firstPixel(end)]);
    tiles.forAll(row, end, [&](int i, int j) {
      const TileHits& part = parts[tiles.number(i, j, row)];
      std::size_t next = 0;
      tiles.forPixels(i, j, [&](std::size_t pixel) {
        for (std::size_t to = image.first[pixel]; to < image.first[pixel + 1]; ++to)
        {
          image.hits[to] = part.hit(next++);
        }
      });
    });
  }
  image.hits.resize(image.first[tiles.pixels()]);
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
