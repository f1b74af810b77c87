// Light, gradient opacity and blend modes of vtkTreeAMRVolumeMapper: against VTK's own volume mapper on a uniform grid,
// and where VTK can do several things at once.
#include "RenderingScene.h"
#include "VolumePair.h"

#include "vtkCamera.h"
#include "vtkContourValues.h"
#include "vtkGPUVolumeRayCastMapper.h"
#include "vtkLight.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkRenderer.h"
#include "vtkTable.h"
#include "vtkTransform.h"
#include "vtkVariant.h"
#include "vtkVersionMacros.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

using namespace treeamr::test;

namespace
{

/// Of 255, in the mean over drawn pixels.
constexpr double tolerance = 2.;

class VolumeEffectsTest : public RenderingTest
{
protected:
  static vtkLight* addLight(vtkRenderer* renderer, int type, const Point& position, const Color& color)
  {
    vtkNew<vtkLight> light;
    light->SetLightType(type);
    light->SetPosition(position[0], position[1], position[2]);
    light->SetFocalPoint(0., 0., 0.);
    light->SetColor(color[0], color[1], color[2]);
    renderer->AddLight(light);
    return light;
  }

  /// Far from VTK's defaults: what leaves one of them out is another picture.
  static void setLight(vtkVolumeProperty* property)
  {
    property->ShadeOn();
    property->SetAmbient(0.2);
    property->SetDiffuse(0.45);
    property->SetSpecular(vtkHasPhongsHighlights ? 0.5 : 0.);
    property->SetSpecularPower(4.);
  }
};

struct Lamp
{
  int type;
  Point towards; // of unit length
  Color color;
  Color ambient;
};

double dot(const Point& a, const Point& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// By Phong's model, seen along z, where values increase along a unit vector; one-sided, what faces them is dark.
Color phong(const Color& color, const Point& increase, vtkVolumeProperty* property, bool isTwoSided,
  const std::vector<Lamp>& lamps)
{
  const bool isHeadlightAlone = lamps.size() == 1 && lamps[0].type == VTK_LIGHT_TYPE_HEADLIGHT;
  Color result;
  for (int c = 0; c < 3; ++c)
  {
    result[c] = isHeadlightAlone ? property->GetAmbient() * color[c] : 0.;
    for (const Lamp& lamp : lamps)
    {
      const double facing = -dot(increase, lamp.towards);
      const double mirrored = 2. * facing * -increase[2] - lamp.towards[2];
      result[c] += isHeadlightAlone ? 0. : property->GetAmbient() * lamp.ambient[c];
      if (isTwoSided || facing > 0.)
      {
        result[c] += lamp.color[c] *
          (property->GetDiffuse() * std::abs(facing) * color[c] +
            property->GetSpecular() * std::pow(std::max(mirrored, 0.), property->GetSpecularPower()));
      }
    }
  }
  return result;
}

} // namespace

TEST_F(VolumeEffectsTest, headlightAsVTK)
{
  VolumePair pair;
  const double plain = pair.difference();
  setLight(pair.property());
  for (const bool parallel : { false, true })
  {
    pair.scene.setCamera(parallel);
    EXPECT_LT(pair.difference(), tolerance) << parallel << ", plain " << plain;
  }
  if (!vtkHasPhongsHighlights)
  {
    return;
  }
  pair.scene.renderer->SetTwoSidedLighting(false);
  EXPECT_LT(pair.difference(), tolerance) << "one-sided";
  // Of the mean over all pixels narrow highlights are a small part.
  pair.property()->SetAmbient(0.);
  pair.property()->SetDiffuse(0.);
  pair.property()->SetSpecular(1.);
  pair.property()->SetSpecularPower(1.);
  EXPECT_LT(pair.difference(), tolerance) << "wide highlights alone";
}

// Of a linear field the normals are known.
TEST_F(VolumeEffectsTest, slicesOfLinearFieldsAreLitByPhongsModel)
{
  const Color color{ 0.4, 0.6, 0.5 };
  const Lamp headlight{ VTK_LIGHT_TYPE_HEADLIGHT, { 0., 0., 1. }, { 1., 0.9, 0.8 }, { 0., 0., 0. } };
  const Lamp sun{ VTK_LIGHT_TYPE_SCENE_LIGHT, { 0.6, 0., 0.8 }, { 0.9, 0.7, 0.5 }, { 0.3, 0.1, 0.6 } };
  const Lamp other{ VTK_LIGHT_TYPE_SCENE_LIGHT, { -0.48, 0.64, 0.6 }, { 0.2, 0.5, 0.4 }, { 0.1, 0., 0. } };
  for (const double angle : { 0., 0.4, 0.9, 2.8, 3.5 })
  {
    const Point increase{ std::sin(angle), 0., std::cos(angle) };
    for (const std::vector<Lamp>& lamps : { std::vector{ headlight }, { sun }, { sun, other } })
    {
      Scene scene(61, 45); // with a pixel in the middle
      const auto linear = [&](const Point& p) { return dot(increase, p); };
      vtkVolume* volume = scene.addVolume(makeGrid({}, { { "linear", linear } }), "linear", color, 50.);
      setLight(volume->GetProperty());
      volume->GetProperty()->SetSpecular(0.4);
      vtkNew<vtkPlane> plane;
      volume->GetProperty()->SetSliceFunction(plane);
      Scene::mapperOf(volume)->SetBlendModeToSlice();
      scene.renderer->AutomaticLightCreationOff();
      for (const Lamp& lamp : lamps)
      {
        addLight(scene.renderer, lamp.type, lamp.towards, lamp.color)->SetAmbientColor(lamp.ambient.data());
      }
      scene.setCameraAlongZ();
      scene.useFloatTarget();
      for (const bool isTwoSided : { true, false })
      {
        scene.renderer->SetTwoSidedLighting(isTwoSided);
        const auto pixel =
          scene.render()[static_cast<std::size_t>(scene.height() / 2) * scene.width() + scene.width() / 2];
        const Color expected = phong(color, increase, volume->GetProperty(), isTwoSided, lamps);
        for (int c = 0; c < 3; ++c)
        {
          EXPECT_NEAR(pixel[c], expected[c], 1e-5)
            << angle << ", " << lamps.size() << ", " << isTwoSided << ", " << c;
        }
      }
    }
  }
}

TEST_F(VolumeEffectsTest, otherLightsAsVTK)
{
  VolumePair pair;
  setLight(pair.property());
  vtkRenderer* renderer = pair.scene.renderer;
  renderer->AutomaticLightCreationOff();
  renderer->RemoveAllLights();
  EXPECT_LT(pair.difference(), tolerance) << "no light";
  vtkLight* camera = addLight(renderer, VTK_LIGHT_TYPE_CAMERA_LIGHT, { 1., 1., 1. }, { 1., 0.9, 0.8 });
  EXPECT_LT(pair.difference(), tolerance) << "camera light";
  camera->SwitchOff();
  vtkLight* scene = addLight(renderer, VTK_LIGHT_TYPE_SCENE_LIGHT, { 2., 3., 4. }, { 0.9, 0.7, 0.5 });
  scene->SetAmbientColor(0.3, 0.1, 0.6);
  EXPECT_LT(pair.difference(), tolerance) << "scene light";
  addLight(renderer, VTK_LIGHT_TYPE_HEADLIGHT, { 0., 0., 1. }, { 0.3, 0.4, 0.5 });
  EXPECT_LT(pair.difference(), tolerance) << "two lights";
}

// VTK mirrors highlights of positional lights to both sides.
TEST_F(VolumeEffectsTest, positionalLightsAsVTKButForHighlights)
{
  VolumePair pair;
  setLight(pair.property());
  pair.property()->SetSpecular(0.);
  vtkRenderer* renderer = pair.scene.renderer;
  renderer->AutomaticLightCreationOff();
  renderer->RemoveAllLights();
  vtkLight* light = addLight(renderer, VTK_LIGHT_TYPE_SCENE_LIGHT, { 1.5, 1.5, 2. }, { 1., 1., 1. });
  light->SetPositional(true);
  light->SetConeAngle(180.);
  light->SetAttenuationValues(0.4, 0.1, 0.05);
  EXPECT_LT(pair.difference(), tolerance);
  light->SetConeAngle(25.);
  light->SetExponent(2.);
  EXPECT_LT(pair.difference(), tolerance) << "cone";
}

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
// VTK's shadow rays take jittered samples.
TEST_F(VolumeEffectsTest, scatteredLightAsVTK)
{
  VolumePair pair;
  setLight(pair.property());
  const auto scattering = [](float blending, float reach) {
    return [=](vtkVolumeMapper* mapper) {
      if (auto own = vtkTreeAMRVolumeMapper::SafeDownCast(mapper))
      {
        own->SetVolumetricScatteringBlending(blending);
        own->SetGlobalIlluminationReach(reach);
        own->SetSampleDistance(0.005);
      }
      if (auto vtk = vtkGPUVolumeRayCastMapper::SafeDownCast(mapper))
      {
        vtk->SetVolumetricScatteringBlending(blending);
        vtk->SetGlobalIlluminationReach(reach);
        vtk->UseJitteringOn();
      }
    };
  };
  EXPECT_LT(pair.difference(scattering(2.f, 0.6f)), tolerance) << "headlight";
  EXPECT_LT(pair.difference(scattering(1.f, 1.f)), tolerance) << "headlight, both kinds of light";
  vtkRenderer* renderer = pair.scene.renderer;
  renderer->AutomaticLightCreationOff();
  renderer->RemoveAllLights();
  vtkLight* light = addLight(renderer, VTK_LIGHT_TYPE_SCENE_LIGHT, { 2., 3., 4. }, { 0.9, 0.7, 0.5 });
  EXPECT_LT(pair.difference(scattering(2.f, 1.f)), tolerance) << "scene light";
  EXPECT_LT(pair.difference(scattering(2.f, 0.f)), tolerance) << "scene light, hardly a shadow";
  EXPECT_LT(pair.difference(scattering(0.5f, 1.f)), tolerance) << "scene light, little of it";
  pair.property()->SetScatteringAnisotropy(0.4f);
  EXPECT_LT(pair.difference(scattering(1.5f, 1.f)), tolerance) << "anisotropic";
  light->SetPositional(true);
  light->SetPosition(1.5, 1.5, 2.);
  light->SetConeAngle(180.);
  EXPECT_LT(pair.difference(scattering(2.f, 1.f)), tolerance) << "positional light";
}
#endif

TEST_F(VolumeEffectsTest, gradientOpacityAsVTK)
{
  VolumePair pair;
  const double plain = pair.difference();
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.);
  function->AddPoint(0.03, 0.2);
  function->AddPoint(0.06, 1.);
  pair.property()->SetGradientOpacity(function);
  EXPECT_LT(pair.difference(), tolerance);
  setLight(pair.property());
  EXPECT_LT(pair.difference(), tolerance) << "lit";
  pair.property()->ShadeOff();
  pair.property()->DisableGradientOpacityOn();
  EXPECT_NEAR(pair.difference(), plain, 1e-9) << "off";
}

TEST_F(VolumeEffectsTest, blendModesAsVTK)
{
  VolumePair pair;
  pair.property()->SetScalarOpacityUnitDistance(0.7);
  for (const int mode : { vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND, vtkVolumeMapper::MINIMUM_INTENSITY_BLEND,
         vtkVolumeMapper::AVERAGE_INTENSITY_BLEND, vtkVolumeMapper::ADDITIVE_BLEND })
  {
    EXPECT_LT(pair.difference([mode](vtkVolumeMapper* mapper) { mapper->SetBlendMode(mode); }), tolerance)
      << mode;
  }
  const auto averageOfARange = [](vtkVolumeMapper* mapper) {
    mapper->SetBlendModeToAverageIntensity();
    mapper->SetAverageIPScalarRange(0.3, 0.8);
  };
  EXPECT_LT(pair.difference(averageOfARange), tolerance) << "average of a range";
}

// VTK's nearest: each cell one value, and by the gradient at its centre where it is lit.
TEST_F(VolumeEffectsTest, nearestAsVTK)
{
  VolumePair pair;
  const double linear = pair.difference();
  pair.showOurs();
  const auto continuous = pair.scene.render();
  pair.property()->SetInterpolationTypeToNearest();
  EXPECT_LT(pair.difference(), tolerance) << "linear " << linear;
  pair.showOurs();
  EXPECT_NE(pair.scene.render(), continuous);
  vtkTable* statistics = pair.mapper()->GetStatistics();
  EXPECT_EQ(statistics->GetValueByName(0, "KeptBytes").ToInt(), 0);
  EXPECT_EQ(statistics->GetValueByName(0, "ReconstructedBlocks").ToInt(), 0);
  setLight(pair.property());
  EXPECT_LT(pair.difference(), tolerance) << "lit";
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.);
  function->AddPoint(0.03, 0.2);
  function->AddPoint(0.06, 1.);
  pair.property()->SetGradientOpacity(function);
  EXPECT_LT(pair.difference(), tolerance) << "lit, by gradients";
  pair.property()->ShadeOff();
  pair.property()->DisableGradientOpacityOn();
  for (const int mode : { vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND, vtkVolumeMapper::MINIMUM_INTENSITY_BLEND,
         vtkVolumeMapper::AVERAGE_INTENSITY_BLEND, vtkVolumeMapper::ADDITIVE_BLEND })
  {
    EXPECT_LT(pair.difference([mode](vtkVolumeMapper* mapper) { mapper->SetBlendMode(mode); }), tolerance)
      << mode;
  }
}

// VTK's default, as of its own mappers.
TEST_F(VolumeEffectsTest, nearestIsTheDefault)
{
  VolumePair pair;
  pair.property()->SetInterpolationTypeToNearest();
  const auto nearest = pair.scene.render();
  vtkNew<vtkVolumeProperty> untouched;
  pair.property()->SetInterpolationType(untouched->GetInterpolationType());
  EXPECT_EQ(pair.scene.render(), nearest);
}

TEST_F(VolumeEffectsTest, slicesInTheDomainsFacesAreWhole)
{
  const auto slice = [](vtkVolumeMapper* mapper) { mapper->SetBlendModeToSlice(); };
  VolumePair pair;
  vtkNew<vtkPlane> plane;
  pair.property()->SetSliceFunction(plane);
  double bounds[6];
  pair.mapper()->GetBounds(bounds);
  for (const int interpolation : { VTK_LINEAR_INTERPOLATION, VTK_NEAREST_INTERPOLATION })
  {
    pair.property()->SetInterpolationType(interpolation);
    for (int face = 0; face < 6; ++face)
    {
      SCOPED_TRACE(face);
      double origin[3] = { 0.1, 0.1, 0.1 };
      double normal[3] = { 0., 0., 0. };
      origin[face / 2] = bounds[face];
      normal[face / 2] = face % 2 == 0 ? -2. : 1.;
      plane->SetOrigin(origin);
      plane->SetNormal(normal);
      EXPECT_LT(pair.difference(slice), tolerance);
    }
  }
}

TEST_F(VolumeEffectsTest, slicesAsVTK)
{
  const auto slice = [](vtkVolumeMapper* mapper) { mapper->SetBlendModeToSlice(); };
  VolumePair pair;
  vtkNew<vtkPlane> plane;
  plane->SetOrigin(0.11, -0.07, 0.05);
  plane->SetNormal(0.3, 0.5, 0.8);
  pair.property()->SetSliceFunction(plane);
  const double plain = pair.difference(slice);
  EXPECT_LT(plain, tolerance);
  // The unit distance has no part.
  pair.property()->SetScalarOpacityUnitDistance(3.);
  EXPECT_NEAR(pair.difference(slice), plain, 0.01);
  pair.scene.setCamera(true);
  EXPECT_LT(pair.difference(slice), tolerance) << "parallel";
  pair.scene.setCamera();
  setLight(pair.property());
  EXPECT_LT(pair.difference(slice), tolerance) << "lit";
  pair.property()->ShadeOff();
  pair.property()->SetInterpolationTypeToNearest();
  EXPECT_LT(pair.difference(slice), tolerance) << "nearest";
  pair.property()->SetInterpolationTypeToLinear();
  // The plane is in world coordinates, what it cuts moves.
  vtkNew<vtkTransform> transform;
  transform->RotateWXYZ(30., 0.2, 1., 0.4);
  transform->Translate(0.2, 0.1, -0.1);
  pair.move(transform);
  EXPECT_LT(pair.difference(slice), tolerance) << "moved";
  const auto cut = [&](vtkVolumeMapper* mapper) {
    slice(mapper);
    mapper->CroppingOn();
    mapper->SetCroppingRegionPlanes(-0.5, 0.6, -0.4, 0.7, -0.3, 0.5);
    mapper->SetCroppingRegionFlagsToSubVolume();
  };
  EXPECT_LT(pair.difference(cut), tolerance) << "cropped";
  pair.showOurs();
  const auto cropped = pair.scene.render();
  pair.mapper()->CroppingOff();
  EXPECT_NE(pair.scene.render(), cropped);
}

// Before and behind what is opaque, and in the segments of depth peeling between what is translucent.
TEST_F(VolumeEffectsTest, slicesHaveTheirDepth)
{
  const Color orange{ 0.9, 0.5, 0.2 };
  const Color blue{ 0.1, 0.2, 0.9 };
  for (const double side : { -1., 1. })
  {
    for (const bool isPeeling : { false, true })
    {
      Scene scene;
      vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, 0.8);
      Scene::mapperOf(volume)->SetBlendModeToSlice();
      vtkNew<vtkPlane> plane;
      plane->SetOrigin(0., 0., 0.1);
      volume->GetProperty()->SetSliceFunction(plane);
      const double opacity = volume->GetProperty()->GetScalarOpacity()->GetValue(1.);
      const double ofRectangle = isPeeling ? 0.4 : 1.;
      scene.addRectangle({ 0., 0., 0.1 + 0.05 * side }, { 0.5, 0., 0. }, { 0., 0.5, 0. }, blue, ofRectangle);
      scene.renderer->SetUseDepthPeeling(isPeeling);
      scene.renderer->SetUseDepthPeelingForVolumes(isPeeling);
      scene.setCameraAlongZ();
      const auto pixels = scene.render();
      const Layer slice{ orange, opacity };
      const Layer rectangle{ blue, ofRectangle };
      const bool isBehind = side < 0.; // the camera looks down
      const Color expected = composite(
        isBehind ? std::vector{ slice, rectangle } : std::vector{ rectangle, slice }, { 0., 0., 0. });
      const Color beside = composite({ slice }, { 0., 0., 0. });
      const auto at = [&](int x, int y) { return pixels[static_cast<std::size_t>(y) * scene.width() + x]; };
      for (int c = 0; c < 3; ++c)
      {
        EXPECT_NEAR(at(scene.width() / 2, scene.height() / 2)[c], expected[c], 2.5 / 255.)
          << side << isPeeling;
        EXPECT_NEAR(at(scene.width() / 2, 2)[c], beside[c], 2.5 / 255.) << side << isPeeling;
      }
    }
  }
}

// In the segments of depth peeling each side of a translucent rectangle has its own maximum.
TEST_F(VolumeEffectsTest, maximaInDepthPeeling)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", { 0.9, 0.5, 0.2 }, 0.8);
  volume->GetProperty()->SetScalarOpacityUnitDistance(1.);
  Scene::mapperOf(volume)->SetBlendModeToMaximumIntensity();
  const double opacity = volume->GetProperty()->GetScalarOpacity()->GetValue(1.);
  const Color blue{ 0.1, 0.2, 0.9 };
  scene.addRectangle({ 0., 0., 0.1 }, { 0.5, 0., 0. }, { 0., 0.5, 0. }, blue, 0.4);
  scene.renderer->UseDepthPeelingOn();
  scene.renderer->UseDepthPeelingForVolumesOn();
  scene.setCameraAlongZ();
  const auto pixels = scene.render();
  const Layer part{ { 0.9, 0.5, 0.2 }, opacity };
  const Color inside = composite({ part, { blue, 0.4 }, part }, { 0., 0., 0. });
  const Color beside = composite({ part }, { 0., 0., 0. });
  const auto expectAt = [&](int x, int y, const Color& expected) {
    for (int c = 0; c < 3; ++c)
    {
      EXPECT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], 2.5 / 255.)
        << x << ", " << y;
    }
  };
  expectAt(scene.width() / 2, scene.height() / 2, inside);
  expectAt(scene.width() / 2, 2, beside);
}

TEST_F(VolumeEffectsTest, litFramesMeetAnError)
{
  VolumePair pair;
  setLight(pair.property());
  pair.showOurs();
  pair.mapper()->SetSamplesPerCell(0.25);
  pair.mapper()->EstimateErrorOn();
  const auto estimate = [&] {
    pair.scene.render();
    return pair.mapper()->GetStatistics()->GetValueByName(0, "EstimatedError").ToDouble();
  };
  const double error = estimate();
  EXPECT_GT(error, 0.);
  pair.mapper()->SetTargetError(0.3 * error);
  EXPECT_LE(estimate(), 0.3 * error);
  EXPECT_GT(estimate(), 0.);
}

// Drafts have fewer rays and cells, and the light of the full picture.
TEST_F(VolumeEffectsTest, draftsAreLitToo)
{
  VolumePair pair;
  setLight(pair.property());
  pair.showOurs();
  const auto unlit = [&] {
    pair.property()->ShadeOff();
    const auto picture = pair.scene.render();
    pair.property()->ShadeOn();
    return picture;
  }();
  const auto mean = [](const auto& a, const auto& b) {
    double sum = 0.;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
      sum += std::abs(a[i][0] - b[i][0]) / static_cast<double>(a.size());
    }
    return sum;
  };
  const auto full = pair.scene.render();
  pair.mapper()->AutoAdjustSampleDistancesOff();
  pair.mapper()->SetImageSampleDistance(2.);
  const auto draft = pair.scene.render();
  EXPECT_NE(draft, full);
  EXPECT_LT(mean(draft, full), 0.2 * mean(unlit, full));
}

// One pass, in order: what stands before a lit volume's isosurface lets its light through.
TEST_F(VolumeEffectsTest, isosurfacesInsideALitVolume)
{
  VolumePair pair;
  setLight(pair.property());
  MessageCounter messages(pair.mapper());
  vtkVolumeProperty* property = pair.property();
  property->GetIsoSurfaceValues()->SetNumberOfContours(1);
  property->GetIsoSurfaceValues()->SetValue(0, 0.7);
  pair.showOurs();
  const auto volume = pair.scene.render();
  pair.mapper()->ShowIsosurfacesOn();
  const auto both = pair.scene.render();
  int opaquer = 0;
  for (std::size_t i = 0; i < volume.size(); ++i)
  {
    EXPECT_GE(both[i][3], volume[i][3] - 2.f / 255.f);
    opaquer += both[i][3] > volume[i][3] + 0.05f;
  }
  EXPECT_GT(opaquer, 100);
  EXPECT_TRUE(messages.warnings.empty());
  EXPECT_TRUE(messages.errors.empty());
}
