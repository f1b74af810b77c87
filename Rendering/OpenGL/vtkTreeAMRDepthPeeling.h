// A volume's part in vtkDualDepthPeelingPass, so that translucent polygons inside it are composited exactly.
//
// The pass peels translucent surfaces from both ends at once and asks volumes, between two peels, for the
// segments of each ray between the surfaces just peeled: first the parts outside of all surfaces, then a
// front and a back segment for every peel, and, when the number of peels is used up, what remains in the
// middle. VTK's GPU mapper takes part through shader substitutions; here the pass's depth textures are read
// back, the segments are traced on the CPU and the images are written the way those substituted shaders write
// them. Naive drawing instead would end up in the pass's working textures.
//
// The pass keeps its stage to itself, but what it substitutes tells it. Its textures hold 8 bits a channel,
// and two volumes in the same pixels are blended by maximum: both are limits of the pass.
#pragma once

#include "vtkTreeAMRQuad.h"
#include "vtkTreeAMRRayImage.h"

#include <vector>

class vtkAbstractMapper;
class vtkOpenGLRenderPass;
class vtkProp;
class vtkRenderer;
class vtkShaderProgram;
class vtkWindow;

class vtkTreeAMRDepthPeeling
{
public:
  vtkTreeAMRDepthPeeling();
  vtkTreeAMRDepthPeeling(const vtkTreeAMRDepthPeeling&) = delete;
  vtkTreeAMRDepthPeeling& operator=(const vtkTreeAMRDepthPeeling&) = delete;

  /// Whether the volume is being rendered by the pass: then Begin, two images and Draw replace drawing over
  /// the framebuffer.
  static bool IsPeeling(vtkProp* volume);
  /// Whether that is for the first time in a frame. Throws treeamr::Error.
  static bool IsFirstStage(vtkAbstractMapper* mapper, vtkProp* volume);

  /// The segments to trace now, for width x height pixels of the viewport. Throws treeamr::Error.
  void Begin(vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* volume, int width, int height,
    vtkTreeAMRRaySegments& front, vtkTreeAMRRaySegments& back);
  /// The same for a frame in which nothing is peeled, at its first stage: the window depths of what is opaque, 1 where
  /// nothing is, at which the one segment of each pixel ends.
  void BeginWithoutPeels(vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* volume, int width,
    int height, std::vector<float>& depth);
  /// Whether Begin() was the first one of its frame.
  bool IsFrameStart() const { return this->CurrentStage == Stage::Outside; }
  /// The images of the two segments; null: nothing. Throws treeamr::Error.
  void Draw(vtkRenderer* renderer, const vtkTreeAMRRayImage* front, const vtkTreeAMRRayImage& back);

  /// For a surface that is being rendered by the pass: window depths of what is opaque behind it, 1 where
  /// nothing is. False when the pass does not tell, which it does when a frame's translucent surfaces are
  /// drawn for the first time. Throws treeamr::Error.
  bool ReadOpaqueDepth(vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* surface, int width,
    int height, std::vector<float>& depth);

  void ReleaseGraphicsResources(vtkWindow* window);

private:
  enum class Stage
  {
    Outside,  // in front of and behind all translucent surfaces
    Peel,     // between the peel before and the one just done, in front and behind
    Remainder // between the last peels
  };
  static vtkOpenGLRenderPass* FindPass(vtkProp* volume);
  static Stage FindStage(vtkOpenGLRenderPass* pass, vtkAbstractMapper* mapper, vtkProp* volume);
  vtkShaderProgram* Probe(vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* volume);
  const char* StageShader() const;

  Stage CurrentStage = Stage::Outside;
  int LastFrontColorUnit = 0;
  vtkTreeAMRQuad ProbeQuad;  // never drawn: holds the texture units that the pass sets
  vtkTreeAMRQuad OpaqueQuad; // nor this one
  vtkTreeAMRQuadSet StageQuads;
  vtkTreeAMRRayTexture Front{ "treeamrFront" };
  vtkTreeAMRRayTexture Back{ "treeamrBack" };
};
