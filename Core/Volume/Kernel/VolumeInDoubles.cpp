// The volume kernel with double lanes, for rays of any origins: what extreme zooms, thin domains and huge values are
// rendered by. The best instruction set is chosen when the program runs.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Volume/Kernel/VolumeInDoubles.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeLoops-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

VolumeLoops LoopsInDoubles()
{
  return loopsOf<double, RayOrigins::Any, VolumeLoop::Plain>();
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(LoopsInDoubles);

VolumeLoops volumeLoopsInDoubles()
{
  return HWY_DYNAMIC_DISPATCH(LoopsInDoubles)();
}

} // namespace treeamr
#endif
