// What colours the samples of the volume kernel besides its own transfer function: other fields, and tables of two values.
// Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMEMIXTURE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEMIXTURE_INL_H
#undef TREEAMR_VOLUMEMIXTURE_INL_H
#else
#define TREEAMR_VOLUMEMIXTURE_INL_H
#endif

#include "Volume/Kernel/VolumeBlocks-inl.h"
#include "Volume/Kernel/VolumeGradients-inl.h"
#include "Volume/Kernel/VolumeIntegrals-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// The vertex values of blocks of other fields, and what they mean.
template <class Real>
struct MixedBlocks
{
  const KernelMixture* mixture = nullptr; // null: there are none
  const KernelTable2D* table = nullptr;   // of its, where samples read one
  const IntegralTable* tables[4] = {};
  Block<Real> blocks[4] = {};
  const VolumeIllumination* lights[4] = {}; // of components that are lit, each by gradients of its own
  GradientBlock<Real> gradients[4] = {};
};

/// What the gradient at samples does, and what colours them.
template <class Real>
struct LightEffect
{
  Reals<Real> color[3];
  Reals<Real> opacity; // times the extinction; of many components it is that
  Reals<Real> times[3];
  Reals<Real> plus[3];
};

/// On some rays through a block.
template <class Real>
class MixtureOnRays
{
public:
  using Effect = LightEffect<Real>;

  explicit HWY_INLINE MixtureOnRays(const MixedBlocks<Real>& mixed)
    : mixed_(mixed)
  {
  }

  HWY_INLINE bool isNone() const { return !mixed_.mixture; }
  /// Whether samples are seen where the volume's own function shows nothing.
  HWY_INLINE bool isOfMany() const
  {
    return mixed_.mixture && mixed_.mixture->mixing == VolumeMixing::Independent;
  }
  HWY_INLINE bool readsTable() const { return mixed_.table; }
  HWY_INLINE const VolumeIllumination& light(int part) const { return *mixed_.lights[part]; }
  HWY_INLINE const GradientBlock<Real>& gradients(int part) const { return mixed_.gradients[part]; }

  /// Not of what reads a table. lighten(part, color): what light makes of a component's colour, where it is lit.
  template <class Lighten>
  HWY_NOINLINE void mix(const Spot<Real>& spot, const Lighten& lighten, Effect& effect) const
  {
    const Places<Real> first = placesOf(0, spot);
    switch (mixed_.mixture->mixing)
    {
      case VolumeMixing::Colors:
        for (int c = 0; c < 3; ++c)
        {
          effect.color[c] = hn::Div(first.term[c], first.term[3]);
        }
        break;
      case VolumeMixing::Channels:
        effect.color[0] = hn::Div(first.term[0], first.term[3]);
        for (int c = 1; c < 3; ++c)
        {
          const Places<Real> own = placesOf(c, spot);
          effect.color[c] = hn::Div(own.term[c], own.term[3]);
        }
        break;
      case VolumeMixing::Independent:
        mixed_.lights[0] ? this->mixComponents<true>(spot, first, lighten, effect)
                         : this->mixComponents<false>(spot, first, lighten, effect);
        break;
      case VolumeMixing::Table:
        break;
    }
  }

  /// The table's colour and extinction. place: of the volume's own value; second: the gradient's length, as records have it.
  HWY_NOINLINE void lookUp(
    Reals<Real> place, Reals<Real> second, const Spot<Real>& spot, Effect& effect) const
  {
    const RealTag<Real> d;
    const IntTag<Real> di;
    const KernelMixture& mixture = *mixed_.mixture;
    const TransferFunction2D& table = mixed_.table->function;
    const Reals<Real> one = hn::Set(d, Real(1));
    const Reals<Real> last[2] = { hn::Set(d, static_cast<Real>(table.first().size - 1)),
      hn::Set(d, static_cast<Real>(table.second().size - 1)) };
    second = mixed_.table->byGradient ? second : placeOf(0, spot);
    const Reals<Real> wanted[2] = { hn::Mul(place, hn::Set(d, static_cast<Real>(mixture.columnsPerPlace))),
      mulAdd(second, hn::Set(d, static_cast<Real>(mixture.rowsPerPlace)),
        hn::Set(d, static_cast<Real>(mixture.firstRow))) };
    Ints<Real> lower[2];
    Reals<Real> parts[2][2]; // of the lower entry and the upper one
    for (int a = 0; a < 2; ++a)
    {
      const Reals<Real> inside = hn::Min(hn::Max(wanted[a], hn::Zero(d)), last[a]);
      const Reals<Real> below = hn::Min(hn::Floor(inside), hn::Sub(last[a], one));
      lower[a] = truncated<Real>(below);
      parts[a][1] = hn::Sub(inside, below);
      parts[a][0] = hn::Sub(one, parts[a][1]);
    }
    const auto columns = static_cast<std::int32_t>(table.first().size);
    const Ints<Real> entry =
      hn::ShiftLeft<2>(hn::Add(hn::Mul(lower[1], hn::Set(di, columns)), lower[0])); // of four floats
    Reals<Real> corners[2][2][4];
    for (int r = 0; r < 2; ++r)
    {
      const float* const row = &table.entries().front().r + 4 * static_cast<std::ptrdiff_t>(columns) * r;
      gatherFours<Real>(row, entry, corners[r][0]);
      gatherFours<Real>(row + 4, entry, corners[r][1]);
    }
    Reals<Real> sums[4];
    for (int c = 0; c < 4; ++c)
    {
      Reals<Real> rows[2];
      for (int r = 0; r < 2; ++r) // exact at either end, however opaque the other one is
      {
        rows[r] = mulAdd(parts[0][0], corners[r][0][c], hn::Mul(parts[0][1], corners[r][1][c]));
      }
      sums[c] = mulAdd(parts[1][0], rows[0], hn::Mul(parts[1][1], rows[1]));
    }
    std::copy_n(sums, 3, effect.color);
    effect.opacity = sums[3];
  }

private:
  /// Places of a part's values at spots.
  HWY_INLINE Reals<Real> placeOf(int part, const Spot<Real>& spot) const
  {
    const Block<Real>& block = mixed_.blocks[part];
    Reals<Real> lower[4];
    Reals<Real> upper[4];
    bool isExact = true;
    if constexpr (Block<Real>::samplesSteps)
    {
      isExact = block.exact;
      if (!isExact)
      {
        QuantisedValues{ block.steps }.pairs(spot.vertex, lower, upper);
      }
    }
    if (isExact)
    {
      ExactValues<Real>{ block.exact }.pairs(spot.vertex, lower, upper);
    }
    return inTable<Real>(block.toTable, between<Real>(spot.f, lower, upper));
  }

  /// And its function there.
  HWY_INLINE Places<Real> placesOf(int part, const Spot<Real>& spot) const
  {
    return findPlaces<Real>(*mixed_.tables[part], placeOf(part, spot));
  }

  /// As VTK has it: the sum of the extinctions' squares by their weighted sum, which is that of the colours.
  template <bool AreLit, class Lighten>
  HWY_INLINE void mixComponents(
    const Spot<Real>& spot, const Places<Real>& first, const Lighten& lighten, Effect& effect) const
  {
    const RealTag<Real> d;
    const auto count = static_cast<int>(mixed_.mixture->parts.size());
    Reals<Real> extinctions[4];
    Reals<Real> weighted = hn::Zero(d);
    Reals<Real> emitted[3] = { weighted, weighted, weighted };
    for (int part = 0; part < count; ++part)
    {
      const Real weight = mixed_.mixture->weights[part];
      extinctions[part] = hn::Zero(d);
      if (!(weight > 0))
      {
        continue;
      }
      const Places<Real> places = part == 0 ? first : placesOf(part, spot);
      const Reals<Real> scale =
        hn::Set(d, static_cast<Real>(std::numbers::log2e * mixed_.tables[part]->unscale()));
      extinctions[part] = hn::Mul(hn::ZeroIfNegative(places.term[3]), scale);
      weighted = mulAdd(hn::Set(d, weight), extinctions[part], weighted);
      if constexpr (AreLit)
      {
        const Mask<Real> shows = hn::Gt(places.term[3], hn::Zero(d));
        const Reals<Real> whole = hn::IfThenElse(shows, places.term[3], hn::Set(d, Real(1)));
        Reals<Real> color[3];
        for (int c = 0; c < 3; ++c)
        {
          color[c] = hn::Div(places.term[c], whole);
        }
        lighten(part, color);
        for (int c = 0; c < 3; ++c)
        {
          emitted[c] = mulAdd(color[c], hn::Mul(extinctions[part], hn::Set(d, weight)), emitted[c]);
        }
        continue;
      }
      const Reals<Real> ofPart = hn::Mul(scale, hn::Set(d, weight));
      for (int c = 0; c < 3; ++c)
      {
        emitted[c] = mulAdd(places.term[c], ofPart, emitted[c]);
      }
    }
    const Mask<Real> isSeen = hn::Gt(weighted, hn::Zero(d));
    const Reals<Real> one = hn::Set(d, Real(1));
    const Reals<Real> divisor = hn::IfThenElse(isSeen, weighted, one);
    effect.opacity = hn::Zero(d);
    for (int part = 0; part < count; ++part) // no squares of what is opaque
    {
      effect.opacity = mulAdd(extinctions[part], hn::Div(extinctions[part], divisor), effect.opacity);
    }
    const Reals<Real> whole = hn::IfThenElse(isSeen, effect.opacity, one);
    for (int c = 0; c < 3; ++c)
    {
      effect.color[c] = hn::IfThenElseZero(isSeen, hn::Div(emitted[c], whole));
    }
  }

  const MixedBlocks<Real>& mixed_;
};

/// Where blocks of other fields are from, for one thread. Constants have what these are with their extinctions.
template <class Real>
class MixtureSource
{
public:
  explicit MixtureSource(const VolumeKernelScene& scene)
  {
    const bool isHere = scene.mixture && (!scene.features.constants || scene.readsGradients());
    if (isHere)
    {
      blocks_.mixture = &*scene.mixture;
      blocks_.table = scene.mixture->table;
      for (std::size_t i = 0; i < scene.mixture->parts.size(); ++i)
      {
        const VolumeKernelScene& part = *scene.mixture->parts[i];
        sources_.push_back(std::make_unique<Source>(part));
        if (part.illumination && part.illumination->shades && scene.isOfMany())
        {
          blocks_.lights[i] = &*part.illumination;
          gradients_.push_back(std::make_unique<GradientSource<Real>>(part));
        }
        blocks_.tables[i] = part.table.integrals.get();
        hasCorners_ = hasCorners_ || part.field.corners();
      }
      // Of a table's two fields the other one has the last word: its own nothing is left of.
      showsParts_ = scene.isOfMany() || (blocks_.table && !sources_.empty());
      skips_ = scene.settings.skipEmpty;
    }
  }

  /// Finds the values of the children of the path's node, or computes and keeps them. False when nothing is
  /// visible of those that make it so.
  bool prepare(const BlockPath& path, BlockCells cells, double leafWidth)
  {
    bool isVisible = !showsParts_ || !skips_;
    for (std::size_t i = 0; i < sources_.size(); ++i)
    {
      sources_[i]->prepare(path, cells, leafWidth, blocks_.blocks[i]);
      isVisible = isVisible || isSeen(i);
    }
    for (std::size_t i = 0; i < gradients_.size() && isVisible; ++i)
    {
      gradients_[i]->prepare(path, cells);
      blocks_.gradients[i] = gradients_[i]->block();
    }
    return isVisible;
  }
  /// Of a node whose value is the same everywhere in it.
  void useConstant(NodeRef node)
  {
    for (std::size_t i = 0; i < sources_.size(); ++i)
    {
      const double place = blocks_.tables[i]->placeOf(blocks_.mixture->parts[i]->field.relative(node));
      blocks_.blocks[i] = sources_[i]->constant(static_cast<Real>(place), 0, true);
    }
    for (std::size_t i = 0; i < gradients_.size(); ++i)
    {
      gradients_[i]->useNone();
      blocks_.gradients[i] = gradients_[i]->block();
    }
  }
  bool hasCorners() const noexcept { return hasCorners_; }

  const MixedBlocks<Real>& blocks() const noexcept { return blocks_; }
  VolumeStatistics statistics() const noexcept
  {
    VolumeStatistics all;
    for (const auto& source : sources_)
    {
      all += source->statistics();
    }
    for (const auto& source : gradients_)
    {
      all.keptGradients += source->kept();
      all.gradients += source->computed();
    }
    return all;
  }

private:
  using Source = BlockSource<Real, VolumeLoop::Colors>;

  /// Whether a part shows something of its block's hull.
  bool isSeen(std::size_t i) const noexcept
  {
    const IntegralTable& table = *blocks_.tables[i];
    const auto valueAt = [&](Real place) {
      return static_cast<float>(table.reference() + static_cast<double>(place) / table.placesPerValue());
    };
    const ToTable<Real>& hull = blocks_.blocks[i].toTable;
    constexpr float far = std::numeric_limits<float>::infinity();
    return blocks_.mixture->parts[i]->transferFunction.isVisible(
      { std::nextafter(valueAt(hull.first), -far), std::nextafter(valueAt(hull.last), far) });
  }

  std::vector<std::unique_ptr<Source>> sources_;
  std::vector<std::unique_ptr<GradientSource<Real>>> gradients_; // of parts that are lit
  MixedBlocks<Real> blocks_;
  bool showsParts_ = false;
  bool hasCorners_ = false;
  bool skips_ = false;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
