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

/// What is sent of a pixel that has been given away: no ray has less than no red, none goes on from no light, and what is no
/// colour yet ends with 0.
constexpr std::array<float, 4> givenAway{ -1.f, 0.f, 0.f, 1.f };

/// Until others have sent something: they may need the processor.
void rest()
{
  std::this_thread::sleep_for(std::chrono::microseconds(50));
}

constexpr std::size_t pixelsOfRun =
  static_cast<std::size_t>(TileRun::tileWidth) * TileRun::tileWidth * TileRun::mostTiles;
/// Flags in a message.
constexpr std::size_t flagsOfFloat = 24;
/// With its number, and of what is gathered flags.
constexpr std::size_t floatsOfRun = 1 + 4 * pixelsOfRun + pixelsOfRun / flagsOfFloat + 1;

constexpr int tilesOf(int pixels) noexcept
{
  return (pixels + TileRun::tileWidth - 1) / TileRun::tileWidth;
}

void appendFlags(const std::vector<unsigned char>& flags, std::vector<float>& numbers)
{
  for (std::size_t first = 0; first < flags.size(); first += flagsOfFloat)
  {
    std::uint32_t bits = 0;
    for (std::size_t i = first; i < std::min(first + flagsOfFloat, flags.size()); ++i)
    {
      bits |= static_cast<std::uint32_t>(flags[i]) << (i - first);
    }
    numbers.push_back(static_cast<float>(bits));
  }
}

bool flagOf(const float* numbers, std::size_t i) noexcept
{
  return (static_cast<std::uint32_t>(numbers[i / flagsOfFloat]) >> i % flagsOfFloat & 1) != 0;
}

/// In numbers that floats have.
std::array<float, 4> keyOf(const Camera& camera, std::span<const double> alike)
{
  std::uint64_t hash = 14695981039346656037u; // Fowler, Noll and Vo
  const auto add = [&](std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte)
    {
      hash = (hash ^ (bits >> 8 * byte & 0xff)) * 1099511628211u;
    }
  };
  const auto addAll = [&](std::span<const double> numbers) {
    for (const double number : numbers)
    {
      std::uint64_t bits;
      std::memcpy(&bits, &number, sizeof(bits));
      add(bits);
    }
  };
  addAll(camera.clipFromData());
  addAll(alike);
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
  , camera_(image.rgba.empty() ? camera : Camera(camera.clipFromData(), image.width, image.height))
  , endDepth_(endDepth)
  , image_(image)
  , runsInRow_((tilesOf(image.width) + TileRun::mostTiles - 1) / TileRun::mostTiles)
  , rows_(tilesOf(image.height))
  , gathers_(image.width != camera.width() || image.height != camera.height())
{
  for (const int peer : frontToBack(boxes, grid, camera))
  {
    const auto number = static_cast<std::size_t>(peer);
    const Bounds bounds = boxes[number].bounds(grid);
    // By the camera's pixels: the same processes take part whatever the image of each.
    if (number < peers.drawing().size() && peers.drawing()[number] && BoxFootprint(bounds, camera).isSeen())
    {
      boxes_.push_back({ peer, BoxFootprint(bounds, camera_) });
    }
  }
  const auto found =
    std::find_if(boxes_.begin(), boxes_.end(), [own](const Box& box) { return box.peer == own; });
  own_ = static_cast<std::size_t>(found - boxes_.begin());
  box_ = boxes[static_cast<std::size_t>(own)];
  domain_ = grid.bounds();
}

BoxRelay::~BoxRelay()
{
  try
  {
    if (hasBegun_)
    {
      this->end(false);
    }
  }
  catch (...)
  {
    // The processes can no longer reach each other.
  }
}

bool BoxRelay::begin(bool can, const Terms& terms)
{
  if (boxes_.size() < 2 || own_ == boxes_.size())
  {
    return false;
  }
  if (can) // what takes much memory, while others can still do without this process
  {
    (gathers_ ? isClosed_ : isLast_).assign(image_.rgba.size() / 4, 0);
    closedColors_.resize(gathers_ ? image_.rgba.size() : 0);
    runs_.assign(static_cast<std::size_t>(runsInRow_) * rows_, RunState::None);
    message_.reserve(floatsOfRun);
  }
  cutsAtFaces_ = terms.cutsAtFaces;
  this->findCutRuns(terms.hits);
  hasBegun_ = this->agree(can, terms.alike);
  if (hasBegun_)
  {
    this->start();
  }
  return hasBegun_;
}

bool BoxRelay::isCutAtFaces(int column, int row) const noexcept
{
  return cutRuns_[static_cast<std::size_t>(row * runsInRow_ + column / TileRun::mostTiles)] != 0;
}

/// What is behind or before the domain ends no ray among its cells.
void BoxRelay::findCutRuns(const TranslucentHits* hits)
{
  cutRuns_.assign(static_cast<std::size_t>(runsInRow_) * rows_, 0);
  if (!endDepth_ && !hits)
  {
    return;
  }
  const auto endsInDomain = [this](int x, int y, float depth) {
    if (!(depth < 1.f))
    {
      return false;
    }
    const Ray ray = camera_.ray(x, y);
    const Vec3 point = pointAt(ray, camera_.tFromDepth(ray, depth));
    bool isIn = true;
    for (int a = 0; a < 3; ++a)
    {
      isIn = isIn && point[a] >= domain_.min[a] && point[a] <= domain_.max[a];
    }
    return isIn;
  };
  tbb::parallel_for(0, runsInRow_ * rows_, [&](int number) {
    bool isCut = false;
    forEachPixel(runOf(number), [&](int x, int y, std::size_t pixel) {
      isCut = isCut || (hits && hits->first[pixel] < hits->first[pixel + 1]) ||
        (endDepth_ && endsInDomain(x, y, endDepth_[pixel]));
    });
    cutRuns_[static_cast<std::size_t>(number)] = isCut ? 1 : 0;
  });
}

/// In steps of 1, 2, 4 ... processes: each tells another one what all before it have told.
bool BoxRelay::agree(bool can, std::span<const double> alike)
{
  std::array<float, 4> least = keyOf(camera_, alike);
  std::array<float, 4> most = least;
  bool all = can;
  const std::size_t count = boxes_.size();
  for (std::size_t step = 1; step < count; step *= 2)
  {
    std::vector<float> numbers{ all ? 1.f : 0.f, cutsAtFaces_ ? 1.f : 0.f };
    numbers.insert(numbers.end(), least.begin(), least.end());
    numbers.insert(numbers.end(), most.begin(), most.end());
    appendFlags(cutRuns_, numbers);
    const std::size_t messageSize = numbers.size();
    peers_.send(boxes_[(own_ + step) % count].peer, BoxPeers::Channel::Agreement, numbers);
    const int from = boxes_[(own_ + count - step) % count].peer;
    while (peers_.receive(from, BoxPeers::Channel::Agreement, numbers) == BoxPeers::anyone)
    {
      rest();
    }
    std::array<float, 4> other;
    all = all && numbers[0] == 1.f;
    cutsAtFaces_ = cutsAtFaces_ || numbers[1] == 1.f;
    std::copy_n(&numbers[2], 4, other.begin());
    least = std::min(least, other);
    std::copy_n(&numbers[6], 4, other.begin());
    most = std::max(most, other);
    if (numbers.size() == messageSize) // that of the same picture
    {
      for (std::size_t run = 0; run < cutRuns_.size(); ++run)
      {
        cutRuns_[run] = cutRuns_[run] != 0 || flagOf(&numbers[10], run) ? 1 : 0;
      }
    }
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

void BoxRelay::start()
{
  for (int number = 0; number < runsInRow_ * rows_; ++number)
  {
    const TileRun run = runOf(number);
    if (boxes_[own_].overlaps(run))
    {
      const bool isFirst = neighbour(run, -1) == BoxPeers::anyone;
      runs_[number] = isFirst ? RunState::Open : RunState::Awaited;
      awaited_ += isFirst ? 0 : 1;
    }
    if (gathersHere())
    {
      const std::size_t last = lastOf(run);
      isToCome_.push_back(last > 0 && last < boxes_.size());
      awaited_ += isToCome_.back() ? 1 : 0;
    }
  }
}

std::size_t BoxRelay::lastOf(const TileRun& run) const noexcept
{
  std::size_t last = boxes_.size();
  for (std::size_t i = 0; i < boxes_.size(); ++i)
  {
    last = boxes_[i].overlaps(run) ? i : last;
  }
  return last;
}

void BoxRelay::findLast()
{
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
    if (!gathers_)
    {
      this->findLast();
    }
    for (int number = 0; number < runsInRow_ * rows_; ++number)
    {
      if (runs_[number] == RunState::Open)
      {
        ready.push_back(runOf(number));
      }
    }
  }
  while (awaited_ > 0 && this->receive(ready))
  {
  }
  return awaited_ > 0;
}

bool BoxRelay::receive(std::vector<TileRun>& ready)
{
  const int sender = peers_.receive(BoxPeers::anyone, BoxPeers::Channel::Tiles, message_);
  if (sender == BoxPeers::anyone)
  {
    return false;
  }
  const int number = static_cast<int>(message_.front());
  if (message_.size() == 1)
  {
    this->goOnWithout(sender, ready);
  }
  else if (number < runsInRow_ * rows_)
  {
    this->take(runOf(number), message_.data() + 1, ready);
  }
  else
  {
    this->takeWhole(number - runsInRow_ * rows_, message_.data() + 1);
  }
  return true;
}

void BoxRelay::goOnWithout(int sender, std::vector<TileRun>& ready)
{
  for (std::size_t number = 0; number < runs_.size(); ++number)
  {
    const TileRun run = runOf(static_cast<int>(number));
    if (runs_[number] == RunState::Awaited && neighbour(run, -1) == sender)
    {
      this->take(run, nullptr, ready);
    }
    if (gathersHere() && isToCome_[number] && boxes_[lastOf(run)].peer == sender)
    {
      isToCome_[number] = false;
      --awaited_;
    }
  }
}

/// Of what is gathered, what all boxes have made of a run.
void BoxRelay::takeWhole(int number, const float* rgba)
{
  forEachPixel(runOf(number), [&](int, int, std::size_t pixel) {
    std::copy_n(rgba, 4, &image_.rgba[4 * pixel]);
    rgba += 4;
  });
  isToCome_[static_cast<std::size_t>(number)] = false;
  --awaited_;
}

/// rgba: null for nothing; flags follow of what is gathered.
void BoxRelay::take(const TileRun& run, const float* rgba, std::vector<TileRun>& ready)
{
  std::size_t count = 0;
  forEachPixel(run, [&](int, int, std::size_t pixel) {
    if (rgba)
    {
      std::copy_n(rgba + 4 * count++, 4, &image_.rgba[4 * pixel]);
    }
  });
  if (rgba && gathers_)
  {
    std::size_t i = 0;
    forEachPixel(run, [&](int, int, std::size_t pixel) {
      isClosed_[pixel] = flagOf(rgba + 4 * count, i++) ? 1 : 0;
      if (isClosed_[pixel])
      {
        float* const color = &image_.rgba[4 * pixel];
        std::copy_n(color, 4, &closedColors_[4 * pixel]);
        std::copy_n(givenAway.data(), 4, color);
      }
    });
  }
  runs_[numberOf(run)] = RunState::Open;
  --awaited_;
  ready.push_back(run);
}

void BoxRelay::finish(const TileRun& run)
{
  const int next = neighbour(run, 1);
  const bool isLast = next == BoxPeers::anyone;
  std::vector<float> numbers = gathers_ ? this->passOn(run, isLast) : this->giveAway(run);
  if (!isLast)
  {
    peers_.send(next, BoxPeers::Channel::Tiles, std::move(numbers));
  }
  else if (gathers_ && !gathersHere())
  {
    numbers.front() += static_cast<float>(runsInRow_ * rows_);
    peers_.send(boxes_.front().peer, BoxPeers::Channel::Tiles, std::move(numbers));
  }
  if (gathers_ && !(isLast && gathersHere()))
  {
    clear(run);
  }
  runs_[numberOf(run)] = RunState::None;
}

std::vector<float> BoxRelay::passOn(const TileRun& run, bool isLast)
{
  std::vector<float> numbers{ static_cast<float>(numberOf(run)) };
  numbers.reserve(floatsOfRun);
  std::vector<unsigned char> closed;
  forEachPixel(run, [&](int, int, std::size_t pixel) {
    float* const rgba = &image_.rgba[4 * pixel];
    bool isClosed = isClosed_[pixel] != 0;
    if (isClosed)
    {
      std::copy_n(&closedColors_[4 * pixel], 4, rgba);
    }
    else
    {
      isClosed = endDepth_ && endDepth_[pixel] < 1.f;
      if (show_ && (isClosed || isLast))
      {
        show_(rgba);
      }
    }
    numbers.insert(numbers.end(), rgba, rgba + 4);
    closed.push_back(isClosed ? 1 : 0);
  });
  appendFlags(closed, numbers);
  return numbers;
}

std::vector<float> BoxRelay::giveAway(const TileRun& run)
{
  std::vector<float> numbers{ static_cast<float>(numberOf(run)) };
  numbers.reserve(floatsOfRun);
  forEachPixel(run, [&](int, int, std::size_t pixel) {
    float* const rgba = &image_.rgba[4 * pixel];
    const bool isGiven = show_ ? rgba[3] > 0.f : rgba[0] < 0.f;
    const bool gives = !isGiven && (isLast_[pixel] || (endDepth_ && endDepth_[pixel] < 1.f));
    const float* const goesOn = isGiven || gives ? givenAway.data() : rgba;
    numbers.insert(numbers.end(), goesOn, goesOn + 4);
    if (!gives)
    {
      std::fill_n(rgba, 4, 0.f);
    }
    else if (show_)
    {
      show_(rgba);
    }
  });
  return numbers;
}

void BoxRelay::clear(const TileRun& run)
{
  forEachPixel(run, [&](int, int, std::size_t pixel) { std::fill_n(&image_.rgba[4 * pixel], 4, 0.f); });
}

void BoxRelay::giveUp()
{
  std::vector<int> waiting;
  for (std::size_t number = 0; number < runs_.size(); ++number)
  {
    if (runs_[number] != RunState::None)
    {
      const TileRun run = runOf(static_cast<int>(number));
      clear(run);
      int next = neighbour(run, 1);
      if (next == BoxPeers::anyone && gathers_ && !gathersHere())
      {
        next = boxes_.front().peer;
      }
      if (next != BoxPeers::anyone && std::find(waiting.begin(), waiting.end(), next) == waiting.end())
      {
        waiting.push_back(next);
      }
    }
  }
  for (const int peer : waiting)
  {
    peers_.send(peer, BoxPeers::Channel::Tiles, { -1.f });
  }
  // What comes for this frame must not be there in the next one.
  std::vector<TileRun> ready;
  while (awaited_ > 0)
  {
    if (!this->receive(ready))
    {
      rest();
    }
  }
  for (const TileRun& run : ready)
  {
    clear(run);
  }
  std::fill(runs_.begin(), runs_.end(), RunState::None);
}

bool BoxRelay::end(bool hasFailed)
{
  hasBegun_ = false;
  cutRuns_.clear();
  return this->agree(!hasFailed, {}); // a process that is done leaves the processor to the others
}

} // namespace treeamr
