// The vertex gradients of blocks, for the volume kernel. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMEGRADIENTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEGRADIENTS_INL_H
#undef TREEAMR_VOLUMEGRADIENTS_INL_H
#else
#define TREEAMR_VOLUMEGRADIENTS_INL_H
#endif

#include "Interpolation/GradientCache.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// The vertex gradients of a block, for sampling.
template <class Real>
struct GradientBlock
{
  using Values = std::conditional_t<std::is_same_v<Real, float>, QuantisedValues, ExactValues<Real>>;
  std::conditional_t<std::is_same_v<Real, float>, const std::uint16_t*, const Real*> steps[3];
  Real stepLength = 0;
};

/// Of a block at spots, in steps.
template <class Real, class Values>
HWY_INLINE void gradientAt(const Values (&values)[3], const Spot<Real>& spot, Reals<Real> (&gradient)[3])
{
  const RealTag<Real> d;
  for (int a = 0; a < 3; ++a)
  {
    Reals<Real> lower[4];
    Reals<Real> upper[4];
    values[a].pairs(spot.vertex, lower, upper);
    gradient[a] = hn::Sub(between<Real>(spot.f, lower, upper), hn::Set(d, Real(BlockGradientRecord::zero)));
  }
}

/// Where blocks have their gradients from, for one thread.
template <class Real>
class GradientSource
{
public:
  explicit GradientSource(const VolumeKernelScene& scene)
    : scene_(scene)
  {
    useNone();
  }

  /// Finds the gradients of the children of the path's node, or computes and keeps them. False when gradient opacity
  /// hides all of them.
  bool prepare(const BlockPath& path, BlockCells cells)
  {
    if (!scene_.gradients)
    {
      return true;
    }
    const std::uint64_t node = path.node[path.depth];
    const BlockGradientRecord* record = scene_.gradients->find(node, cells);
    if (record)
    {
      ++kept_;
    }
    else
    {
      const Octree& octree = scene_.field.octree();
      const unsigned children = cells == BlockCells::Means ? 0xff
        : octree.root().isLeaf()                           ? 1 // of a field at corners
                                                           : octree.children(node).leaf;
      const BlockVertices vertices = verticesOfChildren(children);
      if (!evaluator_)
      {
        evaluator_.emplace(*scene_.ofGradients);
      }
      evaluator_->compute(path, cells, vertices, computed_);
      ++blocks_;
      record_ = BlockGradientRecord(computed_, vertices, scene_.gradients->scale());
      record = scene_.gradients->keep(node, cells, record_);
      record = record ? record : &record_;
    }
    use(*record);
    constexpr float diagonal = 1.7321f; // of three largest components, rounded up
    return !scene_.settings.skipEmpty ||
      diagonal * BlockGradientRecord::most * record->length > scene_.illumination->hiddenLength;
  }
  /// Of a constant.
  void useNone() { use(none()); }

  const GradientBlock<Real>& block() const noexcept { return block_; }
  std::uint64_t kept() const noexcept { return kept_; }
  std::uint64_t computed() const noexcept { return blocks_; }

private:
  static BlockVertices verticesOfChildren(unsigned children) noexcept
  {
    std::uint64_t octants = 0; // x + 4 y + 16 z
    for (; children != 0; children &= children - 1)
    {
      const int child = std::countr_zero(children);
      octants |= std::uint64_t(0x330033) << (2 * (child & 1) + 8 * (child >> 1 & 1) + 32 * (child >> 2));
    }
    return verticesOfOctants(octants);
  }

  static const BlockGradientRecord& none()
  {
    static const BlockGradientRecord record({}, {}, 0.);
    return record;
  }

  void use(const BlockGradientRecord& record)
  {
    block_.stepLength = record.length;
    for (int a = 0; a < 3; ++a)
    {
      if constexpr (std::is_same_v<Real, float>)
      {
        block_.steps[a] = record.steps[a].data();
      }
      else
      {
        std::copy(record.steps[a].begin(), record.steps[a].end(), exact_[a]);
        block_.steps[a] = exact_[a];
      }
    }
  }

  const VolumeKernelScene& scene_;
  std::optional<GradientEvaluator> evaluator_; // once something is computed: it is large
  BlockGradients computed_;
  BlockGradientRecord record_;
  GradientBlock<Real> block_;
  std::conditional_t<std::is_same_v<Real, float>, char, Real[3][128]> exact_;
  std::uint64_t kept_ = 0;
  std::uint64_t blocks_ = 0;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
