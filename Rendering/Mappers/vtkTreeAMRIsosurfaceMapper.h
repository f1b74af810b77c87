/**
 * @class   vtkTreeAMRIsosurfaceMapper
 * @brief   ray-traces isosurfaces of a vtkHyperTreeGrid on the CPU
 *
 * The surfaces are implicit: the points where the generalized trilinear interpolation of the cells' values
 * (see Core/Interpolation) equals one of the values, without cracks at refinement levels and without
 * triangles. The contoured array is SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS,
 * name); unset it is the active scalars or, when there are none, the first cell array.
 *
 * The actor's vtkProperty and the renderer's lights shade it as they shade polygons: with normals that are
 * smooth across cells of all levels or, in flat interpolation, those of the trilinear pieces. It is coloured
 * by an array through vtkMapper's ScalarVisibility, ScalarMode, ColorMode, SelectColorArray() and
 * LookupTable, its opacities included; an array that does not exist or is unfit leaves the solid colour, with
 * a warning; values that are not finite or beyond float have the colour and the opacity of NaN. Coloured by
 * the contoured array each surface has the colour of its value. A table with IndexedLookup makes categories
 * of the values: each point has the colour of its cell's own value, or of an isovalue that the table lists.
 * Real depth is written: the surface meets polygons and volumes correctly.
 *
 * An actor of opacity below 1, or of translucent colours, shows all layers of the surfaces. With depth
 * peeling they are sorted among themselves and with all other translucent geometry and the volumes of this
 * module; each layer takes a peel, and two layers nearer than the depth buffer can tell are one. Without it
 * the layers before what is opaque are blended in their order and count as one, at the nearest, for VTK's
 * order independent pass.
 *
 * Where nothing in the renderer is translucent but actors of such mappers and one vtkTreeAMRVolumeMapper's volume, in
 * no assembly and in passes of VTK's own order, there is nothing to sort: the volume or, without one, one of the
 * actors draws all of them, in one picture with one distance between rays.
 *
 * Ambient occlusion and shadows are traced, with all the mapper's surfaces as obstacles and nothing else of
 * the scene. A translucent surface takes away the part of the light that its opacity says, once. Unlit
 * properties have neither.
 *
 * Actors may share a mapper, and mappers a grid: the data and the surfaces are there once, and each actor has
 * its own matrix, mirrored ones included.
 *
 * While a frame takes long, ProgressEvent and the window's AbortCheckEvent come as from vtkTreeAMRVolumeMapper, and
 * end it alike.
 *
 * Hardware selection gives the cells that the surface is seen in, as indices into the grid's cell arrays; a
 * surface has no points to select. Pickers that read the depth buffer (vtkPropPicker, vtkWorldPointPicker)
 * find points of the surface, where vtkTreeAMRProbeFilter gives the value of any array; those that intersect
 * data sets themselves (vtkCellPicker, vtkHardwarePicker) know no hyper tree grids. What it cannot do warns
 * once when it is asked for: wireframe, points, edges, culling, backface properties,
 * textures, physically based shading, shader code. Needs an OpenGL window.
 *
 * VTK's exporters write polygons alone: they leave this mapper out unless its actor is a
 * vtkTreeAMRIsosurfaceActor.
 */

#ifndef vtkTreeAMRIsosurfaceMapper_h
#define vtkTreeAMRIsosurfaceMapper_h

#include "vtkMapper.h"
#include "vtkNew.h"                    // for ContourValues
#include "vtkTreeAMRRenderingModule.h" // for the export macro

#include <array>      // for std::array
#include <functional> // for std::function
#include <memory>     // for std::unique_ptr
#include <string>     // for std::string
#include <vector>     // for std::vector

class vtkContourValues;
class vtkHyperTreeGrid;

namespace treeamr
{
class ActorLayers;
class MapperMessages;
struct SurfaceActorView;
class Progress;
enum class SurfaceLayers;
class SurfaceShader;
} // namespace treeamr

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRIsosurfaceMapper : public vtkMapper
{
public:
  static vtkTreeAMRIsosurfaceMapper* New();
  vtkTypeMacro(vtkTreeAMRIsosurfaceMapper, vtkMapper);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// What the surfaces are of; null: nothing is drawn.
  void SetInputData(vtkHyperTreeGrid* grid);
  vtkHyperTreeGrid* GetHyperTreeGrid();
  ///@}

  ///@{
  /// The isovalues, as vtkContourValues has them: by default one, 0. Without any nothing is drawn.
  void SetValue(int i, double value);
  double GetValue(int i);
  double* GetValues() VTK_SIZEHINT(GetNumberOfContours());
  void GetValues(double* values);
  void SetNumberOfContours(int number);
  vtkIdType GetNumberOfContours();
  void GenerateValues(int number, double range[2]);
  void GenerateValues(int number, double rangeStart, double rangeEnd);
  ///@}
  ///@{
  /// Component of the contoured array; -1, the default, for the magnitude (of a scalar array the value).
  vtkSetMacro(IsosurfaceComponent, int);
  vtkGetMacro(IsosurfaceComponent, int);
  ///@}

  ///@{
  /// What hardware selection gives as composite index: the flat index of the grid's block in a composite data
  /// set. Default 1, as of a grid that is in none. 0: made of several, so that nothing of it is selected, which a warning
  /// says once.
  vtkSetMacro(CompositeIndex, unsigned int);
  vtkGetMacro(CompositeIndex, unsigned int);
  ///@}

  ///@{
  /// Rays from each surface point of the picture into the half space before it; where they meet a surface
  /// within AmbientOcclusionRadius the point gets darker, as with vtkSSAOPass. 0, the default, for none;
  /// 65535 at most.
  ///
  /// A still frame traces all of them. Of an interactive one (the window's desired update rate is 1 or more)
  /// each pixel traces InteractiveSamples; as long as camera, actor and surfaces stay, frames add theirs to
  /// those before, so that after AmbientOcclusionSamples / InteractiveSamples frames of either kind, or one
  /// still frame, the picture is the same. Pixels next to each other on one smooth piece of surface share
  /// their rays, so 16 of them show no grain there.
  virtual void SetAmbientOcclusionSamples(int value);
  vtkGetMacro(AmbientOcclusionSamples, int);
  static constexpr int InteractiveSamples = 2;
  ///@}
  ///@{
  /// Part of the diagonal of the grid's bounds, as large as the actor shows it. Default 0.05.
  virtual void SetAmbientOcclusionRadius(double value);
  vtkGetMacro(AmbientOcclusionRadius, double);
  ///@}
  ///@{
  /// Shadows of the surfaces on themselves from all lights but headlights, which are at the eye. Default off.
  vtkSetMacro(Shadows, bool);
  vtkGetMacro(Shadows, bool);
  vtkBooleanMacro(Shadows, bool);
  ///@}

  ///@{
  /// Drafts of interactive frames, by the settings and with the defaults of vtkTreeAMRVolumeMapper: when camera,
  /// actor or surfaces have changed, an interactive frame is traced with as few rays as fit InteractiveRenderTime
  /// or, when that is 0, the time that VTK allocates to the actor, and cells smaller than LevelOfDetail pixels of
  /// that picture are drawn together by their means. Pixels have the depth of the surface's tangent plane. While
  /// nothing of it moves, interactive frames keep the picture there is; hardware selection always has one ray a
  /// pixel and every cell.
  vtkSetMacro(AutoAdjustSampleDistances, bool);
  vtkGetMacro(AutoAdjustSampleDistances, bool);
  vtkBooleanMacro(AutoAdjustSampleDistances, bool);
  virtual void SetImageSampleDistance(double value);
  vtkGetMacro(ImageSampleDistance, double);
  virtual void SetMinimumImageSampleDistance(double value);
  vtkGetMacro(MinimumImageSampleDistance, double);
  virtual void SetMaximumImageSampleDistance(double value);
  vtkGetMacro(MaximumImageSampleDistance, double);
  virtual void SetInteractiveRenderTime(double value);
  vtkGetMacro(InteractiveRenderTime, double);
  virtual void SetLevelOfDetail(double value);
  vtkGetMacro(LevelOfDetail, double);
  ///@}
  /// Pixels between the rays of the last frame, in whichever renderer; 0 before the first.
  double GetLastImageSampleDistance();
  /// Of many processes that draw one picture, before each frame and on all: makes drafts as coarse as the slowest one needs.
  /// largest(numbers): makes each number the largest of all processes'.
  void AgreeOnDrafts(
    vtkRenderer* renderer, vtkActor* actor, const std::function<void(std::array<double, 3>&)>& largest);

  ///@{
  /// Octants that the surfaces in use pass through, 0 before the first frame that is no draft; and when they changed.
  vtkIdType GetNumberOfPrimitives();
  vtkMTimeType GetSurfaceBuildTime();
  ///@}

  /// The nearest point of the surfaces on the line from p1 to p2 (data coordinates), between the fractions t1 and t2 of
  /// it: its fraction t, the normal towards lower values (of any length), the surface's value; returns the cell's index
  /// in the cell arrays. -1: there is none, or it failed, as the next frame tells. For vtkTreeAMRPicker.
  vtkIdType IntersectWithLine(
    const double p1[3], const double p2[3], double t1, double t2, double& t, double normal[3], double& value);

  ///@{
  /// Bounds of the trees that this process holds; uninitialised without input.
  double* GetBounds() VTK_SIZEHINT(6) override;
  void GetBounds(double bounds[6]) override { this->Superclass::GetBounds(bounds); }
  ///@}

  /// Whether the array's colours are translucent, by vtkMapper's rules: those of the lookup table, or those
  /// in an array of colours; besides, the lookup table's colour of NaN.
  bool HasTranslucentPolygonalGeometry() override;
  /// The same of another array; null: of any array of values.
  bool HasTranslucentColors(vtkDataArray* array);

  /// Changes with the isovalues, too.
  vtkMTimeType GetMTime() override;
  /// The input, too.
  void ShallowCopy(vtkAbstractMapper* mapper) override;
  ///@{
  /// As all of VTK's mappers have them.
  void Render(vtkRenderer* renderer, vtkActor* actor) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;
  ///@}
  /// Of cells.
  bool GetSupportsSelection() override { return true; }

protected:
  vtkTreeAMRIsosurfaceMapper();
  ~vtkTreeAMRIsosurfaceMapper() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;

  vtkNew<vtkContourValues> ContourValues;
  int IsosurfaceComponent = -1;
  unsigned int CompositeIndex = 1;
  int AmbientOcclusionSamples = 0;
  double AmbientOcclusionRadius = 0.05;
  bool Shadows = false;
  bool AutoAdjustSampleDistances = true;
  double ImageSampleDistance = 1.;
  double MinimumImageSampleDistance = 1.;
  double MaximumImageSampleDistance = 10.;
  double InteractiveRenderTime = 0.;
  double LevelOfDetail = 2.;

private:
  friend class treeamr::ActorLayers;      // takes the surfaces of several mappers together
  friend class vtkTreeAMRIsosurfaceActor; // draws with volumes, too
  struct Internals;

  vtkHyperTreeGrid* UpdateInput();
  void UpdateSurface(vtkHyperTreeGrid* grid);
  /// And the plan of this frame. False: there is nothing to draw.
  bool UpdateSurface(treeamr::SurfaceActorView& view);
  treeamr::MapperMessages& GetMessages();
  /// With the pose of this frame.
  treeamr::SurfaceActorView& FindView(vtkRenderer* renderer, vtkActor* actor, treeamr::SurfaceLayers layers);
  void UpdateHits(treeamr::SurfaceActorView& view, double distance, treeamr::Progress* progress);
  treeamr::SurfaceShader Light(treeamr::SurfaceActorView& view, treeamr::Progress* progress);
  void RecordFrame(treeamr::SurfaceActorView& view, double shadingSeconds);
  bool ReadDepthToFlatten(const treeamr::SurfaceActorView& view, bool hasAll, std::vector<float>& depth);
  void MakePicture(treeamr::SurfaceActorView& view, const std::vector<vtkActor*>& actors, bool hasAll,
    treeamr::Progress* progress);
  void RenderSurface(vtkRenderer* renderer, vtkActor* actor, treeamr::Progress* progress);
  /// When the renderer draws volumes: all surfaces that its translucent scene has, if this actor draws them.
  void RenderWithVolumes(vtkRenderer* renderer, vtkActor* actor);
  /// When it draws what is opaque: the same. False: that cannot be done then.
  bool RenderAfterOpaque(vtkRenderer* renderer, vtkActor* actor);
  void DrawLayers(vtkRenderer* renderer, vtkActor* actor, treeamr::Progress* progress);
  /// Watches what draws, and reports its errors.
  void Watch(vtkRenderer* renderer, const std::function<void(treeamr::Progress*)>& draw);
  void Select(treeamr::SurfaceActorView& view);

  std::unique_ptr<Internals> Private;

  vtkTreeAMRIsosurfaceMapper(const vtkTreeAMRIsosurfaceMapper&) = delete;
  void operator=(const vtkTreeAMRIsosurfaceMapper&) = delete;
};

#endif
