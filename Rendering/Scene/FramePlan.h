// How a frame is to be traced: the whole picture or, while the camera moves, a draft that fits its time. Private to
// the module.
#pragma once

#include "ImageReduction.h"

class vtkProp;
class vtkRenderer;

namespace treeamr
{

/// A mapper's settings, with the names of VTK's.
struct DraftSettings
{
  bool autoAdjustSampleDistances = true;
  double imageSampleDistance = 1.; // when that is off
  double minimumImageSampleDistance = 1.;
  double maximumImageSampleDistance = 10.;
  double interactiveRenderTime = 0.; // seconds; 0: what VTK allocates
  double levelOfDetail = 2.;         // pixels, of drafts
};

struct FramePlan
{
  bool isInteractive = false; // what the window wants
  bool isDraft = false;       // fitted into its time
  double sampleDistance = 1.; // pixels between rays, at least 1
  double levelOfDetail = 0.;  // pixels
};

/// For a viewport of so many pixels. kept: the distance of a picture that is still right, which a draft takes; 0 for
/// none. Hardware selection has one ray a pixel and every cell.
FramePlan planFrame(vtkRenderer* renderer, vtkProp* prop, double pixels, const DraftSettings& settings,
  SampleDistanceControl& control, double kept = 0.);

} // namespace treeamr
