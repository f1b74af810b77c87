#include "SurfaceView.h"

#include "Surface/OcclusionFilter.h"
#include "Surface/SecondaryRays.h"
#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace treeamr
{

void SurfaceView::release()
{
  camera_.reset();
  surface_.reset();
  hits_.first.clear();
  hits_.hits.clear();
}

void SurfaceView::trace(
  SurfaceLevels& levels, const SurfacePose& pose, double distance, double levelOfDetail, Progress* progress)
{
  camera_.reset();
  visibility_ = {};
  openRays_.clear();
  occlusionRays_ = 0;
  shadowLights_.clear();
  pose_ = pose;
  reduction_ = ImageReduction(pose.width, pose.height, distance);
  sampleDistance_ = distance;
  const Camera camera(pose.clipFromData, pose.viewFromData, reduction_.width(), reduction_.height());
  surface_ = levelOfDetail > 0. ? levels.ofDetail(camera, levelOfDetail) : levels.inFull();
  surface_->startFrame();
  RayStops stops;
  stops.cut = pose.cut;
  surface_->render({ camera, stops, progress }, pose.layers, hits_, pose.mostHits, pose.normals);
  camera_ = camera;
}

double SurfaceView::diagonalOf(const RootGrid& grid) const
{
  const SurfaceFrame frame(pose_.viewFromData);
  const Bounds bounds = grid.bounds();
  double longest = 0.;
  for (int corner = 0; corner < 4; ++corner)
  {
    Vec3 diagonal;
    for (int a = 0; a < 3; ++a)
    {
      diagonal[a] = (corner >> a & 1 ? -1. : 1.) * (bounds.max[a] - bounds.min[a]);
    }
    const Vec3 inView = frame.worldVector(diagonal);
    longest = std::max(longest, std::sqrt(dot(inView, inView)));
  }
  return longest;
}

const SurfaceVisibility& SurfaceView::updateVisibility(
  const SecondaryRays& wanted, const std::vector<Light>& lights, Progress* progress)
{
  if (wanted.occlusionRadius != occlusionRadius_ || occlusionRays_ > wanted.occlusionSamples)
  {
    visibility_.open.clear();
    openRays_.clear();
    occlusionRays_ = 0;
  }
  occlusionRadius_ = wanted.occlusionRadius;
  const int end = occlusionRays_ + std::min(wanted.mostNewSamples, wanted.occlusionSamples - occlusionRays_);
  if (end > occlusionRays_)
  {
    // None until all are there: what throws has added some.
    const int begin = std::exchange(occlusionRays_, 0);
    visibility_.open.clear();
    if (begin == 0)
    {
      openRays_.assign(hits_.hits.size(), 0);
    }
    traceAmbientOcclusion(
      *surface_, *camera_, hits_, occlusionRadius_, begin, end, openRays_, pose_.cut, progress);
    visibility_.open = filterAmbientOcclusion(*camera_, hits_, openRays_, end);
    occlusionRays_ = end;
  }

  if (!wanted.shadows)
  {
    visibility_.lit.clear();
    shadowLights_.clear();
  }
  else if (shadowLights_ != lights)
  {
    shadowLights_.clear();
    traceShadows(*surface_, *camera_, hits_, lights, visibility_.lit, pose_.cut, progress);
    shadowLights_ = lights;
  }
  return visibility_;
}

} // namespace treeamr
