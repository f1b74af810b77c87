// vtkTreeAMRVolumeMapper's estimate of a frame's error against the true one, and frames that meet a target.
#include "RenderingScene.h"

#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkPiecewiseFunction.h"

#include <algorithm>
#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr double interactive = 15.;
constexpr double still = 0.002;

using Pixels = std::vector<std::array<float, 4>>;

/// Waves on three levels, soft and solid.
class FrameErrorTest : public RenderingTest
{
protected:
  void SetUp() override
  {
    RenderingTest::SetUp();
    GridOptions options;
    options.roots = { 4, 4, 4 };
    options.refine = [](const Point& c, int level) { return level < 2 && c[0] + c[1] + 0.3 * c[2] > -0.2; };
    if (floatTarget_)
    {
      scene_.useFloatTarget();
    }
    volume_ = scene_.addVolume(
      makeGrid(options,
        { { "waves", [](const Point& p) { return std::sin(4. * p[0] + p[1]) * std::cos(3. * p[2]); } } }),
      "waves", orange, 1.);
    mapper_ = Scene::mapperOf(volume_);
    vtkNew<vtkPiecewiseFunction> opacity;
    for (const auto& [value, alpha] : { std::pair(-0.8, 0.), std::pair(-0.5, 0.5), std::pair(0.3, 0.),
           std::pair(0.5, 0.99), std::pair(0.7, 0.2), std::pair(1., 0.) })
    {
      opacity->AddPoint(value, alpha);
    }
    volume_->GetProperty()->SetScalarOpacity(opacity);
    volume_->GetProperty()->SetScalarOpacityUnitDistance(0.2);
    vtkNew<vtkColorTransferFunction> colors;
    colors->AddRGBPoint(-1., 0.1, 0.2, 0.9);
    colors->AddRGBPoint(1., 1., 0.6, 0.1);
    volume_->GetProperty()->SetColor(colors);
    scene_.setCamera();
  }

  double statistic(const char* name) const { return Scene::statistic(volume_, name); }
  double estimated() const { return statistic("EstimatedError"); }
  double samples() const { return statistic("SamplesPerCell"); }

  Pixels converged()
  {
    const double target = mapper_->GetTargetError();
    mapper_->SetTargetError(0.);
    mapper_->SetSamplesPerCell(64.);
    Pixels pixels = scene_.render();
    mapper_->SetSamplesPerCell(2.);
    mapper_->SetTargetError(target);
    return pixels;
  }

  static double rmse(const Pixels& a, const Pixels& b)
  {
    double sum = 0.;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
      for (int c = 0; c < 3; ++c)
      {
        sum += std::pow(a[i][c] - b[i][c], 2);
      }
    }
    return std::sqrt(sum / (3. * static_cast<double>(a.size())));
  }

  void expectEstimate()
  {
    const Pixels expected = converged();
    mapper_->EstimateErrorOn();
    const double truth = rmse(scene_.render(), expected);
    EXPECT_GT(truth, 1e-4);
    EXPECT_GT(estimated(), 0.5 * truth);
    EXPECT_LT(estimated(), 2. * truth);
  }

  Scene scene_{ 130, 110 };
  vtkVolume* volume_ = nullptr;
  vtkTreeAMRVolumeMapper* mapper_ = nullptr;
  bool floatTarget_ = true;
};

/// With a translucent polygon through the volume. The float target would have no depth peeling.
class PeeledFrameErrorTest : public FrameErrorTest
{
protected:
  PeeledFrameErrorTest() { floatTarget_ = false; }
  void SetUp() override
  {
    FrameErrorTest::SetUp();
    scene_.renderer->SetUseDepthPeeling(true);
    scene_.renderer->SetUseDepthPeelingForVolumes(true);
    scene_.addRectangle({ 0., 0., 0.1 }, { 2., 0., 0. }, { 0., 2., 0.3 }, { 0.3, 0.9, 0.4 }, 0.3);
    scene_.setCamera();
    mapper_->EstimateErrorOn();
  }
};

} // namespace

TEST_F(FrameErrorTest, isOffUntilAskedForAndChangesNoBit)
{
  EXPECT_EQ(samples(), 0.) << "before the first frame";
  const Pixels without = scene_.render();
  EXPECT_EQ(estimated(), -1.);
  EXPECT_EQ(statistic("ErrorSeconds"), 0.);
  EXPECT_EQ(samples(), 2.);
  const double taken = statistic("Samples");
  mapper_->EstimateErrorOn();
  EXPECT_EQ(scene_.render(), without);
  EXPECT_GT(estimated(), 0.);
  EXPECT_GT(statistic("ErrorSeconds"), 0.);
  EXPECT_EQ(statistic("Samples"), taken) << "the frame's own";
}

TEST_F(FrameErrorTest, estimate)
{
  expectEstimate();
}

TEST_F(FrameErrorTest, estimateBehindPolygons)
{
  scene_.addRectangle({ 0.2, 0., 0. }, { 0., 1.2, 0.4 }, { -0.5, 0., 1. }, { 0.2, 0.4, 0.9 });
  expectEstimate();
}

TEST_F(FrameErrorTest, estimateWithIsosurfaces)
{
  mapper_->ShowIsosurfacesOn();
  volume_->GetProperty()->GetIsoSurfaceValues()->SetValue(0, 0.2);
  mapper_->SetIsosurfaceOpacityScale(0.5);
  expectEstimate();
}

TEST_F(FrameErrorTest, interactiveFramesAreNotEstimated)
{
  mapper_->EstimateErrorOn();
  mapper_->SetTargetError(1e-4);
  scene_.window->SetDesiredUpdateRate(interactive);
  scene_.render();
  EXPECT_EQ(estimated(), -1.);
  EXPECT_EQ(samples(), 2.);
  scene_.window->SetDesiredUpdateRate(still);
  scene_.render();
  EXPECT_GT(estimated(), 0.);
  EXPECT_GT(samples(), 2.);
  scene_.window->SetDesiredUpdateRate(interactive);
  scene_.render();
  EXPECT_EQ(samples(), 2.);
}

TEST_F(FrameErrorTest, targetIsMetAtOnce)
{
  const Pixels expected = converged();
  const double before = rmse(scene_.render(), expected);
  const double target = 0.2 * before;
  mapper_->SetTargetError(target);
  EXPECT_LT(rmse(scene_.render(), expected), 2. * target);
  EXPECT_LE(estimated(), target);
  EXPECT_GT(samples(), 2.);
  EXPECT_LT(samples(), 64.);
  // Another view begins with what this one has found.
  const double found = samples();
  scene_.renderer->GetActiveCamera()->Azimuth(3.);
  scene_.render();
  EXPECT_LE(estimated(), target);
  EXPECT_GT(samples(), 0.4 * found);
}

TEST_F(FrameErrorTest, aLaxTargetTakesLessFromTheNextFrameOn)
{
  mapper_->EstimateErrorOn();
  scene_.render();
  const double target = 8. * estimated();
  mapper_->SetTargetError(target);
  scene_.render();
  EXPECT_EQ(samples(), 2.) << "it is there already";
  scene_.render();
  EXPECT_LT(samples(), 2.);
  EXPECT_GE(samples(), 0.25);
  EXPECT_LE(estimated(), target);
  // Without a target the setting counts again.
  mapper_->SetTargetError(0.);
  scene_.render();
  EXPECT_EQ(samples(), 2.);
}

TEST_F(FrameErrorTest, aTargetThatCannotBeMet)
{
  // The fewest samples that come about as close as the most.
  mapper_->SetTargetError(1e-12);
  EXPECT_LE(rmse(scene_.render(), converged()), 0.5 / 255.);
  EXPECT_GT(samples(), 8.);
  EXPECT_GT(estimated(), 1e-12);
  EXPECT_LT(estimated(), 1e-4);
}

TEST_F(PeeledFrameErrorTest, estimateOfParts)
{
  const Pixels expected = converged();
  mapper_->SetSamplesPerCell(0.25);
  const double truth = rmse(scene_.render(), expected);
  EXPECT_GT(statistic("Rays"), 1.1 * scene_.width() * scene_.height()) << "two parts of some rays";
  EXPECT_GT(truth, 0.002) << "above 8 bits";
  EXPECT_GT(estimated(), 0.5 * truth);
  EXPECT_LT(estimated(), 2. * truth);
}

TEST_F(PeeledFrameErrorTest, targetIsMetFromTheNextFrameOn)
{
  scene_.render();
  const double target = 0.3 * estimated();
  mapper_->SetTargetError(target);
  scene_.render();
  EXPECT_EQ(samples(), 2.);
  scene_.render();
  EXPECT_GT(samples(), 2.);
  EXPECT_LE(estimated(), std::sqrt(2.) * target) << "two parts";
}

TEST_F(FrameErrorTest, fewerRaysThanPixels)
{
  mapper_->AutoAdjustSampleDistancesOff();
  mapper_->EstimateErrorOn();
  scene_.render();
  const double full = estimated();
  mapper_->SetImageSampleDistance(2.);
  scene_.render();
  EXPECT_GT(estimated(), full / 2.) << "of the integration alone";
  EXPECT_LT(estimated(), full * 2.);
}
