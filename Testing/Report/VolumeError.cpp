#include "VolumeError.h"

#include "Geometry/RayBox.h"
#include "Interpolation/Sampler.h"
#include "Meter.h"
#include "Picture.h"
#include "ReferenceImage.h"
#include "Scene.h"
#include "Volume/Volume.h"

#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace treeamr::report
{

namespace
{

constexpr std::size_t mebibyte = std::size_t(1) << 20;

using NamedMethod = std::pair<const char*, InterpolationMethod>;

/// What each series goes through.
struct Plan
{
  int pixels = 1000; // along the picture's edge
  std::vector<double> samplesPerCell{ 0.25, 0.5, 1., 2., 4., 8., 16., 32., 64. };
  // Where enough points are taken, pre-integration has no part.
  std::vector<double> samplesWithoutPreIntegration{ 0.25, 0.5, 1., 2. };
  std::vector<double> levelOfDetailPixels{ 0.5, 1., 2., 4., 8. };
  std::vector<double> imageSampleDistances{ 1., 1.5, 2., 3., 4. };
  std::vector<double> keptMebibytes{ 0., 32., 128., 512., 2048. };
  int methodPixels = 300; // 0: no methods
  std::vector<NamedMethod> methods{ { "nearest", InterpolationMethod::Nearest },
    { "current", InterpolationMethod::Current }, { "finest", InterpolationMethod::Finest },
    { "octant", InterpolationMethod::Octant }, { "GTI", InterpolationMethod::GTI } };
};

/// Minutes for the largest data sets.
Plan makePlan(const Octree& octree)
{
  Plan plan;
  // The marcher's samples, two for each of the finest cells' widths, are as many in every data set.
  plan.methodPixels = static_cast<int>(300. * std::exp2(0.5 * (7 - octree.leafLevels())));
  if (octree.leafCount() > 10'000'000)
  {
    plan.samplesPerCell = { 0.5, 1., 2., 4., 8., 16. };
    plan.samplesWithoutPreIntegration = { 0.5, 1., 2. };
    plan.keptMebibytes = { 0., 128., 512., 2048. };
    plan.methodPixels = 0;
  }
  return plan;
}

Plan makeBriefPlan()
{
  Plan plan;
  plan.pixels = 200;
  plan.samplesPerCell = { 0.5, 2., 8. };
  plan.samplesWithoutPreIntegration = { 0.5, 1., 2. };
  plan.levelOfDetailPixels = { 1., 2., 8. };
  plan.imageSampleDistances = { 1., 2., 4. };
  plan.keptMebibytes = { 0., 32., 512. };
  plan.methods = { plan.methods[0], plan.methods[3], plan.methods[4] };
  plan.methodPixels = 100;
  return plan;
}

struct DataSet
{
  std::string name;
  std::shared_ptr<const Field> field;
  TransferFunction transferFunction;
};

struct Frame
{
  bench::Cost seconds;     // with what frames before have kept
  bench::Cost coldSeconds; // without
  VolumeStatistics statistics;
  std::size_t keptBytes;
};

std::vector<bench::Figure> figuresOf(const Frame& frame, const Image& image, const Image& converged)
{
  const double psnr = bench::psnr(image, converged);
  return {
    { "pixels", static_cast<double>(converged.width), "pixels" },
    { "cpu_s", frame.seconds.cpu, "CPU-s", 3 },
    { "cpu_s_cold", frame.coldSeconds.cpu, "cold", 3 },
    { "rmse", std::pow(10., -psnr / 20.), "RMSE", 7 },
    { "psnr_db", psnr, "dB", 2 },
    { "ssim", structuralSimilarity(image, converged), "SSIM", 6 },
    { "samples", static_cast<double>(frame.statistics.samples), "M samples", 3, 1e-6 },
    { "nodes", static_cast<double>(frame.statistics.nodes), "M nodes", 3, 1e-6 },
    { "intervals", static_cast<double>(frame.statistics.intervals), "M intervals", 3, 1e-6 },
    { "kept_bytes", static_cast<double>(frame.keptBytes), "kept MiB", 1, 1. / mebibyte },
  };
}

/// One point of the renderer's settings.
struct Setting
{
  double samplesPerCell = VolumeSettings().samplesPerCell;
  bool preIntegration = true;
  double levelOfDetailPixels = 0.;
  double imageSampleDistance = 1.; // pixels between rays
  std::size_t keptBytes = defaultKeptBytes;

  auto operator<=>(const Setting&) const = default;
};

class RendererSeries
{
public:
  RendererSeries(bench::Report& report, const DataSet& data, const Image& converged)
    : report_(report)
    , data_(data)
    , converged_(converged)
  {
  }

  /// change(setting, value) of the defaults for every value.
  template <class Change>
  void add(const char* name, const std::vector<double>& values, const Change& change)
  {
    for (const double value : values)
    {
      Setting setting;
      change(setting, value);
      std::vector<bench::Figure>& figures = figures_[setting];
      if (figures.empty())
      {
        figures = measure(setting);
      }
      std::ostringstream text;
      text << value;
      report_.add({ data_.name, figures, { { "series", name }, { "setting", text.str() } } });
    }
  }

private:
  /// To magnify the image of fewer rays is not in the time: the window does it.
  std::vector<bench::Figure> measure(const Setting& setting) const
  {
    VolumeSettings settings;
    settings.samplesPerCell = setting.samplesPerCell;
    settings.preIntegration = setting.preIntegration;
    settings.levelOfDetailPixels = setting.levelOfDetailPixels;
    const int pixels = converged_.width;
    const Camera camera =
      bench::makeCamera(static_cast<int>(std::ceil(pixels / setting.imageSampleDistance)));
    Image image(camera.width(), camera.height());
    std::optional<Volume> volume;
    Frame frame{};
    const auto forget = [&] { volume.emplace(data_.field, data_.transferFunction, setting.keptBytes); };
    const auto render = [&] { frame.statistics = volume->render(camera, settings, image); };
    frame.coldSeconds = bench::best(forget, render, 3, 3);
    frame.seconds = bench::best(render);
    frame.keptBytes = volume->keptBytes();
    return figuresOf(frame, magnify(image, pixels, pixels), converged_);
  }

  bench::Report& report_;
  const DataSet& data_;
  const Image& converged_;
  std::map<Setting, std::vector<bench::Figure>> figures_; // the defaults are a point of several series
};

void measureSettings(bench::Report& report, const DataSet& data, const Plan& plan, const Image& converged)
{
  RendererSeries series(report, data, converged);
  series.add(
    "samples per cell", plan.samplesPerCell, [](Setting& s, double value) { s.samplesPerCell = value; });
  series.add("without pre-integration", plan.samplesWithoutPreIntegration, [](Setting& s, double value) {
    s.samplesPerCell = value;
    s.preIntegration = false;
  });
  series.add("level of detail", plan.levelOfDetailPixels,
    [](Setting& s, double value) { s.levelOfDetailPixels = value; });
  series.add("image sample distance", plan.imageSampleDistances,
    [](Setting& s, double value) { s.imageSampleDistance = value; });
  series.add("kept values", plan.keptMebibytes,
    [](Setting& s, double value) { s.keptBytes = static_cast<std::size_t>(value) * mebibyte; });
}

/// Midpoint samples at half a width of the finest cells; nothing is skipped.
VolumeStatistics march(const Sampler& sampler, const DataSet& data, const Camera& camera, Image& image)
{
  const Octree& octree = data.field->octree();
  const Bounds domain = octree.grid().bounds();
  const double step = std::ldexp(0.5 * (domain.max[0] - domain.min[0]), -octree.leafLevels());
  tbb::combinable<std::uint64_t> samples([] { return 0; });
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x)
    {
      const Ray ray = camera.ray(x, y);
      double begin = 0.;
      double end = std::numeric_limits<double>::infinity();
      if (!SlabRay(ray).clip(domain.min, domain.max, begin, end))
      {
        continue;
      }
      std::array<double, 3> color{};
      double transmittance = 1.;
      for (double t = begin + 0.5 * step; t < end && transmittance > opaqueTransmittance; t += step)
      {
        FieldSample sample;
        ++samples.local();
        if (!sampler.sample(pointAt(ray, t), sample))
        {
          continue;
        }
        const TransferFunction::Entry entry = data.transferFunction.at(static_cast<float>(sample.value));
        const double passes = std::exp(-entry.extinction * step);
        const double weight = transmittance * (1. - passes);
        color[0] += weight * entry.r;
        color[1] += weight * entry.g;
        color[2] += weight * entry.b;
        transmittance *= passes;
      }
      float* rgba = image.rgba.data() + 4 * (static_cast<std::size_t>(y) * image.width + x);
      for (int c = 0; c < 3; ++c)
      {
        rgba[c] = static_cast<float>(color[c]);
      }
      rgba[3] = static_cast<float>(1. - transmittance);
    }
  });
  VolumeStatistics statistics;
  statistics.samples = samples.combine(std::plus<>());
  return statistics;
}

void measureMethods(bench::Report& report, const DataSet& data, const Plan& plan)
{
  const Camera camera = bench::makeCamera(plan.methodPixels);
  const Image converged = bench::convergedImage(*data.field, data.transferFunction, camera);
  for (const auto& [name, method] : plan.methods)
  {
    const auto sampler = Sampler::create(method, data.field);
    Image image(camera.width(), camera.height());
    Frame frame{};
    frame.seconds = bench::measure([&] { frame.statistics = march(*sampler, data, camera, image); });
    frame.coldSeconds = frame.seconds; // nothing is kept
    report.add({ data.name, figuresOf(frame, image, converged),
      { { "series", "interpolation" }, { "setting", name } } });
  }
}

} // namespace

void measureVolumeError(const Options& options, bench::Report& report)
{
  for (const bench::Scene& scene : bench::makeScenes())
  {
    const std::string file = options.folder + "/" + scene.name;
    bench::Forest forest = bench::readForest(file + ".p8est");
    const DataSet data{ scene.name, bench::buildField(forest.roots, std::move(forest.cells)),
      scene.transferFunction };
    const Plan plan = options.brief ? makeBriefPlan() : makePlan(data.field->octree());
    const std::string reference = file + (options.brief ? "-brief" : "") + ".reference";
    measureSettings(report, data, plan,
      bench::referenceImage(
        reference, forest.digest, *data.field, scene.transferFunction, bench::makeCamera(plan.pixels)));
    if (plan.methodPixels > 0)
    {
      measureMethods(report, data, plan);
    }
    if (options.brief)
    {
      return;
    }
  }
}

} // namespace treeamr::report
