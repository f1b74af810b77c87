// What VolumeKernel.h calls of a kind of rays and a loop, for the tiles of a frame. Compiled once for each instruction set, as
// Highway wants it.
#if defined(TREEAMR_VOLUMELOOPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMELOOPS_INL_H
#undef TREEAMR_VOLUMELOOPS_INL_H
#else
#define TREEAMR_VOLUMELOOPS_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeTile-inl.h"

#include <hwy/highway.h>

#include <cstddef>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

template <class Real, RayOrigins Origins, VolumeLoop Loop>
VolumeStatistics repeatRow(const VolumeKernelScene& scene, int row, int columns, float position, int repeats)
{
  Tile<Real, Origins, Loop> tile(scene);
  for (int column = 0; column < columns; ++column)
  {
    tile.repeatInCache(column * volumeTileWidth, row * volumeTileWidth, position, repeats);
  }
  return tile.statistics();
}

template <class Real, RayOrigins Origins, VolumeLoop Loop>
void renderListed(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba)
{
  Tile<Real, Origins, Loop> tile(scene);
  while (!groups.empty())
  {
    const int x = groups.front().x / volumeTileWidth * volumeTileWidth;
    const int y = groups.front().y / volumeTileWidth * volumeTileWidth;
    std::size_t inTile = 1;
    while (inTile < groups.size() && groups[inTile].x / volumeTileWidth * volumeTileWidth == x &&
      groups[inTile].y / volumeTileWidth * volumeTileWidth == y)
    {
      ++inTile;
    }
    tile.renderGroups(x, y, groups.first(inTile), rgba);
    rgba += inTile * PixelGroup::rgbaSize;
    groups = groups.subspan(inTile);
  }
}

template <class Real, RayOrigins Origins, VolumeLoop Loop>
VolumeStatistics renderRow(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  Tile<Real, Origins, Loop> tile(scene);
  for (int column = columnBegin; column < columnEnd; ++column)
  {
    tile.render(column * volumeTileWidth, row * volumeTileWidth);
  }
  return tile.statistics();
}

template <class Real, RayOrigins Origins, VolumeLoop Loop>
VolumeLoops loopsOf()
{
  return { renderRow<Real, Origins, Loop>, renderListed<Real, Origins, Loop>,
    repeatRow<Real, Origins, Loop> };
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
