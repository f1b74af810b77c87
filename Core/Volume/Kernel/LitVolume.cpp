// The volume kernel with light and gradient opacity; the best instruction set is chosen when the program runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/LitVolume.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeLight-inl.h"
#include "Volume/Kernel/VolumeLoops-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

VolumeLoops LitLoops()
{
  return loopsOf<float, RayOrigins::Any, VolumeLoop::Lit>();
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(LitLoops);

VolumeLoops litVolumeLoops()
{
  return HWY_DYNAMIC_DISPATCH(LitLoops)();
}

} // namespace treeamr
#endif
