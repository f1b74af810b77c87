#include "FunctionError.h"

#include "Meter.h"
#include "Support/Cameras.h"
#include "Support/ImageError.h"
#include "Support/VolumeCases.h"
#include "Support/VolumeReference.h"

#include <vector>

namespace treeamr::report
{

using namespace test;

void measureFunctionError(const Options& options, bench::Report& report)
{
  const int width = options.brief ? 30 : 180;
  const int height = options.brief ? 25 : 150;
  const std::vector<double> allSamples =
    options.brief ? std::vector{ 1., 2., 4., 16., 64. } : std::vector{ 1., 2., 4., 8., 16., 32., 64. };
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })),
    identityMatrix, width, height);
  for (const auto& [fieldName, field] : volumeFields())
  {
    for (const auto& [functionName, function] : volumeFunctions())
    {
      Image converged(width, height);
      renderVolumeConverged(*field, function, camera, {}, converged);
      Volume volume(field, function);
      for (const double samples : allSamples)
      {
        Image image(width, height);
        VolumeSettings settings;
        settings.samplesPerCell = samples;
        const auto render = [&] { volume.render(camera, settings, image); };
        render(); // fills the memory of vertex values
        const double seconds =
          options.brief ? bench::measure(render).cpu : bench::best([] {}, render, 3, 3).cpu;
        report.add({ fieldName,
          { { "pixels", static_cast<double>(width) }, { "samples_per_cell", samples, "samples" },
            { "rmse", rmse(image, converged), "1e-6 rmse", 2, 1e6 }, { "cpu_s", seconds, "CPU ms", 2, 1e3 } },
          { { "function", functionName } } });
      }
    }
  }
}

} // namespace treeamr::report
