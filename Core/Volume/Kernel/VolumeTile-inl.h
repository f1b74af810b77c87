// A tile's way through the octree: the walk, and the blocks that it meets. Compiled once
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

#include "Volume/Kernel/SharedNodes-inl.h"
#include "Volume/Kernel/VolumeBlocks-inl.h"
#include "Volume/Kernel/VolumeConstants-inl.h"
#include "Volume/Kernel/VolumeIntervals-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"
#include "Volume/TileRelay.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// See TileRays.
template <class Real, RayOrigins Origins, VolumeLoop Loop>
class Tile : TileConstants<Real, Origins, Loop>
{
  using Rays = TileRays<Real, Origins>;
  using Intervals = TileIntervals<Real, Origins, Loop>;
  using Base = TileConstants<Real, Origins, Loop>;

public:
  explicit Tile(const VolumeKernelScene& scene)
    : Base(scene)
    , scene_(scene)
    , octree_(scene.field.octree())
    , grid_(octree_.grid())
    , blocks_(scene)
    , constants_(scene)
    , shared_(scene.relay ? scene.relay->box() : nullptr, grid_,
        [this](const Bounds& bounds) { return Intervals::toKernel(bounds); })
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
      const Real middle = (startAtReference ? 0 : origin_[a][ray]) + t * direction_[a][ray];
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
    if constexpr (isLit)
    {
      statistics.keptGradients = gradients_.kept() + mixture_.statistics().keptGradients;
      statistics.gradients = gradients_.computed() + mixture_.statistics().gradients;
      statistics.keptColors = mixture_.statistics().kept;
      statistics.colors = mixture_.statistics().blocks;
    }
    return statistics;
  }

private:
  using Base::integrateConstants;
  using Intervals::blends_;
  using Intervals::gradients_;
  using Intervals::integrate;
  using Intervals::isComposite;
  using Intervals::isExtreme;
  using Intervals::isLit;
  using Intervals::mixture_;
  using Intervals::statistics_;
  using Rays::begin_;
  using Rays::crossChildren;
  using Rays::crossLastHits;
  using Rays::direction_;
  using Rays::drawnRays_;
  using Rays::end_;
  using Rays::green_;
  using Rays::groupInTile;
  using Rays::makeRays;
  using Rays::origin_;
  using Rays::red_;
  using Rays::startAtReference;
  using Rays::store;
  using Rays::storeAll;

  void integrateRays(int x0, int y0, GroupMask wanted)
  {
    const GroupMask drawn = makeRays(x0, y0) & wanted;
    if (scene_.relay && scene_.relay->isCutAtFaces(x0 / volumeTileWidth, y0 / volumeTileWidth))
    {
      shared_.cutRays(rays());
    }
    if constexpr (!isComposite)
    {
      scene_.goesOn ? blends_.start(red_, green_) : blends_.start();
    }
    walk(drawn);
    crossLastHits();
    if constexpr (!isComposite)
    {
      this->resolve(drawn);
    }
  }

  HWY_NOINLINE void walk(GroupMask active)
  {
    const NodeRef root = octree_.root();
    Range range = scene_.field.range();
    if (active != 0 && !root.isNone() && isVisible(root, range))
    {
      path_.depth = 0;
      index_ = {};
      const Box<Real> box = Intervals::toKernel(grid_.nodeBounds(index_, 0));
      root.isLeaf() ? visitOnlyLeaf(box, active) : visit(root.index(), box, active, range);
      if constexpr (isExtreme)
      {
        visitFromTheMost();
      }
    }
  }

  /// What visits have left: of all of it the node with the largest places is next, so that none is visited that has less than
  /// its rays in the end.
  void visitFromTheMost()
  {
    while (!blends_.queue().isEmpty())
    {
      const auto next = blends_.queue().pop();
      const GroupMask active = blends_.open(next.active, next.most);
      if (active != 0)
      {
        index_ = next.index;
        path_.moveTo(octree_, index_, next.depth);
        visit(next.node, next.box, active, next.range);
      }
    }
  }

  void finish(int x0, int y0) noexcept
  {
    this->countSamples();
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
    return isWanted<Loop>(scene_, range);
  }

  void visit(std::uint64_t node, const Box<Real>& box, GroupMask active, Range range)
  {
    ++statistics_.nodes;
    const Octree::Children children = octree_.children(node);
    if (isBlock(node, children))
    {
      const bool isShared = shared_.takeOwn(rays(), index_, path_.depth, box, active);
      visitBlock(BlockCells::Leaves, children, box, active);
      shared_.giveBack(isShared, rays(), active);
      return;
    }
    if (scene_.features.means && isDrawnByMeans(node, children, box))
    {
      visitBlock(BlockCells::Means, children, box, active);
      return;
    }
    const Vec3 planes = planesBetweenChildren();
    const std::array<Real, 3> middle = inKernel(planes);
    const int nearest = scene_.camera.nearestOctant(planes, scene_.direction);
    // Memory is on its way while rays are tested.
    prefetchNodes(children);
    GroupMask crossing[8];
    crossChildren(box, middle, active, crossing);
    std::array<Range, 8> ranges;
    unsigned wanted =
      chooseChildren(children, crossing, range, ranges) & shared_.childrenInBox(index_, path_.depth);
    prefetchContents(children, wanted);
    bool hasValues = false;
    Block<Real> block;
    for (int i = 0; i < 8; ++i)
    {
      const int octant = i ^ nearest;
      if (!(wanted >> octant & 1))
      {
        continue;
      }
      if constexpr (isExtreme)
      {
        crossing[octant] = blends_.open(
          crossing[octant], blends_.mostOf(children.leaf >> octant & 1 ? range : ranges[octant]));
        if (crossing[octant] == 0)
        {
          continue;
        }
      }
      const Box<Real> childBox = boxOfChild(box, middle, octant);
      if (children.leaf >> octant & 1)
      {
        const Real width = childBox.max[0] - childBox.min[0];
        hasValues = hasValues || prepareLeaves(children, wanted, width, block);
        if (!hasValues)
        {
          wanted &= ~children.leaf;
        }
        else
        {
          const bool isShared = shared_.takeOwn(
            rays(), indexOfChild(index_, octant), path_.depth + 1, childBox, crossing[octant]);
          if (scene_.features.constants)
          {
            integrateConstants(constants_.constants(), childBox, middle, crossing[octant]);
          }
          else
          {
            integrate(block, childBox, Lattice<Real>(childBox, octant), crossing[octant]);
          }
          shared_.giveBack(isShared, rays(), crossing[octant]);
        }
        continue;
      }
      descend(children.innerIndex(octant), octant, childBox, crossing[octant], ranges[octant]);
      hasValues = hasValues && !isLit && !scene_.features.constants && blocks_.outlastsOthers(block);
    }
  }

  Rays& rays() noexcept { return *this; }

  Vec3 planesBetweenChildren() const noexcept
  {
    Vec3 planes;
    for (int a = 0; a < 3; ++a)
    {
      planes[a] = grid_.nodePlane(a, 2 * index_[a] + 1, path_.depth + 1);
    }
    return planes;
  }

  std::array<Real, 3> inKernel(const Vec3& point) const noexcept
  {
    return { Rays::toKernel(0, point[0]), Rays::toKernel(1, point[1]), Rays::toKernel(2, point[2]) };
  }

  /// Of the path's node, those of its leaves that are wanted; false when nothing of them is visible.
  bool prepareLeaves(const Octree::Children& children, unsigned wanted, double leafWidth, Block<Real>& block)
  {
    if (scene_.features.constants)
    {
      return constants_.prepare(children, wanted & children.leaf, path_.depth + 1) &&
        prepareGradients(BlockCells::Leaves);
    }
    return blocks_.prepare(path_, BlockCells::Leaves, leafWidth, block) &&
      prepareEffects(BlockCells::Leaves, leafWidth);
  }

  void descend(std::uint64_t node, int octant, const Box<Real>& box, GroupMask active, const Range& range)
  {
    if constexpr (isExtreme)
    {
      blends_.queue().push({ node, range, box, indexOfChild(index_, octant), path_.depth + 1, active,
        blends_.mostOf(range), blends_.leastOf(range) });
      return;
    }
    const auto index = index_;
    index_ = indexOfChild(index_, octant);
    path_.descend(octant, node);
    visit(node, box, active, range);
    path_.ascend();
    index_ = index;
  }

  static Box<Real> boxOfChild(const Box<Real>& box, const std::array<Real, 3>& middle, int octant) noexcept
  {
    Box<Real> child;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = octant >> a & 1;
      child.min[a] = upper ? middle[a] : box.min[a];
      child.max[a] = upper ? box.max[a] : middle[a];
    }
    return child;
  }

  /// Gradients and colours; false when nothing is visible by them.
  bool prepareEffects([[maybe_unused]] BlockCells cells, [[maybe_unused]] double leafWidth)
  {
    if (!prepareGradients(cells))
    {
      return false;
    }
    if constexpr (isLit)
    {
      return mixture_.prepare(path_, cells, leafWidth);
    }
    return true;
  }
  /// As prepareEffects().
  bool prepareGradients([[maybe_unused]] BlockCells cells)
  {
    if constexpr (isLit)
    {
      return gradients_.prepare(path_, cells);
    }
    return true;
  }

  /// Mask of the children that rays cross and in which there may be something to draw. ranges: of inner ones, when empty
  /// nodes are skipped.
  HWY_INLINE unsigned chooseChildren(const Octree::Children& children, const GroupMask (&crossing)[8],
    const Range& range, std::array<Range, 8>& ranges) const noexcept
  {
    unsigned crossed = 0;
    for (int octant = 0; octant < 8; ++octant)
    {
      crossed |= static_cast<unsigned>(crossing[octant] != 0) << octant;
    }
    unsigned wanted = 0;
    for (unsigned rest = children.inner() & crossed; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      const NodeRef child(NodeKind::Inner, path_.depth + 1, children.innerIndex(octant));
      ranges[octant] = range;
      wanted |= static_cast<unsigned>(isVisible(child, ranges[octant])) << octant;
    }
    for (unsigned rest = children.leaf & crossed; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      wanted |= static_cast<unsigned>(!octree_.isGhost(children.leafIndex(octant))) << octant;
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
      if constexpr (isLit)
      {
        if (scene_.gradients)
        {
          scene_.gradients->prefetchSlot(children.firstInner, BlockCells::Leaves);
        }
      }
    }
  }

  /// Values and ranges of the children that will be visited.
  HWY_INLINE void prefetchContents(const Octree::Children& children, unsigned wanted) const noexcept
  {
    for (unsigned rest = children.inner() & wanted; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      const std::uint64_t child = children.innerIndex(octant);
      const Octree::Children below = octree_.children(child);
      if (below.leaf != 0)
      {
        scene_.kept.prefetchRecord(child, BlockCells::Leaves);
        if constexpr (isLit)
        {
          if (scene_.gradients)
          {
            scene_.gradients->prefetchRecord(child, BlockCells::Leaves);
          }
        }
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
      !shared_.isShared(index_, path_.depth) && isSmall(box);
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

  void visitBlock(BlockCells cells, const Octree::Children& children, const Box<Real>& box, GroupMask active)
  {
    if (scene_.features.constants)
    {
      if (constants_.prepare(children, 0xff, path_.depth + 1) && prepareGradients(cells))
      {
        integrateConstants(constants_.constants(), box, inKernel(planesBetweenChildren()), active);
      }
      return;
    }
    Block<Real> block;
    const double leafWidth = 0.5 * (box.max[0] - box.min[0]);
    if (blocks_.prepare(path_, cells, leafWidth, block) && prepareEffects(cells, leafWidth))
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
    const bool isShared = shared_.takeOwn(rays(), index_, 0, box, active);
    drawOnlyLeaf(box, active);
    shared_.giveBack(isShared, rays(), active);
  }
  void drawOnlyLeaf(const Box<Real>& box, GroupMask active)
  {
    if (scene_.features.constants)
    {
      if (constants_.prepareRoot())
      {
        useNoGradients();
        integrateConstants(constants_.constants(), box, box.max, active);
      }
      return;
    }
    if (scene_.field.corners())
    {
      Block<Real> block;
      const double leafWidth = box.max[0] - box.min[0];
      if (blocks_.prepare(path_, BlockCells::Leaves, leafWidth, block) &&
        prepareEffects(BlockCells::Leaves, leafWidth))
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
    integrateConstant(0, blocks_.constant(static_cast<Real>(place), 0, true), box, active);
  }

  void useNoGradients()
  {
    if constexpr (isLit)
    {
      gradients_.useNone();
    }
  }

  /// A leaf whose value is the same everywhere in it.
  void integrateConstant(std::uint64_t leaf, const Box<Real>& box, GroupMask active)
  {
    const Real place = blocks_.placeOf(scene_.field.leafValues()[leaf]);
    integrateConstant(leaf, blocks_.constant(place, 0), box, active);
  }

  void integrateConstant(
    [[maybe_unused]] std::uint64_t leaf, const Block<Real>& block, const Box<Real>& box, GroupMask active)
  {
    useNoGradients();
    if constexpr (isLit)
    {
      if (mixture_.hasCorners())
      {
        mixture_.prepare(path_, BlockCells::Leaves, box.max[0] - box.min[0]);
        integrate(block, box, Lattice<Real>(box, 0), active);
        return;
      }
      mixture_.useConstant(NodeRef(NodeKind::Leaf, 0, leaf));
    }
    integrate(block, box, Lattice<Real>(box), active);
  }

  const VolumeKernelScene& scene_;
  const Octree& octree_;
  const RootGrid& grid_;
  BlockPath path_;
  BlockSource<Real, Loop> blocks_;
  ConstantSource<Real, Loop> constants_;
  std::array<Coord, 3> index_{};
  SharedNodes<Real> shared_;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
