#include "Limit.h"

#include "Meter.h"

namespace treeamr::bench
{

namespace
{

struct Run
{
  double seconds;
  double intervals;
  double steps;
  double litSteps;
};

Run run(const std::shared_ptr<const Field>& field, const TransferFunction& transferFunction,
  const Camera& camera, double samplesPerCell)
{
  Image image(camera.width(), camera.height());
  VolumeSettings settings;
  settings.samplesPerCell = samplesPerCell;
  VolumeStatistics statistics;
  Volume volume(field, transferFunction, 0);
  const Cost seconds = best([&] { statistics = volume.renderWithoutWalk(camera, settings, 4, image); });
  return { seconds.cpu, static_cast<double>(statistics.intervals), static_cast<double>(statistics.steps),
    static_cast<double>(statistics.litSteps) };
}

} // namespace

double limitSeconds(const std::shared_ptr<const Field>& field, const TransferFunction& transferFunction,
  const Camera& camera, const VolumeStatistics& frame)
{
  const TransferFunction dark(0., 1., { { 0.f, 0.f, 0.f, 0.f }, { 0.f, 0.f, 0.f, 0.f } });
  // One step per interval, and several; the same with light.
  const Run one = run(field, dark, camera, 1e-3);
  const Run several = run(field, dark, camera, 2.);
  const Run lit = run(field, transferFunction, camera, 2.);
  const double step = (several.seconds / several.intervals - one.seconds / one.intervals) /
    (several.steps / several.intervals - one.steps / one.intervals);
  const double interval = (one.seconds - step * one.steps) / one.intervals;
  const double light = (lit.seconds - interval * lit.intervals - step * lit.steps) / lit.litSteps;
  return interval * static_cast<double>(frame.intervals) + step * static_cast<double>(frame.steps) +
    light * static_cast<double>(frame.litSteps);
}

} // namespace treeamr::bench
