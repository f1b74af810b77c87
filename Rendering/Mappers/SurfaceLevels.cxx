#include "SurfaceLevels.h"

#include "MapperInput.h"

#include "Surface/CellDepth.h"

namespace treeamr
{

bool SurfaceLevels::set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues)
{
  if (field_ == field && isovalues_ == isovalues)
  {
    return false;
  }
  *this = SurfaceLevels();
  field_ = field;
  isovalues_ = isovalues;
  return true;
}

const std::shared_ptr<const Isosurface>& SurfaceLevels::inFull()
{
  if (!full_)
  {
    full_ = acquireIsosurface(field_, isovalues_);
  }
  return full_;
}

const std::shared_ptr<const Isosurface>& SurfaceLevels::ofDetail(const Camera& camera, double pixels)
{
  const Octree& octree = field_->octree();
  const int depth = cellDepthFor(octree, camera, pixels);
  if (depth + 1 >= octree.leafLevels())
  {
    return this->inFull();
  }
  // One level more than needed is kept: no new surface at every step to and fro.
  if (!coarse_ || depth > coarseCellDepth_ || depth + 1 < coarseCellDepth_)
  {
    coarse_.reset();
    coarse_ = acquireIsosurface(field_, isovalues_, depth);
    coarseCellDepth_ = depth;
  }
  return coarse_;
}

} // namespace treeamr
