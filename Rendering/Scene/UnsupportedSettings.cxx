#include "UnsupportedSettings.h"

#include "NewerSettings.h"
#include "VolumeEffects.h"

#include "vtkActor.h"
#include "vtkMapper.h"
#include "vtkPlaneCollection.h"
#include "vtkProperty.h"
#include "vtkShaderProperty.h"
#include "vtkTexture.h"
#include "vtkVolume.h"
#include "vtkVolumeMapper.h"
#include "vtkVolumeProperty.h"

#include <initializer_list>

namespace treeamr
{

namespace
{

struct Setting
{
  std::string name;
  bool isSet;
};

SettingNames namesOf(std::initializer_list<Setting> settings)
{
  SettingNames names;
  for (const Setting& setting : settings)
  {
    if (setting.isSet)
    {
      names.push_back(setting.name);
    }
  }
  return names;
}

bool hasShaderCode(vtkProp* prop)
{
  vtkShaderProperty* shaders = prop->GetShaderProperty();
  return shaders->HasVertexShaderCode() || shaders->HasGeometryShaderCode() ||
    shaders->HasFragmentShaderCode() || shaders->GetNumberOfShaderReplacements() > 0;
}

template <class IsSet>
bool anyComponent(int first, const IsSet& isSet)
{
  bool any = false;
  for (int i = first; i < VTK_MAX_VRCOMP; ++i)
  {
    any = any || isSet(i);
  }
  return any;
}

} // namespace

SettingNames unsupportedSettings(vtkVolume* volume, vtkVolumeMapper* mapper, const DrawnVolume& drawn)
{
  vtkVolumeProperty* property = volume->GetProperty();
  // Asking for functions that were never set would make them; colours tell by their channels.
  const bool hasSecondComponent = anyComponent(1, [&](int i) { return property->GetColorChannels(i) != 1; });
  const bool hasWeights = anyComponent(0, [&](int i) { return property->GetComponentWeight(i) != 1.; });
  const std::string ofComponents = "needed are VectorMode DISABLED, IndependentComponents on, an array of 2 "
                                   "to 4 components that is no category, a "
                                   "composite or slice BlendMode and no OpacityArrayName";
  const int blend = mapper->GetBlendMode();
  const bool hasOtherBlend =
    blend != vtkVolumeMapper::COMPOSITE_BLEND && blend != vtkVolumeMapper::SLICE_BLEND;
  return namesOf({
    { "Shade of categories", property->GetShade() && drawn.categories && !drawn.surfaces },
    { "ComputeNormalFromOpacity", computesNormalFromOpacity(*mapper) },
    { "GradientOpacity of categories", hasGradientOpacity(property) && drawn.categories },
    { "Shade of independent components with InterpolationType Nearest",
      property->GetShade() && drawn.independent &&
        property->GetInterpolationType() == VTK_NEAREST_INTERPOLATION },
    { "GradientOpacity of independent components", hasGradientOpacity(property) && drawn.independent },
    { "GradientOpacity with the maximum BlendMode",
      hasGradientOpacity(property) && mapper->GetBlendMode() == vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND },
    { "InterpolationType Nearest of isosurfaces: without effect, they are those of the continuous field",
      property->GetInterpolationType() == VTK_NEAREST_INTERPOLATION &&
        mapper->GetBlendMode() == vtkVolumeMapper::ISOSURFACE_BLEND },
    { "ShowIsosurfaces with a BlendMode of values", blendsValues(mapper) && drawn.surfaces },
    { "TransferFunctionMode TF_2D: without effect, needed are a TransferFunction2D, an array that is no "
      "category and "
      "of which one component or the magnitude is drawn, a composite or slice BlendMode and no "
      "OpacityArrayName",
      property->GetTransferFunctionMode() == vtkVolumeProperty::TF_2D && !drawn.table },
    { "IndependentComponents off: without effect, needed is an array of 2 components (colour, opacity) or 4 "
      "(red, "
      "green, blue, opacity) that is no category, a composite or slice BlendMode and no OpacityArrayName",
      !property->GetIndependentComponents() && !drawn.dependent },
    { "SetColor(1, ...): without effect, " + ofComponents, hasSecondComponent && !drawn.independent },
    { "ComponentWeight: without effect, " + ofComponents, hasWeights && !drawn.independent },
    { "LabelColor, LabelScalarOpacity, LabelGradientOpacity", property->GetNumberOfLabels() > 0 },
    { "UseClippedVoxelIntensity", property->GetUseClippedVoxelIntensity() != 0 },
    { "ScatteringAnisotropy: without effect, needed are Shade and VolumetricScatteringBlending",
      scatteringAnisotropy(*property) != 0.f && !(drawn.scatters && property->GetShade()) },
    { "VolumetricScatteringBlending: without effect, needed is Shade", drawn.scatters && !property->GetShade() },
    { "VolumetricScatteringBlending of independent components",
      drawn.scatters && property->GetShade() && drawn.independent },
    { "VolumetricScatteringBlending with TransferFunctionMode TF_2D",
      drawn.scatters && property->GetShade() && drawn.table },
    { "VolumetricScatteringBlending of BlendModes but composite and slice",
      drawn.scatters && property->GetShade() && hasOtherBlend },
    { "ShaderProperty", hasShaderCode(volume) },
  });
}

SettingNames unsupportedSettings(vtkActor* actor, vtkMapper* mapper)
{
  vtkProperty* property = actor->GetProperty();
  double factor = 0.;
  double units = 0.;
  mapper->GetRelativeCoincidentTopologyPolygonOffsetParameters(factor, units);
  return namesOf({
    { "Representation Wireframe", property->GetRepresentation() == VTK_WIREFRAME },
    { "Representation Points", property->GetRepresentation() == VTK_POINTS },
    { "EdgeVisibility", property->GetEdgeVisibility() != 0 },
    { "VertexVisibility", property->GetVertexVisibility() != 0 },
    { "Interpolation PBR", property->GetInterpolation() == VTK_PBR },
    { "BackfaceCulling", property->GetBackfaceCulling() != 0 },
    { "FrontfaceCulling", property->GetFrontfaceCulling() != 0 },
    { "BackfaceProperty", actor->GetBackfaceProperty() != nullptr },
    { "Texture", actor->GetTexture() || property->GetNumberOfTextures() > 0 },
    { "RelativeCoincidentTopologyPolygonOffset", factor != 0. || units != 0. },
    { "ShaderProperty", hasShaderCode(actor) },
  });
}

} // namespace treeamr
