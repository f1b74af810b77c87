// The isosurfaces that a volume mapper draws: built, traced and lit when what they depend on has changed.
// Private to the module.
#pragma once

#include "SurfaceLevels.h"
#include "SurfaceShading.h"
#include "SurfaceView.h"

#include "Surface/Isosurface.h"

#include <memory>
#include <vector>

namespace treeamr
{

class VolumeSurfaces
{
public:
  /// True when the field or the isovalues are not those of the last call.
  bool set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues);
  bool isEmpty() const noexcept { return levels_.isEmpty(); }
  /// What was traced last; null before, and after release().
  const Isosurface* engine() const noexcept { return view_.surface().get(); }
  void release();

  /// All hits of a picture; the last ones when nothing has changed. Cells smaller than levelOfDetail pixels are drawn
  /// together. Throws Error as Isosurface(), and Interrupted.
  SurfaceView& trace(const SurfacePose& pose, double distance, double levelOfDetail, Progress* progress);
  std::size_t hitCount() const noexcept { return view_.hits().hits.size(); }

private:
  SurfaceLevels levels_;
  SurfaceView view_;
  double levelOfDetail_ = 0.;
};

} // namespace treeamr
