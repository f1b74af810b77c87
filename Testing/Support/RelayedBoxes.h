// Boxes of a domain, each drawn by a thread of its own that goes on from what those before it have made.
#pragma once

#include "Partition/BoxCuts.h"
#include "Partition/BoxRelay.h"
#include "Support/Fields.h"
#include "Support/HeldCells.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeViews.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <utility>
#include <vector>

namespace treeamr::test
{

inline constexpr int width = 90;
inline constexpr int height = 50;
inline constexpr float tolerance = 1e-4f;

/// So that it hardly matters where samples begin, which those of a box do at its faces, and where rays end.
inline VolumeSettings fine()
{
  VolumeSettings settings;
  settings.samplesPerCell = 16.;
  settings.leastTransmittance = 1e-5f;
  return settings;
}

/// Between threads.
class Mailbox
{
public:
  void send(int from, int to, int channel, std::vector<float> numbers)
  {
    const std::lock_guard lock(mutex_);
    floats += channel == static_cast<int>(BoxPeers::Channel::Tiles) ? numbers.size() : 0;
    messages_[{ to, channel }].emplace_back(from, std::move(numbers));
  }
  int receive(int from, int to, int channel, std::vector<float>& numbers)
  {
    const std::lock_guard lock(mutex_);
    auto& queue = messages_[{ to, channel }];
    const auto found = std::ranges::find_if(
      queue, [from](const auto& message) { return from == BoxPeers::anyone || message.first == from; });
    if (found == queue.end())
    {
      return BoxPeers::anyone;
    }
    const int sender = found->first;
    numbers = std::move(found->second);
    queue.erase(found);
    return sender;
  }
  bool isEmpty() const
  {
    return std::ranges::all_of(messages_, [](const auto& queue) { return queue.second.empty(); });
  }

  std::size_t floats = 0; // of tiles

private:
  std::mutex mutex_;
  std::map<std::pair<int, int>, std::deque<std::pair<int, std::vector<float>>>> messages_;
};

class Peers : public BoxPeers
{
public:
  Peers(Mailbox& mailbox, int own, std::vector<bool> drawing)
    : mailbox_(mailbox)
    , own_(own)
    , drawing_(std::move(drawing))
  {
  }
  const std::vector<bool>& drawing() const override { return drawing_; }
  void send(int peer, Channel channel, std::vector<float> numbers) override
  {
    mailbox_.send(own_, peer, static_cast<int>(channel), std::move(numbers));
  }
  int receive(int peer, Channel channel, std::vector<float>& numbers) override
  {
    return mailbox_.receive(peer, own_, static_cast<int>(channel), numbers);
  }

private:
  Mailbox& mailbox_;
  int own_;
  std::vector<bool> drawing_;
};

struct Domain
{
  std::vector<LeafCell> cells =
    makeRandomTree({ .seed = 5, .roots = { 2, 2, 2 }, .levels = 5, .refine = 0.6 });
  RootGrid grid = unitRoots({ 2, 2, 2 });
  std::shared_ptr<const Field> field;

  Domain()
  {
    setValues(cells, [](const std::array<double, 3>& p) {
      return 0.3 + 0.6 * std::sin(p[0] + 0.5 * p[1]) * std::cos(p[2]);
    });
    field = makeField(grid, cells);
  }

  /// What the process holds that draws a box, its values rounded as all are.
  std::shared_ptr<const Field> part(const LatticeBox& box) const
  {
    auto built = buildOctree(grid, supportOf(grid, cells, box).cells);
    return std::make_shared<const Field>(
      built.octree, LargeVector<float>(built.values.begin(), built.values.end()), 0., field->range());
  }

  std::vector<LatticeBox> cut(int parts, int level = 3) const
  {
    CellHistogram histogram(grid.roots(), level);
    for (const LeafCell& leaf : cells)
    {
      histogram.add(leaf.cell);
    }
    return cutBoxes(histogram, parts);
  }
};

/// On a thread for each box: what it gives away.
inline std::vector<Image> drawAll(std::size_t count, const std::function<void(int, Image&)>& draw)
{
  std::vector<Image> images(count, Image(width, height));
  std::vector<std::thread> threads;
  for (std::size_t own = 0; own < count; ++own)
  {
    threads.emplace_back([&, own] { draw(static_cast<int>(own), images[own]); });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  return images;
}

/// No pixel is given away twice.
inline Image together(const std::vector<Image>& images)
{
  Image all(width, height);
  for (std::size_t pixel = 0; pixel < all.rgba.size() / 4; ++pixel)
  {
    int givers = 0;
    for (const Image& image : images)
    {
      const float* const rgba = &image.rgba[4 * pixel];
      givers += std::any_of(rgba, rgba + 4, [](float x) { return x != 0.f; });
      for (int c = 0; c < 4; ++c)
      {
        all.rgba[4 * pixel + c] += rgba[c];
      }
    }
    EXPECT_LE(givers, 1) << pixel;
  }
  return all;
}

inline float largestDifference(const Image& a, const Image& b)
{
  float largest = 0.f;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    largest = std::max(largest, std::abs(a.rgba[i] - b.rgba[i]));
  }
  return largest;
}

/// The window depths of something opaque in the domain, at random places of half of the rays.
inline std::vector<float> randomDepths(const Camera& camera, const Bounds& domain)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.01, 0.99);
  DataCut cut;
  cut.addBox(domain);
  std::vector<float> depths;
  for (int pixel = 0; pixel < width * height; ++pixel)
  {
    const Ray ray = camera.ray(pixel % width, pixel / width);
    const RayParts parts = cut.parts(ray.origin, ray.direction, camera.tFromDepth(ray, 0.), 1e9);
    depths.push_back(1.f);
    if (parts.count > 0 && random() % 2 == 0)
    {
      const double t = parts.begin[0] + place(random) * (parts.end[0] - parts.begin[0]);
      depths.back() = static_cast<float>(camera.depthFromT(ray, t));
    }
  }
  return depths;
}

/// Of those depths that lie in the box, in the window of which the opaque is then.
inline std::vector<float> depthsIn(
  const Bounds& box, const Bounds& domain, const Camera& camera, std::vector<float> depths)
{
  for (int pixel = 0; pixel < width * height; ++pixel)
  {
    const Ray ray = camera.ray(pixel % width, pixel / width);
    const Vec3 point = pointAt(ray, camera.tFromDepth(ray, depths[pixel]));
    bool isIn = true;
    for (int a = 0; a < 3; ++a)
    {
      const bool isLast = box.max[a] == domain.max[a]; // whose upper face is no other's
      isIn = isIn && point[a] >= box.min[a] && (point[a] < box.max[a] || (isLast && point[a] == box.max[a]));
    }
    depths[pixel] = isIn ? depths[pixel] : 1.f;
  }
  return depths;
}

} // namespace treeamr::test
