#include "Surface/BlockIntersection.h"

#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <cmath>

namespace treeamr
{

namespace
{

/// Hits of one surface that are no further apart than this part of a cell are one: pieces that meet in a seam both
/// have a root on it.
constexpr double sameHit = 0x1p-32;

/// Bound of the error of a place in an octant of the block.
double placeError(const BlockPlanes& planes, const SurfaceRay& ray) noexcept
{
  const double perWidth =
    std::max({ planes.inverseWidth[0][0], planes.inverseWidth[1][0], planes.inverseWidth[2][0] });
  return ray.rounding * perWidth;
}

/// The roots on a crossing of a mixed record.
template <class Visit>
void visitMixed(const CrossedBlock& block, const SurfaceRay& ray, double isovalue, const Cubic& cubic,
  const OctantCrossing& crossing, const Visit& visit)
{
  const auto at = [&](const Vec3& place) {
    return onSeam(*block.record, isovalue, crossing.octant, place, placeError(block.planes, ray));
  };
  visitRoots(cubic, at(crossing.from), at(crossing.to), 0., visit);
}

/// Whether it is nearer than the ray's nearest hit. Of equal hits of neighbours the first block's counts, whatever the
/// order of visits.
bool isNearer(double t, std::uint32_t block, const SurfaceRay& ray) noexcept
{
  return t < ray.nearest.t || (t == ray.nearest.t && block < ray.nearest.block);
}

} // namespace

BlockIntersection::BlockIntersection(const SurfaceBlocks& blocks, const TraceSpace& space)
  : blocks_(blocks)
  , space_(space)
  , widest_(0.)
{
  const Bounds& domain = space.domain();
  for (int a = 0; a < 3; ++a)
  {
    widest_ = std::max(widest_, domain.max[a] - domain.min[a]);
  }
}

bool BlockIntersection::start(const Ray& world, double tMin, double tMax, SurfaceRay& ray) const noexcept
{
  const Bounds& domain = space_.domain();
  ray.ray = SlabRay(space_.ray(world));
  ray.tEnter = tMin;
  ray.tLeave = tMax;
  ray.ray.enterUpperFaces(domain);
  if (!ray.ray.clip(domain.min, domain.max, ray.tEnter, ray.tLeave))
  {
    return false;
  }
  ray.rounding = 0.;
  for (int a = 0; a < 3; ++a)
  {
    const double reach = std::abs(ray.ray.origin[a]) + ray.tLeave * std::abs(ray.ray.direction[a]);
    ray.rounding = std::max(ray.rounding, 0x1p-50 * reach);
  }
  ray.limit = std::numeric_limits<double>::infinity();
  ray.nearest.t = std::numeric_limits<double>::infinity();
  ray.nearest.block = SurfaceRay::noBlock;
  ray.all = nullptr;
  ray.most = std::numeric_limits<std::size_t>::max();
  ray.parts = nullptr;
  return true;
}

void BlockIntersection::add(std::size_t mostHits, RayTile& tile) const noexcept
{
  const int i = tile.count++;
  SurfaceRay& ray = tile.rays[i];
  tile.slabs.set(i, ray.ray);
  tile.slabs.enter[i] = ray.tEnter;
  tile.slabs.leave[i] = ray.tLeave;
  tile.slabs.limit[i] = ray.limit;
  tile.slabs.rounding[i] = ray.rounding;
  if (mostHits != 1)
  {
    tile.all[i].clear();
    ray.all = &tile.all[i];
    ray.most = mostHits;
  }
}

bool BlockIntersection::meetsExtent(
  const CrossedBlock& block, std::span<const unsigned> numbers, const SurfaceRay* rays) const noexcept
{
  Vec3 low;
  Vec3 high;
  for (int a = 0; a < 3; ++a)
  {
    low[a] = block.planes.at[a][block.first[a]];
    high[a] = block.planes.at[a][block.end[a]];
  }
  return std::any_of(numbers.begin(), numbers.end(), [&](unsigned number) {
    const SurfaceRay& ray = rays[number];
    double in = ray.tEnter;
    double out = std::min(ray.tLeave, ray.limit);
    // A hit may lie on the box: on a seam, where rounding decides.
    return ray.ray.clip(low, high, in, out) || in - out <= 0x1p-20 * (ray.tLeave - ray.tEnter);
  });
}

bool BlockIntersection::open(
  CrossedBlock& block, std::span<const unsigned> numbers, const SurfaceRay* rays) const
{
  // To compute values again takes longer than to look whether a ray comes near the surface.
  if (blocks_.all()[block.number].isNarrowed() && !blocks_.isKept(block.number) &&
    !meetsExtent(block, numbers, rays))
  {
    return false;
  }
  block.record = &blocks_.record(block.number);
  block.record->prefetch();
  return true;
}

template <class Visit, class GoesOn>
void BlockIntersection::visitHits(
  const CrossedBlock& block, const SurfaceRay& ray, const Visit& visit, const GoesOn& goesOn) const
{
  const SurfaceRecord& record = *block.record;
  // How far from zero a value may be on the seam of two octants that is zero on it.
  const double tolerance = record.tolerance + record.width() * placeError(block.planes, ray);
  walkBlock(block.planes, record.active, ray.ray, ray.tEnter, ray.tLeave, ray.limit,
    [&](const OctantCrossing& crossing) {
      for (std::uint32_t surface = 0; surface < blocks_.isovalues().size(); ++surface)
      {
        const double isovalue = blocks_.isovalues()[surface];
        const Cubic cubic = alongCrossing(record, isovalue, crossing);
        const auto visitRoot = [&](double s) {
          const double t = crossing.t0 + s * (crossing.t1 - crossing.t0);
          return ray.shows(t) && visit(surface, crossing, s, t);
        };
        if (record.isMixed())
        {
          visitMixed(block, ray, isovalue, cubic, crossing, visitRoot);
        }
        else
        {
          visitRoots(cubic, tolerance, visitRoot);
        }
      }
      return goesOn();
    });
}

bool BlockIntersection::nearestInBlock(const CrossedBlock& block, SurfaceRay& ray) const
{
  bool closer = false;
  visitHits(
    block, ray,
    [&](std::uint32_t surface, const OctantCrossing& crossing, double s, double t) {
      if (isNearer(t, block.number, ray))
      {
        closer = true;
        ray.nearest = { t, {}, {}, surface, block.number, static_cast<std::uint8_t>(crossing.octant) };
        ray.place = crossing.place(s);
        ray.limit = t;
      }
      return true;
    },
    [&] { return !closer; });
  return closer;
}

void BlockIntersection::collectInBlock(const CrossedBlock& block, SurfaceRay& ray) const
{
  visitHits(
    block, ray,
    [&](std::uint32_t surface, const OctantCrossing& crossing, double s, double t) {
      ray.all->push_back({ t, {}, {}, surface, block.number, static_cast<std::uint8_t>(crossing.octant) });
      setGradients(block, crossing.place(s), ray.all->back());
      return false;
    },
    [] { return true; });
}

std::uint32_t BlockIntersection::intersect(
  std::uint32_t number, std::span<const unsigned> numbers, SurfaceRay* rays, RayTile* tile) const
{
  if (blocks_.all()[number].isEmpty())
  {
    return 0;
  }
  if (!tile)
  {
    CrossedBlock block(space_, blocks_.all()[number], number);
    std::uint32_t nearer = 0;
    if (open(block, numbers, rays))
    {
      for (std::size_t i = 0; i < numbers.size(); ++i)
      {
        SurfaceRay& ray = rays[numbers[i]];
        if (ray.all)
        {
          collectInBlock(block, ray);
        }
        else if (nearestInBlock(block, ray))
        {
          nearer |= 1u << i;
        }
      }
    }
    return nearer;
  }

  OctantCandidates& candidates = tile->candidates;
  candidates.blocks[candidates.blockCount++] = CrossedBlock(space_, blocks_.all()[number], number);
  if (!open(candidates.last(), numbers, rays))
  {
    --candidates.blockCount;
    return 0;
  }
  for (std::size_t i = 0; i < numbers.size();)
  {
    std::size_t run = 1; // of rays side by side
    while (
      i + run < numbers.size() && run < OctantCandidates::mostRays && numbers[i + run] == numbers[i] + run)
    {
      ++run;
    }
    cross(*tile, static_cast<int>(numbers[i]), static_cast<int>(run));
    i += run;
  }
  candidates.dropEmptyBlock();
  // Those of all layers wait until there are many, unless the next block takes the place of the values.
  if (!tile->rays[numbers[0]].all || candidates.count >= OctantCandidates::enough || !blocks_.isKept(number))
  {
    takeCandidates(*tile);
    candidates.blockCount = 0;
  }
  std::uint32_t nearer = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    SurfaceRay& ray = rays[numbers[i]];
    if (tile->slabs.limit[numbers[i]] < ray.limit)
    {
      ray.limit = tile->slabs.limit[numbers[i]];
      nearer |= 1u << i;
    }
  }
  return nearer;
}

void BlockIntersection::cross(RayTile& tile, int first, int count) const
{
  const std::span<const double> isovalues = blocks_.isovalues();
  constexpr std::size_t together = OctantCandidates::mostIsovalues;
  for (std::size_t s = 0; s < isovalues.size(); s += together)
  {
    if (tile.candidates.count >= OctantCandidates::enough)
    {
      takeCandidates(tile);
      tile.candidates.keepLastBlock();
    }
    crossBlock(isovalues.subspan(s, std::min(together, isovalues.size() - s)), static_cast<int>(s),
      tile.slabs, first, count, tile.candidates);
  }
}

void BlockIntersection::takeCandidates(RayTile& tile) const
{
  OctantCandidates& candidates = tile.candidates;
  if (candidates.count == 0)
  {
    return;
  }
  const CandidateRoots& roots = tile.roots;
  const bool firstOnly = !tile.rays[candidates.ray(0)].all && tile.parts.empty();
  findRoots(candidates, firstOnly, tile.roots);
  for (int i = 0; i < roots.count; ++i)
  {
    if (!candidates.block(roots.candidate[i]).record->isMixed())
    {
      takeRoot(tile, roots.candidate[i], roots.s[i], roots.t[i]);
    }
  }
  for (int i = 0; i < candidates.count; ++i)
  {
    const CrossedBlock& block = candidates.block(i);
    if (block.record->isMixed())
    {
      const SurfaceRay& ray = tile.rays[candidates.ray(i)];
      const OctantCrossing crossing(
        block.planes, ray.ray, candidates.octant(i), candidates.t0[i], candidates.t1[i]);
      visitMixed(block, ray, blocks_.isovalues()[candidates.isovalue(i)], candidates.along(i), crossing,
        [&](double s) {
          takeRoot(tile, i, s, crossing.t0 + s * (crossing.t1 - crossing.t0));
          return firstOnly;
        });
    }
  }
  takePlaces(tile); // before the values are gone
  candidates.count = 0;
}

void BlockIntersection::takeRoot(RayTile& tile, int candidate, double s, double t) const
{
  const OctantCandidates& candidates = tile.candidates;
  const int number = candidates.ray(candidate);
  SurfaceRay& ray = tile.rays[number];
  if (!ray.shows(t))
  {
    return;
  }
  const CrossedBlock& block = candidates.block(candidate);
  const SurfaceHit hit{ t, {}, {}, candidates.isovalue(candidate), block.number,
    candidates.octant(candidate) };
  if (ray.all)
  {
    addPlace(tile, number, block, candidates.place(candidate, s), hit);
  }
  else if (isNearer(t, block.number, ray))
  {
    ray.nearest = hit;
    ray.place = candidates.place(candidate, s);
    tile.slabs.limit[number] = t;
  }
}

void BlockIntersection::addPlace(
  RayTile& tile, int ray, const CrossedBlock& block, const Vec3& place, const SurfaceHit& hit) const
{
  HitPlaces& places = tile.places;
  tile.placed[places.count] = { hit, ray };
  places.add(*block.record, block.planes, space_.domain(), hit.octant, place);
  if (places.count == HitPlaces::most)
  {
    takePlaces(tile);
  }
}

void BlockIntersection::takePlaces(RayTile& tile) const
{
  findNormals(unit(), tile.places);
  for (int i = 0; i < tile.places.count; ++i)
  {
    SurfaceHit& hit = tile.placed[i].hit;
    for (int a = 0; a < 3; ++a)
    {
      hit.gradient[a] = tile.places.gradient[a][i];
      hit.normal[a] = static_cast<float>(tile.places.normal[a][i]);
    }
    const int number = tile.placed[i].ray;
    SurfaceRay& ray = tile.rays[number];
    if (!ray.all)
    {
      ray.nearest = hit;
      continue;
    }
    ray.all->push_back(hit);
    // Not at every hit: to sort them takes time.
    if (ray.all->size() / 2 >= ray.most)
    {
      sort(ray);
      if (ray.all->size() == ray.most)
      {
        tile.slabs.limit[number] = ray.all->back().t;
      }
    }
  }
  tile.places.count = 0;
}

void BlockIntersection::finish(RayTile& tile) const
{
  takeCandidates(tile);
  tile.candidates.blockCount = 0;
  for (int number = 0; number < tile.count; ++number)
  {
    const SurfaceRay& ray = tile.rays[number];
    if (ray.all)
    {
      sort(ray);
    }
    else if (ray.hasHit())
    {
      addPlace(tile, number, opened(ray.nearest.block), ray.place, ray.nearest);
    }
  }
  takePlaces(tile);
}

void BlockIntersection::setGradients(
  const CrossedBlock& block, const Vec3& place, SurfaceHit& hit) const noexcept
{
  auto [exact, smooth] = gradientsAt(*block.record, block.planes, space_.domain(), hit.octant, place);
  for (int a = 0; a < 3; ++a)
  {
    exact[a] /= space_.width(a);
    smooth[a] /= space_.width(a);
  }
  hit.gradient = exact;
  const Vec3 normal = normalized(dot(smooth, exact) > 0. ? smooth : exact);
  std::copy(normal.begin(), normal.end(), hit.normal.begin());
}

CrossedBlock BlockIntersection::opened(std::uint32_t number) const
{
  CrossedBlock block(space_, blocks_.all()[number], number);
  block.record = &blocks_.record(number);
  return block;
}

SurfaceHit BlockIntersection::nearest(const SurfaceRay& ray) const
{
  SurfaceHit hit = ray.nearest;
  setGradients(opened(hit.block), ray.place, hit);
  return hit;
}

void BlockIntersection::sort(const SurfaceRay& ray) const
{
  std::vector<SurfaceHit>& hits = *ray.all;
  // They come nearly sorted.
  for (std::size_t i = 1; i < hits.size(); ++i)
  {
    const auto before = [](const SurfaceHit& a, const SurfaceHit& b) {
      return a.t != b.t ? a.t < b.t : a.surface != b.surface ? a.surface < b.surface : a.block < b.block;
    };
    if (before(hits[i], hits[i - 1]))
    {
      const auto at = std::upper_bound(hits.begin(), hits.begin() + i, hits[i], before);
      std::rotate(at, hits.begin() + i, hits.begin() + i + 1);
    }
  }
  const Vec3& d = ray.ray.direction;
  const double speed = std::max({ std::abs(d[0]), std::abs(d[1]), std::abs(d[2]) });
  std::size_t kept = 0;
  for (const SurfaceHit& hit : hits)
  {
    bool isNew = true;
    for (std::size_t k = kept; k > 0 && (hit.t - hits[k - 1].t) * speed <= sameHit * widest_; --k)
    {
      if (hits[k - 1].surface == hit.surface)
      {
        isNew = (hit.t - hits[k - 1].t) * speed > sameHit * leafWidth(hits[k - 1], { 1., 1., 1. });
        break;
      }
    }
    if (isNew)
    {
      hits[kept++] = hit;
    }
  }
  hits.resize(std::min(kept, ray.most));
}

double BlockIntersection::leafWidth(const SurfaceHit& hit, const Vec3& unit) const noexcept
{
  const BlockPlanes planes(space_, blocks_.all()[hit.block]);
  double width = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    const int cell = hit.octant >> 2 * a & 2;
    width = std::min(width, (planes.at[a][cell + 2] - planes.at[a][cell]) * unit[a]);
  }
  return width;
}

} // namespace treeamr
