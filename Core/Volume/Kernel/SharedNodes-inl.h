// Leaves and blocks of which several processes' boxes have a part: each ray takes such a one all its way through, on the
// process in whose box it enters it. Its steps are those of one process, which where they begin anew at a face they are not.
// Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_SHAREDNODES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_SHAREDNODES_INL_H
#undef TREEAMR_SHAREDNODES_INL_H
#else
#define TREEAMR_SHAREDNODES_INL_H
#endif

#include "Partition/LatticeBox.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// Of one process's box.
template <class Real>
class SharedNodes
{
public:
  /// box: null for a process that draws all. toKernel(bounds): in the kernel's coordinates.
  template <class ToKernel>
  SharedNodes(const LatticeBox* box, const RootGrid& grid, const ToKernel& toKernel)
    : box_(box)
    , padding_(grid.paddingDepth())
  {
    if (box)
    {
      inKernel_ = toKernel(box->bounds(grid));
    }
  }

  /// Mask of the children of a node that have a part in the box.
  unsigned childrenInBox(const std::array<Coord, 3>& index, int depth) const noexcept
  {
    if (!isShared(index, depth))
    {
      return 0xff;
    }
    unsigned inBox = 0;
    for (int o = 0; o < 8; ++o)
    {
      inBox |= static_cast<unsigned>(box_->meets({ indexOfChild(index, o), depth + 1 - padding_ })) << o;
    }
    return inBox;
  }
  /// Whether a node that meets the box has a part beyond it.
  bool isShared(const std::array<Coord, 3>& index, int depth) const noexcept
  {
    return box_ && !box_->contains({ index, depth - padding_ });
  }

  /// Leaves of rays what is in the box.
  template <class Rays>
  void cutRays(Rays& rays) const
  {
    const RealTag<Real> d;
    forEachVector(allGroups, rays.parts_, [&](int part, int ray) {
      Reals<Real> begin = hn::Load(d, rays.begin_[part] + ray);
      Reals<Real> end = hn::Load(d, rays.end_[part] + ray);
      rays.enterBox(inKernel_, ray, begin, end);
      hn::Store(begin, d, rays.begin_[part] + ray);
      hn::Store(end, d, rays.end_[part] + ray);
    });
  }

  /// Before a node is drawn: when it is shared, leaves of the rays of groups those that enter it in the box.
  template <class Rays>
  HWY_INLINE bool takeOwn(
    Rays& rays, const std::array<Coord, 3>& index, int depth, const Box<Real>& node, GroupMask active)
  {
    const bool isTaken = isShared(index, depth);
    if (isTaken)
    {
      take(rays, node, active);
    }
    return isTaken;
  }
  /// After it: the others are there again.
  template <class Rays>
  HWY_INLINE void giveBack(bool isTaken, Rays& rays, GroupMask active) const
  {
    if (isTaken)
    {
      give(rays, active);
    }
  }

private:
  template <class Rays>
  HWY_NOINLINE void take(Rays& rays, const Box<Real>& node, GroupMask active)
  {
    const RealTag<Real> d;
    const Reals<Real> none = hn::Set(d, Rays::finished);
    forEachVector(active, rays.parts_, [&](int part, int ray) {
      Reals<Real> begin = hn::Load(d, rays.begin_[part] + ray);
      const Reals<Real> end = hn::Load(d, rays.end_[part] + ray);
      Reals<Real> leaves = end;
      rays.enterBox(node, ray, begin, leaves);
      // By the same planes, neighbours' boxes have all of a ray, and no place twice.
      Reals<Real> from = hn::Set(d, -std::numeric_limits<Real>::infinity());
      Reals<Real> to = hn::Set(d, std::numeric_limits<Real>::infinity());
      rays.enterBox(inKernel_, ray, from, to);
      const Mask<Real> isOwn = hn::And(hn::Le(from, begin), hn::Lt(begin, to));
      hn::Store(hn::IfThenElse(isOwn, none, end), d, others_[part] + ray);
      hn::Store(hn::IfThenElse(isOwn, end, none), d, rays.end_[part] + ray);
    });
  }
  template <class Rays>
  HWY_NOINLINE void give(Rays& rays, GroupMask active) const
  {
    const RealTag<Real> d;
    forEachVector(active, rays.parts_, [&](int part, int ray) {
      // A ray that has become opaque in another part has ended.
      const Mask<Real> goesOn = hn::Le(hn::Load(d, rays.opacity_ + ray), hn::Set(d, rays.opaque_));
      const Reals<Real> end = hn::Load(d, rays.end_[part] + ray);
      const Reals<Real> all = hn::Max(end, hn::Load(d, others_[part] + ray));
      hn::Store(hn::IfThenElse(goesOn, all, end), d, rays.end_[part] + ray);
    });
  }

  static constexpr GroupMask allGroups = (GroupMask(1) << tileRays / groupRays) - 1;

  template <class Use>
  static HWY_INLINE void forEachVector(GroupMask groups, int parts, const Use& use)
  {
    for (; groups != 0; groups &= groups - 1)
    {
      const int first = std::countr_zero(groups) * groupRays;
      for (int ray = first; ray < first + groupRays; ray += lanes<Real>)
      {
        for (int part = 0; part < parts; ++part)
        {
          use(part, ray);
        }
      }
    }
  }

  const LatticeBox* box_;
  Box<Real> inKernel_{};
  int padding_;
  HWY_ALIGN Real others_[RayParts::most][tileRays]; // ends of rays that are not taken
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
