#include "Surface/SurfaceGradients.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

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
  isPrepared_.store(true, std::memory_order_release);
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

const GradientRecord& SurfaceGradients::complete(
  std::uint32_t block, const SurfaceRecord& values, std::uint64_t octants) const
{
  std::call_once(prepares_, [this] { this->prepare(); });
  const auto with = [&](const GradientRecord& record) -> const GradientRecord& {
    const std::uint64_t missing = octants & ~record.ready(std::memory_order_acquire);
    if (missing != 0)
    {
      this->add(missing, block, values, this->worker(), record);
    }
    return record;
  };
  if (const GradientRecord* kept = this->find(block))
  {
    const std::lock_guard lock(adds_[block % lockCount]);
    return with(*kept);
  }
  Worker& own = this->worker();
  if (own.unkeptBlock == block)
  {
    return with(own.unkept);
  }
  Chunk* chunk = own.writer.room();
  if (!chunk)
  {
    own.unkeptBlock = block;
    unkept_.fetch_add(1, std::memory_order_relaxed);
    return with(*new (&own.unkept) GradientRecord());
  }
  const GradientRecord& record = with(*new (&chunk->records[own.writer.index()]) GradientRecord());
  numbers_[block].store(own.writer.keep(), std::memory_order_release);
  return record;
}

void SurfaceGradients::add(std::uint64_t octants, std::uint32_t number, const SurfaceRecord& values,
  Worker& worker, const GradientRecord& record) const noexcept
{
  const SurfaceBlock& block = blocks_.all()[number];
  BlockVertices vertices = verticesOfOctants(octants);
  const std::uint64_t ready = record.ready(std::memory_order_relaxed);
  const BlockVertices known = verticesOfOctants(ready);
  for (std::size_t z = 0; z < vertices.size(); ++z)
  {
    vertices[z] &= ~known[z]; // others read them
  }
  if (block.depth() < 0 && !blocks_.field().corners())
  {
    worker.gradients = {}; // of a single cell
  }
  else if (block.depth() < 0)
  {
    worker.evaluator.compute(BlockPath(), BlockCells::Leaves, vertices, worker.gradients);
  }
  else
  {
    const BlockPath path = blocks_.pathTo(block);
    worker.evaluator.compute(
      path, blocks_.cellsOf(block, path.node[path.depth]), vertices, worker.gradients, &values.values);
  }
  // The first octants, which one thread adds before others see the record, decide.
  if (ready == 0)
  {
    double largest = 0.;
    forEachVertex(vertices, [&](int v) {
      for (const double slope : worker.gradients[v])
      {
        largest = std::max(largest, std::abs(slope));
      }
    });
    record.exponent = largest > 0. && std::isfinite(largest) ? -std::ilogb(largest) : 0;
  }
  // In two factors: the reciprocal of a denormal number is none.
  const std::array<double, 2> scale{ std::ldexp(1., record.exponent / 2),
    std::ldexp(1., record.exponent - record.exponent / 2) };
  constexpr double most = std::numeric_limits<float>::max();
  forEachVertex(vertices, [&](int v) {
    for (int a = 0; a < 3; ++a)
    {
      const double scaled = std::clamp(worker.gradients[v][a] * scale[0] * scale[1], -most, most);
      record.vertices[v][a] = static_cast<float>(scaled);
    }
  });
  std::atomic_ref(record.octants).fetch_or(octants, std::memory_order_release);
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
