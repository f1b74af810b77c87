// The volume kernel with double lanes, for rays of any origins: what extreme zooms, thin domains and huge values are
// rendered by. The best instruction set is chosen when the program runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/VolumeInDoubles.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeTile-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

VolumeStatistics RenderTilesInDoubles(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  return renderRow<double, false>(scene, row, columnBegin, columnEnd);
}

void RenderGroupsInDoubles(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba)
{
  renderListed<double, false>(scene, groups, rgba);
}

VolumeStatistics RepeatInCacheInDoubles(
  const VolumeKernelScene& scene, int row, int columns, float position, int repeats)
{
  return repeatRow<double, false>(scene, row, columns, position, repeats);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(RenderTilesInDoubles);
HWY_EXPORT(RenderGroupsInDoubles);
HWY_EXPORT(RepeatInCacheInDoubles);

VolumeLoops volumeLoopsInDoubles()
{
  return { HWY_DYNAMIC_DISPATCH(RenderTilesInDoubles), HWY_DYNAMIC_DISPATCH(RenderGroupsInDoubles),
    HWY_DYNAMIC_DISPATCH(RepeatInCacheInDoubles) };
}

} // namespace treeamr
#endif
