#include "VolumeRelay.h"

#include "GridPartition.h"
#include "HyperTreeGridTopology.h"
#include "SceneConversion.h"
#include "vtkTreeAMRTarget.h"

#include "Error.h"

#include "vtkBoundingBox.h"
#include "vtkHyperTreeGrid.h"
#include "vtkVolume.h"

#include <exception>

namespace treeamr
{

VolumeRelay::VolumeRelay(BoxPeers* peers, vtkHyperTreeGrid* grid, vtkRenderer* renderer, vtkVolume* volume)
  : peers_(peers && grid && partitionOf(*grid) ? peers : nullptr)
  , grid_(grid)
  , renderer_(renderer)
  , volume_(volume)
{
}

VolumeRelay::~VolumeRelay()
{
  try
  {
    if (relay_ && relay_->hasBegun())
    {
      relay_->end(hasFailed_);
    }
    relay_.reset();
    if (peers_)
    {
      const vtkTreeAMRViewport viewport = vtkTreeAMRTarget::GetViewport(renderer_);
      const Camera camera(clipFromData(renderer_, volume_), viewport.Width, viewport.Height);
      Image nothing(0, 0); // it may be memory that is short
      this->make(camera, nullptr, nothing);
      relay_->begin(false);
      relay_.reset();
    }
  }
  catch (const std::exception&)
  {
    // A camera or boxes that are none: so for all processes.
  }
}

BoxRelay* VolumeRelay::begin(
  const Camera& camera, const float* endDepth, Image& image, const BoxRelay::Terms& terms)
{
  if (!peers_)
  {
    return nullptr;
  }
  this->make(camera, endDepth, image);
  const bool hasBegun = relay_->begin(true, terms);
  peers_ = nullptr;
  if (!hasBegun)
  {
    relay_.reset();
  }
  return relay_ ? &*relay_ : nullptr;
}

void VolumeRelay::giveUp(bool hasFailed)
{
  if (relay_)
  {
    hasFailed_ = hasFailed_ || hasFailed;
    relay_->giveUp();
  }
}

void VolumeRelay::end()
{
  if (relay_)
  {
    const bool haveAll = relay_->end(hasFailed_);
    relay_.reset();
    if (!haveAll && !hasFailed_)
    {
      throw Error("volume mapper: another process has failed, the picture lacks its part");
    }
  }
}

void VolumeRelay::make(const Camera& camera, const float* endDepth, Image& image)
{
  const auto partition = partitionOf(*grid_);
  relay_.emplace(
    partition->boxes, partition->own, RootGrid(readRootPlanes(*grid_)), *peers_, camera, endDepth, image);
}

void addRelayed(vtkHyperTreeGrid& grid, bool mayGather, double bounds[6])
{
  if (const auto partition = partitionOf(grid))
  {
    const RootGrid roots(readRootPlanes(grid));
    Bounds box = mayGather ? roots.bounds() : partition->box().bounds(roots);
    vtkBoundingBox all(bounds);
    all.AddPoint(box.min.data());
    all.AddPoint(box.max.data());
    all.GetBounds(bounds);
  }
}

} // namespace treeamr
