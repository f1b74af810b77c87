// A frame of many processes each of which draws a box of the domain: a tile's colours go from box to box, from the eye on, in
// floats, so that each ray knows the light that is left, and what is hidden is not traced. Of each pixel one process gives
// the whole colour away: that whose box is the last on the ray, or in whose window something opaque ends it; all others
// give nothing of it. So what is put together of their pictures has been rounded once.
//
// Of an image with fewer pixels than the camera, which is enlarged when it is shown, the process of the nearest box gives all:
// pixels are mixed then, and what one process has of a mixture over that of another is not the mixture of both.
#pragma once

#include "Geometry/Bounds.h"
#include "Geometry/Image.h"
#include "Geometry/RayStops.h"
#include "Partition/BoxOrder.h"
#include "Partition/BoxPeers.h"
#include "Volume/TileRelay.h"

#include <cstddef>
#include <span>
#include <vector>

namespace treeamr
{

class BoxRelay : public TileRelay
{
public:
  /// Of the process that draws boxes[own]; the boxes in the order of cutBoxes(). image: of the camera's size or less, which
  /// gets what this process gives away. endDepth: of the image's pixels, as in RayStops, in this process's window. It and the
  /// image must last until all is finished, peers until the end. Throws Error as frontToBack().
  BoxRelay(const std::vector<LatticeBox>& boxes, int own, const RootGrid& grid, BoxPeers& peers,
    const Camera& camera, const float* endDepth, Image& image);
  ~BoxRelay() override;
  BoxRelay(const BoxRelay&) = delete;
  BoxRelay& operator=(const BoxRelay&) = delete;

  /// What a process has to tell before it begins.
  struct Terms
  {
    std::span<const double> alike{}; // to be the same on all
    bool cutsAtFaces = true;         // in the whole image, as the stops say; see TileRelay::box()
    const TranslucentHits* hits = nullptr; // of this process; null: none
  };
  /// Whether all that see something of their boxes can, see the same, and have the same numbers in `alike`: else each draws
  /// by itself. Waits for all. Once.
  bool begin(bool can, const Terms& terms);
  bool begin(bool can) { return this->begin(can, Terms()); }
  bool hasBegun() const noexcept { return hasBegun_; } // and not ended
  /// This process has failed, or is to stop: nobody waits for what it has not finished, of which it shows nothing.
  void giveUp();
  /// Waits for all, of what has begun; the destructor does, where nobody has. Whether none has failed. Once.
  bool end(bool hasFailed);

  const LatticeBox* box() const noexcept override { return cutsAtFaces_ ? nullptr : &box_; }
  bool isCutAtFaces(int column, int row) const noexcept override;
  bool collect(std::vector<TileRun>& ready) override;
  void finish(const TileRun& run) override;

private:
  struct Box
  {
    int peer;
    BoxFootprint footprint;
    bool overlaps(const TileRun& run) const noexcept;
  };

  /// The next that may see something of a run, `step` by step from the own one; anyone: there is none.
  int neighbour(const TileRun& run, int step) const noexcept;
  TileRun runOf(int number) const noexcept;
  int numberOf(const TileRun& run) const noexcept;
  bool agree(bool can, std::span<const double> alike);
  void findCutRuns(const TranslucentHits* hits);
  void findLast();
  void start();
  /// Of boxes_ the last one that may see something of a run; their number: none does.
  std::size_t lastOf(const TileRun& run) const noexcept;
  bool gathersHere() const noexcept { return gathers_ && own_ == 0; }
  /// Takes what has come; false: nothing has.
  bool receive(std::vector<TileRun>& ready);
  void takeWhole(int number, const float* rgba);
  void goOnWithout(int sender, std::vector<TileRun>& ready);
  void take(const TileRun& run, const float* rgba, std::vector<TileRun>& ready);
  /// What the next process goes on with, of a run that gives away or is gathered.
  std::vector<float> giveAway(const TileRun& run);
  std::vector<float> passOn(const TileRun& run, bool isLast);
  void clear(const TileRun& run);
  template <class Use>
  void forEachPixel(const TileRun& run, const Use& use);

  BoxPeers& peers_;
  const Camera camera_; // that of the footprints: of the image
  const float* endDepth_;
  Image& image_;
  std::vector<Box> boxes_; // that are seen, nearest first
  std::size_t own_;        // of these; their number: this process sees nothing
  int runsInRow_;
  int rows_; // of tiles
  bool hasBegun_ = false; // and not ended
  LatticeBox box_; // the own one
  Bounds domain_;
  bool cutsAtFaces_ = true;
  std::vector<unsigned char> cutRuns_; // by number: in a process's window something ends rays in the domain
  enum class RunState : unsigned char
  {
    None, // of this box, or finished
    Awaited,
    Open
  };
  bool hasStarted_ = false;    // collecting
  std::vector<RunState> runs_; // by number
  std::size_t awaited_ = 0;
  std::vector<float> message_;
  std::vector<unsigned char> isLast_; // by pixel: no other box follows on its ray
  const bool gathers_;
  std::vector<bool> isToCome_;          // by number, where all are gathered: from the last box of the run
  std::vector<unsigned char> isClosed_; // by pixel, of what is gathered: something opaque has ended the ray
  std::vector<float> closedColors_;     // of these, in place of what the image has
};

} // namespace treeamr
