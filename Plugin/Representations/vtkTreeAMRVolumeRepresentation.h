// Direct volume rendering of a vtkHyperTreeGrid in ParaView's render view, by vtkTreeAMRVolumeMapper.
//
// Not a vtkVolumeRepresentation: its vtkPVLODVolume refuses to render a mapper whose input is no vtkDataSet.
//
// While the camera moves the view renders interactively, with drafts; the last one stays in the window until the
// still frame is there. None comes between the two: when the camera stops, ParaView renders once, and again only
// in programs that were started with streaming enabled.

#ifndef vtkTreeAMRVolumeRepresentation_h
#define vtkTreeAMRVolumeRepresentation_h

#include "vtkNew.h" // for members
#include "vtkTreeAMRRepresentation.h"
#include "vtkTreeAMRVolumeMapper.h" // for forwarding
#include "vtkVolumeProperty.h"      // for forwarding

#include <memory> // for Peers

class RankPeers;
class vtkColorTransferFunction;
class vtkImplicitFunction;
class vtkPVTransferFunction2D;
class vtkPiecewiseFunction;
class vtkVolume;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkTreeAMRVolumeRepresentation : public vtkTreeAMRRepresentation
{
public:
  static vtkTreeAMRVolumeRepresentation* New();
  vtkTypeMacro(vtkTreeAMRVolumeRepresentation, vtkTreeAMRRepresentation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// Colours and opacities of the array chosen in the Coloring section. While none is chosen, the last that was is
  /// drawn; before, the first array of the grid, from blue to red and from transparent to opaque over its range.
  void SetColor(vtkColorTransferFunction* colors);
  void SetScalarOpacity(vtkPiecewiseFunction* opacities);
  ///@}

  /// The length over which an opacity of the transfer function accumulates; 0 or less: a tenth of the data's longest
  /// side.
  void SetScalarOpacityUnitDistance(double distance) { this->UnitDistance = distance; }
  ///@{
  /// What rays make of the volume, and surfaces of the drawn array's values, alone (vtkVolumeMapper::ISOSURFACE_BLEND)
  /// or inside a composite; see vtkTreeAMRVolumeMapper.
  void SetBlendMode(int mode) { this->Mapper->SetBlendMode(mode); }
  void SetSliceFunction(vtkImplicitFunction* function) { this->Property->SetSliceFunction(function); }
  void SetShowIsosurfaces(bool show) { this->Mapper->SetShowIsosurfaces(show); }
  void SetNumberOfIsosurfaces(int number);
  void SetIsosurfaceValue(int index, double value);
  void SetIsosurfaceOpacityScale(double scale) { this->Mapper->SetIsosurfaceOpacityScale(scale); }
  void SetShadeIsosurfaces(bool shade) { this->Mapper->SetShadeIsosurfaces(shade); }
  void SetAmbientOcclusionSamples(int samples) { this->Mapper->SetAmbientOcclusionSamples(samples); }
  void SetAmbientOcclusionRadius(double radius) { this->Mapper->SetAmbientOcclusionRadius(radius); }
  void SetShadows(bool shadows) { this->Mapper->SetShadows(shadows); }
  ///@}
  /// vtkVolumeProperty's: whether cells show their own values alone (0) or a field that is continuous (1, default).
  void SetInterpolationType(int type);
  ///@{
  /// The light of the volume, and of its isosurfaces.
  void SetShade(bool shade) { this->Property->SetShade(shade); }
  void SetAnisotropy(float anisotropy) { this->Property->SetScatteringAnisotropy(anisotropy); }
  void SetVolumetricScatteringBlending(float blending)
  {
    this->Mapper->SetVolumetricScatteringBlending(blending);
  }
  void SetGlobalIlluminationReach(float reach) { this->Mapper->SetGlobalIlluminationReach(reach); }
  void SetAmbient(double coefficient) { this->Property->SetAmbient(coefficient); }
  void SetDiffuse(double coefficient) { this->Property->SetDiffuse(coefficient); }
  void SetSpecular(double coefficient) { this->Property->SetSpecular(coefficient); }
  void SetSpecularPower(double power) { this->Property->SetSpecularPower(power); }
  ///@}
  ///@{
  /// As ParaView's Volume: opacity by another array than the one that colours. component: that of the array, -1 for the
  /// magnitude.
  void SetUseSeparateOpacityArray(bool use) { this->UsesOpacityArray = use; }
  void SelectOpacityArray(int index, int port, int connection, int association, const char* name);
  void SelectOpacityArrayComponent(int component) { this->Mapper->SetOpacityComponent(component); }
  ///@}
  ///@{
  /// As ParaView's Volume: colours and opacities by two values, the second one the length of the gradient (default) or an
  /// array's; component: as SelectOpacityArrayComponent(). The opacity array has no effect then.
  void SetTransferFunction2D(vtkPVTransferFunction2D* function);
  void SetUseTransfer2D(bool use) { this->UsesTransfer2D = use; }
  void SetUseGradientForTransfer2D(bool use) { this->UsesGradient = use; }
  void SelectColorArray2(int index, int port, int connection, int association, const char* name);
  void SelectColorArray2Component(int component) { this->Mapper->SetTransfer2DYAxisComponent(component); }
  ///@}
  ///@{
  /// As ParaView's Volume: whether two components of an array are colour and opacity, and four are these themselves, but
  /// for the function of the opacity: with MultiComponentsMapping on (default off), or MapScalars off (default on).
  /// For arrays of other numbers of components neither has an effect, which a warning tells.
  void SetMapScalars(bool map) { this->MapsScalars = map; }
  void SetMultiComponentsMapping(bool map) { this->MapsComponents = map; }
  ///@}
  /// Samples along each cell's width.
  void SetSamplesPerCell(double samples) { this->Mapper->SetSamplesPerCell(samples); }
  ///@{
  /// The error of still frames; see vtkTreeAMRVolumeMapper.
  void SetEstimateError(bool estimate) { this->Mapper->SetEstimateError(estimate); }
  void SetTargetError(double error) { this->Mapper->SetTargetError(error); }
  ///@}
  ///@{
  /// Of the last frame on this process: its error, -1 when it was not estimated, and the seconds it took.
  double GetEstimatedError();
  double GetFrameSeconds();
  ///@}
  ///@{
  /// Of what was drawn there last: the cells, the levels of the grid, MiB of octree, values, kept values and isosurfaces,
  /// and the samples that the frame took. 0 before.
  double GetDrawnCells() { return this->GetStatistic("Cells"); }
  int GetDrawnLevels();
  double GetMemory();
  double GetFrameSamples() { return this->GetStatistic("Samples"); }
  ///@}
  ///@{
  /// As ParaView's Volume: draws what is in the box of the data's bounds, scaled about the origin of data coordinates
  /// and then moved. Default off.
  void SetCropping(bool crop);
  void SetCroppingOrigin(double x, double y, double z);
  void SetCroppingScale(double x, double y, double z);
  ///@}
  /// Memory in MiB for values kept from frame to frame.
  void SetVertexCacheSize(int size) { this->Mapper->SetVertexCacheSize(size); }
  ///@{
  /// Fewer rays while the camera moves; see vtkTreeAMRVolumeMapper.
  void SetAutoAdjustSampleDistances(bool adjust) { this->Mapper->SetAutoAdjustSampleDistances(adjust); }
  void SetImageSampleDistance(double distance) { this->Mapper->SetImageSampleDistance(distance); }
  void SetMinimumImageSampleDistance(double distance)
  {
    this->Mapper->SetMinimumImageSampleDistance(distance);
  }
  void SetMaximumImageSampleDistance(double distance)
  {
    this->Mapper->SetMaximumImageSampleDistance(distance);
  }
  void SetInteractiveRenderTime(double seconds) { this->Mapper->SetInteractiveRenderTime(seconds); }
  void SetLevelOfDetail(double pixels) { this->Mapper->SetLevelOfDetail(pixels); }
  ///@}

protected:
  vtkTreeAMRVolumeRepresentation();
  ~vtkTreeAMRVolumeRepresentation() override;

  vtkProp3D* GetProp() override;
  bool NeedsOrderedCompositing() override { return true; }
  void UpdateFromAllRanks() override;
  std::set<std::string> GetShownArrays() override;
  std::vector<double> GetDraftedIsovalues() override;
  void UpdateMapper(vtkAlgorithmOutput* grid) override;
  void AgreeOnDrafts(vtkRenderer* renderer, const Largest& largest) override
  {
    this->Mapper->AgreeOnTransfer2DRange(this->Volume, largest);
    this->Mapper->AgreeOnDrafts(renderer, this->Volume, largest);
  }
  void FindPeers(vtkMultiProcessController* controller, bool draws) override;

private:
  vtkTreeAMRVolumeRepresentation(const vtkTreeAMRVolumeRepresentation&) = delete;
  void operator=(const vtkTreeAMRVolumeRepresentation&) = delete;

  bool HasSurfaces();
  /// Of cells, in a property of this name.
  std::string TakeCellArray(const char* property, int association, const char* name);
  double GetStatistic(const char* name);

  std::shared_ptr<RankPeers> Peers; // null: there are none
  double UnitDistance = 0.;
  bool UsesOpacityArray = false;
  bool UsesTransfer2D = false;
  bool UsesGradient = true;
  bool MapsScalars = true;
  std::string MappedInVain; // array of which that was said
  bool MapsComponents = false;
  std::string OpacityArray;
  std::string SecondArray; // of TransferFunction2D
  double CroppingOrigin[3] = { 0., 0., 0. };
  double CroppingScale[3] = { 1., 1., 1. };
  double DataBounds[6] = { 0., 0., 0., 0., 0., 0. }; // of all ranks' grids
  vtkNew<vtkVolume> Volume;
  vtkNew<vtkVolumeProperty> Property;
  vtkNew<vtkTreeAMRVolumeMapper> Mapper;
  vtkSmartPointer<vtkColorTransferFunction> Color;
  vtkSmartPointer<vtkPiecewiseFunction> ScalarOpacity;
  struct
  {
    std::string Array;
    vtkSmartPointer<vtkColorTransferFunction> Color;
    vtkSmartPointer<vtkPiecewiseFunction> ScalarOpacity;
  } Chosen;
  std::string DefaultArrayName;
  double DefaultRange[2] = { 0., 0. };
  vtkNew<vtkColorTransferFunction> DefaultColor;
  vtkNew<vtkPiecewiseFunction> DefaultScalarOpacity;
};

#endif
