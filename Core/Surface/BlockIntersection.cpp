#include "Surface/BlockIntersection.h"

#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeamr
{

namespace
{

/// Hits of one surface that are no further apart than this part of a cell are one: pieces that meet in a seam both
/// have a root on it.
constexpr double sameHit = 0x1p-32;

/// Bound of the error of a place in an octant of the block.
double placeError(const BlockPlanes& planes, const RayPart& ray) noexcept
{
  const double perWidth =
    std::max({ planes.inverseWidth[0][0], planes.inverseWidth[1][0], planes.inverseWidth[2][0] });
  return ray.rounding * perWidth;
}

/// The roots on a crossing of a mixed record.
template <class Visit>
void visitMixed(const CrossedBlock& block, double rounding, const RayPart& ray, double isovalue,
  const Cubic& cubic, const OctantCrossing& crossing, const Visit& visit)
{
  const auto at = [&](const Vec3& place) {
    return onSeam(*block.record, isovalue, crossing.octant, place, placeError(block.planes, ray), rounding);
  };
  visitRoots(cubic, at(crossing.from), at(crossing.to), 0., visit);
}

/// In the order of floats, as numbers without sign.
std::uint64_t orderOf(float depth) noexcept
{
  const auto bits = std::bit_cast<std::uint32_t>(depth);
  return bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u);
}

} // namespace

BlockIntersection::BlockIntersection(
  const SurfaceBlocks& blocks, const SurfaceGradients& gradients, const TraceSpace& space)
  : blocks_(blocks)
  , gradients_(gradients)
  , space_(space)
  , widest_(0.)
{
  const Bounds& domain = space.domain();
  for (int a = 0; a < 3; ++a)
  {
    widest_ = std::max(widest_, domain.max[a] - domain.min[a]);
  }
}

void BlockIntersection::add(std::size_t mostHits, RayTile& tile) const noexcept
{
  const int i = tile.count++;
  RayHits& hits = tile.hits[i];
  hits.clear();
  tile.rays.limit[i] = hits.limit;
  if (mostHits != 1)
  {
    tile.all[i].clear();
    hits.all = &tile.all[i];
    hits.found = &tile.found;
    hits.most = mostHits;
  }
}

bool BlockIntersection::meetsExtent(const CrossedBlock& block, const RayPart& ray, double limit) noexcept
{
  Vec3 low;
  Vec3 high;
  for (int a = 0; a < 3; ++a)
  {
    low[a] = block.planes.at[a][block.first[a]];
    high[a] = block.planes.at[a][block.end[a]];
  }
  double in = ray.tEnter;
  double out = std::min(ray.tLeave, limit);
  // A hit may lie on the box: on a seam, where rounding decides.
  return ray.ray.clip(low, high, in, out) || in - out <= 0x1p-20 * (ray.tLeave - ray.tEnter);
}

template <class Visit, class GoesOn>
void BlockIntersection::visitHits(const CrossedBlock& block, const RayPart& ray, const RayHits& hits,
  const Visit& visit, const GoesOn& goesOn) const
{
  const SurfaceRecord& record = *block.record;
  // How far from zero a value may be on the seam of two octants that is zero on it.
  const double tolerance = record.tolerance + record.width() * placeError(block.planes, ray);
  walkBlock(block.planes, record.active, ray.ray, ray.tEnter, ray.tLeave, hits.limit,
    [&](const OctantCrossing& crossing) {
      for (std::uint32_t surface = 0; surface < blocks_.isovalues().size(); ++surface)
      {
        const double isovalue = blocks_.isovalues()[surface];
        const Cubic cubic = alongCrossing(record, isovalue, crossing);
        const auto visitRoot = [&](double s) {
          const double t = crossing.t0 + s * (crossing.t1 - crossing.t0);
          return hits.shows(t) && visit(surface, crossing, s, t);
        };
        if (record.isMixed())
        {
          visitMixed(block, blocks_.rounding(), ray, isovalue, cubic, crossing, visitRoot);
        }
        else
        {
          visitRoots(cubic, tolerance, visitRoot);
        }
      }
      return goesOn();
    });
}

bool BlockIntersection::nearestInBlock(const CrossedBlock& block, const RayPart& ray, RayHits& hits) const
{
  bool closer = false;
  visitHits(
    block, ray, hits,
    [&](std::uint32_t surface, const OctantCrossing& crossing, double s, double t) {
      if (hits.isNearer(t, block.number))
      {
        closer = true;
        hits.nearest = { t, {}, {}, surface, block.number, static_cast<std::uint8_t>(crossing.octant) };
        hits.place = crossing.place(s);
        hits.limit = t;
      }
      return true;
    },
    [&] { return !closer; });
  return closer;
}

void BlockIntersection::collectInBlock(const CrossedBlock& block, const RayPart& ray, RayHits& hits) const
{
  visitHits(
    block, ray, hits,
    [&](std::uint32_t surface, const OctantCrossing& crossing, double s, double t) {
      SurfaceHit& hit = hits.add(t);
      hit = { t, {}, {}, surface, block.number, static_cast<std::uint8_t>(crossing.octant) };
      setGradients(block, crossing.place(s), hit);
      return false;
    },
    [] { return true; });
}

bool BlockIntersection::intersect(std::uint32_t number, const RayPart& ray, RayHits& hits) const
{
  const SurfaceBlock& place = blocks_.all()[number];
  if (place.isEmpty())
  {
    return false;
  }
  CrossedBlock block(space_, place, number);
  // To compute values again takes longer than to look whether the ray comes near the surface.
  if (place.isNarrowed() && !blocks_.isKept(number) && !meetsExtent(block, ray, hits.limit))
  {
    return false;
  }
  block.record = &blocks_.record(number);
  block.record->prefetch();
  if (hits.all)
  {
    collectInBlock(block, ray, hits);
    return false;
  }
  return nearestInBlock(block, ray, hits);
}

std::uint32_t BlockIntersection::intersect(
  std::uint32_t number, int first, std::uint32_t wanted, RayTile& tile) const
{
  blocks_.prefetch(number);
  const CrossedBlock block(space_, blocks_.all()[number], number);
  BlockEntries entries;
  enterBlock(block, tile.rays, first, wanted, entries);
  if (entries.count == 0)
  {
    return 0;
  }
  this->enter(tile, block, entries);
  std::uint32_t nearer = 0;
  for (int i = 0; i < entries.count; ++i)
  {
    const auto ray = static_cast<int>(entries.ray[i]);
    if (tile.rays.limit[ray] < tile.hits[ray].limit)
    {
      tile.hits[ray].limit = tile.rays.limit[ray];
      nearer |= 1u << (ray - first);
    }
  }
  return nearer;
}

void BlockIntersection::takeBlocks(RayTile& tile) const
{
  // So many blocks that their values are in the cache in time.
  constexpr std::size_t ahead = 3;
  std::vector<std::uint64_t>& order = tile.order; // depth << 32 | number of the block among the tile's
  order.clear();
  for (std::size_t i = 0; i < tile.blocks.size(); ++i)
  {
    order.push_back(orderOf(tile.blocks[i].depth) << 32 | i);
  }
  std::sort(order.begin(), order.end());
  const auto blockAt = [&](std::size_t i) { return tile.blocks[order[i] & 0xffffffffu]; };
  BlockEntries entries;
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    if (i + 2 * ahead < order.size())
    {
      blocks_.prefetchBlock(blockAt(i + 2 * ahead).block);
      gradients_.prefetch(blockAt(i + 2 * ahead).block);
    }
    if (i + ahead < order.size())
    {
      blocks_.prefetch(blockAt(i + ahead).block);
      gradients_.prefetchReady(blockAt(i + ahead).block);
    }
    const MetBlock met = blockAt(i);
    const CrossedBlock block(space_, blocks_.all()[met.block], met.block);
    for (std::uint32_t packets = met.packets; packets != 0;)
    {
      packets = enterBlockByPackets(block, tile.rays, tile.count, packets, entries);
      if (entries.count != 0)
      {
        this->enter(tile, block, entries);
        entries.count = 0;
      }
    }
  }
  tile.blocks.clear();
}

void BlockIntersection::enter(RayTile& tile, const CrossedBlock& place, const BlockEntries& entries) const
{
  OctantCandidates& candidates = tile.candidates;
  CrossedBlock& block = candidates.blocks[candidates.blockCount];
  block = place;
  const bool wasKept =
    blocks_.isKept(block.number); // else it may be by another thread now, but not this record
  block.record = &blocks_.record(block.number);
  ++candidates.blockCount;
  this->cross(tile, entries);
  candidates.dropEmptyBlock();
  // Those of all layers wait until there are many, unless the next block takes the place of the values.
  if (!tile.hits[entries.ray[0]].all || candidates.count >= OctantCandidates::enough || !wasKept)
  {
    takeCandidates(tile);
    candidates.blockCount = 0;
  }
  if (!wasKept)
  {
    takePlaces(tile);
  }
}

void BlockIntersection::cross(RayTile& tile, const BlockEntries& entries) const
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
    crossBlock(isovalues.subspan(s, std::min(together, isovalues.size() - s)), static_cast<int>(s), tile.rays,
      entries, tile.candidates);
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
  const bool all = tile.hits[candidates.ray(0)].all;
  const bool firstOnly = !all && tile.parts.empty();
  findRoots(candidates, firstOnly, tile.roots);
  for (int i = 0; i < roots.count;)
  {
    if (all)
    {
      i = takeLayers(tile, i);
      continue;
    }
    if (!candidates.block(roots.candidate[i]).record->isMixed())
    {
      takeRoot(tile, roots.candidate[i], roots.s[i], roots.t[i]);
    }
    ++i;
  }
  for (int i = 0; i < candidates.count; ++i)
  {
    const CrossedBlock& block = candidates.block(i);
    if (block.record->isMixed())
    {
      const RayPart ray = tile.rays.at(candidates.ray(i));
      const OctantCrossing crossing(
        block.planes, ray.ray, candidates.octant(i), candidates.t0[i], candidates.t1[i]);
      visitMixed(block, blocks_.rounding(), ray, blocks_.isovalues()[candidates.isovalue(i)],
        candidates.along(i), crossing, [&](double s) {
          const double t = crossing.t0 + s * (crossing.t1 - crossing.t0);
          if (all)
          {
            withGradients(tile, block, std::uint64_t(1) << crossing.octant,
              [&](const GradientRecord* gradients) { takeLayer(tile, i, s, t, gradients); });
          }
          else
          {
            takeRoot(tile, i, s, t);
          }
          return firstOnly;
        });
    }
  }
  candidates.count = 0;
}

void BlockIntersection::takeRoot(RayTile& tile, int candidate, double s, double t) const
{
  const OctantCandidates& candidates = tile.candidates;
  const int number = candidates.ray(candidate);
  RayHits& hits = tile.hits[number];
  const CrossedBlock& block = candidates.block(candidate);
  if (hits.shows(t) && hits.isNearer(t, block.number))
  {
    hits.nearest.t = t;
    hits.nearest.surface = candidates.isovalue(candidate);
    hits.nearest.block = block.number;
    hits.nearest.octant = candidates.octant(candidate);
    hits.place = candidates.place(candidate, s);
    tile.rays.limit[number] = t;
  }
}

int BlockIntersection::takeLayers(RayTile& tile, int i) const
{
  const OctantCandidates& candidates = tile.candidates;
  const CandidateRoots& roots = tile.roots;
  const CrossedBlock& block = candidates.block(roots.candidate[i]);
  int end = i;
  std::uint64_t octants = 0;
  for (; end < roots.count && &candidates.block(roots.candidate[end]) == &block; ++end)
  {
    octants |= std::uint64_t(1) << candidates.octant(roots.candidate[end]);
  }
  if (!block.record->isMixed())
  {
    withGradients(tile, block, octants, [&](const GradientRecord* gradients) {
      for (; i < end; ++i)
      {
        takeLayer(tile, roots.candidate[i], roots.s[i], roots.t[i], gradients);
      }
    });
  }
  return end;
}

void BlockIntersection::takeLayer(
  RayTile& tile, int candidate, double s, double t, const GradientRecord* gradients) const
{
  const OctantCandidates& candidates = tile.candidates;
  const int number = candidates.ray(candidate);
  RayHits& hits = tile.hits[number];
  if (!hits.shows(t))
  {
    return;
  }
  const CrossedBlock& block = candidates.block(candidate);
  SurfaceHit& hit = hits.add(t);
  hit.t = t;
  hit.surface = candidates.isovalue(candidate);
  hit.block = block.number;
  hit.octant = candidates.octant(candidate);
  addPlace(tile, number, tile.found.size() - 1, block, gradients, hit.octant, candidates.place(candidate, s));
  if (hits.all->size() >= hits.most)
  {
    sort(tile.rays.directionOf(number), hits);
    if (hits.all->size() == hits.most)
    {
      tile.rays.limit[number] = hits.all->back().t;
    }
  }
}

template <class Take>
void BlockIntersection::withGradients(
  RayTile& tile, const CrossedBlock& block, std::uint64_t octants, const Take& take) const
{
  if (!tile.places.withNormals)
  {
    take(nullptr);
    return;
  }
  const bool wasKept = gradients_.isKept(block.number); // else the next ones may take their place
  // Of all layers rays see most octants of a block, sooner or later.
  if (gradients_.lacks(block.number, std::countr_zero(octants)))
  {
    octants = block.record->active;
  }
  take(&gradients_.record(block.number, *block.record, octants));
  if (!wasKept)
  {
    takePlaces(tile);
  }
}

void BlockIntersection::addPlace(RayTile& tile, int ray, std::size_t hit, const CrossedBlock& block,
  const GradientRecord* gradients, int octant, const Vec3& place) const
{
  HitPlaces& places = tile.places;
  if (gradients)
  {
    gradients->prefetch(octant);
  }
  tile.placed[places.count].ray = ray;
  tile.placed[places.count].hit = hit;
  places.add(block, gradients, octant, place);
  if (places.count == HitPlaces::most)
  {
    takePlaces(tile);
  }
}

void BlockIntersection::addNearest(RayTile& tile, int ray) const
{
  const RayHits& hits = tile.hits[ray];
  const SurfaceHit& hit = hits.nearest;
  // Else the next values and gradients may take their place.
  bool wasKept = blocks_.isKept(hit.block);
  const CrossedBlock block = opened(hit.block);
  const GradientRecord* gradients = nullptr;
  if (tile.places.withNormals)
  {
    wasKept = wasKept && gradients_.isKept(hit.block);
    gradients = &gradients_.record(hit.block, *block.record, std::uint64_t(1) << hit.octant);
  }
  addPlace(tile, ray, 0, block, gradients, hit.octant, hits.place);
  if (!wasKept)
  {
    takePlaces(tile);
  }
}

void BlockIntersection::takePlaces(RayTile& tile) const
{
  HitPlaces& places = tile.places;
  findNormals(unit(), places);
  for (int i = 0; i < places.count; ++i)
  {
    RayHits& hits = tile.hits[tile.placed[i].ray];
    SurfaceHit& hit = hits.all ? tile.found[tile.placed[i].hit] : hits.nearest;
    for (int a = 0; a < 3; ++a)
    {
      hit.gradient[a] = places.gradient[a][i];
      hit.normal[a] = static_cast<float>(places.normal[a][i]);
    }
  }
  places.count = 0;
}

void BlockIntersection::prepareGradients(const RayTile& tile) const
{
  // One step at a time for all rays: each waits for memory.
  const auto forHits = [&](const auto& body) {
    for (int number = 0; number < tile.count; ++number)
    {
      if (tile.hits[number].any())
      {
        body(tile.hits[number].nearest.block);
      }
    }
  };
  forHits([&](std::uint32_t block) { gradients_.prefetch(block); });
  forHits([&](std::uint32_t block) { gradients_.prefetchReady(block); });
  std::array<const SurfaceHit*, RayTile::most> hits; // whose gradients are missing
  int count = 0;
  for (int number = 0; number < tile.count; ++number)
  {
    const SurfaceHit& hit = tile.hits[number].nearest;
    if (tile.hits[number].any() && blocks_.isKept(hit.block) && gradients_.lacks(hit.block, hit.octant))
    {
      hits[count++] = &hit;
    }
  }
  std::sort(hits.begin(), hits.begin() + count,
    [](const SurfaceHit* a, const SurfaceHit* b) { return a->block < b->block; });
  for (int i = 0; i < count;)
  {
    const std::uint32_t block = hits[i]->block;
    std::uint64_t octants = 0;
    for (; i < count && hits[i]->block == block; ++i)
    {
      octants |= std::uint64_t(1) << hits[i]->octant;
    }
    gradients_.record(block, blocks_.record(block), octants);
  }
}

void BlockIntersection::finish(RayTile& tile) const
{
  takeBlocks(tile);
  takeCandidates(tile);
  tile.candidates.blockCount = 0;
  if (tile.places.withNormals)
  {
    prepareGradients(tile);
  }
  for (int number = 0; number < tile.count; ++number)
  {
    const RayHits& hits = tile.hits[number];
    if (hits.all)
    {
      sort(tile.rays.directionOf(number), hits);
    }
    else if (hits.any())
    {
      addNearest(tile, number);
    }
  }
  takePlaces(tile);
}

void BlockIntersection::setGradients(const CrossedBlock& block, const Vec3& place, SurfaceHit& hit) const
{
  hit.gradient = gradientAt(*block.record, block.planes, hit.octant, place);
  for (int a = 0; a < 3; ++a)
  {
    hit.gradient[a] /= space_.width(a);
  }
  const Vec3 normal = normalAt(
    gradients_.record(block.number, *block.record, std::uint64_t(1) << hit.octant), hit.octant, place);
  std::copy(normal.begin(), normal.end(), hit.normal.begin());
}

CrossedBlock BlockIntersection::opened(std::uint32_t number) const
{
  CrossedBlock block(space_, blocks_.all()[number], number);
  block.record = &blocks_.record(number);
  return block;
}

SurfaceHit BlockIntersection::nearest(const RayHits& hits) const
{
  SurfaceHit hit = hits.nearest;
  setGradients(opened(hit.block), hits.place, hit);
  return hit;
}

void BlockIntersection::sort(const Vec3& d, const RayHits& ray) const
{
  std::vector<FoundHit>& hits = *ray.all;
  const std::vector<SurfaceHit>& found = *ray.found;
  // They come nearly sorted.
  for (std::size_t i = 1; i < hits.size(); ++i)
  {
    const auto before = [&](const FoundHit& a, const FoundHit& b) {
      if (a.t != b.t)
      {
        return a.t < b.t;
      }
      const SurfaceHit& first = found[a.number];
      const SurfaceHit& second = found[b.number];
      return first.surface != second.surface ? first.surface < second.surface : first.block < second.block;
    };
    if (before(hits[i], hits[i - 1]))
    {
      const auto at = std::upper_bound(hits.begin(), hits.begin() + i, hits[i], before);
      std::rotate(at, hits.begin() + i, hits.begin() + i + 1);
    }
  }
  const double speed = std::max({ std::abs(d[0]), std::abs(d[1]), std::abs(d[2]) });
  std::size_t kept = 0;
  for (const FoundHit& hit : hits)
  {
    bool isNew = true;
    for (std::size_t k = kept; k > 0 && (hit.t - hits[k - 1].t) * speed <= sameHit * widest_; --k)
    {
      const SurfaceHit& before = found[hits[k - 1].number];
      if (before.surface == found[hit.number].surface)
      {
        isNew = (hit.t - before.t) * speed > sameHit * leafWidth(before, { 1., 1., 1. });
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

UnitBox BlockIntersection::unitBox(std::size_t number) const noexcept
{
  const SurfaceBlock& block = blocks_.all()[number];
  UnitBox box;
  if (!block.isEmpty())
  {
    const BlockPlanes planes(space_, block);
    const Bounds& domain = space_.domain();
    for (int a = 0; a < 3; ++a)
    {
      const double extent = domain.max[a] - domain.min[a];
      const double low = planes.at[a][block.firstActive(a)];
      const double high = planes.at[a][block.endActive(a)];
      box.low[a] = static_cast<float>((low - domain.min[a]) / extent) - UnitBox::rounding;
      box.high[a] = static_cast<float>((high - domain.min[a]) / extent) + UnitBox::rounding;
    }
  }
  return box;
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
