// How an image that several boxes of a domain have a part in is rendered box after box: each goes on from what those before
// it have made of a tile's rays, once that has come, while others are at other tiles.
#pragma once

#include <functional>
#include <utility>
#include <vector>

namespace treeamr
{

struct LatticeBox;

/// Neighbouring tiles of a row of tiles: what comes and goes at once.
struct TileRun
{
  static constexpr int tileWidth = 16; // in pixels, of square tiles
  static constexpr int mostTiles = 4;  // in a run
  int row;                             // of tiles, the lowest first
  int columnBegin;                     // of tiles
  int columnEnd;                       // up to, but without
};

/// Of one frame. Called by the thread that renders alone, again and again.
class TileRelay
{
public:
  virtual ~TileRelay() = default;
  /// Adds the runs whose pixels have come into the image since the last call. False: no more will.
  virtual bool collect(std::vector<TileRun>& ready) = 0;
  /// Of a run: the image has what it becomes.
  virtual void finish(const TileRun& run) = 0;
  /// Of several boxes that of the nodes to be drawn here, for which nothing of the stops is needed: rays take cells and
  /// blocks that several boxes have a part of where they enter them, all their way through, so that steps are the same
  /// whatever the boxes. Null: the stops say what is drawn.
  virtual const LatticeBox* box() const noexcept { return nullptr; }
  /// Whether the rays of a tile begin and end at the faces of that box none the less: something else ends some of them in
  /// the domain.
  virtual bool isCutAtFaces(int /*column*/, int /*row*/) const noexcept { return false; }
  /// What the image has of a ray is not a colour, but becomes one by this where no box follows. Of such the fourth number
  /// is 0. Before the first call of collect().
  void showBy(std::function<void(float* rgba)> show) { show_ = std::move(show); }

protected:
  std::function<void(float*)> show_; // none: colours
};

/// Renders what the relay collects, on all threads of TBB's arena, until there is no more. After an exception of render()
/// what is left goes as it came, so that nobody waits for it; then it is thrown. After one of the relay's, others may wait.
void relayTiles(TileRelay& relay, const std::function<void(const TileRun&)>& render);

} // namespace treeamr
