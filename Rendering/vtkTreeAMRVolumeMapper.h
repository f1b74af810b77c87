/**
 * @class   vtkTreeAMRVolumeMapper
 * @brief   ray-traces a vtkHyperTreeGrid as a volume on the CPU
 *
 * The field is the generalized trilinear interpolation of the cells' values (see Core/Interpolation):
 * continuous across refinement levels, without resampling. A volume mapper like VTK's own: colours, scalar
 * opacity and its unit distance (in world units) come from the vtkVolume's vtkVolumeProperty, component 0;
 * the array from SelectScalarArray() and ScalarMode. Without a selection it is the active scalars or, when
 * there are none, the first cell array.
 *
 * Composite blending only. Opaque geometry in front, inside and behind is honoured through the depth buffer,
 * translucent polygons through dual depth peeling (vtkRenderer::UseDepthPeelingForVolumes). Shading, gradient
 * opacity, cropping and clipping planes are not implemented; cropping and clipping warn. Volumes do not take
 * part in hardware selection.
 *
 * What is unchanged is not made again: a camera costs one frame, a colour map a table of 4096 entries, an
 * array its conversion. Needs an OpenGL window.
 */

#ifndef vtkTreeAMRVolumeMapper_h
#define vtkTreeAMRVolumeMapper_h

#include "vtkTreeAMRRenderingModule.h" // for the export macro
#include "vtkVolumeMapper.h"

#include <memory> // for std::unique_ptr

class vtkHyperTreeGrid;

class VTKTREEAMRRENDERING_EXPORT vtkTreeAMRVolumeMapper : public vtkVolumeMapper
{
public:
  static vtkTreeAMRVolumeMapper* New();
  vtkTypeMacro(vtkTreeAMRVolumeMapper, vtkVolumeMapper);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  using Superclass::SetInputData;
  void SetInputData(vtkHyperTreeGrid* grid);
  vtkHyperTreeGrid* GetHyperTreeGrid();

  /// Scalar of arrays with several components, as in vtkSmartVolumeMapper.
  enum VectorModeType
  {
    MAGNITUDE = 0,
    COMPONENT = 1
  };
  ///@{
  /// Whether an array with several components is drawn by its magnitude (default) or by VectorComponent.
  vtkSetClampMacro(VectorMode, int, MAGNITUDE, COMPONENT);
  vtkGetMacro(VectorMode, int);
  ///@}
  ///@{
  /// Default 0.
  vtkSetMacro(VectorComponent, int);
  vtkGetMacro(VectorComponent, int);
  ///@}

  ///@{
  /// Samples of the field along one cell's width, above 0; every ray takes at least one in each cell that it
  /// crosses. Default 2.
  vtkSetMacro(SamplesPerCell, double);
  vtkGetMacro(SamplesPerCell, double);
  ///@}
  ///@{
  /// Memory in MiB to keep reconstructed values in from frame to frame, so that they are not computed
  /// again; 0 keeps none. Only what was seen takes memory. Never changes a pixel. Default 512.
  vtkSetClampMacro(VertexCacheSize, int, 0, VTK_INT_MAX);
  vtkGetMacro(VertexCacheSize, int);
  ///@}
  ///@{
  /// Leave out subtrees that the opacity function makes transparent. Never changes a pixel. Default on.
  vtkSetMacro(SkipEmptySpace, bool);
  vtkGetMacro(SkipEmptySpace, bool);
  vtkBooleanMacro(SkipEmptySpace, bool);
  ///@}

  ///@{
  /// What the last Render() did: inner nodes of the octree entered, cells whose values were reconstructed
  /// (not found kept) and samples along rays.
  vtkGetMacro(LastNumberOfNodes, vtkIdType);
  vtkGetMacro(LastNumberOfCells, vtkIdType);
  vtkGetMacro(LastNumberOfSamples, vtkIdType);
  ///@}
  ///@{
  /// Cells of the field in use, bytes of its octree, values, means and ranges, and wall-clock seconds that
  /// the conversion took when the array was last acquired (next to none when another mapper had made it); 0
  /// before the first Render().
  vtkIdType GetNumberOfCells();
  vtkTypeUInt64 GetOctreeBytes();
  vtkGetMacro(BuildSeconds, double);
  ///@}
  ///@{
  /// Modification times of the field and of the transfer function's table in use; 0 before the first.
  vtkMTimeType GetFieldBuildTime();
  vtkMTimeType GetTransferFunctionBuildTime();
  ///@}

  /// Bounds of the trees that this process holds; uninitialised without input.
  double* GetBounds() VTK_SIZEHINT(6) override;
  void GetBounds(double bounds[6]) override { this->Superclass::GetBounds(bounds); }

  void Render(vtkRenderer* renderer, vtkVolume* volume) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

protected:
  vtkTreeAMRVolumeMapper();
  ~vtkTreeAMRVolumeMapper() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;

  int VectorMode = MAGNITUDE;
  int VectorComponent = 0;
  double SamplesPerCell = 2.;
  bool SkipEmptySpace = true;
  int VertexCacheSize = 512;
  vtkIdType LastNumberOfNodes = 0;
  vtkIdType LastNumberOfCells = 0;
  vtkIdType LastNumberOfSamples = 0;
  double BuildSeconds = 0.;

private:
  struct Internals;

  void CheckSettings();
  void UpdateField();
  void UpdateVertexCache();
  void UpdateTransferFunction(vtkVolume* volume);
  void RenderVolume(vtkRenderer* renderer, vtkVolume* volume);
  void Report(const char* message, vtkVolume* volume);

  std::unique_ptr<Internals> Private;

  vtkTreeAMRVolumeMapper(const vtkTreeAMRVolumeMapper&) = delete;
  void operator=(const vtkTreeAMRVolumeMapper&) = delete;
};

#endif
