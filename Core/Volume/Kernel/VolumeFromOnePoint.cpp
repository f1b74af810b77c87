// The volume kernel for rays that start at one point; the best instruction set is chosen when the program runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/VolumeFromOnePoint.cpp"
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

VolumeStatistics RenderTilesFromOnePoint(
  const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  return renderRow<float, true>(scene, row, columnBegin, columnEnd);
}

void RenderGroupsFromOnePoint(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba)
{
  renderListed<float, true>(scene, groups, rgba);
}

VolumeStatistics RepeatInCacheFromOnePoint(
  const VolumeKernelScene& scene, int row, int columns, float position, int repeats)
{
  return repeatRow<float, true>(scene, row, columns, position, repeats);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(RenderTilesFromOnePoint);
HWY_EXPORT(RenderGroupsFromOnePoint);
HWY_EXPORT(RepeatInCacheFromOnePoint);

VolumeLoops volumeLoopsFromOnePoint()
{
  return { HWY_DYNAMIC_DISPATCH(RenderTilesFromOnePoint), HWY_DYNAMIC_DISPATCH(RenderGroupsFromOnePoint),
    HWY_DYNAMIC_DISPATCH(RepeatInCacheFromOnePoint) };
}

} // namespace treeamr
#endif
