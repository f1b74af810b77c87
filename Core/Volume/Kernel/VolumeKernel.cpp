// The table of the volume kernel's variants. Each is a source of its own, that none takes long to compile.
#include "Volume/Kernel/VolumeKernel.h"

namespace treeamr
{

VolumeLoops volumeLoops(const SceneFeatures& features)
{
  if (features.doubles)
  {
    return volumeLoopsInDoubles();
  }
  return features.commonOrigin ? volumeLoopsFromOnePoint() : volumeLoopsOfAnyRays();
}

} // namespace treeamr
