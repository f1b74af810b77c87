// Surface points on their way to the graphics card.
#pragma once

#include "ImageReduction.h"
#include "vtkTreeAMRQuad.h"

#include <vector>

class vtkOpenGLRenderWindow;
class vtkWindow;

/// Surface points, any number behind each other in a pixel. Pixels come lower left first; the points of one
/// follow each other, nearest first, in rows of Columns.
struct vtkTreeAMRSurfaceImage
{
  static constexpr int Columns = 4096; // of points, and of tiles
  static constexpr int TileSize = 32;  // pixels
  // Column, row and layer of each tile with such a layer, far layers first; the last row is filled up.
  int NumberOfTiles = 0;
  std::vector<float> Tiles;
  // Of each pixel: column and row of its first point, number of its points.
  std::vector<float> Runs;
  // Of each point; the last row is filled up.
  std::vector<float> RGBA;  // not premultiplied
  std::vector<float> Depth; // window depth, in the middle of the pixel
  // Its change along x and y over the whole image; only of images with fewer pixels than the viewport.
  std::vector<float> Slope;
  // x, y, z in view coordinates; only where treeamr::wantsGeometry()
  std::vector<float> Position;
  std::vector<float> Normal;
};

/// A surface image on the graphics card, for all passes that draw it.
class vtkTreeAMRSurfaceTextures
{
public:
  /// Throws treeamr::Error.
  void Upload(vtkOpenGLRenderWindow* window, const treeamr::ImageReduction& reduction,
    const vtkTreeAMRSurfaceImage& image, bool geometry);
  bool HasGeometry() const { return this->Geometry; }
  void ReleaseGraphicsResources(vtkWindow* window);

private:
  friend class vtkTreeAMRSurfacePainter;
  int NumberOfTiles = 0;
  float TileSize[2] = { 0.f, 0.f }; // in texture coordinates
  bool Geometry = false;
  bool Full = true; // a point is one of a pixel
  vtkTreeAMRFloatTexture Tiles;
  vtkTreeAMRFloatTexture Runs;
  vtkTreeAMRFloatTexture Color;
  vtkTreeAMRFloatTexture Depth;
  vtkTreeAMRFloatTexture Slope;
  vtkTreeAMRFloatTexture Position;
  vtkTreeAMRFloatTexture Normal;
};
