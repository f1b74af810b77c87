// The table of the volume kernel's variants. Each is a source of its own, that none takes long to compile.
#include "Volume/Kernel/VolumeKernel.h"

namespace treeamr
{

VolumeLoops volumeLoops(const SceneFeatures& features)
{
  switch (features.loop)
  {
    case VolumeLoop::Lit:
      return features.doubles     ? litVolumeLoopsInDoubles()
        : features.commonOrigin ? litVolumeLoopsFromOnePoint()
                                : litVolumeLoops();
    case VolumeLoop::Extreme:
      return features.doubles ? extremeVolumeLoopsInDoubles() : extremeVolumeLoops();
    case VolumeLoop::Sum:
      return features.doubles ? sumVolumeLoopsInDoubles() : sumVolumeLoops();
    default:
      break;
  }
  if (features.doubles)
  {
    return volumeLoopsInDoubles();
  }
  return features.commonOrigin ? volumeLoopsFromOnePoint() : volumeLoopsOfAnyRays();
}

} // namespace treeamr
