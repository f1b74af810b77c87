// What is drawn into: whatever framebuffer and viewport are bound for drawing, so that render passes, IceT and
// multisampled windows are served as well as plain ones.
#pragma once

class vtkOpenGLRenderWindow;
class vtkRenderer;

/// Where an image goes in the framebuffer that is bound for drawing, in pixels.
struct vtkTreeAMRViewport
{
  int X = 0;
  int Y = 0;
  int Width = 0;
  int Height = 0;
};

class vtkTreeAMRTarget
{
public:
  /// Throws treeamr::Error when the renderer does not draw into an OpenGL window.
  static vtkOpenGLRenderWindow* GetWindow(vtkRenderer* renderer);
  /// The current OpenGL viewport: the renderer's own, except inside passes that draw into textures. Throws
  /// Error.
  static vtkTreeAMRViewport GetViewport(vtkRenderer* renderer);
  /// Forgets OpenGL errors that others left behind, so that what is found next is one's own.
  static void DiscardErrors();
};
