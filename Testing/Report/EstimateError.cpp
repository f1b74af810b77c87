#include "EstimateError.h"

#include "Meter.h"
#include "ReferenceImage.h"
#include "Scene.h"
#include "Support/Cameras.h"
#include "Volume/ErrorEstimate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>

namespace treeamr::report
{

namespace
{

constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct View
{
  Camera camera;
  Image converged;
};

/// From anywhere around the unit cube's middle, some from inside, some with the whole of it in view.
Camera randomCamera(std::mt19937& random, int pixels)
{
  std::uniform_real_distribution<double> uniform(0., 1.);
  const double z = 2. * uniform(random) - 1.;
  const double angle = 2. * std::numbers::pi * uniform(random);
  const double distance = 0.7 + 1.3 * uniform(random);
  const double degrees = 20. + 40. * uniform(random);
  const double r = distance * std::sqrt(1. - z * z);
  const Vec3 eye{ 0.5 + r * std::cos(angle), 0.5 + distance * z, 0.5 + r * std::sin(angle) };
  Vec3 target;
  std::generate(target.begin(), target.end(), [&] { return 0.4 + 0.2 * uniform(random); });
  return Camera(test::multiply(test::perspective(degrees, 0.05, 10.), test::lookAt(eye, target)),
    test::identityMatrix, pixels, pixels);
}

double median(std::vector<double> values)
{
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double trueError(const Image& image, const View& view)
{
  return std::pow(10., -bench::psnr(image, view.converged) / 20.);
}

class Measurement
{
public:
  Measurement(const Options& options, const bench::Scene& scene, bench::Report& report)
    : report_(report)
    , scene_(scene)
    , large_(bench::makeCamera())
  {
    bench::Forest forest = bench::readForest(options.folder + "/" + scene.name + ".p8est");
    field_ = bench::buildField(forest.roots, std::move(forest.cells));
    volume_ = std::make_unique<Volume>(field_, scene.transferFunction);
    std::mt19937 random(5);
    const int count = options.brief ? 4 : 20;
    const int pixels = options.brief ? 200 : 256;
    for (int i = 0; i < count; ++i)
    {
      const Camera camera = randomCamera(random, pixels);
      const std::string path = options.folder + "/" + scene.name + "-view-" + std::to_string(i) +
        (options.brief ? "-brief" : "") + ".reference";
      views_.push_back({ camera,
        bench::referenceImage(path, forest.digest, *field_, scene.transferFunction, camera, 0x1p-20f) });
    }
    VolumeSettings finest;
    finest.samplesPerCell = ErrorTarget::most;
    std::vector<double> errors;
    for (const View& view : views_)
    {
      errors.push_back(trueError(render(view.camera, finest), view));
    }
    floor_ = median(errors);
  }

  /// How far the estimate is from the truth over the views, and what it adds to a large frame.
  void estimate(double samplesPerCell)
  {
    VolumeSettings settings;
    settings.samplesPerCell = samplesPerCell;
    std::vector<double> truth;
    std::vector<double> estimates;
    double within = 0.;
    double worst = 1.;
    for (const View& view : views_)
    {
      const Image image = render(view.camera, settings);
      truth.push_back(trueError(image, view));
      estimates.push_back(estimator(view.camera, settings, image).error());
      const double ratio = estimates.back() / truth.back();
      worst = std::max({ worst, ratio, 1. / ratio });
      within += ratio <= 2. && ratio >= 0.5;
    }
    render(large_, settings); // fills the memory of vertex values
    Image image(large_.width(), large_.height());
    const double frame = bench::best([&] { image = render(large_, settings); }).cpu;
    const double added = bench::best([&] { estimator(large_, settings, image); }).cpu;
    add(none, samplesPerCell, median(truth), median(estimates), worst, within, added / frame, frame);
  }

  /// The same for frames that are to meet a target, each view beginning with the samples of the one before.
  void meet(double target)
  {
    ErrorTarget control(VolumeSettings().samplesPerCell);
    VolumeSettings settings;
    std::vector<double> truth;
    std::vector<double> estimates;
    std::vector<double> samples;
    double met = 0.;
    double worst = 1.;
    const double seconds = bench::measure([&] {
      for (const View& view : views_)
      {
        Image image(0, 0);
        bool again = true;
        for (int frames = 0; again && frames < 3; ++frames)
        {
          settings.samplesPerCell = control.samplesPerCell();
          image = render(view.camera, settings);
          auto estimated = estimator(view.camera, settings, image, EstimateEffort::Thorough);
          again = control.update(estimated, target);
          if (!again || frames == 2)
          {
            estimates.push_back(estimated.error());
          }
        }
        samples.push_back(settings.samplesPerCell);
        truth.push_back(trueError(image, view));
        met += truth.back() <= target;
        worst = std::max(worst, truth.back() / target);
      }
    }).cpu;
    add(target, median(samples), median(truth), median(estimates), worst, met, none,
      seconds / static_cast<double>(views_.size()));
  }

private:
  Image render(const Camera& camera, const VolumeSettings& settings)
  {
    Image image(camera.width(), camera.height());
    volume_->render(camera, settings, image);
    return image;
  }

  ErrorEstimator estimator(const Camera& camera, const VolumeSettings& settings, const Image& frame,
    EstimateEffort effort = EstimateEffort::Quick)
  {
    return { *volume_, camera, settings, frame, effort };
  }

  void add(double target, double samplesPerCell, double truth, double estimated, double worst, double good,
    double costShare, double seconds)
  {
    const auto views = static_cast<double>(views_.size());
    const bool targeted = target > 0.;
    report_.add({ scene_.name,
      { { "target", target, "target", 5 }, { "samples_per_cell", samplesPerCell, "samples", 2 },
        { "cameras", views, "cameras" }, { "true_rmse", truth, "true rmse", 6 },
        { "estimated_rmse", estimated, "estimated", 6 }, { "worst_ratio", worst, "worst", 2 },
        { targeted ? "share_met" : "share_within_factor_2", good / views, "share", 2 },
        { "floor_rmse", floor_, "floor", 6 }, { "cost_share", costShare, "cost/frame", 4 },
        { "cpu_s_frame", seconds, "CPU s", 3 } } });
  }

  bench::Report& report_;
  const bench::Scene& scene_;
  const Camera large_;
  std::shared_ptr<Field> field_;
  std::unique_ptr<Volume> volume_;
  std::vector<View> views_;
  double floor_; // median true error with the most samples: the ends of rays and what no samples change
};

} // namespace

void measureErrorEstimate(const Options& options, bench::Report& report)
{
  const std::vector<bench::Scene> scenes = bench::makeScenes();
  for (std::size_t i = 0; i < (options.brief ? 1 : scenes.size()); ++i)
  {
    Measurement measurement(options, scenes[i], report);
    for (const double samplesPerCell : { 1., 2., 4. })
    {
      measurement.estimate(samplesPerCell);
    }
    for (const double target : { 1e-2, 1e-3, 1e-4 })
    {
      measurement.meet(target);
    }
  }
}

} // namespace treeamr::report
