#include "vtkTreeAMRSurfaceImage.h"

//------------------------------------------------------------------------------
void vtkTreeAMRSurfaceTextures::Upload(vtkOpenGLRenderWindow* window,
  const treeamr::ImageReduction& reduction, const vtkTreeAMRSurfaceImage& image, bool geometry)
{
  this->NumberOfTiles = image.NumberOfTiles;
  this->Geometry = geometry;
  this->Full = reduction.isFull();
  if (image.NumberOfTiles == 0)
  {
    return;
  }
  this->TileSize[0] = static_cast<float>(vtkTreeAMRSurfaceImage::TileSize) / reduction.width();
  this->TileSize[1] = static_cast<float>(vtkTreeAMRSurfaceImage::TileSize) / reduction.height();
  constexpr int columns = vtkTreeAMRSurfaceImage::Columns;
  const int rows = static_cast<int>(image.Depth.size() / columns);
  this->Tiles.Upload(
    window, columns, static_cast<int>(image.Tiles.size() / 3 / columns), 3, image.Tiles.data());
  this->Runs.Upload(window, reduction.width(), reduction.height(), 3, image.Runs.data());
  this->Color.Upload(window, columns, rows, 4, image.RGBA.data());
  this->Depth.Upload(window, columns, rows, 1, image.Depth.data());
  if (!this->Full)
  {
    this->Slope.Upload(window, columns, rows, 2, image.Slope.data());
  }
  if (geometry)
  {
    this->Position.Upload(window, columns, rows, 3, image.Position.data());
    this->Normal.Upload(window, columns, rows, 3, image.Normal.data());
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRSurfaceTextures::ReleaseGraphicsResources(vtkWindow* window)
{
  for (vtkTreeAMRFloatTexture* texture :
    { &this->Tiles, &this->Runs, &this->Color, &this->Depth, &this->Slope, &this->Position, &this->Normal })
  {
    texture->ReleaseGraphicsResources(window);
  }
}
