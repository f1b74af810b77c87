// Direct volume rendering (the paper's section 6.1): emission and absorption, front to back.
#pragma once

#include "Field/Field.h"
#include "Field/TransferFunction.h"
#include "Field/TransferFunction2D.h"
#include "Geometry/Image.h"
#include "Geometry/RayView.h"
#include "MemoryBudget.h"
#include "Volume/VolumeSettings.h"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace treeamr
{

class BlockCache;
class GradientCache;
class ShadowLattice;
class TileRelay;
class VolumeTable;
struct VolumeKernelScene;

/// 4 x 4 neighbouring pixels.
struct PixelGroup
{
  static constexpr int width = 4;                    // in pixels
  static constexpr int rgbaSize = 4 * width * width; // floats that they have
  int x;                                             // of the lower left pixel, a multiple of width
  int y;                                             // likewise
};

/// A field seen through a transfer function, and what its frames have in common: the function's table, and vertex
/// values of earlier frames, and vertex gradients where they were lit. Of its calls one at a time; each takes all threads
/// of TBB's arena.
class Volume
{
public:
  /// transferFunction: over the field's values less its offset. Keeps vertex values within keptBytes, those of a
  /// field that colours within as many, and while frames are lit twice as many of these and their vertex gradients within
  /// four times as many; too few keep none. Throws Error without a field, and as setTransferFunction().
  Volume(std::shared_ptr<const Field> field, TransferFunction transferFunction,
    std::size_t keptBytes = defaultKeptBytes);
  ~Volume();
  ///@{
  /// With all that it has kept.
  Volume(Volume&&) noexcept;
  Volume& operator=(Volume&&) noexcept;
  ///@}

  ///@{
  /// What is drawn.
  const Field& field() const noexcept { return *field_; }
  const TransferFunction& transferFunction() const noexcept { return transferFunction_; }
  ///@}
  /// In place of a table, too. Throws Error, and keeps the one before, when a value of the field is none of its
  /// categories.
  void setTransferFunction(TransferFunction transferFunction);

  /// One of several components of what is drawn, each a field of the same octree with functions of its own.
  struct Component
  {
    std::shared_ptr<const Field> field; // never null
    TransferFunction function;          // over its values less their offset
    float weight = 1.f;                 // at least 0
  };

  /// Colours by another field, in the octree of the first: of the transfer function extinctions alone count then, of
  /// `colors` the colours, over its field's values less their offset. Its gradients are those of light and of gradient
  /// opacity, as VTK's GPU mapper has it. Null: none. Blends of values show
  /// none of them. Throws Error, and keeps what was there, for a field of
  /// another octree and for categories in either function.
  void setColors(std::shared_ptr<const Field> field, const TransferFunction& colors);
  /// Colours that three other fields are: red, green and blue, each of them 0 at the least and 1 at the largest of its
  /// values. Null for all: none. Throws Error, and keeps what was there, as setColors().
  void setChannels(const std::array<std::shared_ptr<const Field>, 3>& rgb);
  /// Two to four components, the first one of the volume's own field and function, mixed at each sample as VTK's GPU
  /// mapper mixes independent components: their extinctions' squares by the weighted sum of these, colours by weight and
  /// extinction. Each is lit by its own gradients, and has no gradient opacity; where cells show values of their own they
  /// are not lit. None or one: the volume alone. Throws Error, and keeps what was there, as setColors() and for weights that
  /// are negative or not finite.
  void setComponents(std::vector<Component> others, float ownWeight = 1.f);
  /// Colours and extinctions by two values: that of the volume's field and, with `second`, that of another one, else the
  /// length of its own gradient per unit of data coordinates. In place of the transfer function, which becomes
  /// table.mostOverFirst(), of all other fields, and of gradient opacity. Sampled by points. Blends of values do not
  /// read it. Throws Error, and keeps what was there, as setColors().
  void setTable(std::shared_ptr<const Field> second, const TransferFunction2D& table);
  /// Whether its light may be scattered: it is as opaque as the transfer function of its own values has it.
  bool canScatter() const noexcept;
  /// Whether any of these four makes samples' colours.
  bool hasColors() const noexcept { return static_cast<bool>(mixture_); }

  /// Forgets the vertex values, unless these are the bytes that it was given before.
  void setKeptBytes(std::size_t bytes);
  /// That vertex values and gradients take.
  std::size_t keptBytes() const noexcept;

  /// Renders into `image` (overwritten). A ray is integrated from stop to stop, with no sample across one; what the
  /// stops hide from all rays is not visited. Throws Error when the image's size or that of the stops is not the
  /// camera's, the settings are not finite and positive, or the stops have hits and the blend is one of values; and
  /// Interrupted when the view's progress is ended: then the image has some of its pixels.
  VolumeStatistics render(const RayView& view, const VolumeSettings& settings, Image& image);

  /// The same of an image that other boxes of the domain have a part in: rays go on from what it has of them, with the
  /// light that is left or, of blends of values, with what these have come to, in each tile once the relay has collected
  /// it. Throws Error as render(), and what the relay throws: before it has collected anything, or when what it has collected is
  /// finished.
  VolumeStatistics render(
    const RayView& view, const VolumeSettings& settings, Image& image, TileRelay& relay);

  /// The pixels of these groups as render() gives them, to the bit. rgba: rgbaSize floats for each group, row by
  /// row from the lower left as in Image; pixels beyond the image are 0. Neighbours in the list that are neighbours in
  /// the image, too, cost less. Throws Error as render(), and for a group outside the image.
  void renderGroups(const RayView& view, const VolumeSettings& settings, std::span<const PixelGroup> groups,
    std::span<float> rgba);

  /// For benchmarks: takes the camera's rays through a block of the transfer function's faintest value `repeats`
  /// times, on this thread, with the tree walk and the memory of vertex values left out: what an interval, a step
  /// and a lit step take at least.
  VolumeStatistics renderWithoutWalk(
    const Camera& camera, const VolumeSettings& settings, int repeats, Image& image);

private:
  struct Mixture;

  /// Whether it is lit by the gradients of the field that colours it, too.
  bool isColoredByOther() const noexcept;
  void prepareMemory(bool withValues, bool withGradients, bool withColors, bool withMeans);
  void forgetKept() noexcept;
  void checkPart(const std::shared_ptr<const Field>& field, const TransferFunction& function) const;
  void mix(Mixture mixture);
  VolumeKernelScene makeScene(const RayView& view, const VolumeSettings& settings, Image* image);
  void scatter(const VolumeSettings& settings, VolumeKernelScene& scene);
  void endFrame(const VolumeKernelScene& scene, const VolumeStatistics& all);

  std::shared_ptr<const Field> field_;
  TransferFunction transferFunction_;
  std::unique_ptr<VolumeTable> table_;           // of the last frame; null: of another function
  std::size_t budget_;                           // of bytes, for values
  std::unique_ptr<BlockCache> kept_;             // null: no frame has been rendered
  std::unique_ptr<GradientCache> keptGradients_; // null: the last frame was not lit
  std::unique_ptr<ShadowLattice> shadows_;       // null: the last frame scattered no light
  std::unique_ptr<Mixture> mixture_;             // null: the transfer function's colours alone
};

} // namespace treeamr
