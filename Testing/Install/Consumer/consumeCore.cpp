// Builds an octree of one refined root and samples a linear field, which the reconstruction reproduces.
#include "Interpolation/Sampler.h"
#include "Octree/OctreeBuilder.h"

#include <cmath>
#include <cstdlib>
#include <iostream>

int main()
{
  std::vector<treeamr::LeafCell> cells;
  for (treeamr::Coord k = 0; k < 4; ++k)
  {
    for (treeamr::Coord j = 0; j < 4; ++j)
    {
      for (treeamr::Coord i = 0; i < 4; ++i)
      {
        cells.push_back({ { { i, j, k }, 2 }, static_cast<float>((i + 0.5) / 4.) });
      }
    }
  }
  auto built = treeamr::buildOctree(
    treeamr::RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), std::move(cells));
  const auto field = std::make_shared<const treeamr::Field>(built.octree, std::move(built.values));
  const auto sampler = treeamr::Sampler::create(treeamr::InterpolationMethod::GTI, field);
  treeamr::FieldSample sample;
  const bool inside = sampler->sample({ 0.4, 0.5, 0.6 }, sample);
  std::cout << "value " << sample.value << "\n";
  return inside && std::abs(sample.value - 0.4) < 1e-6 ? EXIT_SUCCESS : EXIT_FAILURE;
}
