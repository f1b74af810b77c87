// Where the volume kernel has a block's vertex values from: kept, or computed and kept. Compiled once for each
// instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMEBLOCKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEBLOCKS_INL_H
#undef TREEAMR_VOLUMEBLOCKS_INL_H
#else
#define TREEAMR_VOLUMEBLOCKS_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// A node's vertex values, ready for sampling.
template <class Real>
struct Block
{
  /// Float lanes sample blocks as they are kept. For double lanes each visit makes places in the table of them: without
  /// a loop for steps there is half as much to compile.
  static constexpr bool samplesSteps = std::is_same_v<Real, float>;

  const std::uint16_t* steps;
  const Real* exact; // places in the table, not cut off at its ends; null where steps are sampled
  ToTable<Real> toTable;
  Real variation;    // of the extinction over the block's hull, per kernel unit
  bool preIntegrate; // the places are those of the table's integrals
};

/// Whether loops sample the field's values rather than places in the transfer function's table.
constexpr bool samplesValues(VolumeLoop loop)
{
  return loop == VolumeLoop::Extreme || loop == VolumeLoop::Sum;
}

/// Whether something of a range takes part in a ray, whatever the ray has.
template <VolumeLoop Loop>
HWY_INLINE bool isWanted(const VolumeKernelScene& scene, const Range& range)
{
  if constexpr (Loop == VolumeLoop::Extreme || Loop == VolumeLoop::Colors)
  {
    return true;
  }
  if constexpr (Loop == VolumeLoop::Sum)
  {
    if (scene.settings.blend == VolumeBlend::Average)
    {
      const Range& counted = scene.settings.averageRange;
      return range.max >= counted.min && range.min <= counted.max;
    }
  }
  return scene.transferFunction.isVisible(range);
}

/// Of one thread.
template <class Real, VolumeLoop Loop>
class BlockSource
{
public:
  explicit BlockSource(const VolumeKernelScene& scene)
    : scene_(scene)
    , evaluator_(scene.field)
  {
  }

  /// Finds the values of the children of the path's node or computes and keeps them. False when nothing of them is
  /// visible. leafWidth: in kernel units.
  bool prepare(const BlockPath& path, BlockCells cells, double leafWidth, Block<Real>& block)
  {
    const std::uint64_t node = path.node[path.depth];
    const BlockCache::Found found = scene_.kept.find(node, cells);
    Range range = found.range;
    block.exact = nullptr;
    if (found.record)
    {
      ++statistics_.kept;
      block.steps = found.record->values.data();
    }
    else
    {
      compute(path, cells);
      range = values_.range;
    }
    if (scene_.ranges && !isWanted<Loop>(scene_, range))
    {
      if (!found.record && hasSteps(range))
      {
        scene_.kept.keep(node, cells, values_);
      }
      return false;
    }
    classify(range, leafWidth, block);
    if (!found.record && hasSteps(range))
    {
      const BlockRecord* kept = scene_.kept.keep(node, cells, values_);
      if (!kept)
      {
        record_ = BlockRecord(values_);
        kept = &record_;
      }
      block.steps = kept->values.data();
    }
    if (isCoarse(block) || !hasSteps(range))
    {
      if (found.record)
      {
        compute(path, cells);
      }
      placeValues(block);
    }
    else if constexpr (!Block<Real>::samplesSteps)
    {
      placeSteps(block);
    }
    return true;
  }

  /// The place in the table of a value that fills a leaf.
  Real placeOf(float value) const noexcept
  {
    return samplesValues(Loop)
      ? static_cast<Real>((value - scene_.placeOrigin) * scene_.perValue)
      : static_cast<Real>(scene_.transferFunction.position(value) * scene_.table.perEntry);
  }

  /// Of one place in the table.
  Block<Real> constant(Real position, Real variation, bool preIntegrate = false) const noexcept
  {
    alignas(64) static constexpr decltype(BlockRecord::values) noSteps{};
    return { noSteps.data(), Block<Real>::samplesSteps ? nullptr : exact_,
      { 0, position, position, position }, variation, preIntegrate };
  }

  /// Whether a block stays as it is when others are prepared: they may use the buffers.
  bool outlastsOthers(const Block<Real>& block) const noexcept
  {
    return block.steps != record_.values.data() && !block.exact;
  }

  /// What was kept, computed.
  const VolumeStatistics& statistics() const noexcept { return statistics_; }

private:
  /// Whether values in steps would make steps in the picture, too: when their hull is wider than four tables, or one
  /// hides where the function bends.
  bool isCoarse(const Block<Real>& block) const
  {
    if constexpr (samplesValues(Loop))
    {
      return !(std::abs(block.toTable.scale) * scaleToTable() <
        4 / BlockRecord::steps * scene_.table.last * std::abs(scene_.perValue));
    }
    if (block.preIntegrate)
    {
      return block.toTable.scale >
        scene_.partOfFinestStep * scene_.table.integrals->finestStep(block.toTable.first, block.toTable.last);
    }
    return !(block.toTable.scale < 4 / BlockRecord::steps * scene_.table.last);
  }

  /// Whether a block can be kept: denormal numbers cannot count the steps of their hull, and no float the width of the
  /// largest. Float lanes do not get such fields.
  static bool hasSteps(const Range& range)
  {
    using Limits = std::numeric_limits<float>;
    const float width = range.max - range.min;
    return Block<Real>::samplesSteps || width == 0.f || (width >= Limits::min() && width <= Limits::max());
  }

  /// Beyond it no two floats share an entry, and products with their differences would overflow.
  double scaleToTable() const noexcept
  {
    constexpr double steepest = 0x1p880;
    return std::min(scene_.transferFunction.scale() * scene_.table.perEntry, steepest);
  }

  /// Where a block's hull lies in the table, and what lies there.
  HWY_INLINE void classify(const Range& range, double leafWidth, Block<Real>& block) const
  {
    if constexpr (samplesValues(Loop))
    {
      classifyValues(range, block);
      return;
    }
    const TransferFunction& tf = scene_.transferFunction;
    const VolumeTable& table = scene_.table;
    const double scale = scaleToTable();
    const double first = tf.position(range.min) * table.perEntry;
    const double last = tf.position(range.max) * table.perEntry;
    const double offset = (range.min - tf.min()) * scale;
    const double width = static_cast<double>(range.max) - range.min;
    block.toTable = { static_cast<Real>(width * scale / BlockRecord::steps), static_cast<Real>(offset),
      static_cast<Real>(first), static_cast<Real>(last) };
    const auto firstEntry = static_cast<std::size_t>(first);
    const auto lastEntry = std::min(static_cast<std::size_t>(last) + 1, table.variation.size() - 1);
    const double variation = table.variation[lastEntry] - table.variation[firstEntry];
    // Light may change all that is seen, not only what differs in the table.
    const double lit =
      Loop == VolumeLoop::Lit ? variation + table.entries[firstEntry].extinction * std::numbers::ln2 : 0.;
    block.variation = static_cast<Real>(variation + lit);
    if (Loop == VolumeLoop::Lit && (scene_.isOfMany() || scene_.readsTable()))
    {
      block.variation = 0x1p60; // no limit: what else is read varies, too
    }
    const bool isSlice = scene_.features.slices && scene_.features.preIntegration;
    block.preIntegrate = Loop == VolumeLoop::Colors || isSlice ||
      (scene_.features.preIntegration &&
        (table.rough[lastEntry] > table.rough[firstEntry] || isFlat(width * scale) ||
          !pointsSuffice(scene_,
            { variation, table.curvature[lastEntry] - table.curvature[firstEntry], width * scale + 1. },
            leafWidth)));
    if (block.preIntegrate)
    {
      classifyByIntegrals(range, block);
    }
  }

  void classifyValues(const Range& range, Block<Real>& block) const
  {
    const double first = (range.min - scene_.placeOrigin) * scene_.perValue;
    const double last = (range.max - scene_.placeOrigin) * scene_.perValue;
    block.toTable = { static_cast<Real>((last - first) / BlockRecord::steps), static_cast<Real>(first),
      static_cast<Real>(std::min(first, last)), static_cast<Real>(std::max(first, last)) };
    block.variation = 0x1p60; // no limit
    block.preIntegrate = false;
  }

  /// Whether a function of nodes would be seen in few entries only, whose rounding does not even out.
  bool isFlat(double entries) const
  {
    constexpr double few = 8.;
    return entries < few && !scene_.transferFunction.nodes().empty();
  }

  HWY_NOINLINE void classifyByIntegrals(const Range& range, Block<Real>& block) const
  {
    const IntegralTable& integrals = *scene_.table.integrals;
    const double first = integrals.placeOf(range.min);
    const double last = integrals.placeOf(range.max);
    // The last step must not end before the hull, where the function may jump.
    constexpr double up = 1. + 0x1p-21;
    block.toTable = { static_cast<Real>(up * (last - first) / BlockRecord::steps), static_cast<Real>(first),
      static_cast<Real>(first), static_cast<Real>(last) };
    const double lit = Loop == VolumeLoop::Lit ? static_cast<double>(block.variation) : 0.;
    block.variation =
      static_cast<Real>(integrals.variation(integrals.rowOf(first), integrals.rowOf(last) + 1) + lit);
  }

  /// Places in the table at once of the values computed last: a difference from a huge end of the hull would have lost
  /// the other values' digits. So far away, all that matters to floats is that they are finite.
  void placeValues(Block<Real>& block)
  {
    constexpr double far = std::is_same_v<Real, float> ? farthestPlace : std::numeric_limits<double>::max();
    const bool byIntegrals = block.preIntegrate;
    const double origin = samplesValues(Loop) ? scene_.placeOrigin
      : byIntegrals                           ? scene_.table.integrals->reference()
                                              : scene_.transferFunction.min();
    const double scale = samplesValues(Loop) ? scene_.perValue
      : byIntegrals                          ? scene_.table.integrals->placesPerValue()
                                             : scaleToTable();
    for (std::size_t i = 0; i < values_.values.size(); ++i)
    {
      exact_[i] = static_cast<Real>(std::clamp((values_.values[i] - origin) * scale, -far, far));
    }
    useExact(block);
  }

  void placeSteps(Block<Real>& block)
  {
    for (std::size_t i = 0; i < values_.values.size(); ++i)
    {
      exact_[i] = block.steps[i] * block.toTable.scale + block.toTable.offset;
    }
    useExact(block);
  }

  void useExact(Block<Real>& block) const noexcept
  {
    block.exact = exact_;
    block.toTable.scale = 1;
    block.toTable.offset = 0;
  }

  void compute(const BlockPath& path, BlockCells cells)
  {
    evaluator_.compute(path, cells, values_);
    ++statistics_.blocks;
    const Octree& octree = scene_.field.octree();
    statistics_.cells +=
      octree.root().isLeaf() ? 1 : std::popcount(octree.children(path.node[path.depth]).leaf);
  }

  const VolumeKernelScene& scene_;
  BlockEvaluator evaluator_;
  BlockValues values_; // computed last
  BlockRecord record_;
  HWY_ALIGN Real exact_[128] = {};
  VolumeStatistics statistics_;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
