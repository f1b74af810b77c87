// Writes frames as raw numbers, and compares those of two builds: what must not change a picture is shown not to.
//
// treeamr-frames write OUT [FOLDER] [--only FRAME] [--repeat N]
// treeamr-frames compare OUT OTHER [TOLERANCE]
//
// Frames are of the forests <name>.p8est of a folder, whose names Scene.cpp has; without a folder of one procedural
// tree. FRAME is <name>-<kind>, or <name> for all of its kinds. Each becomes a file of 32-bit floats: red, green,
// blue, alpha by pixel, or of an isosurface t and the normal by hit. --repeat renders each of them N times, for
// programs that count what a frame takes.
//
// Comparing prints the largest difference of a number by frame; it fails where that is more than the tolerance, 0
// unless given: then numbers must be equal to the bit.
#include "Error.h"
#include "Scene.h"
#include "Support/Cameras.h"
#include "Surface/Isosurface.h"
#include "Volume/Volume.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace treeamr::bench
{

namespace
{

constexpr int pixels = 500; // along an edge
constexpr const char* suffix = ".frame";

struct Options
{
  std::filesystem::path out;
  std::string folder;
  std::string only;
  int repeat = 1;
};

struct Kind
{
  const char* name;
  std::function<std::vector<float>()> render;
};

Camera lookingFrom(const Vec3& eye, const Vec3& target, const Matrix4& projection)
{
  return Camera(test::multiply(projection, test::lookAt(eye, target)), test::identityMatrix, pixels, pixels);
}

std::vector<float> numbers(const Image& image)
{
  return { image.rgba.begin(), image.rgba.end() };
}

std::vector<float> numbers(const HitImage& image)
{
  std::vector<float> result;
  for (const SurfaceHit& hit : image.hits)
  {
    result.insert(result.end(), { static_cast<float>(hit.t), hit.normal[0], hit.normal[1], hit.normal[2] });
  }
  return result;
}

/// All frames share the values that blocks keep, as a mapper's do.
class Frames
{
public:
  explicit Frames(const Scene& scene, std::shared_ptr<const Field> field)
    : scene_(scene)
    , field_(std::move(field))
    , volume_(field_, scene.transferFunction)
  {
  }

  std::vector<Kind> kinds()
  {
    return { { "volume", [&] { return volume(makeCamera(pixels)); } },
      { "inside",
        [&] {
          return volume(lookingFrom({ 0.7, 0.62, 0.4 }, { 0.1, 0.3, 0.8 }, test::perspective(80., 0.01, 5.)));
        } },
      { "parallel",
        [&] {
          return volume(lookingFrom({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 }, test::parallel(0.7, 0.1, 10.)));
        } },
      { "zoom", // that floats do not resolve
        [&] {
          return volume(lookingFrom({ 2.1, 1.7, 1.3 }, { 0.31, 0.52, 0.48 }, test::parallel(1e-6, 0.1, 10.)));
        } },
      { "means", [&] { return volume(makeCamera(pixels), {}, 4.); } },
      { "nearest", [&] { return nearest(); } }, { "slice", [&] { return slice(); } },
      { "depths", [&] { return depths(makeCamera(pixels)); } },
      { "surfaces", [&] { return surfaces(makeCamera(pixels)); } },
      { "isosurface", [&] { return numbers(hits(makeCamera(pixels))); } },
      { "maximum", [&] { return blend(VolumeBlend::Maximum); } },
      { "average", [&] { return blend(VolumeBlend::Average); } },
      { "additive", [&] { return blend(VolumeBlend::Additive); } },
      // Last: with gradients there is less memory for values.
      { "lit", [&] { return lit(true, false); } }, { "gradients", [&] { return lit(false, true); } },
      { "all", [&] { return lit(true, true); } } };
  }

private:
  std::vector<float> nearest()
  {
    VolumeSettings settings;
    settings.nearest = true;
    return volume(makeCamera(pixels), {}, settings);
  }

  std::vector<float> slice()
  {
    VolumeSettings settings;
    settings.blend = VolumeBlend::Slice;
    settings.unitDistance = 0.05;
    settings.slice = { { 0.3, 0.5, 0.8 }, 0.79 };
    return volume(makeCamera(pixels), {}, settings);
  }

  std::vector<float> blend(VolumeBlend blend)
  {
    VolumeSettings settings;
    settings.blend = blend;
    settings.unitDistance = 0.05;
    return volume(makeCamera(pixels), {}, settings);
  }

  /// By a headlight, as VTK has it by default.
  std::vector<float> lit(bool shades, bool byGradient)
  {
    const Camera camera = makeCamera(pixels);
    VolumeSettings settings;
    if (shades)
    {
      const Vec3 eye = camera.ray(pixels / 2, pixels / 2).origin;
      VolumeShading& shading = settings.shading.emplace();
      shading.lightsFromData[3] = -eye[0];
      shading.lightsFromData[7] = -eye[1];
      shading.lightsFromData[11] = -eye[2];
      Light headlight;
      headlight.positional = true;
      shading.lights = { headlight };
    }
    if (byGradient)
    {
      const Range range = field_->range();
      settings.gradientOpacity = GradientOpacity{ 48. * (range.max - range.min), { 0.f, 1.f, 1.f, 1.f } };
    }
    return volume(camera, {}, settings);
  }

  std::vector<float> volume(const Camera& camera, const RayStops& stops = {}, double means = 0.)
  {
    VolumeSettings settings;
    settings.levelOfDetailPixels = means;
    return volume(camera, stops, settings);
  }

  std::vector<float> volume(const Camera& camera, const RayStops& stops, const VolumeSettings& settings)
  {
    Image image(camera.width(), camera.height());
    volume_.render({ camera, stops }, settings, image);
    return numbers(image);
  }

  /// Depths that a picture of slanted stripes and holes would leave.
  std::vector<float> depths(const Camera& camera)
  {
    const std::size_t count = static_cast<std::size_t>(pixels) * pixels;
    std::vector<float> begin(count);
    std::vector<float> end(count);
    for (int y = 0; y < pixels; ++y)
    {
      for (int x = 0; x < pixels; ++x)
      {
        const Ray ray = camera.ray(x, y);
        const std::size_t pixel = static_cast<std::size_t>(y) * pixels + x;
        begin[pixel] = static_cast<float>(camera.depthFromT(ray, 1.2 + 0.002 * (x % 100)));
        end[pixel] = static_cast<float>(y % 50 < 10 ? 0.f : camera.depthFromT(ray, 1.5 + 0.001 * y));
      }
    }
    return volume(camera, RayStops::depths(begin.data(), end.data()));
  }

  std::vector<float> surfaces(const Camera& camera)
  {
    const HitImage image = hits(camera);
    std::vector<TranslucentHit> translucent;
    for (const SurfaceHit& hit : image.hits)
    {
      translucent.push_back(
        { hit.t, { std::abs(hit.normal[0]), std::abs(hit.normal[1]), std::abs(hit.normal[2]), 0.3f } });
    }
    RayStops stops;
    stops.hits = { image.first, translucent };
    return volume(camera, stops);
  }

  HitImage hits(const Camera& camera)
  {
    if (!isosurface_)
    {
      isosurface_ =
        std::make_unique<Isosurface>(field_, std::vector{ 0.4 * scene_.isovalue, scene_.isovalue });
    }
    HitImage image;
    isosurface_->startFrame();
    isosurface_->render(camera, SurfaceLayers::All, image);
    return image;
  }

  const Scene& scene_;
  std::shared_ptr<const Field> field_;
  Volume volume_;
  std::unique_ptr<Isosurface> isosurface_;
};

void writeFrames(const Options& options, const Scene& scene, const std::shared_ptr<const Field>& field)
{
  Frames frames(scene, field);
  for (const Kind& kind : frames.kinds())
  {
    const std::string name = scene.name + "-" + kind.name;
    if (!options.only.empty() && options.only != scene.name && options.only != name)
    {
      continue;
    }
    std::vector<float> frame;
    for (int i = 0; i < options.repeat; ++i)
    {
      frame = kind.render();
    }
    const std::filesystem::path path = options.out / (name + suffix);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(frame.data()),
      static_cast<std::streamsize>(frame.size() * sizeof(float)));
    if (!file.flush())
    {
      throw Error(path.string() + ": cannot be written");
    }
    std::printf("%-26s  %zu numbers\n", name.c_str(), frame.size());
    std::fflush(stdout);
  }
}

void write(const Options& options)
{
  std::filesystem::create_directories(options.out);
  std::vector<Scene> scenes = makeScenes();
  if (options.folder.empty())
  {
    Scene& scene = scenes.back();
    scene.name = "procedural";
    writeFrames(options, scene, buildProceduralField(6, 2.55));
    return;
  }
  for (const Scene& scene : scenes)
  {
    if (options.only.empty() || options.only.starts_with(scene.name))
    {
      Forest forest = readForest(options.folder + "/" + scene.name + ".p8est");
      writeFrames(options, scene, buildField(forest.roots, std::move(forest.cells)));
    }
  }
}

std::vector<float> read(const std::filesystem::path& path)
{
  std::vector<float> frame(std::filesystem::file_size(path) / sizeof(float));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(
        reinterpret_cast<char*>(frame.data()), static_cast<std::streamsize>(frame.size() * sizeof(float))))
  {
    throw Error(path.string() + ": cannot be read");
  }
  return frame;
}

/// False when a frame is another one, or missing.
bool compare(const std::filesystem::path& out, const std::filesystem::path& other, double tolerance)
{
  std::vector<std::filesystem::path> names;
  for (const std::filesystem::path& folder : { out, other })
  {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
    {
      names.push_back(entry.path().filename());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  bool equal = !names.empty();
  for (const std::filesystem::path& name : names)
  {
    if (!exists(out / name) || !exists(other / name))
    {
      std::printf("%-26s  in one folder only\n", name.stem().c_str());
      equal = false;
      continue;
    }
    const std::vector<float> a = read(out / name);
    const std::vector<float> b = read(other / name);
    if (a.size() != b.size())
    {
      std::printf("%-26s  %zu and %zu numbers\n", name.stem().c_str(), a.size(), b.size());
      equal = false;
      continue;
    }
    double largest = 0.;
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
      if (std::memcmp(&a[i], &b[i], sizeof(float)) != 0)
      {
        ++different;
        const double difference = std::abs(static_cast<double>(a[i]) - b[i]);
        largest = difference <= largest ? largest : difference; // not a number: kept
      }
    }
    const bool within = tolerance > 0. ? largest <= tolerance : different == 0;
    std::printf("%-26s  %zu of %zu numbers differ, by %.3g at most%s\n", name.stem().c_str(), different,
      a.size(), largest, within ? "" : ": too much");
    equal = equal && within;
  }
  return equal;
}

} // namespace

int run(const std::vector<std::string>& arguments)
{
  const auto number = [&](std::size_t i) { return std::strtod(arguments.at(i).c_str(), nullptr); };
  if (arguments.size() >= 3 && arguments.size() <= 4 && arguments[0] == "compare")
  {
    return compare(arguments[1], arguments[2], arguments.size() == 4 ? number(3) : 0.) ? 0 : 1;
  }
  if (arguments.size() >= 2 && arguments[0] == "write")
  {
    Options options;
    options.out = arguments[1];
    std::size_t i = 2;
    if (i < arguments.size() && !arguments[i].starts_with("--"))
    {
      options.folder = arguments[i++];
    }
    for (; i + 1 < arguments.size(); i += 2)
    {
      if (arguments[i] == "--only")
      {
        options.only = arguments[i + 1];
      }
      else if (arguments[i] == "--repeat")
      {
        options.repeat = static_cast<int>(number(i + 1));
      }
      else
      {
        break;
      }
    }
    if (i == arguments.size())
    {
      write(options);
      return 0;
    }
  }
  std::fprintf(stderr,
    "usage: treeamr-frames write OUT [FOLDER] [--only FRAME] [--repeat N]\n"
    "       treeamr-frames compare OUT OTHER [TOLERANCE]\n");
  return 2;
}

} // namespace treeamr::bench

int main(int argc, char* argv[])
{
  try
  {
    return treeamr::bench::run({ argv + 1, argv + argc });
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "treeamr-frames: %s\n", error.what());
    return 1;
  }
}
