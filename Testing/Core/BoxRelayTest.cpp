// A frame of several boxes, each drawn by a thread of its own that goes on from what those before it have made: what all give
// away is the picture of the whole.
#include "Partition/BoxRelay.h"
#include "Error.h"
#include "Partition/BoxCuts.h"
#include "Support/Fields.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeViews.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <random>
#include <stdexcept>
#include <thread>
#include <tuple>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 90;
constexpr int height = 50;
constexpr float tolerance = 1e-4f;

/// So that it hardly matters where samples begin, which those of a box do at its faces, and where rays end.
VolumeSettings fine()
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
std::vector<Image> drawAll(std::size_t count, const std::function<void(int, Image&)>& draw)
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
Image together(const std::vector<Image>& images)
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

float largestDifference(const Image& a, const Image& b)
{
  float largest = 0.f;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    largest = std::max(largest, std::abs(a.rgba[i] - b.rgba[i]));
  }
  return largest;
}

/// The window depths of something opaque in the domain, at random places of half of the rays.
std::vector<float> randomDepths(const Camera& camera, const Bounds& domain)
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
std::vector<float> depthsIn(
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

} // namespace

TEST(BoxOrder, ABoxComesAfterAllThatARayMeetsBeforeIt)
{
  const Domain domain;
  for (const int parts : { 1, 2, 3, 8, 21 })
  {
    const std::vector<LatticeBox> boxes = domain.cut(parts, parts == 21 ? 0 : 3); // 13 are empty then
    for (const View& view : views())
    {
      const Camera camera(view.clip, width, height);
      std::vector<std::size_t> places(boxes.size());
      const std::vector<int> order = frontToBack(boxes, domain.grid, camera);
      EXPECT_EQ(order.size(), parts == 21 ? 8u : boxes.size());
      for (std::size_t place = 0; place < order.size(); ++place)
      {
        places[order[place]] = place;
      }
      for (int pixel = 0; pixel < width * height; pixel += 7)
      {
        const Ray ray = camera.ray(pixel % width, pixel / width);
        std::vector<std::pair<double, std::size_t>> met; // where, and the place in the order
        for (std::size_t b = 0; b < boxes.size(); ++b)
        {
          DataCut cut;
          cut.addBox(boxes[b].bounds(domain.grid));
          const RayParts parts_ = cut.parts(ray.origin, ray.direction, camera.tFromDepth(ray, 0.), 1e9);
          const BoxFootprint footprint(boxes[b].bounds(domain.grid), camera);
          if (boxes[b].isEmpty())
          {
            continue;
          }
          const bool isMet = footprint.meets(pixel % width, pixel / width);
          if (parts_.count > 0 && parts_.end[0] - parts_.begin[0] > 1e-9)
          {
            EXPECT_TRUE(isMet);
            EXPECT_TRUE(pixel % width >= footprint.left() && pixel % width < footprint.right() &&
              pixel / width >= footprint.lower() && pixel / width < footprint.upper());
            met.emplace_back(parts_.begin[0], places[b]);
          }
          else if (parts_.count == 0)
          {
            EXPECT_FALSE(isMet);
          }
        }
        std::ranges::sort(met);
        EXPECT_TRUE(std::ranges::is_sorted(met, {}, [](const auto& box) { return box.second; })) << view.name;
      }
    }
  }
}

TEST(BoxOrder, BoxesThatNoPlanePartsAreAnError)
{
  const Domain domain;
  const Camera camera(views().front().clip, width, height);
  EXPECT_THROW(frontToBack({ { 0, {}, { 2, 2, 1 } }, { 0, {}, { 2, 1, 2 } } }, domain.grid, camera), Error);
}

TEST(BoxRelay, BoxesTogetherAreTheWhole)
{
  const Domain domain;
  for (const int parts : { 2, 3, 8 })
  {
    const std::vector<LatticeBox> boxes = domain.cut(parts);
    for (const View& view : views())
    {
      for (const bool hasOpaque : { false, true })
      {
        const Camera camera(view.clip, width, height);
        const std::vector<float> depths =
          hasOpaque ? randomDepths(camera, domain.grid.bounds()) : std::vector<float>();
        Image whole(width, height);
        const VolumeStatistics ofWhole = renderVolume(*domain.field, smooth(), camera,
          RayStops::depths(nullptr, hasOpaque ? depths.data() : nullptr), fine(), whole);
        Mailbox mailbox;
        std::mutex mutex;
        std::uint64_t samples = 0;
        const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
          Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
          const Bounds box = boxes[own].bounds(domain.grid);
          const std::vector<float> ownDepths =
            hasOpaque ? depthsIn(box, domain.grid.bounds(), camera, depths) : depths;
          RayStops stops = RayStops::depths(nullptr, hasOpaque ? ownDepths.data() : nullptr);
          stops.cut.addBox(box);
          BoxRelay relay(boxes, own, domain.grid, peers, camera, stops.endDepth, image);
          if (relay.begin(true))
          {
            const VolumeStatistics statistics =
              volumeOf(*domain.field, smooth()).render({ camera, stops }, fine(), image, relay);
            const std::lock_guard lock(mutex);
            samples += statistics.samples;
          }
        });
        EXPECT_LT(largestDifference(together(images), whole), tolerance)
          << parts << " boxes, " << view.name << (hasOpaque ? ", opaque" : "");
        EXPECT_TRUE(mailbox.isEmpty());
        if (std::string(view.name) != "inside" && !hasOpaque) // there are some that see nothing
        {
          EXPECT_LT(static_cast<double>(samples), 1.2 * static_cast<double>(ofWhole.samples)) << view.name;
        }
      }
    }
  }
}

TEST(BoxRelay, SurfacesInBoxesComeInTheirOrder)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(5);
  const Camera camera(views().front().clip, width, height);
  const auto hitsIn = [&](const DataCut& cut, std::vector<std::size_t>& first) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> t(2., 8.);
    std::uniform_real_distribution<float> colour(0.f, 1.f);
    std::vector<TranslucentHit> hits;
    first.assign(1, 0);
    for (int pixel = 0; pixel < width * height; ++pixel)
    {
      const Ray ray = camera.ray(pixel % width, pixel / width);
      std::vector<TranslucentHit> ofRay;
      for (int i = 0; i < 4; ++i)
      {
        ofRay.push_back(
          { t(random), { colour(random), colour(random), colour(random), 0.5f * colour(random) } });
      }
      std::ranges::sort(ofRay, {}, &TranslucentHit::t);
      std::ranges::copy_if(ofRay, std::back_inserter(hits), [&](const TranslucentHit& hit) {
        const RayParts parts = cut.parts(ray.origin, ray.direction, 0., 100.);
        return parts.count > 0 && hit.t >= parts.begin[0] && hit.t < parts.end[0];
      });
      first.push_back(hits.size());
    }
    return hits;
  };
  const auto stopsOf = [&](const Bounds& box, std::vector<std::size_t>& first,
                         std::vector<TranslucentHit>& hits) {
    RayStops stops;
    stops.cut.addBox(box);
    hits = hitsIn(stops.cut, first);
    stops.hits = { first, hits };
    return stops;
  };
  std::vector<std::size_t> first;
  std::vector<TranslucentHit> hits;
  Image whole(width, height);
  renderVolume(*domain.field, smooth(), camera, stopsOf(domain.grid.bounds(), first, hits), fine(), whole);
  Mailbox mailbox;
  const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
    Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
    std::vector<std::size_t> ownFirst;
    std::vector<TranslucentHit> ownHits;
    const RayStops stops = stopsOf(boxes[own].bounds(domain.grid), ownFirst, ownHits);
    BoxRelay relay(boxes, own, domain.grid, peers, camera, nullptr, image);
    ASSERT_TRUE(relay.begin(true));
    volumeOf(*domain.field, smooth()).render({ camera, stops }, fine(), image, relay);
  });
  EXPECT_LT(largestDifference(together(images), whole), tolerance);
}

TEST(BoxRelay, WhoFailsOrDrawsNothingLeavesTheOthersTheirPart)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(4);
  const Camera camera(views().front().clip, width, height);
  constexpr int failing = 1;
  std::vector<bool> drawing(boxes.size(), true);
  drawing[2] = false;
  Image expected(width, height);
  for (const int peer : frontToBack(boxes, domain.grid, camera))
  {
    if (peer != failing && drawing[peer])
    {
      RayStops stops;
      stops.cut.addBox(boxes[peer].bounds(domain.grid));
      Image part(width, height);
      VolumeSettings settings;
      settings.samplesPerCell = 16.; // samples are others than where light is known
      renderVolume(*domain.field, smooth(), camera, stops, settings, part);
      for (std::size_t i = 0; i < part.rgba.size(); ++i)
      {
        part.rgba[i] *= 1.f - expected.rgba[i / 4 * 4 + 3];
      }
      std::ranges::transform(part.rgba, expected.rgba, expected.rgba.begin(), std::plus());
    }
  }
  Mailbox mailbox;
  const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
    if (!drawing[own])
    {
      return;
    }
    Peers peers(mailbox, own, drawing);
    RayStops stops;
    stops.cut.addBox(boxes[own].bounds(domain.grid));
    VolumeSettings settings;
    settings.samplesPerCell = 16.;
    BoxRelay relay(boxes, own, domain.grid, peers, camera, nullptr, image);
    ASSERT_TRUE(relay.begin(true));
    if (own == failing)
    {
      EXPECT_THROW(
        relayTiles(relay, [](const TileRun&) { throw std::runtime_error("no more"); }), std::runtime_error);
      return;
    }
    volumeOf(*domain.field, smooth()).render({ camera, stops }, settings, image, relay);
  });
  EXPECT_LT(largestDifference(together(images), expected), 2e-3f);
  EXPECT_TRUE(mailbox.isEmpty());
}

TEST(BoxRelay, BeginsWhereAllCanAndSeeTheSame)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(7);
  const Camera camera(views().front().clip, width, height);
  Matrix4 moved = camera.clipFromData();
  moved[3] = std::nextafter(moved[3], 10.);
  const Camera otherCamera(moved, width, height);
  for (int odd = -1; odd < 7; ++odd)
  {
    for (const bool seesOther : { false, true })
    {
      Mailbox mailbox;
      drawAll(boxes.size(), [&](int own, Image& image) {
        Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
        BoxRelay relay(
          boxes, own, domain.grid, peers, own == odd && seesOther ? otherCamera : camera, nullptr, image);
        EXPECT_EQ(relay.begin(own != odd || seesOther), odd < 0);
        if (odd < 0)
        {
          relayTiles(relay, [](const TileRun&) {});
        }
      });
      EXPECT_TRUE(mailbox.isEmpty());
    }
  }
}

TEST(BoxRelay, OneBoxOrNoneThatIsSeenHasNobodyToAsk)
{
  const Domain domain;
  const Camera camera(views().front().clip, width, height);
  for (const std::vector<bool>& drawing : { std::vector<bool>{ true, false }, { false, false } })
  {
    Mailbox mailbox;
    Peers peers(mailbox, 0, drawing);
    Image image(width, height);
    BoxRelay relay(domain.cut(2), 0, domain.grid, peers, camera, nullptr, image);
    EXPECT_FALSE(relay.begin(true));
    EXPECT_TRUE(mailbox.isEmpty());
  }
}

TEST(BoxRelay, BlendsOfValuesTogetherAreTheWhole)
{
  const Domain domain;
  for (const VolumeBlend blend :
    { VolumeBlend::Maximum, VolumeBlend::Minimum, VolumeBlend::Average, VolumeBlend::Additive })
  {
    const bool isExtreme = blend == VolumeBlend::Maximum || blend == VolumeBlend::Minimum;
    VolumeSettings settings = fine();
    settings.blend = blend;
    settings.unitDistance = 20.; // sums are neither black nor white
    settings.averageRange = { 0.2f, 0.9f };
    for (const int parts : { 2, 3, 8 })
    {
      const std::vector<LatticeBox> boxes = domain.cut(parts);
      for (const View& view : views())
      {
        for (const bool hasOpaque : { false, true })
        {
          const Camera camera(view.clip, width, height);
          const std::vector<float> depths =
            hasOpaque ? randomDepths(camera, domain.grid.bounds()) : std::vector<float>();
          Image whole(width, height);
          renderVolume(*domain.field, smooth(), camera,
            RayStops::depths(nullptr, hasOpaque ? depths.data() : nullptr), settings, whole);
          Mailbox mailbox;
          const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
            Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
            const Bounds box = boxes[own].bounds(domain.grid);
            const std::vector<float> ownDepths =
              hasOpaque ? depthsIn(box, domain.grid.bounds(), camera, depths) : depths;
            RayStops stops = RayStops::depths(nullptr, hasOpaque ? ownDepths.data() : nullptr);
            stops.cut.addBox(box);
            BoxRelay relay(boxes, own, domain.grid, peers, camera, stops.endDepth, image);
            if (relay.begin(true))
            {
              volumeOf(*domain.field, smooth()).render({ camera, stops }, settings, image, relay);
            }
          });
          EXPECT_LT(largestDifference(together(images), whole), isExtreme ? 1e-5f : 2e-3f)
            << static_cast<int>(blend) << ", " << parts << " boxes, " << view.name
            << (hasOpaque ? ", opaque" : "");
          EXPECT_TRUE(mailbox.isEmpty());
        }
      }
    }
  }
}

namespace
{

/// Whose memory is used up after some messages of tiles.
class FailingPeers : public Peers
{
public:
  enum class Way
  {
    Sending,
    Receiving
  };

  FailingPeers(Mailbox& mailbox, int own, std::vector<bool> drawing, Way way, int messages)
    : Peers(mailbox, own, std::move(drawing))
    , way_(way)
    , left_(messages)
  {
  }
  void send(int peer, Channel channel, std::vector<float> numbers) override
  {
    constexpr std::size_t fits = 16;
    if (way_ == Way::Sending && channel == Channel::Tiles && numbers.size() > fits)
    {
      count();
    }
    Peers::send(peer, channel, std::move(numbers));
  }
  int receive(int peer, Channel channel, std::vector<float>& numbers) override
  {
    if (way_ == Way::Receiving && channel == Channel::Tiles && !hasFailed)
    {
      count();
    }
    return Peers::receive(peer, channel, numbers);
  }

  bool hasFailed = false;

private:
  void count()
  {
    if (left_-- <= 0)
    {
      hasFailed = true;
      throw std::bad_alloc();
    }
  }

  Way way_;
  int left_;
};

} // namespace

TEST(BoxRelay, WhoFailsWithinAMessageIsToldOfByAll)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(4);
  const Camera camera(views().front().clip, width, height);
  Image whole(width, height);
  renderVolume(*domain.field, smooth(), camera, {}, fine(), whole);
  int failures = 0;
  for (int failing = 0; failing < 4; ++failing)
  {
    const BoxFootprint footprint(boxes[failing].bounds(domain.grid), camera);
    for (const FailingPeers::Way way : { FailingPeers::Way::Sending, FailingPeers::Way::Receiving })
    {
      for (const int messages : { 0, 1, 3 })
      {
        Mailbox mailbox;
        std::array<bool, 4> have{};
        bool hasFailed = false;
        const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
          const std::vector<bool> drawing(boxes.size(), true);
          FailingPeers peers(mailbox, own, drawing, way, own == failing ? messages : 1 << 30);
          RayStops stops;
          stops.cut.addBox(boxes[own].bounds(domain.grid));
          BoxRelay relay(boxes, own, domain.grid, peers, camera, nullptr, image);
          ASSERT_TRUE(relay.begin(true));
          try
          {
            volumeOf(*domain.field, smooth()).render({ camera, stops }, fine(), image, relay);
          }
          catch (const std::bad_alloc&)
          {
            relay.giveUp();
          }
          if (own == failing)
          {
            hasFailed = peers.hasFailed;
          }
          have[own] = relay.end(peers.hasFailed);
        });
        // The last box sends nothing, the first one waits for nothing.
        EXPECT_EQ(std::ranges::count(have, !hasFailed), 4);
        EXPECT_TRUE(mailbox.isEmpty());
        failures += hasFailed;
        const Image all = together(images);
        for (int pixel = 0; pixel < width * height; ++pixel)
        {
          const int x = pixel % width;
          const int y = pixel / width;
          const TileRun run{ y / TileRun::tileWidth, x / 64 * 4, x / 64 * 4 + 4 };
          const bool isPast = hasFailed && footprint.left() < run.columnEnd * 16 &&
            footprint.right() > run.columnBegin * 16 && footprint.lower() < (run.row + 1) * 16 &&
            footprint.upper() > run.row * 16;
          for (int c = 0; c < 4 && !isPast; ++c)
          {
            EXPECT_NEAR(all.rgba[4 * pixel + c], whole.rgba[4 * pixel + c], tolerance);
          }
        }
      }
    }
  }
  EXPECT_GE(failures, 12);
}

TEST(BoxRelay, WhoGivesUpBeforeItHasCollectedAnythingKeepsNobodyWaiting)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(4);
  const Camera camera(views().front().clip, width, height);
  for (int stopping = 0; stopping < 4; ++stopping)
  {
    Mailbox mailbox;
    const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
      Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
      BoxRelay relay(boxes, own, domain.grid, peers, camera, nullptr, image);
      ASSERT_TRUE(relay.begin(true));
      own == stopping ? relay.giveUp() : relayTiles(relay, [](const TileRun&) {});
      EXPECT_TRUE(relay.end(false));
    });
    EXPECT_TRUE(mailbox.isEmpty());
    EXPECT_TRUE(std::ranges::all_of(images[stopping].rgba, [](float x) { return x == 0.f; }));
  }
}

TEST(BoxRelay, BeginsWhereAllTellValuesAlike)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(3);
  const Camera camera(views().front().clip, width, height);
  for (int odd = -1; odd < 3; ++odd)
  {
    Mailbox mailbox;
    drawAll(boxes.size(), [&](int own, Image& image) {
      Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
      BoxRelay relay(boxes, own, domain.grid, peers, camera, nullptr, image);
      const std::array<double, 2> range{ 0., own == odd ? std::nextafter(1., 2.) : 1. };
      EXPECT_EQ(relay.begin(true, range), odd < 0);
      if (odd < 0)
      {
        relayTiles(relay, [](const TileRun&) {});
      }
    });
    EXPECT_TRUE(mailbox.isEmpty());
  }
}
