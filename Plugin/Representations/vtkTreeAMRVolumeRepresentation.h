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

class vtkColorTransferFunction;
class vtkPiecewiseFunction;
class vtkTreeAMRVolumeMapper;
class vtkVolume;
class vtkVolumeProperty;

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

  /// The length over which an opacity of the transfer function accumulates.
  void SetScalarOpacityUnitDistance(double distance);
  ///@{
  /// Surfaces of the drawn array's values, alone (vtkVolumeMapper::ISOSURFACE_BLEND) or inside the volume; see
  /// vtkTreeAMRVolumeMapper.
  void SetBlendMode(int mode);
  void SetShowIsosurfaces(bool show);
  void SetNumberOfIsosurfaces(int number);
  void SetIsosurfaceValue(int index, double value);
  void SetIsosurfaceOpacityScale(double scale);
  void SetShade(bool shade);
  void SetAmbient(double coefficient);
  void SetDiffuse(double coefficient);
  void SetSpecular(double coefficient);
  void SetSpecularPower(double power);
  ///@}
  /// Samples along each cell's width.
  void SetSamplesPerCell(double samples);
  ///@{
  /// The error of still frames; see vtkTreeAMRVolumeMapper.
  void SetEstimateError(bool estimate);
  void SetTargetError(double error);
  ///@}
  ///@{
  /// Of the last frame on this process: its error, -1 when it was not estimated, and the seconds it took.
  double GetEstimatedError();
  double GetFrameSeconds();
  ///@}
  ///@{
  /// As ParaView's Volume: draws what is in the box of the data's bounds, scaled about the origin of data coordinates
  /// and then moved. Default off.
  void SetCropping(bool crop);
  void SetCroppingOrigin(double x, double y, double z);
  void SetCroppingScale(double x, double y, double z);
  ///@}
  /// Memory in MiB for values kept from frame to frame.
  void SetVertexCacheSize(int size);
  ///@{
  /// Fewer rays while the camera moves; see vtkTreeAMRVolumeMapper.
  void SetAutoAdjustSampleDistances(bool adjust);
  void SetImageSampleDistance(double distance);
  void SetMinimumImageSampleDistance(double distance);
  void SetMaximumImageSampleDistance(double distance);
  void SetInteractiveRenderTime(double seconds);
  void SetLevelOfDetail(double pixels);
  ///@}

protected:
  vtkTreeAMRVolumeRepresentation();
  ~vtkTreeAMRVolumeRepresentation() override;

  vtkProp3D* GetProp() override;
  bool NeedsOrderedCompositing() override { return true; }
  void UpdateFromAllRanks() override;
  std::vector<double> GetDraftedIsovalues() override;
  void UpdateMapper(vtkAlgorithmOutput* grid) override;

private:
  vtkTreeAMRVolumeRepresentation(const vtkTreeAMRVolumeRepresentation&) = delete;
  void operator=(const vtkTreeAMRVolumeRepresentation&) = delete;

  bool HasSurfaces();
  void UpdateShade();

  bool Shade = true; // the isosurfaces
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
