// A volume's frame of many processes: whether this one goes on from others' pixels (Partition/BoxRelay.h). Private to the
// module.
#pragma once

#include "Partition/BoxRelay.h"

#include <memory>
#include <optional>

class vtkHyperTreeGrid;
class vtkRenderer;
class vtkVolume;

namespace treeamr
{

/// Of a call of Render(). All processes ask each other once in each, whatever happens to this one: else the others would wait.
class VolumeRelay
{
public:
  /// peers: null for a process alone, which has nobody to ask.
  VolumeRelay(BoxPeers* peers, vtkHyperTreeGrid* grid, vtkRenderer* renderer, vtkVolume* volume);
  ~VolumeRelay();
  VolumeRelay(const VolumeRelay&) = delete;
  VolumeRelay& operator=(const VolumeRelay&) = delete;

  /// When this process can: null unless all can, on the same terms. camera: of all of the viewport's pixels. endDepth and
  /// the image must last until all is finished.
  BoxRelay* begin(
    const Camera& camera, const float* endDepth, Image& image, const BoxRelay::Terms& terms);
  /// Where this process draws no more of what has begun: others go on without.
  void giveUp(bool hasFailed);
  /// When all is drawn, or the destructor does: throws Error when another process has failed.
  void end();

private:
  void make(const Camera& camera, const float* endDepth, Image& image);

  BoxPeers* peers_; // null: nobody has to be asked any more
  vtkHyperTreeGrid* grid_;
  vtkRenderer* renderer_;
  vtkVolume* volume_;
  std::optional<BoxRelay> relay_; // that has begun
  bool hasFailed_ = false;        // this process, once it has begun
};

/// Adds where others' pixels may come to a process: to the box that it draws or, of pictures that are gathered, anywhere in
/// the domain. Beyond the bounds of its props nothing of a process's picture is composited.
void addRelayed(vtkHyperTreeGrid& grid, bool mayGather, double bounds[6]);

} // namespace treeamr
