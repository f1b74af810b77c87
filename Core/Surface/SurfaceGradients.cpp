#include "Surface/SurfaceGradients.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeamr
{

SurfaceGradients::SurfaceGradients(const SurfaceBlocks& blocks, std::size_t budgetBytes)
  : blocks_(blocks)
  , budgetBytes_(budgetBytes)
{
}

void SurfaceGradients::prepare() const
{
  Numbers numbers(blocks_.all().size());
  pool_.emplace(numbers.size(), budgetBytes_ - std::min(budgetBytes_, numbers.size() * sizeof(numbers[0])));
  numbers_ = std::move(numbers);
}

SurfaceGradients::Worker& SurfaceGradients::worker() const
{
  std::unique_ptr<Worker>& worker = workers_.local();
  if (!worker)
  {
    worker.reset(
      new Worker{ GradientEvaluator(blocks_.field()), ChunkPool<Chunk>::Writer(*pool_), {}, {}, noBlock });
  }
  return *worker;
}

const GradientRecord& SurfaceGradients::record(std::uint32_t block, const SurfaceRecord& values) const
{
  std::call_once(prepared_, [this] { this->prepare(); });
  const std::uint32_t number = numbers_[block].load(std::memory_order_acquire);
  if (number != 0)
  {
    return pool_->chunkOf(number).records[number % Chunk::size];
  }
  Worker& own = this->worker();
  if (own.unkeptBlock == block)
  {
    return own.unkept;
  }
  Chunk* chunk = own.writer.room();
  if (!chunk)
  {
    this->evaluate(blocks_.all()[block], values, own, own.unkept);
    own.unkeptBlock = block;
    unkept_.fetch_add(1, std::memory_order_relaxed);
    return own.unkept;
  }
  GradientRecord& record = chunk->records[own.writer.index()];
  this->evaluate(blocks_.all()[block], values, own, record);
  numbers_[block].store(own.writer.keep(), std::memory_order_release);
  return record;
}

void SurfaceGradients::evaluate(const SurfaceBlock& block, const SurfaceRecord& values, Worker& worker,
  GradientRecord& record) const noexcept
{
  if (block.depth() < 0) // a single cell
  {
    record.gradients = {};
    return;
  }
  const BlockVertices vertices = verticesOfOctants(values.active);
  const BlockPath path = blocks_.pathTo(block);
  worker.evaluator.compute(
    path, blocks_.cellsOf(block, path.node[path.depth]), vertices, worker.gradients, &values.values);
  const auto forAll = [&](const auto& f) {
    for (int z = 0; z < block::verticesPerEdge; ++z)
    {
      for (std::uint32_t rest = vertices[z]; rest != 0; rest &= rest - 1)
      {
        f(std::countr_zero(rest) + block::vertexStride[2] * z);
      }
    }
  };
  double largest = 0.;
  forAll([&](int v) {
    for (const double slope : worker.gradients[v])
    {
      largest = std::max(largest, std::abs(slope));
    }
  });
  const int exponent = largest > 0. && std::isfinite(largest) ? -std::ilogb(largest) : 0;
  // In two factors: the reciprocal of a denormal number is none.
  const std::array<double, 2> scale{ std::ldexp(1., exponent / 2), std::ldexp(1., exponent - exponent / 2) };
  forAll([&](int v) {
    for (int a = 0; a < 3; ++a)
    {
      record.gradients[v][a] = static_cast<float>(worker.gradients[v][a] * scale[0] * scale[1]);
    }
  });
}

void SurfaceGradients::startFrame() const
{
  if (pool_ && unkept_ > pool_->byteSize() / sizeof(GradientRecord))
  {
    for (auto& number : numbers_)
    {
      number.store(0, std::memory_order_relaxed);
    }
    workers_.clear();
    pool_->forget();
  }
  unkept_ = 0;
}

std::size_t SurfaceGradients::byteSize() const noexcept
{
  return pool_ ? numbers_.size() * sizeof(numbers_[0]) + pool_->byteSize() : 0;
}

} // namespace treeamr
