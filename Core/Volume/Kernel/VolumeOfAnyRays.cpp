// The volume kernel for rays of any origins; the best instruction set is chosen when the program runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/VolumeOfAnyRays.cpp"
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

VolumeStatistics RenderTilesOfAnyRays(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  return renderRow<float, false>(scene, row, columnBegin, columnEnd);
}

void RenderGroupsOfAnyRays(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba)
{
  renderListed<float, false>(scene, groups, rgba);
}

VolumeStatistics RepeatInCacheOfAnyRays(
  const VolumeKernelScene& scene, int row, int columns, float position, int repeats)
{
  return repeatRow<float, false>(scene, row, columns, position, repeats);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(RenderTilesOfAnyRays);
HWY_EXPORT(RenderGroupsOfAnyRays);
HWY_EXPORT(RepeatInCacheOfAnyRays);

VolumeLoops volumeLoopsOfAnyRays()
{
  return { HWY_DYNAMIC_DISPATCH(RenderTilesOfAnyRays), HWY_DYNAMIC_DISPATCH(RenderGroupsOfAnyRays),
    HWY_DYNAMIC_DISPATCH(RepeatInCacheOfAnyRays) };
}

} // namespace treeamr
#endif
