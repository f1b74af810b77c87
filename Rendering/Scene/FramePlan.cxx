#include "FramePlan.h"

#include "SceneConversion.h"

#include "vtkProp.h"
#include "vtkRenderer.h"

namespace treeamr
{

FramePlan planFrame(vtkRenderer* renderer, vtkProp* prop, double pixels, const DraftSettings& settings,
  SampleDistanceControl& control, double kept)
{
  FramePlan plan;
  plan.isInteractive = isInteractive(renderer);
  if (renderer->GetSelector())
  {
    return plan;
  }
  if (!settings.autoAdjustSampleDistances)
  {
    plan.sampleDistance = settings.imageSampleDistance;
    return plan;
  }
  plan.isDraft = plan.isInteractive;
  plan.sampleDistance = settings.minimumImageSampleDistance;
  if (plan.isDraft)
  {
    plan.levelOfDetail = settings.levelOfDetail;
    const double seconds =
      settings.interactiveRenderTime > 0. ? settings.interactiveRenderTime : prop->GetAllocatedRenderTime();
    plan.sampleDistance = kept > 0. ? kept
                                    : control.choose(seconds / pixels, settings.minimumImageSampleDistance,
                                        settings.maximumImageSampleDistance);
  }
  return plan;
}

} // namespace treeamr
