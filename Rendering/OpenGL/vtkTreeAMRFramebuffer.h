// Images of the CPU renderers into VTK's OpenGL framebuffers, and out of them the depth of what is there.
//
// Works on whatever framebuffer and viewport are bound for drawing, so that it serves render passes, IceT and
// multisampled windows as well as plain ones. All OpenGL state is restored: vtkOpenGLState keeps a copy of it
// and, in debugging builds of VTK, compares the two at every call.
#pragma once

#include "vtkTreeAMRQuad.h"
#include "vtkTreeAMRRayImage.h"

#include <vector>

class vtkAbstractMapper;
class vtkActor;
class vtkOpenGLRenderWindow;
class vtkProp;
class vtkRenderer;
class vtkWindow;

/// Where the image goes in the framebuffer that is bound for drawing, in pixels.
struct vtkTreeAMRViewport
{
  int X = 0;
  int Y = 0;
  int Width = 0;
  int Height = 0;
};

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
  // x, y, z in view coordinates; only when vtkTreeAMRFramebuffer::WantsGeometry()
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
  friend class vtkTreeAMRFramebuffer;
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

class vtkTreeAMRFramebuffer
{
public:
  vtkTreeAMRFramebuffer();
  vtkTreeAMRFramebuffer(const vtkTreeAMRFramebuffer&) = delete;
  vtkTreeAMRFramebuffer& operator=(const vtkTreeAMRFramebuffer&) = delete;

  /// Throws treeamr::Error when the renderer does not draw into an OpenGL window.
  static vtkOpenGLRenderWindow* GetWindow(vtkRenderer* renderer);
  /// The current OpenGL viewport: the renderer's own, except inside passes that draw into textures. Throws
  /// Error.
  static vtkTreeAMRViewport GetViewport(vtkRenderer* renderer);
  /// Forgets OpenGL errors that others left behind, so that what is found next is one's own.
  static void DiscardErrors();

  /// Window depth of each pixel of the viewport; 1 everywhere when the framebuffer has no depth. Of a
  /// multisampled framebuffer one sample a pixel. Throws Error.
  void ReadDepth(vtkRenderer* renderer, const vtkTreeAMRViewport& viewport, std::vector<float>& depth);

  /// Blends an image over the viewport's colour and alpha (IceT composites with the alpha); depth is neither
  /// tested nor written. Throws Error.
  void DrawOver(vtkRenderer* renderer, const vtkTreeAMRRayImage& image);

  /// Whether a pass around this prop's rendering takes positions and normals (vtkSSAOPass).
  static bool WantsGeometry(vtkProp* prop);
  /// Whether a pass around this actor's rendering sorts fragments by depth.
  static bool IsDepthPeeling(vtkProp* prop);
  /// Draws with real depth: opaque points in the opaque pass; in the translucent pass by the protocol of the
  /// pass (order independent or depth peeling), blended with the image's alpha, back to front in each pixel.
  /// Throws Error.
  void DrawSurface(vtkRenderer* renderer, vtkActor* actor, vtkAbstractMapper* mapper,
    const vtkTreeAMRSurfaceTextures& textures);

  void ReleaseGraphicsResources(vtkWindow* window);

private:
  vtkTreeAMRQuad& SurfaceQuad(vtkActor* actor, vtkAbstractMapper* mapper, bool full);

  vtkTreeAMRQuadSet OverQuads;
  vtkTreeAMRRayTexture Over{ "treeamrImage" };
  // The passes rewrite the shader and have stages of their own: one program for each text they make.
  vtkTreeAMRQuadSet SurfaceQuads;
};
