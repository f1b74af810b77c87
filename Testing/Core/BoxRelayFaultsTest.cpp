// A process that fails within a frame of several keeps none of the others waiting.
#include "Support/RelayedBoxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>

using namespace treeamr;
using namespace treeamr::test;

TEST(BoxRelayFaults, WhoFailsOrDrawsNothingLeavesTheOthersTheirPart)
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

TEST(BoxRelayFaults, WhoFailsWithinAMessageIsToldOfByAll)
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

TEST(BoxRelayFaults, WhoGivesUpBeforeItHasCollectedAnythingKeepsNobodyWaiting)
{
  const Domain domain;
  const std::vector<LatticeBox> boxes = domain.cut(4);
  const Camera camera(views().front().clip, width, height);
  const Camera finer(views().front().clip, 2 * width, 2 * height); // of a picture that is gathered
  for (const Camera* const of : { &camera, &finer })
  {
    for (int stopping = 0; stopping < 4; ++stopping)
    {
      Mailbox mailbox;
      const std::vector<Image> images = drawAll(boxes.size(), [&](int own, Image& image) {
        Peers peers(mailbox, own, std::vector<bool>(boxes.size(), true));
        BoxRelay relay(boxes, own, domain.grid, peers, *of, nullptr, image);
        ASSERT_TRUE(relay.begin(true));
        own == stopping ? relay.giveUp() : relayTiles(relay, [](const TileRun&) {});
        EXPECT_TRUE(relay.end(false));
      });
      EXPECT_TRUE(mailbox.isEmpty());
      EXPECT_TRUE(std::ranges::all_of(images[stopping].rgba, [](float x) { return x == 0.f; }));
    }
  }
}
