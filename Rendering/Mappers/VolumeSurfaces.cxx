#include "VolumeSurfaces.h"

namespace treeamr
{

bool VolumeSurfaces::set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues)
{
  if (!levels_.set(field, isovalues))
  {
    return false;
  }
  view_.release(); // before there are others
  return true;
}

void VolumeSurfaces::release()
{
  levels_ = SurfaceLevels();
  view_.release();
}

SurfaceView& VolumeSurfaces::trace(
  const SurfacePose& pose, double distance, double levelOfDetail, Progress* progress)
{
  if (!view_.isOf(pose) || view_.sampleDistance() != distance || levelOfDetail_ != levelOfDetail)
  {
    view_.trace(levels_, pose, distance, levelOfDetail, progress);
    levelOfDetail_ = levelOfDetail;
  }
  return view_;
}

} // namespace treeamr
