#include "ReferenceImage.h"

#include "Error.h"
#include "Support/VolumeReference.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>

namespace treeamr::bench
{

namespace
{

constexpr double samplesPerCell = 64.;
/// To be raised when the reference renderer's pictures change.
constexpr std::uint64_t rendererVersion = 2;

struct Header
{
  ContentDigest digest;
  std::int32_t width;
  std::int32_t height;
};
static_assert(sizeof(Header) == 24);

Header describe(const ContentDigest& forest, const TransferFunction& transferFunction, const Camera& camera,
  float leastTransmittance)
{
  Header header{ forest, camera.width(), camera.height() };
  header.digest.add(rendererVersion);
  header.digest.add(samplesPerCell);
  if (leastTransmittance != opaqueTransmittance)
  {
    header.digest.add(static_cast<double>(leastTransmittance));
  }
  header.digest.add(transferFunction.min());
  header.digest.add(transferFunction.scale());
  for (const TransferFunction::Entry& e : transferFunction.entries())
  {
    for (const float value : { e.r, e.g, e.b, e.extinction })
    {
      header.digest.add(static_cast<double>(value));
    }
  }
  for (const auto& [x, y] : { std::array{ 0, 0 }, { camera.width(), 0 }, { 0, camera.height() } })
  {
    const Ray ray = camera.ray(x, y);
    for (int a = 0; a < 3; ++a)
    {
      header.digest.add(ray.origin[a]);
      header.digest.add(ray.direction[a]);
    }
  }
  return header;
}

std::streamsize byteSize(const Image& image)
{
  return static_cast<std::streamsize>(image.rgba.size() * sizeof(float));
}

} // namespace

Image convergedImage(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  float leastTransmittance)
{
  Image image(camera.width(), camera.height());
  VolumeSettings settings;
  settings.samplesPerCell = samplesPerCell;
  settings.leastTransmittance = leastTransmittance;
  test::renderVolumeReference(field, transferFunction, camera, {}, settings, image);
  return image;
}

Image referenceImage(const std::string& path, const ContentDigest& forest, const Field& field,
  const TransferFunction& transferFunction, const Camera& camera, float leastTransmittance)
{
  const Header header = describe(forest, transferFunction, camera, leastTransmittance);
  Image image(camera.width(), camera.height());
  Header found{};
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(&found), sizeof(found));
  if (in && found.digest == header.digest && found.width == header.width && found.height == header.height &&
    in.read(reinterpret_cast<char*>(image.rgba.data()), byteSize(image)))
  {
    return image;
  }
  image = convergedImage(field, transferFunction, camera, leastTransmittance);
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&header), sizeof(header));
  out.write(reinterpret_cast<const char*>(image.rgba.data()), byteSize(image));
  if (!out.flush())
  {
    throw Error(path + ": cannot be written");
  }
  return image;
}

double psnr(const Image& image, const Image& reference)
{
  double sum = 0.;
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
  {
    sum += i % 4 < 3 ? std::pow(image.rgba[i] - reference.rgba[i], 2) : 0.;
  }
  return -10. * std::log10(sum / (0.75 * static_cast<double>(image.rgba.size())));
}

void writePicture(const std::string& path, const Image& image)
{
  std::ofstream out(path, std::ios::binary);
  out << "P6 " << image.width << ' ' << image.height << " 255\n";
  for (int y = image.height; y-- > 0;) // PPM begins at the top
  {
    for (int x = 0; x < image.width; ++x)
    {
      for (int c = 0; c < 3; ++c)
      {
        const float value = image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x) + c];
        out.put(static_cast<char>(std::lround(255.f * std::clamp(value, 0.f, 1.f))));
      }
    }
  }
  if (!out.flush())
  {
    throw Error(path + ": cannot be written");
  }
}

} // namespace treeamr::bench
