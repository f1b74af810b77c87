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
#include <array>
#include <bit>
#include <cmath>
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
  std::conditional_t<std::is_same_v<Real, float>, const std::int16_t*, const Real*> steps[3];
  Real stepLength = 0;
  Real entriesPerStep = 0; // of gradient opacity
  /// Mask of the children in which gradient opacity is that of long gradients, wherever they point.
  unsigned ofLong = 0;
};

/// Parts of an octant's width that pairs of steps are weighted in.
constexpr int weightBits = 14;

/// Of pairs of steps, in the halves of lanes, the sums weighted by two numbers that make 2^weightBits together: exact.
HWY_INLINE Ints<float> weighted(Ints<float> pairs, Ints<float> ofUpper)
{
  const IntTag<float> di;
  const Ints<float> ofLower = hn::Sub(hn::Set(di, 1 << weightBits), ofUpper);
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
  const hn::Repartition<std::int16_t, IntTag<float>> d16;
  const Ints<float> weights = hn::Or(hn::And(ofLower, hn::Set(di, 0xffff)), hn::ShiftLeft<16>(ofUpper));
  Ints<float> none = hn::Zero(di); // on these processors
  return hn::ReorderWidenMulAccumulate(
    di, hn::BitCast(d16, pairs), hn::BitCast(d16, weights), hn::Zero(di), none);
#else
  return hn::Add(hn::Mul(hn::ShiftRight<16>(hn::ShiftLeft<16>(pairs)), ofLower),
    hn::Mul(hn::ShiftRight<16>(pairs), ofUpper));
#endif
}

/// Of a block at spots, in steps: along x in whole numbers, which is as if spots were moved by less than 2^-weightBits of
/// an octant.
HWY_INLINE void gradientAt(
  const GradientBlock<float>& block, const Spot<float>& spot, Reals<float> (&gradient)[3])
{
  const RealTag<float> d;
  const Ints<float> upper = nearest<float>(hn::Mul(spot.f[0], hn::Set(d, float(1 << weightBits))));
  constexpr int rows[4] = { 0, 5, 25, 30 };
  for (int a = 0; a < 3; ++a)
  {
    const QuantisedValues values(reinterpret_cast<const std::uint16_t*>(block.steps[a]));
    Reals<float> along[4];
    for (int r = 0; r < 4; ++r)
    {
      along[r] = hn::ConvertTo(d, weighted(values.pairs(rows[r], spot.vertex), upper));
    }
    const Reals<float> low = lerp(spot.f[1], along[0], along[1]);
    const Reals<float> high = lerp(spot.f[1], along[2], along[3]);
    gradient[a] = hn::Mul(lerp(spot.f[2], low, high), hn::Set(d, 1.f / (1 << weightBits)));
  }
}

HWY_INLINE void gradientAt(
  const GradientBlock<double>& block, const Spot<double>& spot, Reals<double> (&gradient)[3])
{
  for (int a = 0; a < 3; ++a)
  {
    const ExactValues<double> values{ block.steps[a] };
    Reals<double> lower[4];
    Reals<double> upper[4];
    values.pairs(spot.vertex, lower, upper);
    gradient[a] = between<double>(spot.f, lower, upper);
  }
}

/// Of children in a mask those that spots are in.
template <class Real>
HWY_INLINE Mask<Real> areIn(unsigned children, const Spot<Real>& spot)
{
  const RealTag<Real> d;
  const Reals<Real> one = hn::Set(d, Real(1));
  const Reals<Real> vertex = asReals<Real>(spot.vertex);
  const Reals<Real> z = hn::Floor(hn::Mul(vertex, hn::Set(d, Real(0.0401)))); // of 25
  const Reals<Real> inLayer = negMulAdd(z, hn::Set(d, Real(25)), vertex);
  const Reals<Real> y = hn::Floor(hn::Mul(inLayer, hn::Set(d, Real(0.201)))); // of 5
  const Reals<Real> x = negMulAdd(y, hn::Set(d, Real(5)), inLayer);
  const auto upper = [&](Reals<Real> at, int bit) {
    return hn::IfThenElseZero(hn::Gt(at, one), hn::Set(d, Real(bit)));
  };
  const Reals<Real> child = hn::Add(upper(x, 1), hn::Add(upper(y, 2), upper(z, 4)));
  const hn::RebindToUnsigned<RealTag<Real>> du;
  const auto bit = hn::BitCast(du, asWideAsLanes<Real>(truncated<Real>(child)));
  const auto isIn = hn::And(hn::Shr(hn::Set(du, children), bit), hn::Set(du, 1));
  return hn::RebindMask(d, hn::Ne(isIn, hn::Zero(du)));
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
      diagonal * BlockGradientRecord::most * record->length() > scene_.illumination->hiddenLength;
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
    block_.stepLength = record.length();
    block_.ofLong = 0;
    if (scene_.gradients && scene_.illumination->gradientOpacity)
    {
      block_.entriesPerStep = block_.stepLength * static_cast<Real>(scene_.illumination->entriesPerLength);
      block_.ofLong = findLong(record);
    }
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

  /// See GradientBlock.
  unsigned findLong(const BlockGradientRecord& record) const noexcept
  {
    const double parts = BlockGradientRecord::leastParts * scene_.illumination->longLength /
      (static_cast<double>(record.length()) * BlockGradientRecord::most);
    constexpr double mostParts = 255.;
    unsigned children = 0;
    if (scene_.settings.skipEmpty && parts <= mostParts) // NaN is none
    {
      const auto needed = static_cast<std::uint8_t>(std::ceil(parts));
      const std::array<std::uint8_t, 8> least = record.least();
      for (int child = 0; child < 8; ++child)
      {
        children |= static_cast<unsigned>(least[child] >= needed) << child;
      }
    }
    return children;
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
