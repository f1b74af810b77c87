// How volumes that overlap are drawn: layer by layer of the rays.
#include "VolumeEffects.h"
#include "VolumeLayers.h"
#include "VolumeMapperInternals.h"

#include "Volume/VolumeSettings.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace
{

// How often what overlaps is halved at most, where it is dense: layers of cells' width in trees of eight levels.
constexpr int halvingsOfPictures = 8;
constexpr int halvingsOfDrafts = 3;

} // anonymous namespace

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::PrepareShared(const Pictures& pictures, Picture& picture)
{
  const auto sharesMapper = [&](const std::unique_ptr<Picture>& other) {
    return other.get() != &picture && MapperOf(*other) == MapperOf(picture);
  };
  if (std::any_of(pictures.Volumes.begin(), pictures.Volumes.end(), sharesMapper))
  {
    picture.HasVolume = MapperOf(picture)->PrepareVolume(picture.Renderer, picture.Volume);
    picture.Shaders.reset();
  }
}

//------------------------------------------------------------------------------
treeamr::MixedImage vtkTreeAMRVolumeMapper::TraceLayer(const Pictures& pictures,
  const treeamr::VolumeLayer& layer, const vtkTreeAMRRaySegments& rays, const treeamr::ImagePart& part)
{
  treeamr::MixedImage all{ treeamr::Image(part.width, part.height), {} };
  if (rays.IsEmpty())
  {
    return all;
  }
  bool isFirst = true;
  for (const std::size_t v : layer.volumes)
  {
    const auto found = std::find_if(pictures.Volumes.begin(), pictures.Volumes.end(),
      [&](const std::unique_ptr<Picture>& picture) { return picture->Volume == pictures.Order.volumes[v]; });
    if (found == pictures.Volumes.end())
    {
      continue; // it failed
    }
    PrepareShared(pictures, **found);
    vtkTreeAMRVolumeMapper* mapper = MapperOf(**found);
    treeamr::Image image(part.width, part.height);
    mapper->Composite(**found, rays, part, image);
    treeamr::applyColorWindow(mapper->FinalColorWindow, mapper->FinalColorLevel, image);
    if (isFirst)
    {
      all.image = std::move(image);
    }
    else
    {
      layer.isMixed ? treeamr::mixIn(image, all) : treeamr::putBehind(image, all.image);
    }
    isFirst = false;
  }
  return all;
}

//------------------------------------------------------------------------------
vtkTreeAMRRayImage vtkTreeAMRVolumeMapper::TraceLayers(
  const Pictures& pictures, const vtkTreeAMRRaySegments& pixels)
{
  const Picture& own = *pictures.Volumes.front();
  treeamr::VolumeFrame& frame = this->Private->CurrentFrame;
  const treeamr::ImageReduction reduction(own.Viewport.Width, own.Viewport.Height, frame.ImageSampleDistance);
  vtkTreeAMRRayImage result{ reduction, treeamr::Image(reduction.width(), reduction.height()), {} };
  vtkTreeAMRRaySegments rays = reduction.isFull() ? pixels : pixels.Reduce(reduction);
  if (!reduction.isFull())
  {
    result.Lengths = pixels.GetLengths();
  }
  const std::size_t count = result.Image.rgba.size() / 4;
  rays.Begin.resize(count, 0.f);
  rays.End.resize(count, 1.f);
  const auto trace = [&](const treeamr::VolumeLayer& layer, const treeamr::ImagePart& part,
                       const treeamr::PixelMask& wanted, const treeamr::Image& before) {
    vtkTreeAMRRaySegments segments{ std::vector<float>(wanted.size()), std::vector<float>(wanted.size()) };
    std::size_t i = 0;
    for (int row = 0; row < part.height; ++row)
    {
      for (int column = 0; column < part.width; ++column, ++i)
      {
        const std::size_t pixel = part.pixel(column, row);
        const bool isDone = before.rgba[4 * i + 3] > 1.f - treeamr::opaqueTransmittance;
        segments.Begin[i] = std::max(rays.Begin[pixel], layer.begin);
        segments.End[i] = isDone || !wanted[i] ? segments.Begin[i] : std::min(rays.End[pixel], layer.end);
      }
    }
    return TraceLayer(pictures, layer, segments, part);
  };
  for (const treeamr::VolumeLayer& layer : treeamr::makeVolumeLayers(own.Renderer, pictures.Order))
  {
    treeamr::addLayer(layer, frame.Interactive ? halvingsOfDrafts : halvingsOfPictures, trace, result.Image);
  }
  return result;
}
