// Pictures of a ball, as files and looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

constexpr int pictureSize = 120; // pixels along an edge

/// rgba: four floats a pixel, lower left first, colour times alpha. Writes a PPM before black and counts what is drawn:
/// whether that is a disk in the middle of such a radius, in edges of the picture.
inline bool writeBall(const std::string& path, const std::vector<float>& rgba, double radius)
{
  std::ofstream file(path, std::ios::binary);
  file << "P6\n" << pictureSize << " " << pictureSize << "\n255\n";
  int drawn = 0;
  int wrong = 0;
  for (int y = pictureSize - 1; y >= 0; --y)
  {
    for (int x = 0; x < pictureSize; ++x)
    {
      const float* const pixel = rgba.data() + 4 * (static_cast<std::size_t>(y) * pictureSize + x);
      for (int c = 0; c < 3; ++c)
      {
        file.put(static_cast<char>(static_cast<int>(255.f * std::clamp(pixel[c], 0.f, 1.f) + 0.5f)));
      }
      const double fromMiddle =
        std::hypot((x + 0.5) / pictureSize - 0.5, (y + 0.5) / pictureSize - 0.5) - radius;
      const bool isDrawn = pixel[3] > 0.f;
      drawn += isDrawn;
      wrong += std::abs(fromMiddle) > 3. / pictureSize && isDrawn != (fromMiddle < 0.);
    }
  }
  std::cout << path << ": " << drawn << " pixels drawn, " << wrong
            << " of them or others at the wrong place\n";
  return file.good() && drawn > 0 && wrong == 0;
}
