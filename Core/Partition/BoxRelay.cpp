#include "Partition/BoxRelay.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <thread>

namespace treeamr
{

namespace
{

/// What is sent of a pixel that has been given away: no ray has less than no red, and none goes on from no light.
constexpr std::array<float, 4> givenAway{ -1.f, 0.f, 0.f, 1.f };

bool isGivenAway(const float* rgba) noexcept
{
  return rgba[0] < 0.f;
}

constexpr int tilesOf(int pixels) noexcept
{
  return (pixels + TileRun::tileWidth - 1) / TileRun::tileWidth;
}

/// In numbers that floats have.
std::array<float, 4> keyOf(const Camera& camera)
{
  std::uint64_t hash = 14695981039346656037u; // Fowler, Noll and Vo
  const auto add = [&](std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte)
    {
      hash = (hash ^ (bits >> 8 * byte & 0xff)) * 1099511628211u;
    }
  };
  for (const double element : camera.clipFromData())
  {
    std::uint64_t bits;
    std::memcpy(&bits, &element, sizeof(bits));
    add(bits);
  }
  add(static_cast<std::uint64_t>(camera.width()) << 32 | static_cast<std::uint64_t>(camera.height()));
  std::array<float, 4> key;
  for (int part = 0; part < 4; ++part)
  {
    key[part] = static_cast<float>(hash >> 16 * part & 0xffff);
  }
  return key;
}

} // namespace

bool BoxRelay::Box::overlaps(const TileRun& run) const noexcept
{
  constexpr int width = TileRun::tileWidth;
  return footprint.left() < run.columnEnd * width && footprint.right() > run.columnBegin * width &&
    footprint.lower() < (run.row + 1) * width && footprint.upper() > run.row * width;
}

BoxRelay::BoxRelay(const std::vector<LatticeBox>& boxes, int own, const RootGrid& grid, BoxPeers& peers,
  const Camera& camera, const float* endDepth, Image& image)
  : peers_(peers)
  , camera_(camera)
  , endDepth_(endDepth)
  , image_(image)
  , runsInRow_((tilesOf(image.width) + TileRun::mostTiles - 1) / TileRun::mostTiles)
  , rows_(tilesOf(image.height))
{
  for (const int peer : frontToBack(boxes, grid, camera))
  {
    const auto number = static_cast<std::size_t>(peer);
    const BoxFootprint footprint(boxes[number].bounds(grid), camera_);
    if (number < peers.drawing().size() && peers.drawing()[number] && footprint.isSeen())
    {
      boxes_.push_back({ peer, footprint });
    }
  }
  const auto found =
    std::find_if(boxes_.begin(), boxes_.end(), [own](const Box& box) { return box.peer == own; });
  own_ = static_cast<std::size_t>(found - boxes_.begin());
}

BoxRelay::~BoxRelay()
{
  if (hasBegun_)
  {
    this->agree(true); // a process that is done leaves the processor to the others
  }
}

bool BoxRelay::begin(bool can)
{
  if (boxes_.size() < 2 || own_ == boxes_.size())
  {
    return false;
  }
  hasBegun_ = this->agree(can);
  if (hasBegun_)
  {
    this->findLast();
  }
  return hasBegun_;
}

/// In steps of 1, 2, 4 ... processes: each tells another one what all before it have told.
bool BoxRelay::agree(bool can)
{
  std::array<float, 4> least = keyOf(camera_);
  std::array<float, 4> most = least;
  bool all = can;
  const std::size_t count = boxes_.size();
  for (std::size_t step = 1; step < count; step *= 2)
  {
    std::vector<float> numbers{ all ? 1.f : 0.f };
    numbers.insert(numbers.end(), least.begin(), least.end());
    numbers.insert(numbers.end(), most.begin(), most.end());
    peers_.send(boxes_[(own_ + step) % count].peer, BoxPeers::Channel::Agreement, numbers);
    const int from = boxes_[(own_ + count - step) % count].peer;
    while (peers_.receive(from, BoxPeers::Channel::Agreement, numbers) == BoxPeers::anyone)
    {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    std::array<float, 4> other;
    all = all && numbers[0] == 1.f;
    std::copy_n(&numbers[1], 4, other.begin());
    least = std::min(least, other);
    std::copy_n(&numbers[5], 4, other.begin());
    most = std::max(most, other);
  }
  return all && least == most;
}

TileRun BoxRelay::runOf(int number) const noexcept
{
  const int column = number % runsInRow_ * TileRun::mostTiles;
  return { number / runsInRow_, column, std::min(column + TileRun::mostTiles, tilesOf(image_.width)) };
}

int BoxRelay::numberOf(const TileRun& run) const noexcept
{
  return run.row * runsInRow_ + run.columnBegin / TileRun::mostTiles;
}

int BoxRelay::neighbour(const TileRun& run, int step) const noexcept
{
  for (std::size_t i = own_ + step; i < boxes_.size(); i += step) // wraps around below 0
  {
    if (boxes_[i].overlaps(run))
    {
      return boxes_[i].peer;
    }
  }
  return BoxPeers::anyone;
}

template <class Use>
void BoxRelay::forEachPixel(const TileRun& run, const Use& use)
{
  constexpr int width = TileRun::tileWidth;
  for (int y = run.row * width; y < std::min((run.row + 1) * width, image_.height); ++y)
  {
    for (int x = run.columnBegin * width; x < std::min(run.columnEnd * width, image_.width); ++x)
    {
      use(x, y, static_cast<std::size_t>(y) * image_.width + x);
    }
  }
}

void BoxRelay::findLast()
{
  isLast_.assign(image_.rgba.size() / 4, 0);
  tbb::parallel_for(0, runsInRow_ * rows_, [this](int number) {
    const TileRun run = runOf(number);
    if (!boxes_[own_].overlaps(run))
    {
      return;
    }
    std::vector<const BoxFootprint*> behind;
    for (std::size_t i = own_ + 1; i < boxes_.size(); ++i)
    {
      if (boxes_[i].overlaps(run))
      {
        behind.push_back(&boxes_[i].footprint);
      }
    }
    forEachPixel(run, [&](int x, int y, std::size_t pixel) {
      isLast_[pixel] = std::none_of(
        behind.begin(), behind.end(), [&](const BoxFootprint* other) { return other->meets(x, y); });
    });
  });
}

bool BoxRelay::collect(std::vector<TileRun>& ready)
{
  if (!hasStarted_)
  {
    hasStarted_ = true;
    for (int number = 0; number < runsInRow_ * rows_; ++number)
    {
      const TileRun run = runOf(number);
      if (boxes_[own_].overlaps(run))
      {
        neighbour(run, -1) == BoxPeers::anyone ? ready.push_back(run) : static_cast<void>(++awaited_);
      }
    }
  }
  std::vector<float> numbers;
  while (
    awaited_ > 0 && peers_.receive(BoxPeers::anyone, BoxPeers::Channel::Tiles, numbers) != BoxPeers::anyone)
  {
    this->take(numbers, ready);
  }
  return awaited_ > 0;
}

void BoxRelay::take(const std::vector<float>& numbers, std::vector<TileRun>& ready)
{
  const TileRun run = runOf(static_cast<int>(numbers.front()));
  const float* rgba = numbers.data() + 1;
  forEachPixel(run, [&](int, int, std::size_t pixel) {
    std::copy_n(rgba, 4, &image_.rgba[4 * pixel]);
    rgba += 4;
  });
  ready.push_back(run);
  --awaited_;
}

void BoxRelay::finish(const TileRun& run)
{
  std::vector<float> numbers{ static_cast<float>(numberOf(run)) };
  forEachPixel(run, [&](int, int, std::size_t pixel) {
    float* const rgba = &image_.rgba[4 * pixel];
    const bool isGiven = isGivenAway(rgba);
    const bool gives = !isGiven && (isLast_[pixel] || (endDepth_ && endDepth_[pixel] < 1.f));
    const float* const goesOn = isGiven || gives ? givenAway.data() : rgba;
    numbers.insert(numbers.end(), goesOn, goesOn + 4);
    if (!gives)
    {
      std::fill_n(rgba, 4, 0.f);
    }
  });
  const int next = neighbour(run, 1);
  if (next != BoxPeers::anyone)
  {
    peers_.send(next, BoxPeers::Channel::Tiles, std::move(numbers));
  }
}

} // namespace treeamr
