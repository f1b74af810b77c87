/**
 * @class   vtkTreeAMRVolumeMapper
 * @brief   ray-traces a vtkHyperTreeGrid as a volume on the CPU
 *
 * With linear interpolation the field is the generalized trilinear interpolation of the cells' values (see
 * Core/Interpolation): continuous across refinement levels, without resampling. A volume mapper like VTK's own: colours,
 * scalar opacity and its unit distance (in data units: a scaled volume looks the same) come from the vtkVolume's
 * vtkVolumeProperty, component 0; the array from SelectScalarArray() and ScalarMode. Without a selection it is the active
 * scalars or, when there are none, the first cell array.
 *
 * Composite blending, lit where the property's Shade asks for it, by normals that are continuous across levels, and with
 * its gradient opacity: a function of the change across the width of the finest cells, where VTK's is of that across an
 * image's spacing. Maximum, minimum and average intensity and additive blending as VTK's GPU mapper has them. Slices
 * (SetSliceFunction(), a vtkPlane in world coordinates): the colour and, whatever the unit distance, the opacity of the
 * value in the plane, lit as a composite is. Or isosurface blending: the surfaces of the property's GetIsoSurfaceValues()
 * (VTK's default is one, 0) alone, each coloured and as opaque as the functions are at its value, whatever the unit
 * distance, and shaded when the property is. With ShowIsosurfaces composite blending has them inside the volume, in one
 * pass and in their order.
 *
 * Several volumes of such mappers in a renderer are drawn when the first one is, each where it lies before or behind the
 * others, in depth peeling, too. Where they overlap their light is merged along the rays, in thin layers across the
 * direction of projection, and no error is estimated; where one of them blends values, the one whose centre is nearer is
 * before the other, which warns once. Volumes of VTK's own mappers come when VTK asks them.
 *
 * Opaque geometry in front, inside and behind is honoured through the depth buffer, translucent polygons
 * through dual depth peeling (vtkRenderer::UseDepthPeelingForVolumes). Where nothing is translucent but one such
 * volume and actors of vtkTreeAMRIsosurfaceMapper, the volume draws these with itself, each ray once through
 * everything, with and without depth peeling. Isosurfaces leave no depth. Clipping planes (world coordinates) and
 * cropping (regions of data coordinates) cut the volume and its own isosurfaces, at the planes and not at cells,
 * and what is cut away takes no time. What VTK's volume mappers do besides warns once when it is asked for.
 * Selections of cells and points pass through volumes; props alone are selected (vtkPropPicker) where the volume is seen.
 *
 * As with VTK's mappers the property's interpolation type says what is in between the cells' centres, and its default
 * is nearest: each cell shows its own value everywhere in it, by the gradient at its centre where it is lit. The
 * reconstructed field is what SetInterpolationTypeToLinear() asks for. Isosurfaces are of it in either case.
 *
 * A colour function with IndexedLookup makes categories of the values: each cell is drawn in the colour that
 * surfaces of its own value have, with the opacity function's opacity there, and nothing is interpolated.
 *
 * VolumeMapperRenderStartEvent and VolumeMapperRenderEndEvent come with each call of Render(), in frames that take
 * long VolumeMapperRenderProgressEvent and ProgressEvent twenty times a second, with the part of the present work that is
 * done: a frame may take several (isosurfaces, their occlusion, the volume). Meanwhile the window checks for aborts, and
 * vtkRenderWindow::SetAbortRender(1) by an observer of any of these ends the frame, of which nothing is kept. Where there
 * are several processes none aborts.
 *
 * What is unchanged is not made again: a camera costs one frame, a colour map a table of 4096 entries, an
 * array its conversion. While the render window asks for one frame a second or more (vtkRenderWindow::
 * SetDesiredUpdateRate(), as interactors do while the camera moves) the image is traced with as few rays as
 * fit the time; at lower rates it is always the full one. Needs an OpenGL window.
 */

#ifndef vtkTreeAMRVolumeMapper_h
#define vtkTreeAMRVolumeMapper_h

#include "vtkTreeAMRRenderingModule.h" // for the export macro
#include "vtkVolumeMapper.h"

#include <array>      // for std::array
#include <cstddef>    // for std::size_t
#include <functional> // for std::function
#include <memory>     // for std::unique_ptr
#include <optional>   // for std::optional
#include <string>     // for std::string
#include <vector>     // for std::vector

class vtkHyperTreeGrid;
class vtkVolumeProperty;
class vtkTable;
struct vtkTreeAMRRayImage;
struct vtkTreeAMRRaySegments;
namespace treeamr
{
struct ArraySelection;
class BoxPeers;
class BoxRelay;
class Field;
struct DraftSettings;
struct Image;
struct ImagePart;
struct MixedImage;
class Progress;
struct RayView;
struct VolumeLayer;
class VolumeRelay;
} // namespace treeamr

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRVolumeMapper : public vtkVolumeMapper
{
public:
  static vtkTreeAMRVolumeMapper* New();
  vtkTypeMacro(vtkTreeAMRVolumeMapper, vtkVolumeMapper);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  using Superclass::SetInputData;
  ///@{
  /// What is drawn; null: nothing is.
  void SetInputData(vtkHyperTreeGrid* grid);
  vtkHyperTreeGrid* GetHyperTreeGrid();
  ///@}

  /// What is drawn of arrays with several components, as in vtkSmartVolumeMapper.
  enum VectorModeType
  {
    DISABLED = -1,
    MAGNITUDE = 0,
    COMPONENT = 1
  };
  ///@{
  /// Whether an array with several components is drawn by its magnitude (default), by VectorComponent, or, DISABLED, two
  /// to four of them at once as VTK's GPU mapper draws them: each by the property's functions and unit distance of that
  /// component, mixed by ComponentWeight, and lit by its own gradients and coefficients unless the interpolation is nearest.
  /// With the property's IndependentComponents off, two are colour and
  /// opacity (see OpacityArrayName), and of four the last makes opaque by the functions of component 0 and its own unit
  /// distance, and the first three are the colour, each from the least to the largest of its values. Of composites and
  /// slices; not of categories.
  vtkSetClampMacro(VectorMode, int, DISABLED, COMPONENT);
  vtkGetMacro(VectorMode, int);
  ///@}
  ///@{
  /// Default 0.
  vtkSetMacro(VectorComponent, int);
  vtkGetMacro(VectorComponent, int);
  ///@}

  ///@{
  /// Cell array that makes the volume opaque, by the property's scalar opacity over its values; the colour remains that of
  /// the mapper's own array. Both need values in the same cells. Empty (default) is for one array. The same is drawn of
  /// the two components of an array when the property has IndependentComponents off, as VTK's mappers draw it:
  /// colour by the first one, opacity by the second over that component's unit distance. Of composites and slices; not of
  /// categories.
  void SetOpacityArrayName(const char* name);
  const char* GetOpacityArrayName() const { return this->OpacityArrayName.c_str(); }
  ///@}
  ///@{
  /// Of the array for opacity; -1 (default), and one beyond the last, is for the magnitude where there are several. Others
  /// are taken for it with a warning.
  vtkSetMacro(OpacityComponent, int);
  vtkGetMacro(OpacityComponent, int);
  ///@}

  ///@{
  /// Cell array whose values are the second axis of the property's TransferFunction2D, in TransferFunctionMode TF_2D, as in
  /// VTK's GPU mapper; both arrays need values in the same cells. Empty (default): the length of the drawn array's gradient
  /// is. Of composites and slices of one component or the magnitude, without OpacityArrayName; not of categories. Opacities
  /// are over component 0's unit distance, VTK's over each of its samples, whatever their distance.
  void SetTransfer2DYAxisArray(const char* name);
  const char* GetTransfer2DYAxisArray() const { return this->Transfer2DYAxisArray.c_str(); }
  ///@}
  ///@{
  /// Of that array, as OpacityComponent. Default 0, as VTK has it.
  vtkSetMacro(Transfer2DYAxisComponent, int);
  vtkGetMacro(Transfer2DYAxisComponent, int);
  ///@}
  ///@{
  /// Where the TransferFunction2D lies: from the least to the largest value of the first axis, then of the second one. An
  /// axis whose largest is below its least (default) has VTK's: the range of this process's values, and for gradients from 0
  /// to a quarter of that range across the width of the finest cells. (ParaView's ranks agree on these.)
  vtkSetVector4Macro(Transfer2DRange, double);
  vtkGetVector4Macro(Transfer2DRange, double);
  ///@}

  ///@{
  /// Samples of the field along one cell's width, from FewestSamplesPerCell to MostSamplesPerCell, where colour or opacity
  /// vary in the cell; fewer where little can change, but at least one in each cell, or block of eight cells of one size,
  /// that a ray crosses. Where the opacity function varies more than samples can follow its integral over each step is
  /// used. Default 2.
  virtual void SetSamplesPerCell(double value);
  vtkGetMacro(SamplesPerCell, double);
  static constexpr double FewestSamplesPerCell = 0.01;
  static constexpr double MostSamplesPerCell = 1024.;
  ///@}
  ///@{
  /// As of VTK's volume mappers: the longest distance, in the world, between samples of a ray, in whose place the
  /// widest cells have so many samples, and smaller ones as many, as SamplesPerCell has it (and within its limits).
  /// 0 or less (default) is for SamplesPerCell; so is LockSampleDistanceToInputSpacing (default off): cells are the
  /// spacing. TargetError comes before both.
  vtkSetMacro(SampleDistance, double);
  vtkGetMacro(SampleDistance, double);
  vtkSetMacro(LockSampleDistanceToInputSpacing, bool);
  vtkGetMacro(LockSampleDistanceToInputSpacing, bool);
  vtkBooleanMacro(LockSampleDistanceToInputSpacing, bool);
  ///@}
  ///@{
  /// Hides the rings that too few samples make in VTK's volume mappers. There are none here: each step has its integral.
  /// On warns once. Default off.
  vtkSetMacro(UseJittering, bool);
  vtkGetMacro(UseJittering, bool);
  vtkBooleanMacro(UseJittering, bool);
  ///@}
  ///@{
  /// As of VTK's volume mappers: the picture's colours from Level - Window / 2 to Level + Window / 2 become those from 0 to
  /// 1, in composites as much of them as covers what is behind. Window may be negative, but not 0. Default 1 and 0.5.
  vtkSetMacro(FinalColorWindow, double);
  vtkGetMacro(FinalColorWindow, double);
  vtkSetMacro(FinalColorLevel, double);
  vtkGetMacro(FinalColorLevel, double);
  ///@}
  ///@{
  /// Whether long frames tell their progress. They check for aborts in any case. Default on.
  vtkSetMacro(ReportProgress, bool);
  vtkGetMacro(ReportProgress, bool);
  vtkBooleanMacro(ReportProgress, bool);
  ///@}
  ///@{
  /// Memory in MiB to keep reconstructed values in from frame to frame, so that they are not computed
  /// again; 0 keeps none. While the volume is shaded or its opacity is by gradients, values may take
  /// twice as much, gradients four times.
  /// Only what was seen takes memory. Of several processes on one machine each has its share. Never changes a pixel.
  /// Default 512.
  virtual void SetVertexCacheSize(int value);
  vtkGetMacro(VertexCacheSize, int);
  ///@}
  ///@{
  /// Leave out subtrees that the opacity function makes transparent. Never changes a pixel. Default on.
  vtkSetMacro(SkipEmptySpace, bool);
  vtkGetMacro(SkipEmptySpace, bool);
  vtkBooleanMacro(SkipEmptySpace, bool);
  ///@}

  ///@{
  /// If on, the distance between rays is varied so that casting them takes the time allocated to the volume
  /// (controlled by the desired update rate of the window and any culling in use; but see
  /// InteractiveRenderTime), and interactive frames use LevelOfDetail. Frames of a window that asks for less
  /// than one frame a second have the minimum distance and full detail. If off, every frame is traced at
  /// ImageSampleDistance in full detail. Default on.
  vtkSetMacro(AutoAdjustSampleDistances, bool);
  vtkGetMacro(AutoAdjustSampleDistances, bool);
  vtkBooleanMacro(AutoAdjustSampleDistances, bool);
  ///@}
  ///@{
  /// Distance between rays in pixels, from 1 (default) to 100, while AutoAdjustSampleDistances is off: 1
  /// casts one ray a pixel, 2 one for every 4 (2 by 2) pixels. An image of fewer rays is magnified
  /// bilinearly.
  virtual void SetImageSampleDistance(double value);
  vtkGetMacro(ImageSampleDistance, double);
  ///@}
  ///@{
  /// The least distance that AutoAdjustSampleDistances chooses, and that of all still frames. Default 1.
  virtual void SetMinimumImageSampleDistance(double value);
  vtkGetMacro(MinimumImageSampleDistance, double);
  ///@}
  ///@{
  /// The greatest distance that AutoAdjustSampleDistances chooses. Default 10. A greater minimum takes its
  /// place.
  virtual void SetMaximumImageSampleDistance(double value);
  vtkGetMacro(MaximumImageSampleDistance, double);
  ///@}
  ///@{
  /// Seconds that casting the rays of an interactive frame may take. 0 (default) takes the time that VTK
  /// allocates: an equal share, or one by the area covered, for each prop, as if all of them cost alike.
  virtual void SetInteractiveRenderTime(double value);
  vtkGetMacro(InteractiveRenderTime, double);
  ///@}
  ///@{
  /// Interactive frames draw parts of the tree from means where its cells are smaller than this many pixels
  /// of the traced image. 0 is off, default 2. Still frames are always drawn from the cells.
  virtual void SetLevelOfDetail(double value);
  vtkGetMacro(LevelOfDetail, double);
  ///@}

  ///@{
  /// Whether still frames estimate how far they are from the converged picture: by integrating some of their
  /// pixels again, in less than 3 % of a frame's time from 500 x 500 pixels on. Root mean square over
  /// red, green and blue, premultiplied, peak 1, of all pixels of the renderer; of the integration along rays
  /// alone, not of what fewer rays than pixels leave out. Depth peeling draws a frame in parts, whose squared
  /// errors are added. Every process of a parallel program estimates its own image. Default off.
  vtkSetMacro(EstimateError, bool);
  vtkGetMacro(EstimateError, bool);
  vtkBooleanMacro(EstimateError, bool);
  ///@}
  ///@{
  /// The error, as EstimateError has it, that still frames may have: instead of SamplesPerCell they take the
  /// least samples from 0.25 to 64 that meet it, starting from those of the still frame before in the same
  /// renderer, or SamplesPerCell. A frame that misses the target is rendered again, at most twice; while
  /// peeling only the next one is better, and each part is held to the target. When 64 are too few the frame
  /// has the fewest that come about as close as any. Estimates look at more pixels for it, in a fifth to a third of
  /// a frame's time. 0 (default) is for SamplesPerCell.
  virtual void SetTargetError(double value);
  vtkGetMacro(TargetError, double);
  ///@}

  ///@{
  /// Whether composite blending shows the property's isosurfaces, too. Default off.
  vtkSetMacro(ShowIsosurfaces, bool);
  vtkGetMacro(ShowIsosurfaces, bool);
  vtkBooleanMacro(ShowIsosurfaces, bool);
  ///@}
  ///@{
  /// Whether isosurfaces are lit whatever vtkVolumeProperty::Shade says of the volume. Default off: as the volume.
  vtkSetMacro(ShadeIsosurfaces, bool);
  vtkGetMacro(ShadeIsosurfaces, bool);
  vtkBooleanMacro(ShadeIsosurfaces, bool);
  ///@}
  ///@{
  /// Factor of the isosurfaces' opacities, which end at 1: a function that suits a volume may leave surfaces
  /// faint. Default 1.
  virtual void SetIsosurfaceOpacityScale(double value);
  vtkGetMacro(IsosurfaceOpacityScale, double);
  ///@}
  ///@{
  /// Of the isosurfaces, where the property is shaded and there is light: what vtkTreeAMRIsosurfaceMapper has by these
  /// names, with its defaults and limits. The volume neither darkens nor is darkened.
  virtual void SetAmbientOcclusionSamples(int value);
  vtkGetMacro(AmbientOcclusionSamples, int);
  virtual void SetAmbientOcclusionRadius(double value);
  vtkGetMacro(AmbientOcclusionRadius, double);
  vtkSetMacro(Shadows, bool);
  vtkGetMacro(Shadows, bool);
  vtkBooleanMacro(Shadows, bool);
  ///@}

  ///@{
  /// Scattered light of a shaded volume, with shadows of the volume on itself, as of vtkGPUVolumeRayCastMapper (limits and
  /// defaults, too): how much of its light it is, from 0 (default: none) over 1 (least where it is opaque) to 2 (all); and
  /// how far shadows reach, from 0 (default: hardly) to 1 (all through the volume). The property's ScatteringAnisotropy
  /// counts. Of composites and slices; shadows are as sharp as a 96th of the longest edge of the data's bounds, and of what
  /// this process holds.
  vtkSetClampMacro(VolumetricScatteringBlending, float, 0.f, 2.f);
  vtkGetMacro(VolumetricScatteringBlending, float);
  vtkSetClampMacro(GlobalIlluminationReach, float, 0.f, 1.f);
  vtkGetMacro(GlobalIlluminationReach, float);
  ///@}

  /// What there is, and what the last frame did: one row with these columns. Counts and bytes are 64-bit
  /// integers, the rest doubles; all are 0 before the first Render().
  ///   Cells, OctreeBytes: of the field in use; octree, values, means and ranges
  ///   KeptBytes: allocated for values that are kept between frames
  ///   Rays, Nodes: rays cast, inner nodes entered
  ///   KeptBlocks, ReconstructedBlocks, ReconstructedCells: blocks of cells whose vertex values were found
  ///     kept or computed, and cells in the latter
  ///   Intervals, Samples: groups of rays taken through a cell or block, samples along rays
  ///   SurfaceBytes, SurfaceHits: of the isosurfaces in use, and of rays with them
  ///   ImageSampleDistance: pixels between rays
  ///   LevelOfDetail: pixels, 0 when it was off
  ///   SamplesPerCell: that the frame was rendered with
  ///   EstimatedError: of the frame, -1 when it was not estimated
  ///   FieldSeconds: the conversion to the field in use, when it was made (next to none when another mapper
  ///     had made it before)
  ///   TransferFunctionSeconds: the table in use, when it was made
  ///   RayCastingSeconds, ErrorSeconds, CompositingSeconds: the frame's; for rays (also of a frame that missed
  ///     the target), for the estimate and the choice of samples, and for reading depths, which waits for what
  ///     OpenGL had to draw before, and drawing the image
  /// Belongs to the mapper, which fills it in when asked.
  vtkTable* GetStatistics();
  /// Of many processes that draw one picture, before each frame and on all: makes drafts as coarse as the slowest one
  /// needs. largest(numbers): makes each number the largest of all processes'.
  void AgreeOnDrafts(
    vtkRenderer* renderer, vtkVolume* volume, const std::function<void(std::array<double, 3>&)>& largest);
  /// Of the same, and as often: who draws the other boxes of the grid, so that frames of all are that of one process alone
  /// (Partition/BoxRelay.h). Null (default): nobody, each process draws by itself.
  void SetPeers(std::shared_ptr<treeamr::BoxPeers> peers);
  /// Of the same, and as often: the ranges by default of Transfer2DRange become those of all processes' values.
  void AgreeOnTransfer2DRange(vtkVolume* volume, const std::function<void(std::array<double, 3>&)>& largest);
  ///@{
  /// Modification times of the field and of the transfer function's table in use; 0 before the first.
  vtkMTimeType GetFieldBuildTime();
  vtkMTimeType GetTransferFunctionBuildTime();
  ///@}
  /// Modification time of the isosurfaces in use; 0 before the first.
  vtkMTimeType GetIsosurfaceBuildTime();

  /// The first point on the line from p1 to p2 (data coordinates), between the fractions t1 and t2 of it and in the
  /// cropping regions, where the volume's scalar opacity (of a TransferFunction2D the largest for the value) is at least
  /// `opacity`, found in steps of an eighth of a cell: its fraction t, the normal towards lower values or of the face
  /// entered (of any length; 0: there is none) and the value of the drawn array; returns the cell's index in the cell
  /// arrays. -1: there is none, or it failed, as the next frame tells. For vtkTreeAMRPicker.
  vtkIdType IntersectWithLine(vtkVolume* volume, const double p1[3], const double p2[3], double t1, double t2,
    double opacity, double& t, double normal[3], double& value);

  ///@{
  /// Bounds of the trees that this process holds, and with peers of its box; uninitialised without input.
  double* GetBounds() VTK_SIZEHINT(6) override;
  void GetBounds(double bounds[6]) override { this->Superclass::GetBounds(bounds); }
  ///@}

  /// The input, too.
  void ShallowCopy(vtkAbstractMapper* mapper) override;
  ///@{
  /// As all of VTK's mappers have them.
  void Render(vtkRenderer* renderer, vtkVolume* volume) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;
  ///@}

protected:
  vtkTreeAMRVolumeMapper();
  ~vtkTreeAMRVolumeMapper() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;

  int VectorMode = MAGNITUDE;
  int VectorComponent = 0;
  std::string OpacityArrayName;
  int OpacityComponent = -1;
  std::string Transfer2DYAxisArray;
  int Transfer2DYAxisComponent = 0;
  double Transfer2DRange[4] = { 0., -1., 0., -1. };
  double SamplesPerCell = 2.;
  double SampleDistance = 0.;
  bool LockSampleDistanceToInputSpacing = false;
  bool UseJittering = false;
  double FinalColorWindow = 1.;
  double FinalColorLevel = 0.5;
  bool ReportProgress = true;
  bool SkipEmptySpace = true;
  int VertexCacheSize; // defaultKeptBytes
  bool AutoAdjustSampleDistances = true;
  double ImageSampleDistance = 1.;
  double MinimumImageSampleDistance = 1.;
  double MaximumImageSampleDistance = 10.;
  double InteractiveRenderTime = 0.;
  double LevelOfDetail = 2.;
  bool EstimateError = false;
  double TargetError = 0.;
  bool ShowIsosurfaces = false;
  bool ShadeIsosurfaces = false;
  double IsosurfaceOpacityScale = 1.;
  int AmbientOcclusionSamples = 0;
  double AmbientOcclusionRadius = 0.05;
  bool Shadows = false;
  float VolumetricScatteringBlending = 0.f;
  float GlobalIlluminationReach = 0.f;

private:
  struct Internals;
  struct Picture;

  void CheckSettings();
  void WarnOfSettings(vtkVolume* volume);
  bool ShowsVolume() const;
  treeamr::ArraySelection SelectArray();
  /// What the array's components are.
  enum class Components
  {
    One,  // is drawn, or their magnitude
    Pair, // of colour and opacity
    RGBA,
    Independent
  };
  Components GetComponents(vtkVolume* volume);
  /// Whose unit distance the property's opacities are over.
  int GetComponentOfUnitDistance() const;
  /// Whether other arrays can take part in what is drawn.
  bool CanMix(vtkVolume* volume);
  /// Those beside the volume's own field.
  std::vector<std::shared_ptr<const treeamr::Field>> AcquireComponents(
    Components components, const treeamr::ArraySelection& own, const treeamr::Field& field);
  void MixComponents(vtkVolumeProperty* property);
  /// Whether the property's function of two values is seen.
  bool ReadsTable(vtkVolume* volume);
  /// Null when the second one is no array's.
  std::shared_ptr<const treeamr::Field> AcquireTableField(
    bool readsTable, const treeamr::ArraySelection& own, const treeamr::Field& field);
  /// Less the fields' offsets.
  std::array<double, 4> GetTableRange() const;
  /// As Transfer2DRange.
  std::array<double, 4> GetTableRangeOfData() const;
  ///@{
  /// What a volume shows, which is made where there is none. property: null is for nothing.
  void SetFunctions(vtkVolumeProperty* property, std::size_t keptBytes);
  void SetTable(vtkVolumeProperty* property, std::size_t keptBytes);
  ///@}
  treeamr::ArraySelection SelectComponent(const std::string& setting, const std::string& name, int component);
  /// Of what makes the volume opaque, when that is not the array itself.
  std::optional<treeamr::ArraySelection> SelectOpacity(vtkVolume* volume);
  void UpdateField(vtkVolume* volume);
  void UpdateVolume(vtkVolume* volume);
  void UpdateIsosurfaces(vtkRenderer* renderer, vtkVolume* volume);
  /// False: it failed, and has been reported.
  bool PrepareVolume(vtkRenderer* renderer, vtkVolume* volume);
  treeamr::DraftSettings GetDraftSettings() const;
  void RecordLastFrame();
  double GetFrameSamplesPerCell(vtkVolume* volume);
  void StartFrame(const Picture& picture);
  void TraceSurfaces(Picture& picture);
  void CastRays(const treeamr::RayView& view, bool isPart, treeamr::BoxRelay* relay, treeamr::Image& image);
  void Composite(Picture& picture, const vtkTreeAMRRaySegments& rays, const treeamr::ImagePart& part,
    treeamr::Image& image);
  vtkTreeAMRRayImage Trace(Picture& picture, const vtkTreeAMRRaySegments& pixels);
  struct Pictures;
  static vtkTreeAMRVolumeMapper* MapperOf(const Picture& picture);
  void StartFrames(const Pictures& pictures);
  static void PrepareShared(const Pictures& pictures, Picture& picture);
  static treeamr::MixedImage TraceLayer(const Pictures& pictures, const treeamr::VolumeLayer& layer,
    const vtkTreeAMRRaySegments& rays, const treeamr::ImagePart& part);
  vtkTreeAMRRayImage TraceLayers(const Pictures& pictures, const vtkTreeAMRRaySegments& pixels);
  vtkTreeAMRRayImage TraceAll(const Pictures& pictures, const vtkTreeAMRRaySegments& pixels);
  void DrawPeeled(const Pictures& pictures);
  void DrawOver(const Pictures& pictures);
  /// For a selector of props alone.
  void SelectProp(vtkRenderer* renderer, vtkVolume* volume);
  /// False: there was nothing left to draw.
  bool RenderVolume(
    vtkRenderer* renderer, vtkVolume* volume, treeamr::VolumeRelay& relay, treeamr::Progress* progress);

  std::unique_ptr<Internals> Private;

  vtkTreeAMRVolumeMapper(const vtkTreeAMRVolumeMapper&) = delete;
  void operator=(const vtkTreeAMRVolumeMapper&) = delete;
};

#endif
