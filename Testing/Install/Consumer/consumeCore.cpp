// A ball in an adaptive grid by Core alone: a volume and an isosurface of it, each as a picture.
#include <treeamr/Contour.h>
#include <treeamr/Field.h>
#include <treeamr/Isosurface.h>
#include <treeamr/Sampler.h>
#include <treeamr/Volume.h>

#include "picture.h"

#include <cmath>
#include <cstdlib>
#include <iostream>

namespace
{

constexpr double radius = 0.3;

/// One minus the distance from the middle of the unit cube; cells near the ball's surface are a level finer.
void addCells(const std::array<treeamr::Coord, 3>& index, int level, std::vector<treeamr::LeafCell>& cells)
{
  const double width = std::ldexp(1., -level);
  double squared = 0.;
  for (const treeamr::Coord i : index)
  {
    squared += std::pow((static_cast<double>(i) + 0.5) * width - 0.5, 2);
  }
  const double distance = std::sqrt(squared);
  if (level < 4 || (level < 5 && std::abs(distance - radius) < width))
  {
    for (int octant = 0; octant < 8; ++octant)
    {
      addCells(treeamr::indexOfChild(index, octant), level + 1, cells);
    }
    return;
  }
  cells.push_back({ { index, level }, static_cast<float>(1. - distance) });
}

/// Along z, all of the unit cube and a little more.
treeamr::Camera lookingAlongZ()
{
  const double scale = 1.8; // clip coordinates are this times those from the middle
  return treeamr::Camera({ scale, 0, 0, -0.5 * scale, 0, scale, 0, -0.5 * scale, 0, 0, -1, 0.5, 0, 0, 0, 1 },
    pictureSize, pictureSize);
}

std::vector<float> volumeOf(const std::shared_ptr<const treeamr::Field>& field, const treeamr::Camera& camera)
{
  const treeamr::TransferFunction orange(
    1. - radius, 1. - radius + 0.01, { { 1.f, 0.5f, 0.f, 0.f }, { 1.f, 0.5f, 0.f, 8.f } });
  treeamr::Image image(camera.width(), camera.height());
  treeamr::Volume(field, orange).render(camera, {}, image);
  return { image.rgba.begin(), image.rgba.end() };
}

std::vector<float> surfaceOf(
  const std::shared_ptr<const treeamr::Field>& field, const treeamr::Camera& camera)
{
  const treeamr::Isosurface surface(field, { 1. - radius });
  treeamr::HitImage hits;
  surface.render(camera, treeamr::SurfaceLayers::Nearest, hits);
  treeamr::Material material;
  material.diffuse = { 0.2f, 0.6f, 1.f };
  treeamr::Light light;
  light.direction = { 0., 0., -1. };
  const treeamr::SurfaceFrame frame(camera.worldFromData());
  const treeamr::Vec3 toEye{ 0., 0., 1. };
  std::vector<float> rgba(4 * static_cast<std::size_t>(pictureSize) * pictureSize);
  for (std::size_t pixel = 0; 4 * pixel < rgba.size(); ++pixel)
  {
    for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
    {
      const treeamr::SurfaceHit& hit = hits.hits[i];
      const auto color =
        treeamr::shade(material, { light }, {}, frame.shadingNormal(hit.gradient, hit.normal, toEye), toEye);
      std::copy(color.begin(), color.end(), rgba.begin() + 4 * static_cast<std::ptrdiff_t>(pixel));
      rgba[4 * pixel + 3] = 1.f;
    }
  }
  return rgba;
}

} // namespace

int main()
{
  std::vector<treeamr::LeafCell> cells;
  addCells({}, 0, cells);
  auto built = treeamr::buildOctree(
    treeamr::RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), std::move(cells));
  const auto field = std::make_shared<const treeamr::Field>(built.octree, std::move(built.values));
  const treeamr::Camera camera = lookingAlongZ();
  bool good = writeBall("core-volume.ppm", volumeOf(field, camera), 0.5 * 1.8 * radius);
  good = writeBall("core-isosurface.ppm", surfaceOf(field, camera), 0.5 * 1.8 * radius) && good;

  treeamr::FieldSample sample;
  const bool inside =
    treeamr::Sampler::create(treeamr::InterpolationMethod::GTI, field)->sample({ 0.5, 0.5, 0.8 }, sample);
  std::cout << "value " << sample.value << " at the ball's surface\n";
  good = good && inside && std::abs(sample.value - (1. - radius)) < 0.01;
  const treeamr::ContourMesh mesh = treeamr::contour(*field, 1. - radius);
  std::cout << mesh.triangles.size() << " triangles\n";
  try
  {
    treeamr::Isosurface(field, {});
    good = false;
  }
  catch (const treeamr::Error& error)
  {
    std::cout << error.what() << "\n";
  }
  return good && !mesh.triangles.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}
