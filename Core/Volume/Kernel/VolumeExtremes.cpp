// The volume kernel of the largest or smallest value on each ray; the best instruction set is chosen when the program
// runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/VolumeExtremes.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Volume/Kernel/VolumeBlends-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeLoops-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

VolumeLoops ExtremeLoops()
{
  return loopsOf<float, RayOrigins::Either, VolumeLoop::Extreme>();
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(ExtremeLoops);

VolumeLoops extremeVolumeLoops()
{
  return HWY_DYNAMIC_DISPATCH(ExtremeLoops)();
}

} // namespace treeamr
#endif
