// A frame of several boxes, each drawn by a thread of its own that goes on from what those before it have made: what all give
// away is the picture of the whole.
#include "Error.h"
#include "Support/RelayedBoxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <random>
#include <string>

using namespace treeamr;
using namespace treeamr::test;

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

/// How many have anything.
long givers(const std::vector<Image>& images)
{
  return std::ranges::count_if(images,
    [](const Image& image) { return std::ranges::any_of(image.rgba, [](float x) { return x != 0.f; }); });
}

struct PictureOptions
{
  int reduction = 1;            // pixels of the camera along each axis for one of the picture
  DataCut cut{};                // of all
  bool withOpaqueThings = true; // else only without
};

/// Pictures that boxes make together, and that of the whole domain, in several cuts, views and with something opaque or not:
/// check(difference, samples of all boxes, samples of the whole, hasOpaque, view, what to say of it).
template <class Check>
void forEachPicture(const Domain& domain, const VolumeSettings& settings, const Check& check,
  const PictureOptions& options = {})
{
  for (const int count : { 2, 3, 8 })
  {
    const std::vector<LatticeBox> boxes = domain.cut(count);
    std::vector<std::shared_ptr<const Field>> parts;
    for (const LatticeBox& box : boxes)
    {
      parts.push_back(domain.part(box));
    }
    for (const View& view : views())
    {
      for (const bool hasOpaque : { false, true })
      {
        if (hasOpaque && !options.withOpaqueThings)
        {
          continue;
        }
        const Camera camera(view.clip, width, height);
        const std::vector<float> depths =
          hasOpaque ? randomDepths(camera, domain.grid.bounds()) : std::vector<float>();
        Image whole(width, height);
        RayStops stopsOfWhole = RayStops::depths(nullptr, hasOpaque ? depths.data() : nullptr);
        stopsOfWhole.cut = options.cut;
        const VolumeStatistics ofWhole =
          renderVolume(*domain.field, smooth(), camera, stopsOfWhole, settings, whole);
        Mailbox mailbox;
        std::mutex mutex;
        std::uint64_t samples = 0;
        const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
          Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
          const Bounds box = boxes[own].bounds(domain.grid);
          const std::vector<float> ownDepths =
            hasOpaque ? depthsIn(box, domain.grid.bounds(), camera, depths) : depths;
          RayStops stops = RayStops::depths(nullptr, hasOpaque ? ownDepths.data() : nullptr);
          stops.cut = options.cut;
          const Camera ofAll(view.clip, options.reduction * width, options.reduction * height);
          BoxRelay relay(boxes, own, domain.grid, peers, ofAll, stops.endDepth, image);
          if (relay.begin(true, { .cutsAtFaces = false }))
          {
            const VolumeStatistics statistics =
              volumeOf(*parts[own], smooth()).render({ camera, stops }, settings, image, relay);
            const std::lock_guard lock(mutex);
            samples += statistics.samples;
          }
        });
        const std::string about =
          std::to_string(count) + " boxes, " + view.name + (hasOpaque ? ", opaque" : "");
        check(largestDifference(together(images), whole), samples, ofWhole.samples, hasOpaque, view, about);
        EXPECT_TRUE(mailbox.isEmpty()) << about;
        EXPECT_TRUE(options.reduction == 1 || givers(images) <= 1) << about;
      }
    }
  }
}

TEST(BoxRelay, BoxesTogetherAreTheWhole)
{
  forEachPicture(Domain(), fine(),
    [](float difference, std::uint64_t samples, std::uint64_t ofWhole, bool hasOpaque, const View& view,
      const std::string& about) {
      EXPECT_LT(difference, tolerance) << about;
      if (std::string(view.name) != "inside" && !hasOpaque) // there are some that see nothing
      {
        EXPECT_LT(static_cast<double>(samples), 1.2 * static_cast<double>(ofWhole)) << about;
      }
    });
}

TEST(BoxRelay, StepsAreThoseOfTheWhole)
{
  // Few and long ones, which would show where boxes cut them.
  VolumeSettings few;
  few.samplesPerCell = 1.;
  VolumeSettings lit;
  lit.shading.emplace();
  lit.shading->lights.push_back({ .direction = { 0., 0., -1. } });
  VolumeSettings inDoubles;
  inDoubles.doubles = true;
  DataCut cut; // of most rays, into two parts
  cut.halfSpaces.push_back({ { 1., 0.3, -0.2 }, 0.4 });
  cut.cropping = CroppingRegions{ { 0.8, 1.1, 0.7, 1.2, 0.5, 1.3 }, ~(1u << 13) };
  const Domain domain;
  for (const auto& [settings, ofAll] : { std::pair(few, DataCut()), { VolumeSettings(), DataCut() },
         { lit, DataCut() }, { inDoubles, DataCut() }, { few, cut } })
  {
    forEachPicture(domain, settings,
      [](float difference, std::uint64_t samples, std::uint64_t ofWhole, bool /*hasOpaque*/, const View& view,
        const std::string& about) {
        EXPECT_LT(difference, 1e-6f) << about;
        if (std::string(view.name) != "inside") // as above
        {
          EXPECT_NEAR(
            static_cast<double>(samples), static_cast<double>(ofWhole), 1e-4 * static_cast<double>(ofWhole))
            << about;
        }
      },
      { .cut = ofAll, .withOpaqueThings = false }); // these end rays that another process begins
  }
}

TEST(BoxRelay, PicturesToBeEnlargedAreOneProcesss)
{
  forEachPicture(Domain(), fine(),
    [](float difference, auto&&, auto&&, bool hasOpaque, auto&&, const std::string& about) {
      EXPECT_LT(difference, hasOpaque ? tolerance : 1e-6f) << about;
    },
    { .reduction = 5 });
  VolumeSettings maximum = fine();
  maximum.blend = VolumeBlend::Maximum;
  forEachPicture(Domain(), maximum,
    [](float difference, auto&&, auto&&, auto&&, auto&&, const std::string& about) {
      EXPECT_LT(difference, 1e-5f) << about;
    },
    { .reduction = 2 });
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
    forEachPicture(
      domain, settings, [&](float difference, auto&&, auto&&, auto&&, auto&&, const std::string& about) {
        EXPECT_LT(difference, isExtreme ? 1e-5f : 2e-3f) << static_cast<int>(blend) << ", " << about;
      });
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
      EXPECT_EQ(relay.begin(true, { .alike = range }), odd < 0);
      if (odd < 0)
      {
        relayTiles(relay, [](const TileRun&) {});
      }
    });
    EXPECT_TRUE(mailbox.isEmpty());
  }
}
