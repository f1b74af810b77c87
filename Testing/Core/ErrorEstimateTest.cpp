// The estimate of a frame's error against the true one, of pictures that are integrated as far as digits go.
#include "Volume/ErrorEstimate.h"

#include "Error.h"
#include "Interpolation/BlockCache.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeCases.h"
#include "Support/VolumeReference.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 134;
constexpr int height = 118;

/// Waves over 2 x 2 x 2, on cells of several levels.
std::shared_ptr<const Field> makeWaves(unsigned seed)
{
  auto cells = makeRandomTree({ seed, { 2, 2, 2 }, 5, 0.6, 0.05, false });
  setValues(
    cells, [](const auto& p) { return std::sin(5. * p[0] + p[1]) * std::cos(4. * p[2]) + 0.3 * p[1]; });
  return makeField(unitRoots({ 2, 2, 2 }), cells);
}

/// Nodes at the given parts of -1 to 1.6 and at 1/32 of it: few, or converged pictures take minutes.
template <class Extinction>
TransferFunction ofParts(std::vector<double> parts, const Extinction& extinction)
{
  for (int i = 0; i <= 32; ++i)
  {
    parts.push_back(i / 32.);
  }
  std::ranges::sort(parts);
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  std::vector<TransferFunction::Node> nodes;
  for (const double u : parts)
  {
    const auto entry = [&](double beside) {
      const auto part = static_cast<float>(u);
      return TransferFunction::Entry{ part, 1.f - part, 0.5f + 0.5f * std::sin(20.f * part),
        static_cast<float>(extinction(beside)) };
    };
    constexpr double beside = 1e-9; // so that steps are jumps
    nodes.push_back({ -1. + 2.6 * u, entry(u - beside), entry(u + beside) });
  }
  return TransferFunction::ofNodes(std::move(nodes));
}

std::vector<TransferFunction> transferFunctions()
{
  std::vector<double> peak;
  for (int i = -8; i <= 8; ++i)
  {
    peak.push_back(0.55 + 0.0015 * i);
  }
  std::vector<double> shells;
  for (double u = std::numbers::pi / 80.; u < 1.; u += std::numbers::pi / 40.)
  {
    shells.insert(shells.end(), { u - 0.0025, u + 0.0025 });
  }
  return { // A soft haze.
    ofParts({}, [](double u) { return 3. * std::max(0., u); }),
    // Solids.
    ofParts({}, [](double u) { return 60. * std::pow(std::max(0., u - 0.4), 2); }),
    ofParts({ 0.6 }, [](double u) { return u > 0.6 ? 40. : 0.; }),
    // Spikes, that are integrated.
    ofParts(peak, [](double u) { return 300. * std::exp(-std::pow((u - 0.55) / 0.004, 2)); }),
    ofParts(shells, [](double u) { return std::abs(std::sin(40. * u)) > std::cos(0.1) ? 100. : 0.; })
  };
}

/// Fields and functions of every kind, where the estimate was not made for them: on two data sets each, of several
/// trees, with long cells, and with a fifth of the cells left out, and from outside, in parallel, and from inside.
class Cases
{
public:
  struct Case
  {
    std::string name;
    std::shared_ptr<const Field> field;
    TransferFunction function;
    Camera camera;
  };

  Cases()
  {
    const auto values = volumeFieldValues();
    std::size_t i = 0;
    for (const auto& [functionName, function] : volumeFunctions())
    {
      for (int second = 0; second < 2; ++second, ++i)
      {
        const auto& [fieldName, value] = values[(i + second) % values.size()];
        const DataSet& data = dataSets_[i % dataSets_.size()];
        cases_.push_back({ fieldName + ", " + functionName + ", " + data.name, fieldOf(data, value), function,
          cameraTo(data, static_cast<View>(i / dataSets_.size() % 3)) });
      }
    }
  }
  const std::vector<Case>& all() const { return cases_; }

private:
  enum class View
  {
    Outside,
    Parallel,
    Inside
  };
  struct DataSet
  {
    const char* name;
    RandomTree tree;
    Vec3 width; // of a tree
  };

  static std::shared_ptr<const Field> fieldOf(
    const DataSet& data, const std::function<double(const Point&)>& value)
  {
    auto cells = makeRandomTree(data.tree);
    setValues(cells, [&](Point p) {
      for (int a = 0; a < 3; ++a)
      {
        p[a] *= 2. / data.tree.roots[a];
      }
      return value(p);
    });
    return makeField(RootGrid::uniform(data.tree.roots, { 0., 0., 0. }, data.width), cells);
  }

  Camera cameraTo(const DataSet& data, View view)
  {
    const auto random = [this] { return uniform_(random_); };
    Vec3 middle;
    Vec3 target;
    for (int a = 0; a < 3; ++a)
    {
      middle[a] = 0.5 * data.width[a] * data.tree.roots[a];
      target[a] = middle[a] + 0.4 * (random() - 0.5);
    }
    const double distance = view == View::Inside ? 0.5 : 2.5 + random();
    const double z = 1.8 * random() - 0.9;
    const double angle = 6.28 * random();
    const double r = distance * std::sqrt(1. - z * z);
    const Vec3 eye{ middle[0] + r * std::cos(angle), middle[1] + distance * z,
      middle[2] + r * std::sin(angle) };
    const Matrix4 projection = view == View::Parallel ? parallel(0.6 + 0.6 * random(), 0.01, 20.)
                                                      : perspective(35. + 30. * random(), 0.01, 20.);
    return Camera(multiply(projection, lookAt(eye, target)), identityMatrix, 80, 64);
  }

  std::vector<DataSet> dataSets_{ { "several trees", { 103, { 3, 1, 2 }, 5, 0.6, 0., true },
                                    { 0.7, 2.1, 0.9 } },
    { "long cells", { 104, { 2, 2, 2 }, 5, 0.6, 0., false }, { 0.5, 1.7, 1. } },
    { "masked", { 105, { 2, 2, 2 }, 5, 0.6, 0.2, false }, { 1., 1., 1. } },
    { "plain", { 106, { 2, 2, 2 }, 4, 0.7, 0., false }, { 1., 1., 1. } } };
  std::mt19937 random_{ 2026 };
  std::uniform_real_distribution<double> uniform_{ 0., 1. };
  std::vector<Case> cases_;
};

Camera randomCamera(std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(0., 1.);
  const double z = 2. * uniform(random) - 1.;
  const double angle = 6.28 * uniform(random);
  const double distance = 1.3 + 3.5 * uniform(random);
  const double r = distance * std::sqrt(1. - z * z);
  const Matrix4 view =
    lookAt({ 1. + r * std::cos(angle), 1. + distance * z, 1. + r * std::sin(angle) }, { 1., 0.9, 1.1 });
  const Matrix4 projection = uniform(random) < 0.7 ? perspective(30. + 40. * uniform(random), 0.01, 20.)
                                                   : parallel(0.6 + 1.5 * uniform(random), 0.01, 20.);
  return Camera(multiply(projection, view), identityMatrix, width, height);
}

/// A frame and what it is rendered from.
struct Frame
{
  const Field& field;
  const TransferFunction& transferFunction;
  Camera camera;
  VolumeSettings settings;
  RayStops stops{};
  Volume volume = volumeOf(field, transferFunction);

  Image render()
  {
    Image image(camera.width(), camera.height());
    volume.render({ camera, stops }, settings, image);
    return image;
  }
  ErrorEstimator estimator(const Image& image, EstimateEffort effort = EstimateEffort::Quick)
  {
    return { volume, { camera, stops }, settings, image, effort };
  }
  Image converged() const
  {
    Image image(camera.width(), camera.height());
    renderVolumeConverged(field, transferFunction, camera, stops, image);
    return image;
  }
};

/// As errors are estimated.
double colorRmse(const Image& a, const Image& b)
{
  return rmse(a, b, 3);
}

/// How many of a set of frames have an estimate within a factor of two of the truth.
struct Score
{
  int good = 0;
  int all = 0;
  double worst = 1.;

  void add(double estimate, double truth)
  {
    const double ratio = std::max(estimate / truth, truth / estimate);
    good += ratio <= 2.;
    ++all;
    worst = std::max(worst, ratio);
  }
  void expectMostAreGood(const char* what) const
  {
    EXPECT_GE(good, 0.95 * all) << what << ", worst " << worst;
  }
};

} // namespace

TEST(ErrorEstimate, IsWithinAFactorOfTwo)
{
  const auto field = makeWaves(12);
  std::mt19937 random(3);
  Score score;
  for (const TransferFunction& transferFunction : transferFunctions())
  {
    for (int i = 0; i < 3; ++i)
    {
      Frame frame{ *field, transferFunction, randomCamera(random), {} };
      const Image converged = frame.converged();
      for (const double samples : { 1., 2., 4. })
      {
        frame.settings.samplesPerCell = samples;
        const Image image = frame.render();
        score.add(frame.estimator(image).error(), colorRmse(image, converged));
      }
    }
  }
  EXPECT_EQ(score.all, 45);
  score.expectMostAreGood("estimate");
}

TEST(ErrorEstimate, HoldsForFunctionsOfEveryKind)
{
  const Cases cases;
  Score estimates;
  for (const auto& [name, field, function, camera] : cases.all())
  {
    Frame frame{ *field, function, camera, {} };
    const Image converged = frame.converged();
    const auto truthWith = [&](double samplesPerCell) {
      frame.settings.samplesPerCell = samplesPerCell;
      return colorRmse(frame.render(), converged);
    };
    for (const double samples : { 0.5, 1., 2., 4., 8. })
    {
      const double truth = truthWith(samples);
      if (truth > 1e-4)
      {
        estimates.add(frame.estimator(frame.render()).error(), truth);
      }
    }
    for (const double target : { 3e-3, 1e-3 })
    {
      ErrorTarget control(VolumeSettings().samplesPerCell);
      bool again = true;
      for (int frames = 0; again; ++frames)
      {
        ASSERT_LT(frames, 3) << name;
        frame.settings.samplesPerCell = control.samplesPerCell();
        auto estimator = frame.estimator(frame.render(), EstimateEffort::Thorough);
        again = control.update(estimator, target);
      }
      // Never more than twice the samples needed: but for what the estimate errs by.
      const double samples = control.samplesPerCell();
      EXPECT_LE(truthWith(samples), 1.1 * target) << name;
      EXPECT_TRUE(0.5 * samples < ErrorTarget::least || truthWith(0.5 * samples) > 0.95 * target) << name;
    }
  }
  EXPECT_GT(estimates.all, 60);
  estimates.expectMostAreGood("estimate");
}

TEST(ErrorEstimate, IsWithinAFactorOfTwoOfPartsOfRaysWithSurfaces)
{
  const auto field = makeWaves(5);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  Score score;
  for (const TransferFunction& transferFunction : transferFunctions())
  {
    for (int i = 0; i < 8; ++i)
    {
      const Camera camera = randomCamera(random);
      // Polygons in front of the left half, nothing to see in the upper part, a surface across the middle of every
      // ray.
      std::vector<float> begin(width * height, 0.f);
      std::vector<float> end(width * height, 1.f);
      PixelHits hits;
      for (std::size_t pixel = 0; pixel < begin.size(); ++pixel)
      {
        const auto x = static_cast<int>(pixel) % width;
        const auto y = static_cast<int>(pixel) / width;
        const Ray ray = camera.ray(x, y);
        const double middle = dot(Vec3{ 1., 1., 1. } - ray.origin, ray.direction);
        if (x < width / 2)
        {
          end[pixel] = static_cast<float>(std::clamp(camera.depthFromT(ray, middle + 0.3), 0., 1.));
        }
        begin[pixel] = y > 3 * height / 4 ? 1.f : 0.f;
        hits.add(middle, { uniform(random), 0.5f, 0.2f, 0.3f });
        hits.endPixel();
      }
      Frame frame{ *field, transferFunction, camera, {}, hits.stops(begin.data(), end.data()) };
      const Image image = frame.render();
      score.add(frame.estimator(image).error(), colorRmse(image, frame.converged()));
    }
  }
  EXPECT_EQ(score.all, 40);
  score.expectMostAreGood("estimate");
}

TEST(ErrorEstimate, IsTheSameOnAnyNumberOfThreads)
{
  const auto field = makeWaves(12);
  const TransferFunction solid = transferFunctions()[1];
  std::mt19937 random(3);
  Frame frame{ *field, solid, randomCamera(random), {} };
  const Image image = frame.render();
  const double all = frame.estimator(image).error();
  EXPECT_GT(all, 0.);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(frame.estimator(image).error(), all);
}

TEST(ErrorEstimate, IsZeroWhereNothingIsDrawn)
{
  const auto field = makeWaves(12);
  const TransferFunction nothing = ofParts({}, [](double) { return 0.; });
  std::mt19937 random(3);
  Frame frame{ *field, nothing, randomCamera(random), {} };
  auto estimator = frame.estimator(frame.render());
  EXPECT_EQ(estimator.error(), 0.);
  EXPECT_EQ(estimator.findSamplesPerCell(1e-3, 0.25, 64.), 0.25);
  EXPECT_EQ(frame.volume.keptBytes(), BlockCache(*field, defaultKeptBytes).byteSize());
}

TEST(ErrorEstimate, AFrameOfAnotherSizeIsAnError)
{
  const auto field = makeWaves(12);
  const TransferFunction haze = transferFunctions()[0];
  std::mt19937 random(3);
  Frame frame{ *field, haze, randomCamera(random), {} };
  EXPECT_THROW(frame.estimator(Image(width, height - 4)), Error);
  EXPECT_THROW(frame.estimator(Image(width + 4, height)), Error);
}

TEST(ErrorEstimate, OnePixelIsEstimated)
{
  const auto field = makeWaves(12);
  const TransferFunction haze = transferFunctions()[0];
  const Camera camera(
    multiply(perspective(5., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 1, 1);
  Volume volume(field, haze, 0);
  Image image(1, 1);
  const VolumeSettings settings;
  volume.render(camera, settings, image);
  Image finer(1, 1);
  VolumeSettings more;
  more.samplesPerCell = 16.; // the least that is compared with
  volume.render(camera, more, finer);
  const ErrorEstimator estimator(volume, camera, settings, image);
  EXPECT_GT(estimator.error(), 0.);
  EXPECT_NEAR(estimator.error(), colorRmse(image, finer), 1e-12);
}

TEST(ErrorEstimate, FindsTheSamplesForAnError)
{
  const auto field = makeWaves(12);
  const TransferFunction solid = transferFunctions()[1];
  std::mt19937 random(8);
  for (int i = 0; i < 4; ++i)
  {
    Frame frame{ *field, solid, randomCamera(random), {} };
    const Image converged = frame.converged();
    // More samples, and fewer: no target is below what ends of rays leave.
    for (const auto& [from, factor] : { std::pair(0.5, 0.1), { 2., 0.5 }, { 2., 3. } })
    {
      frame.settings.samplesPerCell = from;
      auto estimator = frame.estimator(frame.render());
      const double target = factor * estimator.error();
      const double samples = estimator.findSamplesPerCell(target, 0.25, 64.);
      EXPECT_EQ(samples > from, factor < 1.) << factor;
      // Half of the samples would not do.
      const auto truthWith = [&](double samplesPerCell) {
        Frame other{ *field, solid, frame.camera, { .samplesPerCell = samplesPerCell } };
        return colorRmse(other.render(), converged);
      };
      EXPECT_LT(truthWith(samples), 2. * target) << factor;
      EXPECT_GT(truthWith(0.5 * samples), 0.5 * target) << factor;
    }
    auto estimator = frame.estimator(frame.render());
    // What cannot be met: the fewest that come about as close as any.
    const double fewest = estimator.findSamplesPerCell(0., 0.25, 16.);
    EXPECT_GT(fewest, 2.);
    EXPECT_LE(estimator.errorWith(fewest), 1.11 * estimator.errorWith(16.));
    EXPECT_GT(estimator.errorWith(0.5 * fewest), 1.1 * estimator.errorWith(16.));
    EXPECT_EQ(estimator.findSamplesPerCell(1., 0.25, 16.), 0.25);
  }
}

TEST(ErrorEstimate, FramesComeToTheirTarget)
{
  const auto field = makeWaves(12);
  const TransferFunction solid = transferFunctions()[1];
  std::mt19937 random(8);
  const Camera camera = randomCamera(random);
  Frame frame{ *field, solid, camera, { .samplesPerCell = 1. } };
  const double target = 0.35 * frame.estimator(frame.render()).error();
  ErrorTarget control(1.);
  EXPECT_EQ(control.samplesPerCell(), 1.);
  int frames = 1;
  for (bool again = true; again; ++frames)
  {
    ASSERT_LE(frames, 3);
    frame.settings.samplesPerCell = control.samplesPerCell();
    const Image image = frame.render();
    auto estimator = frame.estimator(image);
    again = control.update(estimator, target);
    EXPECT_EQ(again, estimator.error() > target);
  }
  EXPECT_GT(frames, 2);
  EXPECT_GT(control.samplesPerCell(), 1.);
  // A frame far better than its target stays, the next one takes less.
  auto estimator = frame.estimator(frame.render());
  EXPECT_FALSE(control.update(estimator, 20. * target));
  EXPECT_LT(control.samplesPerCell(), 0.5 * frame.settings.samplesPerCell);
  // What cannot be met is not tried again and again.
  frame.settings.samplesPerCell = ErrorTarget::most;
  ErrorTarget most(1e9);
  EXPECT_EQ(most.samplesPerCell(), ErrorTarget::most);
  auto best = frame.estimator(frame.render());
  EXPECT_FALSE(most.update(best, 1e-30));
}
