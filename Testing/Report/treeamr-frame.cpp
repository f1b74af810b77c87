// Renders one small frame of a procedural tree on one thread, for instructions.py to count what it takes.
//
// treeamr-frame nothing|volume|isosurface
//
// All three build the tree and its field; the last two render.
#include "Scene.h"
#include "Surface/Isosurface.h"
#include "Volume/Volume.h"

#include <oneapi/tbb/global_control.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string_view>

namespace treeamr::report
{

namespace
{

void run(std::string_view what)
{
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::shared_ptr<const Field> field = bench::buildProceduralField(5, 2.55);
  const Camera camera = bench::makeCamera(64);
  const bench::Scene scene = bench::makeScenes().back();
  if (what == "volume")
  {
    Image image(camera.width(), camera.height());
    Volume(field, scene.transferFunction).render(camera, {}, image);
  }
  else if (what == "isosurface")
  {
    HitImage hits;
    Isosurface(field, { scene.isovalue }).render(camera, SurfaceLayers::Nearest, hits);
  }
}

} // namespace

} // namespace treeamr::report

int main(int argc, char* argv[])
{
  const std::string_view what = argc == 2 ? argv[1] : "";
  if (what != "nothing" && what != "volume" && what != "isosurface")
  {
    std::fprintf(stderr, "usage: treeamr-frame nothing|volume|isosurface\n");
    return 2;
  }
  try
  {
    treeamr::report::run(what);
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "treeamr-frame: %s\n", error.what());
    return 1;
  }
  return 0;
}
