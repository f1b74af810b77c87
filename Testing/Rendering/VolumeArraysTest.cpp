// Volumes whose opacity is that of another array than their colour, by vtkTreeAMRVolumeMapper: against VTK's own volume
// mapper on a uniform grid.
#include "RenderingScene.h"
#include "VolumePair.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkLight.h"
#include "vtkPiecewiseFunction.h"
#include "vtkRenderer.h"
#include "vtkVolumeProperty.h"

#include <cmath>
#include <limits>
#include <string>

using namespace treeamr::test;

namespace
{

/// Of 255, in the mean over drawn pixels.
constexpr double tolerance = 2.;

class VolumeArraysTest : public RenderingTest
{
protected:
  static vtkHyperTreeGrid* gridOf(VolumePair& pair)
  {
    return vtkHyperTreeGrid::SafeDownCast(pair.mapper()->GetInputDataObject(0, 0));
  }
  static void useIndependentComponents(VolumePair& pair, int count)
  {
    pair.useComponents("components", count);
    pair.mapper()->SetVectorMode(vtkTreeAMRVolumeMapper::DISABLED);
    vtkVolumeProperty* property = pair.property();
    for (int i = 1; i < count; ++i)
    {
      vtkNew<vtkColorTransferFunction> colors;
      colors->AddRGBPoint(0., 0.2 * i, 0.9, 0.1);
      colors->AddRGBPoint(1., 0.9, 0.3 * i, 0.7);
      vtkNew<vtkPiecewiseFunction> opacities;
      opacities->AddPoint(0., 0.3 / i);
      opacities->AddPoint(0.5, 0.);
      opacities->AddPoint(1., 0.2);
      property->SetColor(i, colors);
      property->SetScalarOpacity(i, opacities);
      property->SetScalarOpacityUnitDistance(i, 0.2);
    }
  }
};

} // namespace

TEST_F(VolumeArraysTest, dependentComponentsAsVTK)
{
  VolumePair pair;
  const auto before = pair.scene.render();
  pair.usePairs();
  EXPECT_LT(pair.difference(), tolerance) << "a unit distance of 1";
  pair.property()->SetScalarOpacityUnitDistance(1, 0.2);
  EXPECT_LT(pair.difference(), tolerance);
  pair.showOurs();
  const auto unlit = pair.scene.render();
  EXPECT_NE(unlit, before);
  // By the gradient of the component of colours.
  pair.property()->ShadeOn();
  EXPECT_LT(pair.difference(), tolerance) << "lit";
  pair.showOurs();
  EXPECT_NE(pair.scene.render(), unlit);
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.);
  function->AddPoint(0.06, 1.);
  pair.property()->SetGradientOpacity(function);
  EXPECT_LT(pair.difference(), tolerance) << "lit, opacity by gradients";
}

TEST_F(VolumeArraysTest, fourDependentComponentsAsVTK)
{
  VolumePair pair;
  pair.useComponents("rgba", 4);
  pair.property()->IndependentComponentsOff();
  pair.property()->SetScalarOpacityUnitDistance(3, 0.2);
  MessageCounter messages(pair.mapper());
  EXPECT_LT(pair.difference(), tolerance);
  // By the gradient of the opacity's component. VTK's shader wants coefficients of that one, too, and gets the first's.
  pair.showOurs();
  const auto unlit = pair.scene.render();
  pair.property()->ShadeOn();
  const auto lit = pair.scene.render();
  int darker = 0;
  for (std::size_t i = 0; i < lit.size(); ++i)
  {
    EXPECT_NEAR(lit[i][3], unlit[i][3], 1.5 / 255.);
    darker += lit[i][0] + lit[i][1] + lit[i][2] < 0.9 * (unlit[i][0] + unlit[i][1] + unlit[i][2]);
  }
  EXPECT_GT(darker, 1000);
  pair.property()->ShadeOff();
  pair.property()->SetInterpolationTypeToNearest();
  EXPECT_LT(pair.difference(), tolerance) << "nearest";
  EXPECT_TRUE(messages.warnings.empty());
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(VolumeArraysTest, independentComponentsAsVTK)
{
  for (const int count : { 2, 3, 4 })
  {
    VolumePair pair;
    useIndependentComponents(pair, count);
    vtkVolumeProperty* property = pair.property();
    MessageCounter messages(pair.mapper());
    EXPECT_LT(pair.difference(), tolerance) << count;
    pair.showOurs();
    const auto evenly = pair.scene.render();
    property->SetComponentWeight(0, 0.5);
    property->SetComponentWeight(count - 1, 0.8);
    EXPECT_LT(pair.difference(), tolerance) << count << ", weights";
    pair.showOurs();
    EXPECT_NE(pair.scene.render(), evenly);
    property->SetInterpolationTypeToNearest();
    EXPECT_LT(pair.difference(), tolerance) << count << ", nearest";
    EXPECT_TRUE(messages.warnings.empty());
    // What they have not is said once.
    pair.showOurs();
    property->ShadeOn();
    pair.scene.render();
    pair.mapper()->SetBlendModeToMaximumIntensity();
    pair.scene.render();
    ASSERT_EQ(messages.warnings.size(), 4u);
    EXPECT_NE(messages.warnings[0].find("Shade of independent"), std::string::npos) << messages.warnings[0];
    EXPECT_TRUE(messages.errors.empty());
  }
}

// Each by its own gradients and coefficients.
TEST_F(VolumeArraysTest, litComponentsAsVTK)
{
  for (const int count : { 2, 3, 4 })
  {
    VolumePair pair;
    useIndependentComponents(pair, count);
    vtkVolumeProperty* property = pair.property();
    pair.showOurs();
    const auto unlit = pair.scene.render();
    MessageCounter messages(pair.mapper());
    property->ShadeOn();
    for (int i = 0; i < count; ++i)
    {
      property->SetAmbient(i, 0.3 - 0.08 * i);
      property->SetDiffuse(i, 0.4 + 0.15 * i);
      property->SetSpecular(i, vtkHasPhongsHighlights ? 0.15 * i : 0.);
      property->SetSpecularPower(i, 5. + 9. * i);
    }
    EXPECT_LT(pair.difference(), tolerance) << count << ", headlight";
    pair.showOurs();
    const auto lit = pair.scene.render();
    EXPECT_NE(lit, unlit);
    property->SetDiffuse(count - 1, 0.1);
    EXPECT_LT(pair.difference(), tolerance) << count;
    pair.showOurs();
    EXPECT_NE(pair.scene.render(), lit);
    vtkRenderer* renderer = pair.scene.renderer;
    renderer->AutomaticLightCreationOff();
    renderer->RemoveAllLights();
    vtkNew<vtkLight> light;
    light->SetLightTypeToSceneLight();
    light->SetPosition(2., 3., 4.);
    light->SetColor(0.9, 0.7, 0.5);
    light->SetAmbientColor(0.3, 0.1, 0.6);
    renderer->AddLight(light);
    EXPECT_LT(pair.difference(), tolerance) << count << ", scene light";
    EXPECT_TRUE(messages.warnings.empty());
    EXPECT_TRUE(messages.errors.empty());
  }
}

TEST_F(VolumeArraysTest, anOpacityArrayIsTheSecondOfAPair)
{
  VolumePair pair;
  pair.showOurs();
  const auto plain = pair.scene.render();
  pair.mapper()->SelectScalarArray("other");
  pair.mapper()->SetOpacityArrayName("wave");
  const auto two = pair.scene.render();
  EXPECT_NE(two, plain);
  pair.mapper()->SetOpacityArrayName("");
  pair.usePairs();
  pair.property()->SetScalarOpacityUnitDistance(1, 0.2);
  EXPECT_EQ(pair.scene.render(), two);
  // By component of a pair, and with isosurfaces of the array that colours.
  pair.property()->IndependentComponentsOn();
  pair.mapper()->SelectScalarArray("other");
  pair.mapper()->SetOpacityArrayName("pair");
  pair.mapper()->SetOpacityComponent(1);
  EXPECT_EQ(pair.scene.render(), two);
  pair.mapper()->SetOpacityComponent(-1);
  const auto magnitude = pair.scene.render();
  EXPECT_NE(magnitude, two);
  pair.mapper()->SetOpacityComponent(2);
  EXPECT_EQ(pair.scene.render(), magnitude);
  pair.mapper()->SetOpacityComponent(1);
  pair.mapper()->ShowIsosurfacesOn();
  pair.property()->GetIsoSurfaceValues()->SetValue(0, 0.5);
  EXPECT_NE(pair.scene.render(), two);
  pair.mapper()->ShowIsosurfacesOff();
  EXPECT_EQ(pair.scene.render(), two);
  pair.mapper()->SelectScalarArray("wave");
  pair.mapper()->SetOpacityArrayName(nullptr);
  EXPECT_EQ(pair.scene.render(), plain);
}

TEST_F(VolumeArraysTest, componentsThatThereAreNotAreSaid)
{
  VolumePair pair;
  pair.showOurs();
  pair.mapper()->SelectScalarArray("other");
  pair.mapper()->SetOpacityArrayName("wave");
  const auto magnitude = pair.scene.render();
  for (const int component : { 9, -2 })
  {
    const MessageCounter messages(pair.mapper());
    pair.mapper()->SetOpacityComponent(component);
    EXPECT_EQ(pair.scene.render(), magnitude);
    pair.scene.render();
    ASSERT_EQ(messages.warnings.size(), 1u) << component;
    EXPECT_NE(messages.warnings[0].find("OpacityComponent " + std::to_string(component) + " of 'wave'"),
      std::string::npos)
      << messages.warnings[0];
    pair.mapper()->SetOpacityComponent(1);
    EXPECT_EQ(pair.scene.render(), magnitude);
    EXPECT_EQ(messages.warnings.size(), 1u);
  }
}

TEST_F(VolumeArraysTest, threeComponentsAreDependentOfNone)
{
  VolumePair pair;
  pair.useComponents("components", 3);
  pair.showOurs();
  const auto magnitude = pair.scene.render();
  const auto expectSaid = [&](const std::string& text) {
    const MessageCounter messages(pair.mapper());
    EXPECT_EQ(pair.scene.render(), magnitude) << text;
    ASSERT_EQ(messages.warnings.size(), 1u) << text;
    EXPECT_NE(messages.warnings[0].find(text), std::string::npos) << messages.warnings[0];
  };
  pair.property()->IndependentComponentsOff();
  expectSaid("IndependentComponents off: without effect");
  pair.property()->IndependentComponentsOn();
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0., 1., 0., 0.);
  pair.property()->SetColor(1, colors);
  expectSaid("SetColor(1, ...): without effect, needed are VectorMode DISABLED");
}

TEST_F(VolumeArraysTest, newFunctionsAndArraysAreDrawn)
{
  VolumePair pair;
  pair.showOurs();
  pair.mapper()->SelectScalarArray("other");
  pair.mapper()->SetOpacityArrayName("wave");
  const auto first = pair.scene.render();
  pair.property()->GetRGBTransferFunction()->AddRGBPoint(0.25, 0., 1., 0.);
  const auto colored = pair.scene.render();
  EXPECT_NE(colored, first);
  pair.property()->GetScalarOpacity()->AddPoint(0.7, 0.);
  EXPECT_NE(pair.scene.render(), colored);
  // A volume that copies the mapper's settings is the same.
  const auto last = pair.scene.render();
  vtkNew<vtkTreeAMRVolumeMapper> copy;
  copy->ShallowCopy(pair.mapper());
  EXPECT_STREQ(copy->GetOpacityArrayName(), "wave");
  EXPECT_EQ(pair.scene.render(), last);
}

TEST_F(VolumeArraysTest, whatCannotBeDrawnIsSaid)
{
  VolumePair pair;
  pair.showOurs();
  MessageCounter messages(pair.mapper());
  pair.mapper()->SetOpacityArrayName("missing");
  pair.scene.render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("'missing'"), std::string::npos) << messages.errors[0];
  messages.errors.clear();
  pair.mapper()->SetOpacityArrayName("other");
  pair.mapper()->SetBlendModeToMaximumIntensity();
  pair.scene.render();
  pair.scene.render();
  EXPECT_TRUE(messages.errors.empty());
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("OpacityArrayName"), std::string::npos) << messages.warnings[0];
  // No array at all, where components would be dependent.
  pair.mapper()->SetOpacityArrayName("");
  pair.mapper()->SetBlendModeToComposite();
  pair.mapper()->SetScalarModeToUsePointFieldData();
  pair.property()->IndependentComponentsOff();
  pair.scene.render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("scalar mode"), std::string::npos) << messages.errors[0];
  messages.errors.clear();
  pair.property()->IndependentComponentsOn();
  pair.mapper()->SetScalarModeToUseCellFieldData();
  pair.mapper()->SetOpacityArrayName("other");
  // Cells of one array alone.
  pair.mapper()->SetBlendModeToComposite();
  vtkDataArray* array = gridOf(pair)->GetCellData()->GetArray("other");
  array->SetComponent(array->GetNumberOfTuples() - 1, 0, std::numeric_limits<double>::quiet_NaN());
  array->Modified();
  gridOf(pair)->Modified();
  pair.scene.render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("in 262143; colour"), std::string::npos) << messages.errors[0];
}
