// A tile's way through the octree: the walk, the blocks that it meets, and the steps of rays through them. Compiled once
// for each instruction set, as Highway wants it.
//
// A tile of 16 x 16 rays descends the octree once, front to back. Its rays form 16 groups of 4 x 4 pixels, a
// group filling one AVX-512 vector (or 2 or 4 narrower ones); a node's eight children are tested together
// against the groups that met the node. A node whose children are all leaves is a block: its rays are taken
// through it in one interval, from its 5 x 5 x 5 vertex values. Leaves beside refined nodes use their part of
// the same values.
#if defined(TREEAMR_VOLUMETILE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMETILE_INL_H
#undef TREEAMR_VOLUMETILE_INL_H
#else
#define TREEAMR_VOLUMETILE_INL_H
#endif

#include "Volume/Kernel/VolumeBlocks-inl.h"
#include "Volume/Kernel/VolumeIntegrals-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// See TileRays.
template <class Real, bool CommonOrigin>
class Tile : TileRays<Real, CommonOrigin>
{
  using Rays = TileRays<Real, CommonOrigin>;

public:
  explicit Tile(const VolumeKernelScene& scene)
    : Rays(scene)
    , scene_(scene)
    , octree_(scene.field.octree())
    , grid_(octree_.grid())
    , blocks_(scene)
    , table_(&scene.table.entries.data()->r)
    , samplesPerCell_(static_cast<Real>(scene.settings.samplesPerCell))
    , integralTolerance_(integralTolerance / samplesPerCell_)
  {
  }

  void render(int x0, int y0)
  {
    integrateRays(x0, y0, ~GroupMask(0));
    finish(x0, y0);
  }

  /// Groups of one tile alone.
  void renderGroups(int x0, int y0, std::span<const PixelGroup> wanted, float* rgba)
  {
    GroupMask mask = 0;
    for (const PixelGroup& group : wanted)
    {
      mask |= GroupMask(1) << groupInTile(group.x - x0, group.y - y0);
    }
    integrateRays(x0, y0, mask);
    for (const PixelGroup& group : wanted)
    {
      const int first = groupInTile(group.x - x0, group.y - y0) * groupRays;
      for (int r = first; r < first + groupRays; ++r, rgba += 4)
      {
        store(r, rgba);
      }
    }
  }

  /// The work of a frame without its walk: the tile's rays go through one box of a position in the table, as often
  /// as asked for.
  void repeatInCache(int x0, int y0, Real position, int repeats)
  {
    const GroupMask active = makeRays(x0, y0);
    const Block<Real> block = blocks_.constant(position, std::numeric_limits<Real>::max());
    // Around the point of the middle ray at half of its length, wide enough for all.
    constexpr int ray = tileRays / 2;
    const Real t = Real(0.5) * (begin_[0][ray] + std::min(end_[0][ray], begin_[0][ray] + 2));
    const auto half = static_cast<Real>(2. * volumeTileWidth * (scene_.pixelWidth + scene_.pixelGrowth * t));
    Box<Real> box;
    for (int a = 0; a < 3; ++a)
    {
      const Real middle = (CommonOrigin ? 0 : origin_[a][ray]) + t * direction_[a][ray];
      box.min[a] = middle - half;
      box.max[a] = middle + half;
    }
    const Lattice<Real> lattice(box);
    for (int repeat = 0; repeat < repeats; ++repeat)
    {
      integrate(block, box, lattice, active);
    }
    finish(x0, y0);
  }

  VolumeStatistics statistics() const noexcept
  {
    VolumeStatistics statistics = statistics_;
    statistics += blocks_.statistics();
    statistics.rays = drawnRays_;
    return statistics;
  }

private:
  using Rays::begin_;
  using Rays::blue_;
  using Rays::crossChildren;
  using Rays::crossHits;
  using Rays::crossLastHits;
  using Rays::direction_;
  using Rays::drawnRays_;
  using Rays::end_;
  using Rays::enterBox;
  using Rays::finished;
  using Rays::green_;
  using Rays::groupInTile;
  using Rays::hasHits_;
  using Rays::lengthPerT_;
  using Rays::makeRays;
  using Rays::nextHitT_;
  using Rays::opacity_;
  using Rays::origin_;
  using Rays::parts_;
  using Rays::red_;
  using Rays::store;
  using Rays::storeAll;
  using Rays::toKernel;

  void integrateRays(int x0, int y0, GroupMask wanted)
  {
    walk(makeRays(x0, y0) & wanted);
    crossLastHits();
  }

  HWY_NOINLINE void walk(GroupMask active)
  {
    const NodeRef root = octree_.root();
    Range range = scene_.field.range();
    if (active != 0 && !root.isNone() && isVisible(root, range))
    {
      path_.depth = 0;
      index_ = {};
      const Bounds bounds = grid_.nodeBounds(index_, 0);
      Box<Real> box;
      for (int a = 0; a < 3; ++a)
      {
        box.min[a] = toKernel(a, bounds.min[a]);
        box.max[a] = toKernel(a, bounds.max[a]);
      }
      root.isLeaf() ? visitOnlyLeaf(box, active) : visit(root.index(), box, active, range);
    }
  }

  void finish(int x0, int y0) noexcept
  {
    statistics_.samples = std::accumulate(samples_, samples_ + lanes<Real>, statistics_.samples);
    std::fill_n(samples_, lanes<Real>, 0);
    storeAll(x0, y0, scene_.image->rgba.data());
  }

  /// range: the parent's, and the node's on return when empty nodes are skipped.
  bool isVisible(NodeRef node, Range& range) const noexcept
  {
    if (!node.isInner() || !scene_.ranges)
    {
      return true;
    }
    range = scene_.ranges->of(node.index(), range);
    return scene_.transferFunction.isVisible(range);
  }

  void visit(std::uint64_t node, const Box<Real>& box, GroupMask active, Range range)
  {
    ++statistics_.nodes;
    const Octree::Children children = octree_.children(node);
    const bool constants = scene_.features.categories;
    if (!constants && isBlock(node, children))
    {
      visitBlock(BlockCells::Leaves, box, active);
      return;
    }
    if (!constants && scene_.settings.levelOfDetailPixels > 0. && isDrawnByMeans(node, children, box))
    {
      visitBlock(BlockCells::Means, box, active);
      return;
    }
    std::array<Range, 8> ranges;
    unsigned wanted = chooseChildren(children, range, ranges);
    if (wanted == 0)
    {
      return;
    }
    std::array<Real, 3> middle;
    Vec3 planes;
    for (int a = 0; a < 3; ++a)
    {
      planes[a] = grid_.nodePlane(a, 2 * index_[a] + 1, path_.depth + 1);
      middle[a] = toKernel(a, planes[a]);
    }
    const int nearest = scene_.camera.nearestOctant(planes, scene_.direction);
    // Memory is on its way while rays are tested.
    prefetchNodes(children);
    GroupMask crossing[8];
    crossChildren(box, middle, active, crossing);
    prefetchContents(children, wanted, crossing);
    bool hasValues = false;
    Block<Real> block;
    for (int i = 0; i < 8; ++i)
    {
      const int octant = i ^ nearest;
      if (!(wanted >> octant & 1) || crossing[octant] == 0)
      {
        continue;
      }
      Box<Real> childBox;
      for (int a = 0; a < 3; ++a)
      {
        const bool upper = octant >> a & 1;
        childBox.min[a] = upper ? middle[a] : box.min[a];
        childBox.max[a] = upper ? box.max[a] : middle[a];
      }
      if (children.leaf >> octant & 1)
      {
        if (constants)
        {
          integrateConstant(children.leafIndex(octant), childBox, crossing[octant]);
          continue;
        }
        if (!hasValues)
        {
          if (!blocks_.prepare(path_, BlockCells::Leaves, childBox.max[0] - childBox.min[0], block))
          {
            wanted &= ~children.leaf;
            continue;
          }
          hasValues = true;
        }
        integrate(block, childBox, Lattice<Real>(childBox, octant), crossing[octant]);
        continue;
      }
      const auto index = index_;
      index_ = indexOfChild(index_, octant);
      path_.descend(octant, children.innerIndex(octant));
      visit(children.innerIndex(octant), childBox, crossing[octant], ranges[octant]);
      path_.ascend();
      index_ = index;
      hasValues = hasValues && blocks_.outlastsOthers(block);
    }
  }

  /// Mask of the children in which there may be something to draw, whatever the rays. ranges: of inner ones, when
  /// empty nodes are skipped.
  HWY_INLINE unsigned chooseChildren(
    const Octree::Children& children, const Range& range, std::array<Range, 8>& ranges) const noexcept
  {
    unsigned wanted = 0;
    for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      const NodeRef child(NodeKind::Inner, path_.depth + 1, children.innerIndex(octant));
      ranges[octant] = range;
      wanted |= static_cast<unsigned>(isVisible(child, ranges[octant])) << octant;
    }
    for (unsigned rest = children.leaf; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      const std::uint64_t leaf = children.leafIndex(octant);
      const bool isWanted = !octree_.isGhost(leaf) && !(scene_.features.categories && isSkipped(leaf));
      wanted |= static_cast<unsigned>(isWanted) << octant;
    }
    return wanted;
  }

  /// What says where the children have their own children and values.
  HWY_INLINE void prefetchNodes(const Octree::Children& children) const noexcept
  {
    if (children.inner() != 0)
    {
      octree_.prefetchChildren(children.firstInner);
      scene_.kept.prefetchSlot(children.firstInner, BlockCells::Leaves);
    }
  }

  /// Values and ranges of the children that will be visited.
  HWY_INLINE void prefetchContents(
    const Octree::Children& children, unsigned wanted, const GroupMask (&crossing)[8]) const noexcept
  {
    for (unsigned rest = children.inner() & wanted; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      if (crossing[octant] == 0)
      {
        continue;
      }
      const std::uint64_t child = children.innerIndex(octant);
      const Octree::Children below = octree_.children(child);
      if (below.leaf != 0)
      {
        scene_.kept.prefetchRecord(child, BlockCells::Leaves);
      }
      if (below.inner() != 0 && scene_.ranges)
      {
        scene_.ranges->prefetch(below.firstInner);
      }
    }
  }

  /// Whether the node's children are drawn together.
  bool isBlock(std::uint64_t node, const Octree::Children& children) const noexcept
  {
    // Above the root trees widths may differ and parts be missing.
    return children.allLeaves() && path_.depth >= grid_.paddingDepth() && !octree_.hasGhostsBelow(node);
  }

  bool isDrawnByMeans(
    std::uint64_t node, const Octree::Children& children, const Box<Real>& box) const noexcept
  {
    return children.exists == 0xff && path_.depth >= grid_.paddingDepth() && !octree_.hasGhostsBelow(node) &&
      isSmall(box);
  }

  bool isSmall(const Box<Real>& box) const noexcept
  {
    double squared = 0.;
    double width = 0.;
    for (int a = 0; a < 3; ++a)
    {
      squared += std::pow(0.5 * (box.min[a] + box.max[a]), 2);
      width = std::max(width, 0.5 * static_cast<double>(box.max[a] - box.min[a]));
    }
    const double pixel = scene_.pixelWidth + scene_.pixelGrowth * std::sqrt(squared);
    return width < scene_.settings.levelOfDetailPixels * pixel;
  }

  void visitBlock(BlockCells cells, const Box<Real>& box, GroupMask active)
  {
    Block<Real> block;
    if (blocks_.prepare(path_, cells, 0.5 * (box.max[0] - box.min[0]), block))
    {
      integrate(block, box, Lattice<Real>(box), active);
    }
  }

  /// A tree without inner nodes: one constant, or what is between its corners.
  void visitOnlyLeaf(const Box<Real>& box, GroupMask active)
  {
    if (octree_.isGhost(0))
    {
      return;
    }
    if (scene_.field.corners() && !scene_.features.categories)
    {
      Block<Real> block;
      if (blocks_.prepare(path_, BlockCells::Leaves, box.max[0] - box.min[0], block))
      {
        integrate(block, box, Lattice<Real>(box, 0), active);
      }
      return;
    }
    if (!scene_.features.preIntegration)
    {
      integrateConstant(0, box, active);
      return;
    }
    const double place = scene_.table.integrals->placeOf(scene_.field.leafValues()[0]);
    integrate(blocks_.constant(static_cast<Real>(place), 0, true), box, Lattice<Real>(box), active);
  }

  /// Of a category.
  Real positionOf(std::uint64_t leaf) const noexcept
  {
    const float value = scene_.field.leafValues()[leaf];
    return static_cast<Real>(scene_.transferFunction.position(value) * scene_.table.perEntry);
  }

  /// Whether a leaf of a category is transparent and such ones are left out.
  bool isSkipped(std::uint64_t leaf) const noexcept
  {
    return scene_.settings.skipEmpty &&
      scene_.table.entries[static_cast<std::size_t>(positionOf(leaf))].extinction == 0.f;
  }

  /// A leaf whose value is the same everywhere in it.
  void integrateConstant(std::uint64_t leaf, const Box<Real>& box, GroupMask active)
  {
    integrate(blocks_.constant(positionOf(leaf), 0), box, Lattice<Real>(box), active);
  }

  void integrate(
    const Block<Real>& block, const Box<Real>& box, const Lattice<Real>& lattice, GroupMask active)
  {
    if constexpr (Block<Real>::samplesSteps)
    {
      if (!block.exact)
      {
        integrate(QuantisedValues{ block.steps }, block, box, lattice, active);
        return;
      }
    }
    integrate(ExactValues<Real>{ block.exact }, block, box, lattice, active);
  }

  template <class Values>
  void integrate(const Values& values, const Block<Real>& block, const Box<Real>& box,
    const Lattice<Real>& lattice, GroupMask active)
  {
    for (; active != 0; active &= active - 1)
    {
      const int group = std::countr_zero(active);
      for (int ray = group * groupRays; ray < (group + 1) * groupRays; ray += lanes<Real>)
      {
        // Exact values are few: a loop without stops for them would cost more to compile than it saves.
        constexpr bool isFrequent = std::is_same_v<Values, QuantisedValues>;
        if (!isFrequent || hasHits_ || parts_ > 1)
        {
          block.preIntegrate ? integrateFromStopToStop<true>(values, block, box, lattice, ray)
                             : integrateFromStopToStop<false>(values, block, box, lattice, ray);
          continue;
        }
        if constexpr (isFrequent)
        {
          block.preIntegrate ? integrate<true>(values, block, box, lattice, ray)
                             : integrate<false>(values, block, box, lattice, ray);
        }
      }
    }
  }

  /// Takes the rays from `ray` on through a box.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void integrate(const Values& values, const Block<Real>& block, const Box<Real>& box,
    const Lattice<Real>& lattice, int ray)
  {
    const RealTag<Real> d;
    Reals<Real> begin = hn::Load(d, begin_[0] + ray);
    Reals<Real> end = hn::Load(d, end_[0] + ray);
    enterBox(box, ray, begin, end);
    integratePart<PreIntegrated>(values, block, lattice, ray, begin, end);
  }

  /// The same, from stop to stop.
  template <bool PreIntegrated, class Values>
  HWY_NOINLINE void integrateFromStopToStop(const Values& values, const Block<Real>& block,
    const Box<Real>& box, const Lattice<Real>& lattice, int ray)
  {
    const RealTag<Real> d;
    for (int part = 0; part < parts_; ++part)
    {
      Reals<Real> begin = hn::Load(d, begin_[part] + ray);
      Reals<Real> end = hn::Load(d, end_[part] + ray);
      enterBox(box, ray, begin, end);
      do
      {
        const Reals<Real> stop = hasHits_ ? hn::Min(end, hn::Load(d, nextHitT_ + ray)) : end;
        integratePart<PreIntegrated>(values, block, lattice, ray, begin, stop);
      }
      while (hasHits_ && crossHits(part, ray, begin, end));
    }
  }

  /// Takes the rays from `ray` on from begin to end in a block: by midpoint samples, or by the transfer function's
  /// integrals over what the field covers in each step.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void integratePart(const Values& values, const Block<Real>& block, const Lattice<Real>& lattice,
    int ray, Reals<Real> begin, Reals<Real> end)
  {
    const RealTag<Real> d;
    const Mask<Real> crosses = hn::Lt(begin, end);
    if (hn::AllFalse(d, crosses))
    {
      return;
    }
    ++statistics_.intervals;
    const Reals<Real> length = hn::IfThenElseZero(crosses, hn::Sub(end, begin));
    Span<Real> span;
    Reals<Real> squared = hn::Zero(d);
    for (int a = 0; a < 3; ++a)
    {
      const Reals<Real> direction = hn::Load(d, direction_[a] + ray);
      const Reals<Real> scale = hn::Set(d, lattice.scale[a]);
      Reals<Real> corner = hn::Set(d, -lattice.min[a]);
      if (!CommonOrigin)
      {
        corner = hn::Add(corner, hn::Load(d, origin_[a] + ray));
      }
      span.start[a] = hn::Mul(mulAdd(begin, direction, corner), scale);
      span.slope[a] = hn::Mul(direction, scale);
      squared = mulAdd(span.slope[a], span.slope[a], squared);
    }
    const Reals<Real> opacity = hn::Load(d, opacity_ + ray);
    const Reals<Real> transmittance = hn::Sub(hn::Set(d, Real(1)), opacity);
    const Reals<Real> lengthPerT = hn::Load(d, lengthPerT_ + ray);
    // Squares: of the way in widths of a leaf, and of what the variation of optical depth on it asks for.
    const Reals<Real> widths = hn::Mul(hn::Mul(squared, hn::Set(d, Real(0.25))), hn::Mul(length, length));
    const Reals<Real> variation = hn::Mul(hn::Mul(length, lengthPerT),
      hn::Mul(
        transmittance, hn::Set(d, samplesPerRootVariation * samplesPerRootVariation * block.variation)));
    const Reals<Real> wanted =
      hn::Mul(hn::Min(widths, variation), hn::Set(d, samplesPerCell_ * samplesPerCell_));
    const Real mostSamples = chooseSteps<Real>(hn::IfThenElseZero(crosses, wanted), length, span);
    span.depthPerExtinction = hn::Mul(span.step, lengthPerT);
    span.samples = hn::IfThenElseZero(crosses, span.samples);
    const IntTag<Real> di;
    hn::Store(hn::Add(hn::Load(di, samples_), nearest<Real>(span.samples)), di, samples_);
    statistics_.steps += PreIntegrated ? 0 : static_cast<std::uint64_t>(mostSamples);

    Light<Real> light{ transmittance, opacity, hn::Load(d, red_ + ray), hn::Load(d, green_ + ray),
      hn::Load(d, blue_ + ray) };
    if constexpr (PreIntegrated)
    {
      const std::uint64_t steps = takeIntegrals(
        *scene_.table.integrals, span, integralTolerance_, values, block.toTable, lattice, light);
      statistics_.steps += steps;
      statistics_.litSteps += steps;
    }
    else
    {
      Real i = 0;
      for (; i + 1 < mostSamples; i += 2)
      {
        statistics_.litSteps += takePoints<2>(table_, span, i, values, block.toTable, lattice, light);
      }
      if (i < mostSamples)
      {
        statistics_.litSteps += takePoints<1>(table_, span, i, values, block.toTable, lattice, light);
      }
    }
    hn::Store(light.opacity, d, opacity_ + ray);
    hn::Store(light.red, d, red_ + ray);
    hn::Store(light.green, d, green_ + ray);
    hn::Store(light.blue, d, blue_ + ray);
    const Mask<Real> done = hn::Gt(light.opacity, hn::Set(d, Real(opaque)));
    int part = 0;
    do
    {
      Real* ends = end_[part] + ray;
      hn::Store(hn::IfThenElse(done, hn::Set(d, finished), hn::Load(d, ends)), d, ends);
    }
    while (++part < parts_);
  }

  const VolumeKernelScene& scene_;
  const Octree& octree_;
  const RootGrid& grid_;
  BlockPath path_;
  BlockSource<Real> blocks_;
  const float* table_;
  Real samplesPerCell_;
  Real integralTolerance_;
  std::array<Coord, 3> index_{};

  VolumeStatistics statistics_;
  /// By lane: summing a vector up at each interval takes longer.
  HWY_ALIGN std::int32_t samples_[lanes<Real>] = {};
};

template <class Real, bool CommonOrigin>
VolumeStatistics repeatRow(const VolumeKernelScene& scene, int row, int columns, float position, int repeats)
{
  Tile<Real, CommonOrigin> tile(scene);
  for (int column = 0; column < columns; ++column)
  {
    tile.repeatInCache(column * volumeTileWidth, row * volumeTileWidth, position, repeats);
  }
  return tile.statistics();
}

template <class Real, bool CommonOrigin>
void renderListed(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba)
{
  Tile<Real, CommonOrigin> tile(scene);
  while (!groups.empty())
  {
    const int x = groups.front().x / volumeTileWidth * volumeTileWidth;
    const int y = groups.front().y / volumeTileWidth * volumeTileWidth;
    std::size_t inTile = 1;
    while (inTile < groups.size() && groups[inTile].x / volumeTileWidth * volumeTileWidth == x &&
      groups[inTile].y / volumeTileWidth * volumeTileWidth == y)
    {
      ++inTile;
    }
    tile.renderGroups(x, y, groups.first(inTile), rgba);
    rgba += inTile * PixelGroup::rgbaSize;
    groups = groups.subspan(inTile);
  }
}

template <class Real, bool CommonOrigin>
VolumeStatistics renderRow(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  Tile<Real, CommonOrigin> tile(scene);
  for (int column = columnBegin; column < columnEnd; ++column)
  {
    tile.render(column * volumeTileWidth, row * volumeTileWidth);
  }
  return tile.statistics();
}

template <class Real, bool CommonOrigin>
VolumeLoops loopsOf()
{
  return { renderRow<Real, CommonOrigin>, renderListed<Real, CommonOrigin>, repeatRow<Real, CommonOrigin> };
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
